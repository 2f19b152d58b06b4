//! What speaks against beliefs about cameras, with what the cameras may be integrated out.
//!
//! Laplace's approximation (`MacKay` 1992): the cost at the optimum, in nats, the logarithms of the beliefs' widths, and half of that of
//! the determinant of the normal matrix. Where tangents say nothing of a number the last two cancel.

use super::camera::{Camera, INTRINSIC};
use super::invertible::Invertible;
use super::joint::Problem;

/// What speaks against the beliefs of a problem, nats, but for what is the same whatever is believed of a camera by itself; NaN where
/// the normal matrix is not usable. The cameras are those that fit best.
pub fn against(problem: &Problem, fit: &[Camera]) -> f64 {
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
