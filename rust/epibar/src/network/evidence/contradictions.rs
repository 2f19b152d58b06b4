//! Does what was given of a camera agree with what moves?
//!
//! A number that is given is held, and errors are stated as if it were right. So each kind of number is solved for once more in all cameras
//! of which it was given, and in the one alone that gains most by it: where all may be wrong, little is known of each. How far that moves
//! one is compared with its own covariance, the one that errors are stated by (Wald 1943).

use nalgebra::{DMatrix, DVector};

use super::covariance::{Covariance, covariance_with_principal_points};
use super::outlines::{Shapes, outline_errors};
use crate::network::given::input::Kind;
use crate::network::model::camera::{Camera, Step};
use crate::network::model::invertible::Invertible;
use crate::network::model::joint::Beliefs;
use crate::network::solve::networks::Solved;
use crate::network::solve::principal::{self, Likely};
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
    /// Every camera as it is without that, and with what was given of it where that is not contradicted.
    pub cameras: Vec<Camera>,
}

/// What is contradicted; of several kinds the one that explains most, as a wrong focal length asks for another principal point as well.
pub fn contradictions(solved: &Solved, likely: &Likely, shapes: Shapes) -> Option<Contradictions> {
    let cost = solved.problem(&solved.beliefs).cost(&solved.network.cameras);
    let tried = Kind::ALL.into_iter().flat_map(|kind| {
        let given = given(solved, kind);
        let suspected = if given.len() > 1 { suspected(solved, kind, &given) } else { None };
        let alone = suspected.map(|camera| vec![camera]);
        [Some(given), alone].into_iter().flatten().filter_map(move |of| Tried::of(solved, kind, of, cost))
    });
    let contradicted =
        tried.filter_map(|tried| Some((tried.gain, tried.contradicted(solved, likely, shapes)?)));
    contradicted.max_by(|p, q| p.0.total_cmp(&q.0)).map(|(_, found)| found)
}

/// Cameras that stand and of which a kind of number is given.
fn given(solved: &Solved, kind: Kind) -> Vec<usize> {
    let is_given = |&c: &usize| {
        let beliefs = &solved.beliefs[c];
        solved.network.placed[c] && !beliefs.posed && kind.is_given(beliefs)
    };
    (0..solved.beliefs.len()).filter(is_given).collect()
}

/// What is believed where a kind of number is not given of some cameras after all.
fn without(solved: &Solved, kind: Kind, of: &[usize]) -> Vec<Beliefs> {
    let mut beliefs = solved.beliefs.clone();
    for &c in of {
        kind.free(&mut beliefs[c], &solved.network.cameras[c]);
    }
    beliefs
}

/// The camera of which a kind of number is worth most if it is solved for in it alone, to first order: half of `gᵀ S⁻¹ g` with the
/// gradient by its numbers and the normal matrix, both with all others solved for (the score test, Rao 1948).
fn suspected(solved: &Solved, kind: Kind, given: &[usize]) -> Option<usize> {
    let beliefs = without(solved, kind, given);
    let problem = solved.problem(&beliefs);
    let active = problem.active();
    let linear = problem.linear(&solved.network.cameras, &active);
    let is_freed = |(camera, k): &(usize, usize)| given.contains(camera) && kind.parameters().contains(k);
    let [freed, others]: [Vec<usize>; 2] =
        [true, false].map(|is| (0..active.len()).filter(|&i| is_freed(&active[i]) == is).collect());
    let block = |rows: &[usize], columns: &[usize]| {
        DMatrix::from_fn(rows.len(), columns.len(), |i, j| linear.normal[(rows[i], columns[j])])
    };
    let along = |of: &[usize]| DVector::from_fn(of.len(), |i, _| linear.gradient[of[i]]);
    let across = block(&others, &freed);
    let onto = across.tr_mul(&Invertible::of(&block(&others, &others))?.inverse());
    let complement = block(&freed, &freed) - &onto * across;
    let score = along(&freed) - onto * along(&others);
    let worth = |camera: usize| {
        let own: Vec<usize> = (0..freed.len()).filter(|&i| active[freed[i]].0 == camera).collect();
        let score = DVector::from_fn(own.len(), |i, _| score[own[i]]);
        let within = DMatrix::from_fn(own.len(), own.len(), |i, j| complement[(own[i], own[j])]);
        Some(0.5 * score.dot(&within.cholesky()?.solve(&score))).filter(|worth| worth.is_finite())
    };
    let worth = given.iter().filter_map(|&c| Some((c, worth(c)?)));
    worth.max_by(|p, q| p.1.total_cmp(&q.1)).map(|(camera, _)| camera)
}

/// A network with one kind of number solved for in cameras of which it was given.
struct Tried {
    kind: Kind,
    freed: Vec<usize>,
    /// The network, over the tangents that met before.
    solved: Solved,
    /// What that gains, in nats, less one for each number.
    gain: f64,
}

impl Tried {
    /// `None` where it is freed of none, or nothing is gained.
    fn of(given: &Solved, kind: Kind, freed: Vec<usize>, cost: f64) -> Option<Self> {
        if freed.is_empty() {
            return None;
        }
        let beliefs = without(given, kind, &freed);
        let (cameras, without) = given.problem(&beliefs).solve(&given.network.cameras, STEPS);
        let numbers = (freed.len() * kind.parameters().len()) as f64;
        let gain = (cost - without) / given.settled.prior_weight - numbers;
        let network = Placed { cameras, placed: given.network.placed.clone() };
        (gain > 0.0).then(|| Self { kind, freed, solved: Solved { network, beliefs, ..given.clone() }, gain })
    }

    fn contradicted(self, given: &Solved, likely: &Likely, shapes: Shapes) -> Option<Contradictions> {
        let (kind, cameras) = (self.kind, &self.solved.network.cameras);
        let outlines = outline_errors(&given.settled.under(cameras), self.shapes(shapes));
        let errors = covariance_with_principal_points(&self.solved, likely, &outlines)?;
        let of_camera = |&camera: &usize| {
            let deviate = deviate(&given.beliefs[camera], &cameras[camera], &errors, camera, kind)?;
            (deviate >= limits::CONTRADICTED_DEVIATES).then_some(Contradiction { camera, kind, deviate })
        };
        let found: Vec<Contradiction> = self.freed.iter().filter_map(of_camera).collect();
        let mut cameras = self.solved.network.cameras;
        for &c in self.freed.iter().filter(|&&c| found.iter().all(|one| one.camera != c)) {
            cameras[c] = with_given(&cameras[c], &given.network.cameras[c], kind);
        }
        (!found.is_empty()).then_some(Contradictions { found, cameras })
    }

    /// What outlines may be wrong by. Coarse shapes ask for other principal points by themselves, in all cameras; where they no longer do
    /// once this kind is solved for, or the principal point of one camera, it was this.
    fn shapes(&self, shapes: Shapes) -> Shapes {
        let is_of_all = self.kind == Kind::PrincipalPoint && self.freed.len() > 1;
        if shapes != Shapes::Strained || is_of_all || principal::is_strained(&self.solved) {
            return shapes;
        }
        Shapes::Convex
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
        let alike = if kind == Kind::Aspect { limits::ASPECT_ALIKE } else { 0.0 };
        block[(i, i)] += given.intrinsic[k].deviation.powi(2) + alike.powi(2);
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
    use crate::network::given::input::{AS_SOLD, INSET};
    use crate::network::model::joint::{Belief, Problem};
    use crate::network::solve::settle::Settled;
    use crate::network::solve::settle::tests::seen;

    const LIKELY: Likely = Likely::only(AS_SOLD);

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
                centred: false,
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
        assert_eq!(contradictions(&solved(|_, _| ()), &LIKELY, Shapes::Masks), None);
    }

    #[test]
    fn a_false_focal_length_is_of_its_camera() {
        let false_one = solved(|c, camera| camera.log_focal += if c == 2 { 0.1 } else { 0.0 });
        let found = contradictions(&false_one, &LIKELY, Shapes::Masks).unwrap().found;
        let [one] = found[..] else { panic!("{found:?}") };
        assert_eq!((one.camera, one.kind), (2, Kind::Focal));
        // What was given of the others is what they go on with.
        let found = contradictions(&false_one, &LIKELY, Shapes::Masks).unwrap().cameras;
        for (c, camera) in found.iter().enumerate() {
            let given = false_one.network.cameras[c].log_focal;
            assert_eq!((camera.log_focal - given).abs() < 1e-12, c != 2, "{c}: {} {given}", camera.log_focal);
        }
    }

    #[test]
    fn two_false_focal_lengths_are_of_their_cameras() {
        let by = [0.0, -0.1, 0.1, 0.0];
        let found =
            contradictions(&solved(|c, camera| camera.log_focal += by[c]), &LIKELY, Shapes::Masks).unwrap();
        let of: Vec<usize> = found.found.iter().map(|c| c.camera).collect();
        assert_eq!(of, [1, 2]);
        let turned_back = found.cameras[1].log_focal - (480_f64.ln() - 0.1);
        assert!((turned_back - 0.1).abs() < 0.01, "{turned_back}");
    }

    #[test]
    fn a_false_principal_point_is_of_its_camera_though_all_are_given() {
        let aside = |c: usize, camera: &mut Camera| camera.principal[0] += if c == 1 { 60.0 } else { 0.0 };
        let false_one = solved(aside);
        assert_eq!(suspected(&false_one, Kind::PrincipalPoint, &[0, 1, 2, 3]), Some(1));
        let found = contradictions(&false_one, &LIKELY, Shapes::Masks).unwrap().found;
        let [one] = found[..] else { panic!("{found:?}") };
        assert_eq!((one.camera, one.kind), (1, Kind::PrincipalPoint));
        // Shapes that stand for others ask for other principal points in all cameras, and these do in one.
        let shapes = |of: &Solved| {
            let tried = Tried::of(of, Kind::PrincipalPoint, vec![1], f64::INFINITY).unwrap();
            tried.shapes(Shapes::Strained)
        };
        assert_eq!(shapes(&false_one), Shapes::Convex);
        assert_eq!(shapes(&solved(|_, camera| camera.principal[0] += 60.0)), Shapes::Strained);
    }

    #[test]
    fn pixels_that_are_a_little_off_square_may_be_outlines() {
        let of = |aspect: f64| {
            let one = solved(|c, camera| camera.log_aspect += if c == 1 { aspect } else { 0.0 });
            contradictions(&one, &LIKELY, Shapes::Masks).map_or(vec![], |found| found.found)
        };
        assert_eq!(of(0.008), []);
        let [one] = of(0.03)[..] else { panic!("{:?}", of(0.03)) };
        assert_eq!((one.camera, one.kind), (1, Kind::Aspect));
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
