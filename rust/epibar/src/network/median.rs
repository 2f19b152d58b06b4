//! The median of some numbers.

/// The median; `None` of nothing, or where a value is not finite.
pub fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut all: Vec<f64> = values.collect();
    if all.is_empty() || all.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let middle = all.len() / 2;
    Some(*all.select_nth_unstable_by(middle, f64::total_cmp).1)
}
