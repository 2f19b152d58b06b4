//! Does what was given of a camera agree with what moves?
//!
//! A number that is given is held, and errors are stated as if it were right. So each kind of number is solved for once more in all cameras
//! of which it was given. How far that moves one is compared with its own covariance, the one that errors are stated by (Wald 1943).

use nalgebra::{DMatrix, DVector};

use super::covariance::{Covariance, covariance};
use super::outlines::{Shapes, outline_errors};
use crate::network::given::input::Kind;
use crate::network::model::camera::{Camera, Step};
use crate::network::model::joint::Beliefs;
use crate::network::solve::networks::Solved;
use crate::network::solve::principal;
use crate::network::solve::relocate::Placed;
use crate::network::thresholds as limits;

/// Steps of the solver.
const STEPS: usize = 40;

/// What was given of a camera, and is contradicted by what moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contradiction {
    /// Which camera.
    pub camera: usize,
    /// What was given.
    pub kind: Kind,
    /// By how much another value fits better, a normal deviate.
    pub deviate: f64,
}

/// What is contradicted, and the cameras as they stand without that.
#[derive(Debug, Clone, PartialEq)]
pub struct Contradictions {
    /// Camera by camera, all of one kind.
    pub found: Vec<Contradiction>,
    /// Every camera with that kind solved for, and with what was given of it where that is not contradicted.
    pub cameras: Vec<Camera>,
}

/// What is contradicted; of several kinds the one that explains most, as a wrong focal length asks for another principal point as well.
pub fn contradictions(solved: &Solved, shapes: Shapes) -> Option<Contradictions> {
    let cost = solved.problem(&solved.beliefs).cost(&solved.network.cameras);
    let tried = Kind::ALL.into_iter().filter_map(|kind| Tried::of(solved, kind, cost));
    let contradicted = tried.filter_map(|tried| Some((tried.gain, tried.contradicted(solved, shapes)?)));
    contradicted.max_by(|p, q| p.0.total_cmp(&q.0)).map(|(_, found)| found)
}

/// A network with one kind of number solved for in all cameras of which it was given.
struct Tried {
    kind: Kind,
    given: Vec<usize>,
    beliefs: Vec<Beliefs>,
    cameras: Vec<Camera>,
    /// What that gains, in nats, less one for each number.
    gain: f64,
}

impl Tried {
    /// `None` where it was not given of any, or nothing is gained.
    fn of(solved: &Solved, kind: Kind, cost: f64) -> Option<Self> {
        let mut beliefs = solved.beliefs.clone();
        let given: Vec<usize> = (0..beliefs.len())
            .filter(|&c| solved.network.placed[c] && !beliefs[c].posed && kind.is_given(&beliefs[c]))
            .collect();
        if given.is_empty() {
            return None;
        }
        for &c in &given {
            kind.free(&mut beliefs[c], &solved.network.cameras[c]);
        }
        let (cameras, freed) = solved.problem(&beliefs).solve(&solved.network.cameras, STEPS);
        let numbers = (given.len() * kind.parameters().len()) as f64;
        let gain = (cost - freed) / solved.settled.prior_weight - numbers;
        (gain > 0.0).then_some(Self { kind, given, beliefs, cameras, gain })
    }

    fn contradicted(self, solved: &Solved, shapes: Shapes) -> Option<Contradictions> {
        let outlines = outline_errors(&solved.settled.under(&self.cameras), self.shapes(solved, shapes));
        let errors = covariance(&solved.problem(&self.beliefs), &self.cameras, &outlines)?;
        let kind = self.kind;
        let of_camera = |&camera: &usize| {
            let deviate = deviate(&solved.beliefs[camera], &self.cameras[camera], &errors, camera, kind)?;
            (deviate >= limits::CONTRADICTED_DEVIATES).then_some(Contradiction { camera, kind, deviate })
        };
        let found: Vec<Contradiction> = self.given.iter().filter_map(of_camera).collect();
        let mut cameras = self.cameras;
        for &c in self.given.iter().filter(|&&c| found.iter().all(|one| one.camera != c)) {
            cameras[c] = with_given(&cameras[c], &solved.network.cameras[c], kind);
        }
        (!found.is_empty()).then_some(Contradictions { found, cameras })
    }

    /// What outlines may be wrong by. Coarse shapes ask for other principal points by themselves; where they no longer do once this kind is
    /// solved for, it was this.
    fn shapes(&self, solved: &Solved, shapes: Shapes) -> Shapes {
        if shapes != Shapes::Strained || self.kind == Kind::PrincipalPoint {
            return shapes;
        }
        let network = Placed { cameras: self.cameras.clone(), placed: solved.network.placed.clone() };
        let free = Solved { network, beliefs: self.beliefs.clone(), ..solved.clone() };
        if principal::call(&free).strain > 0.0 { Shapes::Strained } else { Shapes::Convex }
    }
}

/// A camera with the numbers of one kind as they were given: what is held stays where it starts.
fn with_given(camera: &Camera, given: &Camera, kind: Kind) -> Camera {
    let mut step = Step::zeros();
    for &k in kind.parameters() {
        step[k] = given.intrinsic()[k] - camera.intrinsic()[k];
    }
    camera.stepped(&step)
}

/// How many standard deviations what fits is from what was given, as a normal deviate; `None` where that is not known.
fn deviate(given: &Beliefs, fits: &Camera, errors: &Covariance, camera: usize, kind: Kind) -> Option<f64> {
    let numbers = kind.parameters();
    let places: Vec<usize> = numbers
        .iter()
        .map(|&k| errors.active.iter().position(|p| *p == (camera, k)))
        .collect::<Option<_>>()?;
    let off = DVector::from_iterator(
        numbers.len(),
        numbers.iter().map(|&k| fits.intrinsic()[k] - given.intrinsic[k].mean),
    );
    let mut block =
        DMatrix::from_fn(places.len(), places.len(), |i, j| errors.matrix[(places[i], places[j])]);
    for (i, &k) in numbers.iter().enumerate() {
        block[(i, i)] += given.intrinsic[k].deviation.powi(2);
    }
    let squared = off.dot(&block.cholesky()?.solve(&off));
    Some(normal_of_chi_square(squared, numbers.len() as f64))
}

/// The normal deviate that is as rare as a χ² (the cube-root approximation of Wilson and Hilferty 1931).
fn normal_of_chi_square(squared: f64, freedom: f64) -> f64 {
    let variance = 2.0 / (9.0 * freedom);
    ((squared / freedom).cbrt() - (1.0 - variance)) / variance.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::given::input::INSET;
    use crate::network::model::joint::{Belief, Problem};
    use crate::network::solve::settle::Settled;
    use crate::network::solve::settle::tests::seen;

    /// Four cameras of which all but the clock, the inset and the place is given.
    fn solved(change: impl Fn(usize, &mut Camera)) -> Solved {
        let mut settled = Settled { scale: 0.1, ..seen([0.05; 4]) };
        for (c, camera) in settled.cameras.iter_mut().enumerate() {
            change(c, camera);
        }
        let beliefs: Vec<Beliefs> = settled
            .cameras
            .iter()
            .map(|c| Beliefs {
                intrinsic: [c.log_focal, c.log_aspect, c.principal[0], c.principal[1], 0.0, 0.0, 0.0]
                    .map(Belief::fixed),
                clock: [Belief::fixed(0.0); 2],
                inset: Belief { mean: 0.0, ..INSET },
                posed: false,
            })
            .collect();
        let problem = Problem {
            pairs: &settled.pairs,
            beliefs: &beliefs,
            scale: settled.scale,
            prior_weight: settled.prior_weight,
            moving: vec![true; 4],
        };
        let cameras = problem.solve(&settled.cameras, 30).0;
        let settled = settled.under(&cameras);
        let network = Placed { cameras, placed: vec![true; 4] };
        Solved { network, settled, beliefs, excess: 1.0 }
    }

    #[test]
    fn what_is_right_is_not_contradicted() {
        assert_eq!(contradictions(&solved(|_, _| ()), Shapes::Masks), None);
    }

    #[test]
    fn a_false_focal_length_is_of_its_camera() {
        let false_one = solved(|c, camera| camera.log_focal += if c == 2 { 0.1 } else { 0.0 });
        let found = contradictions(&false_one, Shapes::Masks).unwrap().found;
        let [one] = found[..] else { panic!("{found:?}") };
        assert_eq!((one.camera, one.kind), (2, Kind::Focal));
        // What was given of the others is what they go on with.
        let found = contradictions(&false_one, Shapes::Masks).unwrap().cameras;
        for (c, camera) in found.iter().enumerate() {
            let given = false_one.network.cameras[c].log_focal;
            assert_eq!((camera.log_focal - given).abs() < 1e-12, c != 2, "{c}: {} {given}", camera.log_focal);
        }
    }

    #[test]
    fn two_false_focal_lengths_are_of_their_cameras() {
        let by = [0.0, -0.1, 0.1, 0.0];
        let found = contradictions(&solved(|c, camera| camera.log_focal += by[c]), Shapes::Masks).unwrap();
        let of: Vec<usize> = found.found.iter().map(|c| c.camera).collect();
        assert_eq!(of, [1, 2]);
        let turned_back = found.cameras[1].log_focal - (480_f64.ln() - 0.1);
        assert!((turned_back - 0.1).abs() < 0.01, "{turned_back}");
    }

    #[test]
    fn a_chi_square_is_as_rare_as_a_normal_deviate() {
        // On both sides, and the approximation is a little short of rare ones.
        for (z, one_sided) in [(2.0, 1.69), (4.0, 3.83), (6.0, 5.88)] {
            let found = normal_of_chi_square(f64::powi(z, 2), 1.0);
            assert!((0.9 * one_sided..1.03 * one_sided).contains(&found), "{z}: {found}");
        }
        // Of three numbers 21.1 is as rare as 3.7 of one on one side (p = 1e-4).
        assert!((normal_of_chi_square(21.108, 3.0) - 3.72).abs() < 0.1);
        assert!(normal_of_chi_square(f64::NAN, 3.0).is_nan());
    }
}
