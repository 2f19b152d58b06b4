//! Least squares over the seven parameters of a fundamental matrix, and what may be unknown beside them, with a robust loss.

use nalgebra::{SMatrix, SVector};

use crate::geometry::seven_parameters::{SevenParameters, Step};

/// What is solved for: a point on a manifold of `N` dimensions.
pub trait Unknowns<const N: usize> {
    /// The point moved by a step.
    #[must_use]
    fn stepped(&self, step: &SVector<f64, N>) -> Self;
}

impl Unknowns<7> for SevenParameters {
    fn stepped(&self, step: &Step) -> Self {
        self.stepped(step)
    }
}

/// A least-squares problem, over the seven parameters where nothing else is said.
pub trait Problem<At = SevenParameters, const N: usize = 7> {
    /// A step that lowers the cost by a smaller share is the last.
    const LEAST_GAIN: f64 = 1e-6;

    /// Robust cost, `JᵀWJ` and `JᵀWr` at a point.
    fn linearise(&self, at: &At) -> (f64, SMatrix<f64, N, N>, SVector<f64, N>);
}

/// Levenberg–Marquardt: at most `iterations` accepted or refused steps, ends where the cost no longer falls.
pub fn minimise<P: Problem<At, N>, At: Unknowns<N>, const N: usize>(
    problem: &P,
    start: At,
    iterations: usize,
) -> (At, f64) {
    let mut at = start;
    let (mut cost, mut normal, mut gradient) = problem.linearise(&at);
    let mut damping = 1e-4;
    for _ in 0..iterations {
        let mut damped = normal;
        for k in 0..N {
            damped[(k, k)] += damping * (normal[(k, k)] + 1e-12);
        }
        let Some(step) = damped.cholesky().map(|c| c.solve(&-gradient)) else {
            damping *= 10.0;
            continue;
        };
        let tried = at.stepped(&step);
        // Most steps are accepted, so the normal equations are worth having at once.
        let (new_cost, new_normal, new_gradient) = problem.linearise(&tried);
        if new_cost < cost {
            let gain = (cost - new_cost) / cost.max(f64::MIN_POSITIVE);
            at = tried;
            (cost, normal, gradient) = (new_cost, new_normal, new_gradient);
            damping = (damping * 0.3).max(1e-9);
            if gain < P::LEAST_GAIN {
                break;
            }
        } else {
            damping *= 8.0;
            if damping > 1e8 {
                break;
            }
        }
    }
    (at, cost)
}

/// Cauchy loss `½ s² ln(1 + r²/s²)` and its weight `1 / (1 + r²/s²)`.
pub fn cauchy(residual: f64, scale: f64) -> (f64, f64) {
    let q = 1.0 + (residual / scale).powi(2);
    (0.5 * scale * scale * q.ln(), 1.0 / q)
}
