//! Is what one geometry explains more than another in each frame more than chance?

/// Blocks of frames that are compared: what one frame shows the next shows nearly so.
pub(super) const BLOCKS: usize = 16;

/// Normal deviate of the mean of gains, by blocks of frames; NaN of too few.
pub(super) fn deviate(gains: &[f64]) -> f64 {
    let blocks: Vec<f64> =
        gains.chunks(gains.len().div_ceil(BLOCKS).max(1)).map(|block| block.iter().sum()).collect();
    let n = blocks.len() as f64;
    let mean = blocks.iter().sum::<f64>() / n;
    let variance = blocks.iter().map(|block| (block - mean).powi(2)).sum::<f64>() / (n - 1.0);
    mean / (variance / n).sqrt()
}
