//! Parts of the network's time, with about as much to compare in each.
//!
//! Where nobody moves nothing is compared, and cameras film for different times by clocks of their own: a share of one camera's film is
//! neither a share of another's nor of what is compared.

/// Parts of the network's time with about as many moments in each, the same for all pairs.
#[derive(Debug, Clone, PartialEq)]
pub struct TimeParts {
    /// When each begins, seconds of the network's time; the first reaches back to all before.
    starts: Vec<f64>,
}

impl TimeParts {
    /// So many parts of the moments at some times, in any order.
    pub fn new(mut times: Vec<f64>, parts: usize) -> Self {
        times.sort_unstable_by(f64::total_cmp);
        let start = |k: usize| times.get(k * times.len() / parts).copied().unwrap_or(0.0);
        Self { starts: (0..parts).map(start).collect() }
    }

    /// The part in which a time lies.
    pub fn of(&self, time: f64) -> usize {
        self.starts.partition_point(|start| *start <= time).saturating_sub(1)
    }

    /// Which parts have any of some moments.
    pub fn occupied(&self, times: &[f64]) -> Vec<bool> {
        let mut found = vec![false; self.starts.len()];
        for time in times {
            found[self.of(*time)] = true;
        }
        found
    }

    /// When a part begins.
    pub fn start(&self, part: usize) -> f64 {
        self.starts[part]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_has_as_many_moments() {
        // Nothing moves for the second half of the time.
        let times: Vec<f64> =
            (0..60).map(|k| f64::from(k) * 0.5).chain([60.0, 61.0, 62.0, 63.0]).rev().collect();
        let parts = TimeParts::new(times.clone(), 8);
        let mut counts = [0; 8];
        for time in &times {
            counts[parts.of(*time)] += 1;
        }
        assert_eq!(counts, [8; 8]);
        assert_eq!((parts.start(0), parts.start(4), parts.of(-5.0), parts.of(100.0)), (0.0, 16.0, 0, 7));
    }

    #[test]
    fn moments_at_one_time_are_in_one_part() {
        assert_eq!(TimeParts::new(Vec::new(), 3).of(1.0), 2);
        let parts = TimeParts::new(vec![2.0; 5], 3);
        assert_eq!(parts.of(2.0), 2);
        assert_eq!(parts.occupied(&[2.0, 9.0]), [false, false, true]);
    }
}
