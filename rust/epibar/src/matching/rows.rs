//! Rows of A that meet the columns together, and the best columns that each has met so far.

use std::ops::Range;

use super::best::BestFew;
use super::columns::{Asked, Columns, by_ones, stats};
use super::correlation::Match;
use super::popcount::{GROUP, Lanes, Level, Row, RowStats, Thresholds};
use crate::bits::ones_of;
use crate::recording::Barcodes;

/// Rows of A that one task compares with columns.
const ROWS: usize = 128;
/// Pairs that are kept back before the columns are told of them.
const HELD_BACK: usize = 1024;

/// Rows that lie next to one another in the order of their counts.
pub(super) struct Rows<'a> {
    barcodes: &'a Barcodes,
    columns: &'a Columns,
    indices: Vec<u32>,
    stats: Vec<RowStats>,
    /// The groups of columns that each row has met, and those within its reach.
    met: Vec<Range<usize>>,
    within: Vec<Range<usize>>,
    best: BestFew,
}

/// All rows of A that are not constant, those with few and with many ones in turn, so that all columns soon know good
/// rows and can be skipped.
pub(super) fn in_turns<'a>(
    a: &'a Barcodes,
    columns: &'a Columns,
    mutual: usize,
    floor: f32,
) -> Vec<Rows<'a>> {
    let all = stats(a);
    let order = by_ones(&all);
    let mut tasks: Vec<&[u32]> = order.chunks(ROWS).collect();
    let mut turns: Vec<usize> = (0..tasks.len()).collect();
    turns.sort_by_key(|task| task.reverse_bits());
    tasks = turns.into_iter().map(|task| tasks[task]).collect();
    let best = |rows: &[u32]| BestFew::new(rows.len(), mutual, floor);
    tasks.into_iter().map(|rows| Rows::new(a, columns, rows, &all, best(rows))).collect()
}

impl<'a> Rows<'a> {
    fn new(
        barcodes: &'a Barcodes,
        columns: &'a Columns,
        rows: &[u32],
        all: &[RowStats],
        best: BestFew,
    ) -> Self {
        let stats: Vec<RowStats> = rows.iter().map(|&i| all[i as usize]).collect();
        let met: Vec<Range<usize>> =
            stats.iter().map(|row| columns.likest(row)).map(|group| group..group).collect();
        Self { barcodes, columns, indices: rows.to_vec(), stats, within: met.clone(), met, best }
    }

    /// What rounding may add to a score, for a column with a scale of one.
    pub(super) fn most_rounding(&self) -> f32 {
        let frames = self.barcodes.frames as f32;
        self.stats.iter().map(|row| row.rounding(frames)).fold(0.0, f32::max)
    }

    /// Widens the reach to the columns with which correlations of `reach` are possible; tells how many groups these are in all.
    pub(super) fn widen(&mut self, reach: f32) -> usize {
        for (r, row) in self.stats.iter().enumerate() {
            let (groups, within) = (self.columns.groups(), &mut self.within[r]);
            // Next to one another, as rows and columns are in the order of odds.
            while within.start > 0 && groups[within.start - 1].bound_of_counts(row) >= reach {
                within.start -= 1;
            }
            while within.end < groups.len() && groups[within.end].bound_of_counts(row) >= reach {
                within.end += 1;
            }
        }
        self.within.iter().map(Range::len).sum()
    }

    /// Compares the rows with the columns within reach that they have not met.
    pub(super) fn meet(&mut self, level: Level) {
        if self.within == self.met {
            return;
        }
        let within = self.within.clone();
        let rows: Vec<Row> = (self.indices.iter().zip(&self.stats))
            .map(|(&i, stats)| Row::new(self.barcodes.row(i as usize), self.barcodes.frames, *stats))
            .collect();
        let first = within.iter().map(|groups| groups.start).min().unwrap_or(0);
        let last = within.iter().map(|groups| groups.end).max().unwrap_or(0);
        let mut asked = Asked::default();
        for (block, groups) in self.columns.likest_first(&self.stats[self.stats.len() / 2], first..last) {
            asked.ask(self.columns, block, groups.clone());
            for (r, row) in rows.iter().enumerate() {
                let (met, within) = (&self.met[r], &within[r]);
                let fewer = within.start.max(groups.start)..met.start.min(groups.end);
                let more = met.end.max(groups.start)..within.end.min(groups.end);
                self.compare(level, (r, row), fewer.chain(more), &mut asked);
                if asked.held_back() > HELD_BACK {
                    asked.tell(self.columns);
                }
            }
            asked.tell(self.columns);
        }
        self.met = within;
    }

    fn compare(
        &mut self,
        level: Level,
        (r, row): (usize, &Row),
        groups: impl Iterator<Item = usize>,
        asked: &mut Asked,
    ) {
        let frames = self.barcodes.frames as f32;
        let mut threshold = self.best.threshold(r);
        let mut scores = Lanes([0.0; GROUP]);
        for g in groups {
            let group = &self.columns.groups()[g];
            let (wanted, least) = asked.wanted(g);
            if group.bound(frames, &row.stats) < threshold.min(least) {
                continue;
            }
            let thresholds = Thresholds { row: threshold, columns: wanted };
            for k in ones_of(level.scores(frames, row, group, thresholds, &mut scores)) {
                let score = scores.0[k];
                if score >= threshold {
                    self.best.offer(r, score, self.columns.row(g, k));
                    threshold = self.best.threshold(r);
                }
                asked.hold_back(self.columns, g, k, self.indices[r], score);
            }
        }
    }

    /// Pairs that are among the best of both, as far as these have met.
    pub(super) fn mutual(&self) -> impl Iterator<Item = Match> {
        self.indices.iter().enumerate().flat_map(move |(r, &a)| {
            self.best.of(r).enumerate().filter_map(move |(place, (correlation, b))| {
                let other = self.columns.place(b, a)?;
                Some(Match { a, b, correlation, rank: place.max(other) as u32 })
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::best::POSITIVE;
    use super::super::popcount::rounded_up;
    use super::*;

    #[test]
    fn whatever_correlates_by_more_than_is_certain_has_met() {
        let mut state = 5u64;
        let mut barcodes = |count: usize| {
            let mut barcodes = Barcodes::zeros(count, 150);
            for row in 0..count {
                for frame in 0..150 {
                    state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
                    let moving = (state >> 33) % 100 < 5 + row as u64 % 90;
                    barcodes.bits[row * barcodes.words_per + frame / 64] |= u64::from(moving) << (frame % 64);
                }
            }
            barcodes
        };
        let (a, b) = (barcodes(700), barcodes(900));
        let columns = Columns::new(&b, 2, POSITIVE);
        let mut tasks = in_turns(&a, &columns, 2, POSITIVE);
        let rounding = columns.most_rounding(&tasks);
        let mut before = 0;
        for reach in [0.98, 0.8, 0.5, 0.3, 0.2] {
            let certain = rounded_up(reach, rounding);
            let mut met = 0;
            for rows in &mut tasks {
                met += rows.widen(reach);
                rows.meet(Level::Plain);
                for (row, met) in rows.stats.iter().zip(&rows.met) {
                    for (g, group) in columns.groups().iter().enumerate() {
                        assert!(met.contains(&g) || group.bound(150.0, row) <= certain, "{reach}");
                    }
                }
            }
            assert!(before < met, "{reach}: nobody new");
            before = met;
        }
        let everything: usize = tasks.iter_mut().map(|rows| rows.widen(0.0)).sum();
        assert_eq!(everything, a.count * columns.groups().len());
    }
}
