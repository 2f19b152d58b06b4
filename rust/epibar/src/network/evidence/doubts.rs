//! How much what was given may be wrong without being contradicted.
//!
//! Between what chance explains and what it does not lies what is half believed: a principal point two or three standard deviations from
//! where it fits best. Held, it turns its camera by what it is off, and errors stated as if it were right say nothing of that. So each
//! alternative has a share, by the Bayes factor of it (Kass and Raftery 1995), and stated errors are those of all together, as far as
//! they are likelier than before anything was seen: where the tangents say nothing, what is given is relied on.
//! Of shapes that stand for others nothing is doubted: their outlines are wrong alike everywhere, and ask for other numbers by themselves.

use nalgebra::{DMatrix, DVector};

use super::alternatives::Alternative;
use super::covariance::Covariance;
use super::outlines::Shapes;
use crate::network::given::input::Kind;
use crate::network::model::camera::{Camera, Step};
use crate::network::thresholds as limits;

/// Something that was given and may be wrong.
#[derive(Debug, Clone)]
pub struct Doubt {
    /// What was given.
    pub kind: Kind,
    /// Of which cameras.
    pub cameras: Vec<usize>,
    /// By how much likelier it is now that it is wrong, of 1.
    pub share: f64,
    /// By how much each camera is moved without it.
    pub steps: Vec<Step>,
    /// How well all is known without it.
    errors: Covariance,
}

/// All of some cameras, of the alternatives to what is given of them; each excludes the others. That pixels are square nobody
/// doubts.
pub fn doubts(given: &[Camera], alternatives: &[Alternative], shapes: Shapes) -> Vec<Doubt> {
    let doubted = alternatives.iter().filter(|one| shapes == Shapes::Masks && one.kind != Kind::Aspect);
    let doubted: Vec<&Alternative> = doubted.collect();
    let most = doubted.iter().map(|one| one.log_evidence).fold(0.0, f64::max);
    let odds = limits::GIVEN_WRONG / (1.0 - limits::GIVEN_WRONG);
    // In units of what the likeliest would have, as that of some is beyond any number.
    let weighed = doubted.into_iter().map(|one| (odds * (one.log_evidence - most).exp(), one));
    let weighed: Vec<(f64, &Alternative)> = weighed.collect();
    let sum = (-most).exp() + weighed.iter().map(|(weight, _)| weight).sum::<f64>();
    let doubt = |(weight, one): (f64, &Alternative)| {
        let share = (weight / sum - limits::GIVEN_WRONG) / (1.0 - limits::GIVEN_WRONG);
        let cameras = one.solved.network.cameras.iter().zip(given);
        let steps = cameras.map(|(fits, held)| fits.step_from(held)).collect();
        let errors = one.errors.clone();
        (share > 0.0).then(|| Doubt { kind: one.kind, cameras: one.freed.clone(), share, steps, errors })
    };
    weighed.into_iter().filter_map(doubt).collect()
}

/// Errors where something that was given may be wrong: those of what is given and of every doubt together, each as likely as it is. What
/// was given of a camera has errors by that as well.
pub fn with_doubts(errors: Covariance, doubts: &[Doubt]) -> Covariance {
    let relied_on = 1.0 - doubts.iter().map(|doubt| doubt.share).sum::<f64>();
    let mut active = errors.active.clone();
    for at in doubts.iter().flat_map(|doubt| &doubt.errors.active) {
        if !active.contains(at) {
            active.push(*at);
        }
    }
    let n = active.len();
    let of = |one: &Covariance| {
        let place: Vec<Option<usize>> =
            active.iter().map(|at| one.active.iter().position(|p| p == at)).collect();
        DMatrix::from_fn(n, n, |i, j| match (place[i], place[j]) {
            (Some(p), Some(q)) => one.matrix[(p, q)],
            _ => 0.0,
        })
    };
    let mut matrix = of(&errors) * relied_on;
    for doubt in doubts {
        let step = DVector::from_iterator(n, active.iter().map(|&(c, k)| doubt.steps[c][k]));
        matrix += (of(&doubt.errors) + &step * step.transpose()) * doubt.share;
    }
    Covariance { active, matrix, off: errors.off.resize_vertically(n, 0.0) }
}

#[cfg(test)]
mod tests {
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
            let found = doubts(&one.network.cameras, &tried, shapes);
            assert!(found.iter().map(|doubt| doubt.share).sum::<f64>() <= 1.0);
            let of_one = |d: &&Doubt| d.kind == Kind::PrincipalPoint && d.cameras == [1];
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
        assert_eq!(with_doubts(errors.clone(), &[]).matrix, errors.matrix);
        let mut step = Step::zeros();
        (step[FOCAL], step[ROTATION]) = (0.1, -3.0);
        let wider = of(&[(0, FOCAL), (0, ROTATION)], 4.0);
        let doubt =
            Doubt { kind: Kind::Focal, cameras: vec![0], share: 0.25, steps: vec![step], errors: wider };
        let found = with_doubts(errors, &[doubt]);
        assert_eq!(found.active, [(0, ROTATION), (0, FOCAL)]);
        let expected = [0.75 + 0.25 * (4.0 + 9.0), -0.25 * 0.3, -0.25 * 0.3, 0.25 * (4.0 + 0.01)];
        assert!(found.matrix.iter().zip(expected).all(|(p, q)| (p - q).abs() < 1e-12), "{}", found.matrix);
    }
}
