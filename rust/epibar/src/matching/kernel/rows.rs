//! Rows of A that meet the columns together, and the best columns that each has met so far.

use std::ops::Range;

use super::best::BestFew;
use super::columns::{Asked, Columns, by_ones, stats};
use super::popcount::{GROUP, Lanes, Level, RowStats, SparseRow, Thresholds};
use crate::bits_of_bytes::ones_of;
use crate::matching::correlation::Match;
use crate::recording::Barcodes;

/// Rows of A that one task compares with columns.
const ROWS: usize = 128;
/// Pairs that are held back before they are offered to the columns.
const HELD_BACK: usize = 1024;

/// Rows that lie next to one another in the order of their counts.
pub(in crate::matching) struct Rows<'a> {
    barcodes: &'a Barcodes,
    columns: &'a Columns,
    indices: Vec<u32>,
    stats: Vec<RowStats>,
    best: BestFew,
}

/// All rows of A that are not constant, those with few and with many ones in turn, so that all columns soon know good
/// rows and can be skipped.
pub(in crate::matching) fn in_turns<'a>(
    a: &'a Barcodes,
    columns: &'a Columns,
    mutual: usize,
) -> Vec<Rows<'a>> {
    let all = stats(a);
    let order = by_ones(&all);
    let mut tasks: Vec<&[u32]> = order.chunks(ROWS).collect();
    let mut turns: Vec<usize> = (0..tasks.len()).collect();
    turns.sort_by_key(|task| task.reverse_bits());
    tasks = turns.into_iter().map(|task| tasks[task]).collect();
    let rows = |rows: &[u32]| Rows {
        barcodes: a,
        columns,
        indices: rows.to_vec(),
        stats: rows.iter().map(|&i| all[i as usize]).collect(),
        best: BestFew::new(rows.len(), mutual),
    };
    tasks.into_iter().map(rows).collect()
}

impl Rows<'_> {
    /// Compares the rows with all columns.
    pub(in crate::matching) fn meet(&mut self, level: Level) {
        let rows: Vec<SparseRow> = (self.indices.iter().zip(&self.stats))
            .map(|(&i, stats)| SparseRow::new(self.barcodes.row(i as usize), self.barcodes.frames, *stats))
            .collect();
        let mut asked = Asked::default();
        for (block, groups) in self.columns.likest_first(&self.stats[self.stats.len() / 2]) {
            asked.ask(self.columns, block, groups.clone());
            for (r, row) in rows.iter().enumerate() {
                self.compare(level, (r, row), groups.clone(), &mut asked);
                if asked.held_back() > HELD_BACK {
                    asked.offer_all(self.columns);
                }
            }
            asked.offer_all(self.columns);
        }
    }

    fn compare(
        &mut self,
        level: Level,
        (r, row): (usize, &SparseRow),
        groups: Range<usize>,
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

    /// Pairs that are among the best of both, once all rows have met the columns.
    pub(in crate::matching) fn mutual(&self) -> impl Iterator<Item = Match> {
        self.indices.iter().enumerate().flat_map(move |(r, &a)| {
            self.best.of(r).enumerate().filter_map(move |(place, (correlation, b))| {
                let other = self.columns.place(b, a)?;
                Some(Match { a, b, correlation, rank: place.max(other) as u32 })
            })
        })
    }
}
