//! The stretch of a recording in which most moves.

use std::cmp::Reverse;
use std::ops::Range;

/// The stretch of at most `length` frames in which most are busy; of equals the one that begins closest to `near`.
pub fn fullest(busy: &[bool], length: usize, near: usize) -> Range<usize> {
    let length = busy.len().min(length);
    let mut count = busy[..length].iter().filter(|busy| **busy).count();
    let mut best = (count, Reverse(near), 0);
    for first in 1..=busy.len() - length {
        count = count + usize::from(busy[first + length - 1]) - usize::from(busy[first - 1]);
        best = best.max((count, Reverse(first.abs_diff(near)), first));
    }
    best.2..best.2 + length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn most_is_busy_there_and_of_equals_the_nearest_is_taken() {
        let busy: Vec<bool> = (0..100).map(|k| (70..80).contains(&k)).collect();
        assert_eq!(
            [fullest(&busy, 20, 0), fullest(&busy, 20, 65), fullest(&busy, 20, 99)],
            [60..80, 65..85, 70..90]
        );
        assert_eq!([fullest(&[true; 9], 4, 0), fullest(&[true; 9], 4, 3)], [0..4, 3..7]);
        assert_eq!([fullest(&[false; 3], 8, 0), fullest(&[], 8, 0)], [0..3, 0..0]);
    }
}
