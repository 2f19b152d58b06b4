//! The best few partners of many rows.

/// Only positive correlations count.
const POSITIVE: f32 = f32::MIN_POSITIVE;

/// For each of some rows its best `k` partners, best first; ties go to the lower index.
///
/// What is kept depends on what was offered, not on the order in which it came.
pub(super) struct BestFew {
    k: usize,
    /// `k` places for each row; an empty one is a score of nought.
    entries: Vec<(f32, u32)>,
}

impl BestFew {
    pub(super) fn new(rows: usize, k: usize) -> Self {
        Self { k, entries: vec![(0.0, u32::MAX); rows * k] }
    }

    /// A score below this cannot be among the best of the row; one that is equal can, for its lower index.
    pub(super) fn threshold(&self, row: usize) -> f32 {
        self.entries[row * self.k + self.k - 1].0.max(POSITIVE)
    }

    /// Takes a positive score if it is among the best.
    pub(super) fn offer(&mut self, row: usize, score: f32, index: u32) {
        let entries = &mut self.entries[row * self.k..][..self.k];
        let better = |entry: (f32, u32)| entry.0 > score || (entry.0 == score && entry.1 < index);
        if better(entries[self.k - 1]) {
            return;
        }
        let mut at = self.k - 1;
        while at > 0 && !better(entries[at - 1]) {
            entries[at] = entries[at - 1];
            at -= 1;
        }
        entries[at] = (score, index);
    }

    /// Score and index of the partners of a row, best first.
    pub(super) fn of(&self, row: usize) -> impl Iterator<Item = (f32, u32)> {
        self.entries[row * self.k..][..self.k].iter().copied().take_while(|entry| entry.0 > 0.0)
    }

    /// At which place an index is among the partners of a row.
    pub(super) fn place(&self, row: usize, index: u32) -> Option<usize> {
        self.of(row).position(|(_, i)| i == index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_are_kept_whatever_the_order() {
        let offers = [(0.5, 4), (0.9, 7), (0.5, 2), (0.1, 0), (0.9, 9), (0.5, 3)];
        for turn in 0..offers.len() {
            let mut best = BestFew::new(2, 4);
            assert_eq!(best.threshold(1), POSITIVE);
            let mut turned = offers;
            turned.rotate_left(turn);
            for (score, index) in turned {
                best.offer(1, score, index);
            }
            assert!(best.of(1).eq([(0.9, 7), (0.9, 9), (0.5, 2), (0.5, 3)]));
            assert_eq!((best.place(1, 2), best.place(1, 4), best.threshold(1)), (Some(2), None, 0.5));
            assert_eq!(best.of(0).count(), 0);
        }
    }
}
