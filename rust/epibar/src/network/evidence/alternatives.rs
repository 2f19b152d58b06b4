//! Networks in which something that was given of a camera is solved for after all.
//!
//! Each kind of number is, once in all cameras of which it was given, and once in the one alone that gains most by it: where all may
//! be wrong, little is known of each. How far that moves a number is compared with its own covariance, the one that errors are stated
//! by (Wald 1943), and how well the tangents are explained with what they cost.

use std::cell::LazyCell;

use nalgebra::{DMatrix, DVector};

use super::covariance::{Covariance, covariance_with_principal_points};
use super::outlines::{Shapes, outline_errors};
use crate::network::given::input::IntrinsicKind;
use crate::network::model::beliefs::Beliefs;
use crate::network::model::invertible::Invertible;
use crate::network::model::laplace;
use crate::network::solve::networks::Solved;
use crate::network::solve::principal::{self, Likely};
use crate::network::solve::relocate::Placed;
use crate::network::thresholds as limits;

/// Steps of the solver.
const STEPS: usize = 40;

/// A network with one kind of number solved for in cameras of which it was given.
pub struct Alternative {
    /// The kind.
    pub kind: IntrinsicKind,
    /// The cameras of which it is solved for.
    pub freed: Vec<usize>,
    /// The network, over the tangents that met before.
    pub solved: Solved,
    /// What that gains, in nats, less one for each number.
    pub gain: f64,
    /// That gain, less what it costs that the numbers may be anything: the logarithm of the Bayes factor of it against what was given. `None`
    /// where it says nothing: outlines that are wrong alike everywhere, as those of shapes that stand for others, ask for other numbers in all
    /// cameras by themselves, and those that are all too tall for another fy / fx.
    pub log_evidence: Option<f64>,
    /// What was believed before.
    given: Vec<Beliefs>,
    /// How well all is known.
    pub errors: Covariance,
}

/// All of a network that gain something.
pub fn alternatives(solved: &Solved, likely: &Likely, shapes: Shapes) -> Vec<Alternative> {
    let problem = solved.problem(&solved.beliefs);
    let cost = problem.cost(&solved.network.cameras);
    let against = LazyCell::new(|| laplace::against(&problem, &solved.network.cameras));
    let as_given = AsGiven { cost, against: &|| *against };
    let tried = IntrinsicKind::ALL.into_iter().flat_map(|kind| {
        let given = given(solved, kind);
        let suspected = if given.len() > 1 { suspected(solved, kind, &given) } else { None };
        let alone = suspected.map(|camera| vec![camera]);
        [Some(given), alone].into_iter().flatten().map(move |freed| (kind, freed))
    });
    tried.filter_map(|(kind, freed)| Alternative::of(solved, kind, freed, as_given, likely, shapes)).collect()
}

/// Cameras that stand and of which a kind of number is given.
fn given(solved: &Solved, kind: IntrinsicKind) -> Vec<usize> {
    let is_given = |&c: &usize| {
        let beliefs = &solved.beliefs[c];
        solved.network.placed[c] && !beliefs.posed && kind.is_given(beliefs)
    };
    (0..solved.beliefs.len()).filter(is_given).collect()
}

/// What is believed where a kind of number is not given of some cameras after all.
fn without(solved: &Solved, kind: IntrinsicKind, of: &[usize]) -> Vec<Beliefs> {
    let mut beliefs = solved.beliefs.clone();
    for &c in of {
        kind.free(&mut beliefs[c], &solved.network.cameras[c]);
    }
    beliefs
}

/// The camera of which a kind of number is worth most if it is solved for in it alone, to first order: half of `gᵀ S⁻¹ g` with the
/// gradient by its numbers and the normal matrix, both with all others solved for (the score test, Rao 1948).
fn suspected(solved: &Solved, kind: IntrinsicKind, given: &[usize]) -> Option<usize> {
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

/// The network with all that is given held.
#[derive(Clone, Copy)]
struct AsGiven<'a> {
    /// Its cost.
    cost: f64,
    /// What speaks against it, nats, where that is asked for.
    against: &'a dyn Fn() -> f64,
}

impl Alternative {
    /// `None` where it is freed of none, nothing is gained, or how well it is known is not.
    fn of(
        given: &Solved,
        kind: IntrinsicKind,
        freed: Vec<usize>,
        as_given: AsGiven<'_>,
        likely: &Likely,
        shapes: Shapes,
    ) -> Option<Self> {
        if freed.is_empty() {
            return None;
        }
        let beliefs = without(given, kind, &freed);
        let problem = given.problem(&beliefs);
        let (cameras, without) = problem.solve(&given.network.cameras, STEPS);
        let numbers = (freed.len() * kind.parameters().len()) as f64;
        let gain = (as_given.cost - without) / given.settled.prior_weight - numbers;
        if gain.is_nan() || gain <= 0.0 {
            return None;
        }
        let tells = shapes == Shapes::Masks && kind != IntrinsicKind::Aspect && freed.len() == 1;
        let log_evidence = tells.then(|| (as_given.against)() - laplace::against(&problem, &cameras));
        if log_evidence.is_some_and(|nats| !nats.is_finite()) {
            return None;
        }
        let settled = given.settled.under(&cameras);
        let network = Placed { cameras, placed: given.network.placed.clone() };
        let solved = Solved { network, settled, beliefs, ..given.clone() };
        let outlines = outline_errors(&solved.settled, shapes_without(&solved, kind, &freed, shapes));
        let errors = covariance_with_principal_points(&solved, likely, &outlines)?;
        Some(Self { kind, freed, solved, gain, log_evidence, given: given.beliefs.clone(), errors })
    }

    /// How far from what was given the numbers of some of the cameras that are freed are, and the covariance of that; `None` where it is
    /// not known.
    pub fn off(&self, cameras: &[usize]) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let numbers: Vec<(usize, usize)> =
            cameras.iter().flat_map(|&c| self.kind.parameters().iter().map(move |&k| (c, k))).collect();
        let given = |&(c, k): &(usize, usize)| self.given[c].intrinsic[k];
        let off =
            numbers.iter().map(|at| self.solved.network.cameras[at.0].intrinsic()[at.1] - given(at).mean);
        let mut covariance = self.errors.of(&numbers)?;
        let alike = if self.kind == IntrinsicKind::Aspect { limits::ASPECT_ALIKE } else { 0.0 };
        for (i, at) in numbers.iter().enumerate() {
            covariance[(i, i)] += given(at).deviation.powi(2) + alike.powi(2);
        }
        Some((DVector::from_iterator(numbers.len(), off), covariance))
    }
}

/// What outlines may be wrong by once a kind is freed. Coarse shapes ask for other principal points by themselves, in all cameras; where
/// they no longer do once this kind is solved for, or the principal point of one camera, it was this.
fn shapes_without(solved: &Solved, kind: IntrinsicKind, freed: &[usize], shapes: Shapes) -> Shapes {
    let is_of_all = kind == IntrinsicKind::PrincipalPoint && freed.len() > 1;
    if shapes != Shapes::Strained || is_of_all || principal::is_strained(solved) {
        return shapes;
    }
    Shapes::Convex
}

#[cfg(test)]
pub(in crate::network) mod tests {
    use super::*;
    use crate::network::given::input::{AS_SOLD, INSET};
    use crate::network::model::beliefs::{Belief, InsetBeliefs};
    use crate::network::model::camera::Camera;
    use crate::network::model::joint::JointProblem;
    use crate::network::solve::settle::Settled;
    use crate::network::solve::settle::tests::seen;

    /// Four cameras of which all but the clock, the inset and the place is given.
    pub fn solved(change: impl Fn(usize, &mut Camera)) -> Solved {
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
                insets: InsetBeliefs::all_around(Belief { mean: 0.0, ..INSET }),
                centred: false,
                posed: false,
            })
            .collect();
        let problem = JointProblem {
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
    fn who_gains_most_is_suspected_and_outlines_are_not_where_it_explains_them() {
        let false_one = solved(|c, camera| camera.principal[0] += if c == 1 { 60.0 } else { 0.0 });
        assert_eq!(suspected(&false_one, IntrinsicKind::PrincipalPoint, &[0, 1, 2, 3]), Some(1));
        // Shapes that stand for others ask for other principal points in all cameras, and these do in one.
        let shapes = |of: &Solved| {
            let likely = Likely::only(AS_SOLD);
            let (kind, as_given) =
                (IntrinsicKind::PrincipalPoint, AsGiven { cost: f64::INFINITY, against: &|| 0.0 });
            let tried = Alternative::of(of, kind, vec![1], as_given, &likely, Shapes::Strained).unwrap();
            shapes_without(&tried.solved, kind, &tried.freed, Shapes::Strained)
        };
        assert_eq!(shapes(&false_one), Shapes::Convex);
        assert_eq!(shapes(&solved(|_, camera| camera.principal[0] += 60.0)), Shapes::Strained);
    }
}
