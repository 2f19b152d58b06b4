//! How much what was given may be wrong without being contradicted.
//!
//! Between what chance explains and what it does not lies what is half believed: a principal point two or three standard deviations from
//! where it fits best. Held, it turns its camera by what it is off, and errors stated as if it were right say nothing of that. So each
//! alternative has a share, by the Bayes factor of it (Kass and Raftery 1995), as far as it is likelier than before anything was seen, and
//! stated errors count how far it moves the cameras. Where the tangents say nothing, what is given is relied on; and where outlines that
//! are wrong alike speak for an alternative that is next to what was given, as they do of true numbers, it moves nothing.

use std::iter::once;

use super::alternatives::Alternative;
use super::covariance::Covariance;
use crate::network::given::input::IntrinsicKind;
use crate::network::model::camera::{Camera, CameraStep};
use crate::network::thresholds as limits;

/// Something that was given and may be wrong.
#[derive(Debug, Clone)]
pub struct Doubt {
    /// What was given.
    pub kind: IntrinsicKind,
    /// Of which cameras.
    pub cameras: Vec<usize>,
    /// By how much likelier it is now that it is wrong, of 1.
    pub share: f64,
    /// By how much each camera is moved without it.
    pub steps: Vec<CameraStep>,
    /// What is solved for without it.
    active: Vec<(usize, usize)>,
}

/// All of some cameras, of the alternatives to what is given of them of which the evidence says something; each excludes the others.
pub fn doubts(given: &[Camera], alternatives: &[Alternative]) -> Vec<Doubt> {
    let known = || alternatives.iter().filter_map(|one| Some((one.log_evidence?, one)));
    let most = known().map(|(log_evidence, _)| log_evidence).fold(0.0, f64::max);
    let odds = limits::GIVEN_WRONG / (1.0 - limits::GIVEN_WRONG);
    // In units of what the likeliest would have, as that of some is beyond any number.
    let weighed: Vec<(f64, &Alternative)> =
        known().map(|(log_evidence, one)| (odds * (log_evidence - most).exp(), one)).collect();
    let sum = (-most).exp() + weighed.iter().map(|(weight, _)| weight).sum::<f64>();
    let doubt = |(weight, one): (f64, &Alternative)| {
        let share = (weight / sum - limits::GIVEN_WRONG) / (1.0 - limits::GIVEN_WRONG);
        let cameras = one.solved.network.cameras.iter().zip(given);
        let steps: Vec<CameraStep> = cameras.map(|(fits, held)| fits.step_from(held)).collect();
        let active = one.errors.active.clone();
        (share > 0.0).then(|| Doubt { kind: one.kind, cameras: one.freed.clone(), share, steps, active })
    };
    weighed.into_iter().filter_map(doubt).collect()
}

/// Errors where something that was given may be wrong: those that are stated of what is given, and as likely as that is, by how far the
/// cameras are moved without it. What was given of a camera has errors by that as well.
pub fn with_doubts(errors: Covariance, doubts: &[Doubt]) -> Option<Covariance> {
    let relied_on = 1.0 - doubts.iter().map(|doubt| doubt.share).sum::<f64>();
    let moved =
        |doubt: &Doubt| (errors.among(&doubt.active).off_by(|camera, k| doubt.steps[camera][k]), doubt.share);
    let doubted: Vec<(Covariance, f64)> = doubts.iter().map(moved).collect();
    Covariance::of_several(once((errors.off_by(|_, _| 0.0), relied_on)).chain(doubted).collect())
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::network::evidence::alternatives::alternatives;
    use crate::network::evidence::alternatives::tests::solved;
    use crate::network::evidence::outlines::Shapes;
    use crate::network::given::input::AS_SOLD;
    use crate::network::model::camera::{FOCAL, ROTATION};
    use crate::network::solve::principal::Likely;

    #[test]
    fn what_is_false_is_doubted_and_what_is_true_is_not() {
        let doubted = |aside: f64, shapes: Shapes| {
            let mut one = solved(|c, camera| camera.principal[0] += if c == 1 { aside } else { 0.0 });
            // As many tangents as would say ten times as much.
            one.settled.prior_weight *= 0.1;
            let tried = alternatives(&one, &Likely::only(AS_SOLD), shapes);
            let found = doubts(&one.network.cameras, &tried);
            assert!(found.iter().map(|doubt| doubt.share).sum::<f64>() <= 1.0);
            let of_one = |d: &&Doubt| d.kind == IntrinsicKind::PrincipalPoint && d.cameras == [1];
            found.iter().find(of_one).map_or(0.0, |d| d.share)
        };
        assert_eq!(doubted(0.0, Shapes::Masks), 0.0);
        let found = doubted(60.0, Shapes::Masks);
        assert!(found > limits::DOUBT_SAID, "{found}");
        assert_eq!(doubted(60.0, Shapes::Convex), 0.0);
    }

    #[test]
    fn errors_count_what_is_doubted_as_far_as_it_is_likely() {
        let of = |active: &[(usize, usize)], variance: f64| Covariance {
            active: active.to_vec(),
            matrix: DMatrix::from_diagonal_element(active.len(), active.len(), variance),
            off: DVector::zeros(active.len()),
        };
        let errors = of(&[(0, ROTATION)], 1.0);
        assert_eq!(with_doubts(errors.clone(), &[]).unwrap().matrix, errors.matrix);
        let mut step = CameraStep::zeros();
        (step[FOCAL], step[ROTATION]) = (0.1, -3.0);
        let active = vec![(0, FOCAL), (0, ROTATION)];
        let doubt =
            Doubt { kind: IntrinsicKind::Focal, cameras: vec![0], share: 0.25, steps: vec![step], active };
        let found = with_doubts(errors, &[doubt]).unwrap();
        assert_eq!(found.active, [(0, ROTATION), (0, FOCAL)]);
        let expected = [1.0 + 0.25 * 9.0, -0.25 * 0.3, -0.25 * 0.3, 0.25 * 0.01];
        assert!(found.matrix.iter().zip(expected).all(|(p, q)| (p - q).abs() < 1e-12), "{}", found.matrix);
    }
}
