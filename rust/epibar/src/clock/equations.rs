//! The equations of a clock and an `F` together, and their solution.

use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

use super::clock::Clock;
use crate::geometry::SevenParameters;
use crate::recording::{RecordedFrame, Recording};
use crate::refine::least_squares::cauchy;
use crate::refine::loss_scale;

/// A walker's outline is off in the same way for several steps.
const BLOCK_SECONDS: f64 = 4.0;
/// Or so short that there are so many.
const FEWEST_BLOCKS: f64 = 30.0;
/// Equations that one thread adds up.
const SUMMED: usize = 512;

type ClockMatrix = SMatrix<f64, 9, 9>;
/// A number for each parameter: the seven of `F`, offset and rate.
pub(super) type ClockVector = SVector<f64, 9>;

/// Standard errors of a clock.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClockError {
    pub(super) offset: f64,
    pub(super) rate: f64,
}

/// The stretch of time that a clock is fitted over.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    /// Seconds by A's clock, from A's first frame.
    start: f64,
    middle: f64,
    half: f64,
    step_b: f64,
}

impl Span {
    pub(super) fn new(a: &Recording, b: &Recording, first: RecordedFrame, last: RecordedFrame) -> Self {
        let (first, last) = (a.times[first.index()], a.times[last.index()]);
        let (start, middle) = (a.times[0], 0.5 * (first + last));
        Self { start, middle, half: (0.5 * (last - first)).max(1e-9), step_b: b.frame_interval() }
    }

    /// −1 at the first frame, 1 at the last.
    pub(super) fn place(&self, time: f64) -> f64 {
        (time - self.middle) / self.half
    }

    /// Seconds that share their error; a short recording keeps enough of them to have a variance.
    pub(super) fn block(&self) -> f64 {
        BLOCK_SECONDS.min(2.0 * self.half / FEWEST_BLOCKS)
    }

    /// A clock moved by `offset` frames in the middle, and by `drift` more at the end.
    pub(super) fn stepped(&self, clock: Clock, offset: f64, drift: f64) -> Clock {
        Clock {
            offset: clock.offset + offset + drift * self.place(self.start),
            rate: clock.rate + drift * self.step_b / self.half,
        }
    }

    pub(super) fn error(&self, covariance: &ClockMatrix) -> ClockError {
        let place = self.place(self.start);
        let offset =
            covariance[(7, 7)] + 2.0 * place * covariance[(7, 8)] + place * place * covariance[(8, 8)];
        ClockError { offset: offset.sqrt(), rate: covariance[(8, 8)].sqrt() * self.step_b / self.half }
    }
}

/// One matched tangent.
pub(super) struct Equation {
    pub(super) residual: f64,
    pub(super) row: ClockVector,
    pub(super) weight: f64,
    pub(super) block: i64,
}

/// Linear equations in the seven parameters of `F`, the offset in the middle and the drift to the end, frames of B.
pub(super) struct ClockEquations {
    pub(super) at: SevenParameters,
    pub(super) span: Span,
    pub(super) radius: f64,
    /// The radius that suits these residuals.
    pub(super) next_radius: f64,
    pub(super) equations: Vec<Equation>,
}

/// Their solution.
pub(super) struct Fit {
    pub(super) step: ClockVector,
    pub(super) covariance: ClockMatrix,
}

impl ClockEquations {
    /// Robust least squares; the covariance takes what a few seconds share as one (the sandwich estimator with clusters).
    pub(super) fn fit(&self, with_rate: bool) -> Option<Fit> {
        const ROUNDS: usize = 8;
        let scale = loss_scale(self.radius);
        let mut step = ClockVector::zeros();
        let mut inverse = ClockMatrix::zeros();
        for _ in 0..ROUNDS {
            let some = |equations: &[Equation]| {
                let (mut normal, mut gradient) = (ClockMatrix::zeros(), ClockVector::zeros());
                for e in equations {
                    let weight = e.weight * cauchy(e.residual + e.row.dot(&step), scale).1;
                    normal.ger(weight, &e.row, &e.row, 1.0);
                    gradient.axpy(weight * e.residual, &e.row, 1.0);
                }
                (normal, gradient)
            };
            // Added up in their order, whatever thread they come from.
            let parts: Vec<(ClockMatrix, ClockVector)> =
                self.equations.par_chunks(SUMMED).map(some).collect();
            let (mut normal, mut gradient) = (ClockMatrix::zeros(), ClockVector::zeros());
            for part in &parts {
                normal += part.0;
                gradient += part.1;
            }
            if !with_rate {
                normal.row_mut(8).fill(0.0);
                normal.column_mut(8).fill(0.0);
                normal[(8, 8)] = 1.0;
                gradient[8] = 0.0;
            }
            inverse = normal.try_inverse()?;
            step = -(inverse * gradient);
        }
        let mut meat = ClockMatrix::zeros();
        let mut count = 0.0;
        for block in self.equations.chunk_by(|p, q| p.block == q.block) {
            let mut gradient = ClockVector::zeros();
            for e in block {
                let residual = e.residual + e.row.dot(&step);
                gradient.axpy(e.weight * cauchy(residual, scale).1 * residual, &e.row, 1.0);
            }
            if !with_rate {
                gradient[8] = 0.0;
            }
            meat.ger(1.0, &gradient, &gradient, 1.0);
            count += 1.0;
        }
        let covariance = inverse * meat * inverse * (count / (count - 9.0f64).max(1.0));
        let finite = step.iter().chain(covariance.iter()).all(|v| v.is_finite());
        finite.then_some(Fit { step, covariance })
    }
}
