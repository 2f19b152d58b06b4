//! The median of some numbers, and how far they are from nought by it.

/// The median; `None` of nothing, or where a value is not finite.
pub fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut all: Vec<f64> = values.collect();
    if all.is_empty() || all.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let middle = all.len() / 2;
    Some(*all.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Robust standard deviation about 0: that of normal deviates with the same median of absolute values; `None` as of [`median`].
pub fn deviation(values: impl Iterator<Item = f64>) -> Option<f64> {
    median(values.map(f64::abs)).map(|middle| 1.4826 * middle)
}
