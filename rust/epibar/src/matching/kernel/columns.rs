//! The rows of B, side by side for the kernel, and the best rows of A that each has met so far.

use std::ops::Range;
use std::sync::Mutex;

use rayon::prelude::*;

use super::best::BestFew;
use super::popcount::{GROUP, Lanes, RowGroup, RowStats, words_of};
use crate::recording::Barcodes;

/// Bytes of B that are compared with all rows of a task before the next ones: they stay in the first-level cache.
const BLOCK_BYTES: usize = 28 << 10;

const UNPOISONED: &str = "a task that panics ends the whole scan";

/// All rows of B that are not constant, fewest ones first.
pub(in crate::matching) struct Columns {
    order: Vec<u32>,
    /// At which place of the order a row of B stands.
    places: Vec<u32>,
    groups: Vec<RowGroup>,
    /// Of each block of groups the best rows of A for each of its columns.
    best: Vec<Mutex<BestFew>>,
    groups_per_block: usize,
}

/// What the counts of the rows say.
pub(super) fn stats(barcodes: &Barcodes) -> Vec<RowStats> {
    (0..barcodes.count).into_par_iter().map(|i| RowStats::new(barcodes.frames, barcodes.ones(i))).collect()
}

/// The rows that are not constant, fewest ones first.
pub(super) fn by_ones(stats: &[RowStats]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..stats.len() as u32).filter(|&i| stats[i as usize].scale > 0.0).collect();
    order.sort_by(|&i, &j| stats[i as usize].ones.total_cmp(&stats[j as usize].ones));
    order
}

impl Columns {
    pub(in crate::matching) fn new(b: &Barcodes, mutual: usize) -> Self {
        let stats = stats(b);
        let order = by_ones(&stats);
        let mut places = vec![u32::MAX; b.count];
        for (at, &j) in order.iter().enumerate() {
            places[j as usize] = at as u32;
        }
        let groups_per_block = (BLOCK_BYTES / (4 * GROUP * words_of(b.frames).max(1))).max(1);
        let groups = order.par_chunks(GROUP).map(|rows| RowGroup::new(b, rows, &stats)).collect();
        let best = order
            .chunks(groups_per_block * GROUP)
            .map(|rows| Mutex::new(BestFew::new(rows.len(), mutual)))
            .collect();
        Self { order, places, groups, best, groups_per_block }
    }

    pub(super) fn groups(&self) -> &[RowGroup] {
        &self.groups
    }

    /// Row of B in a group.
    pub(super) fn row(&self, group: usize, lane: usize) -> u32 {
        self.order[group * GROUP + lane]
    }

    /// All blocks and their groups, those whose odds are like the row's first.
    pub(super) fn likest_first(&self, row: &RowStats) -> Vec<(usize, Range<usize>)> {
        let (per, count) = (self.groups_per_block, self.groups.len());
        let mut blocks: Vec<(usize, Range<usize>)> = (0..count.div_ceil(per))
            .map(|block| (block, block * per..count.min((block + 1) * per)))
            .collect();
        let unlike = |groups: &Range<usize>| {
            let ratio = self.groups[groups.start.midpoint(groups.end)].most_odds / row.odds;
            ratio.max(1.0 / ratio)
        };
        blocks.sort_by(|(_, p), (_, q)| unlike(p).total_cmp(&unlike(q)));
        blocks
    }

    /// At which place the row of A stands for the row of B.
    pub(super) fn place(&self, j: u32, i: u32) -> Option<usize> {
        let per = self.groups_per_block * GROUP;
        let at = self.places[j as usize] as usize;
        self.best[at / per].lock().expect(UNPOISONED).place(at % per, i)
    }
}

/// What a task knows of the columns of some groups of a block, and scores that it has not yet offered them.
#[derive(Default)]
pub(super) struct Asked {
    block: usize,
    groups: Range<usize>,
    /// A score below this does not concern the column. They only rise, so that old ones cost time, not truth.
    thresholds: Vec<Lanes<f32>>,
    /// The least of each group.
    least: Vec<f32>,
    /// Place in the block, row of A, score.
    held_back: Vec<(u32, u32, f32)>,
}

impl Asked {
    /// What the groups of a block want.
    pub(super) fn ask(&mut self, columns: &Columns, block: usize, groups: Range<usize>) {
        (self.block, self.groups) = (block, groups);
        self.held_back.clear();
        self.offer_all(columns);
    }

    /// What a score must reach to concern a column of the group, and the least of these.
    pub(super) fn wanted(&self, group: usize) -> (&Lanes<f32>, f32) {
        (&self.thresholds[group - self.groups.start], self.least[group - self.groups.start])
    }

    /// Keeps a score if it concerns the column.
    pub(super) fn hold_back(&mut self, columns: &Columns, group: usize, lane: usize, row: u32, score: f32) {
        if score < self.wanted(group).0.0[lane] {
            return;
        }
        let place = (group - self.block * columns.groups_per_block) * GROUP + lane;
        self.held_back.push((place as u32, row, score));
    }

    pub(super) fn held_back(&self) -> usize {
        self.held_back.len()
    }

    /// Offers what was held back, and asks again what they want.
    pub(super) fn offer_all(&mut self, columns: &Columns) {
        let mut best = columns.best[self.block].lock().expect(UNPOISONED);
        for (place, row, score) in self.held_back.drain(..) {
            best.offer(place as usize, score, row);
        }
        self.thresholds.clear();
        self.least.clear();
        let first = self.block * columns.groups_per_block;
        for g in self.groups.clone() {
            // Places beyond the last row score nought and reach no threshold.
            let mut thresholds = Lanes([f32::INFINITY; GROUP]);
            for (k, threshold) in thresholds.0.iter_mut().enumerate().take(columns.groups[g].rows) {
                *threshold = best.threshold((g - first) * GROUP + k);
            }
            self.least.push(thresholds.0.iter().copied().fold(f32::INFINITY, f32::min));
            self.thresholds.push(thresholds);
        }
    }
}
