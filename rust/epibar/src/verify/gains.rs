//! Is what one geometry explains more than another in each frame more than chance?

use crate::frontier::Views;
use crate::frontier::symmetric::symmetric_score_by_frame;
use crate::geometry::Fundamental;

/// Blocks of frames that are compared: what one frame shows the next shows nearly so.
pub(super) const BLOCKS: usize = 16;

/// What one geometry explains beside another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// As a share of what the other explains.
    pub share: f64,
    /// By how many standard errors more, over blocks of frames; NaN of too few.
    pub deviate: f64,
}

impl Gain {
    /// Of `f` beside `other`, each at the radius that suits it.
    pub(super) fn of(views: &Views, f: &Fundamental, other: &Fundamental) -> Self {
        let [own, others] = [f, other].map(|f| symmetric_score_by_frame(views, f).1);
        let gains: Vec<f64> = own.iter().zip(&others).map(|(own, other)| own - other).collect();
        let share = own.iter().sum::<f64>() / others.iter().sum::<f64>();
        Self { share, deviate: deviate(&gains) }
    }
}

/// Normal deviate of the mean of gains, by blocks of frames; NaN of too few.
pub(super) fn deviate(gains: &[f64]) -> f64 {
    let blocks: Vec<f64> =
        gains.chunks(gains.len().div_ceil(BLOCKS).max(1)).map(|block| block.iter().sum()).collect();
    let n = blocks.len() as f64;
    let mean = blocks.iter().sum::<f64>() / n;
    let variance = blocks.iter().map(|block| (block - mean).powi(2)).sum::<f64>() / (n - 1.0);
    mean / (variance / n).sqrt()
}
