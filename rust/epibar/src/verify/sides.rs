//! The two sides of a moment, between which a camera may have been moved: of pairs here, of networks in `network::evidence::knocks`.

use std::ops::Range;

/// Parts of a recording between which the moment is looked for.
pub const PARTS: usize = 8;
/// The first and the last moment that is asked for, in parts: before and after that too little is left to tell.
pub const MOMENTS: Range<usize> = 2..PARTS - 1;
/// Shifts of the clocks whose evidence is what chance has there.
pub const SHIFTS: usize = 3;

/// Evidence beyond chance of each tangent that could meet.
pub fn rate(excess: f64, ends: f64) -> f64 {
    (excess / ends.max(1.0)).max(0.0)
}

/// Of a shift of the clocks, what its evidence adds to that beyond chance.
pub fn beyond_chance(excess: f64, shift: usize) -> f64 {
    if shift == 0 { excess } else { -excess / SHIFTS as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evidence_is_beyond_chance_and_of_what_could_meet() {
        let sum: f64 = [60.0, 8.0, 9.0, 10.0].into_iter().enumerate().map(|(k, e)| beyond_chance(e, k)).sum();
        assert_eq!((sum, rate(sum, 102.0)), (51.0, 0.5));
        assert_eq!([rate(5.0, 0.0), rate(-5.0, 9.0)], [5.0, 0.0]);
    }
}
