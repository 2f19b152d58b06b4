//! The median of some numbers and other quantiles, and how far they are from nought by it.

/// The number that a share of them, below 1, are below; `None` of nothing, or where a value is not finite.
pub fn quantile(values: impl Iterator<Item = f64>, share: f64) -> Option<f64> {
    let mut all: Vec<f64> = values.collect();
    if all.is_empty() || all.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let at = (share * all.len() as f64) as usize;
    Some(*all.select_nth_unstable_by(at, f64::total_cmp).1)
}

/// The median; `None` as of [`quantile`].
pub fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    quantile(values, 0.5)
}

/// Robust standard deviation about 0: that of normal deviates with the same median of absolute values; `None` as of [`median`].
pub fn deviation(values: impl Iterator<Item = f64>) -> Option<f64> {
    median(values.map(f64::abs)).map(|middle| 1.4826 * middle)
}
