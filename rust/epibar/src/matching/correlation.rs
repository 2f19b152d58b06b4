//! Normalised correlation of packed barcodes (paper §1.3).
//!
//! For two bit vectors of `N` frames with `a` and `b` ones of which `n₁₁` are common,
//! `r = (N·n₁₁ − a·b) / √(a(N−a)·b(N−b))`: three counts decide it, so the kernel is AND and popcount.
//!
//! A constant barcode has no variance; its correlation is defined as 0 and it is never matched.

/// Correlation of two barcodes of `frames` frames from their counts.
pub fn correlation(frames: u32, ones_a: u32, ones_b: u32, common: u32) -> f64 {
    let n = f64::from(frames);
    let (a, b) = (f64::from(ones_a), f64::from(ones_b));
    let variance = a * (n - a) * b * (n - b);
    if variance <= 0.0 {
        return 0.0;
    }
    (n * f64::from(common) - a * b) / variance.sqrt()
}

/// Row index of A, row index of B and their correlation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// Row of A.
    pub a: u32,
    /// Row of B.
    pub b: u32,
    /// Normalised correlation, −1 to 1.
    pub correlation: f32,
    /// The pair is in the mutual top `rank + 1`: the worse of its two places, from 0.
    pub rank: u32,
}
