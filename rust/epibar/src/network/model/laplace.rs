//! What speaks against beliefs about cameras, with what the cameras may be integrated out.
//!
//! Laplace's approximation (`MacKay` 1992): the cost at the optimum, in nats, the logarithms of the beliefs' widths, and half of that of
//! the determinant of the normal matrix. Where tangents say nothing of a number the last two cancel.

use super::camera::{Camera, INTRINSIC};
use super::invertible::Invertible;
use super::joint::JointProblem;

/// What speaks against the beliefs of a problem, nats, but for what is the same whatever is believed of a camera by itself; NaN where
/// the normal matrix is not usable. The cameras are those that fit best.
pub fn against(problem: &JointProblem, fit: &[Camera]) -> f64 {
    let active = problem.active();
    let linear = problem.linear(fit, &active);
    let determinant = Invertible::of(&linear.normal).map_or(f64::NAN, |normal| normal.log_determinant());
    let width = |&(camera, k): &(usize, usize)| match problem.beliefs[camera].intrinsic.get(k) {
        Some(belief) if belief.deviation.is_finite() => belief.deviation.ln(),
        _ => 0.0,
    };
    let widths: f64 = active.iter().map(width).sum();
    let solved_for = active.iter().filter(|(_, k)| *k < INTRINSIC).count() as f64;
    let nat = problem.prior_weight;
    linear.cost / nat + widths + 0.5 * determinant - 0.5 * solved_for * nat.ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::evidence::alternatives::tests::solved;
    use crate::network::model::beliefs::Belief;
    use crate::network::solve::networks::Solved;

    /// What speaks against a belief of one focal length, about what it is.
    fn with_focal(one: &Solved, deviation: f64) -> f64 {
        let mut beliefs = one.beliefs.clone();
        beliefs[1].intrinsic[0] = Belief::about(one.network.cameras[1].log_focal, deviation);
        against(&one.problem(&beliefs), &one.network.cameras)
    }

    #[test]
    fn a_wider_belief_of_what_tangents_tell_costs_its_width() {
        let mut one = solved(|_, _| ());
        one.settled.prior_weight = 1e-6;
        let with = |deviation: f64| with_focal(&one, deviation);
        // What they tell is far more than either says, so that only the volumes differ.
        assert!((with(0.6) - with(0.3) - 2_f64.ln()).abs() < 1e-3, "{}", with(0.6) - with(0.3));
    }

    #[test]
    fn a_belief_of_what_tangents_do_not_tell_costs_nothing() {
        let mut one = solved(|_, _| ());
        one.settled.prior_weight = 1e9;
        let with = |deviation: f64| with_focal(&one, deviation);
        let given = against(&one.problem(&one.beliefs), &one.network.cameras);
        assert!((with(0.6) - with(0.3)).abs() < 1e-3, "{}", with(0.6) - with(0.3));
        assert!((with(0.6) - given).abs() < 1e-3, "{}", with(0.6) - given);
    }
}
