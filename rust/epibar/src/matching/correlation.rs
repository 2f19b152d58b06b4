//! Normalised correlation of packed barcodes and the mutual best pairs (paper §1.3 and §2).
//!
//! For two bit vectors of `N` frames with `a` and `b` ones of which `n₁₁` are common,
//! `r = (N·n₁₁ − a·b) / √(a(N−a)·b(N−b))`: three counts decide it, so the kernel is AND and popcount.
//! The `n₁ × n₂` matrix never exists: each row of A keeps the best few of B and, at the same time, offers itself to
//! the best few of each column.
//!
//! Rows are taken in the order of their counts of ones, because those bound a correlation: `r² ≤ a(N−b) / (b(N−a))` for
//! `a ≤ b`. Each row meets first the columns like it, and later skips those with which it cannot reach
//! what it and they already have.
//!
//! A constant barcode has no variance; its correlation is defined as 0 and it is never matched.

use std::sync::Mutex;

use rayon::prelude::*;

use super::best::{BestFew, NONE_YET};
use super::popcount::{GROUP, Group, Lanes, Level, Row, RowStats, Thresholds, words_of};
use crate::recording::Barcodes;
use crate::{Error, Result};

/// Rows of A that one task compares with all of B.
const ROWS: usize = 128;
/// Bytes of B that are compared with all rows of a task before the next ones: they stay in the first-level cache.
const BLOCK_BYTES: usize = 28 << 10;
/// Pairs that are kept back before the columns are told of them.
const HELD_BACK: usize = 1024;

/// Correlation of two barcodes of `frames` frames from their counts.
pub fn correlation(frames: u32, ones_a: u32, ones_b: u32, common: u32) -> f64 {
    let n = f64::from(frames);
    let (a, b) = (f64::from(ones_a), f64::from(ones_b));
    let variance = a * (n - a) * b * (n - b);
    if variance <= 0.0 {
        return 0.0;
    }
    (n * f64::from(common) - a * b) / variance.sqrt()
}

/// Row index of A, row index of B and their correlation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// Row of A.
    pub a: u32,
    /// Row of B.
    pub b: u32,
    /// Normalised correlation, −1 to 1.
    pub correlation: f32,
    /// The pair is in the mutual top `rank + 1`: the worse of its two places, from 0.
    pub rank: u32,
}

/// Pairs that are in the mutual top `mutual` of each other, best correlation first, at most `limit`.
///
/// Only pairs with positive correlation count. Ties are broken by the lower row index, so the result does
/// not depend on the number of threads.
///
/// # Errors
/// [`Error::Length`] if the barcodes cover different numbers of frames, [`Error::Argument`] if `mutual` is 0.
pub fn mutual_matches(a: &Barcodes, b: &Barcodes, mutual: usize, limit: usize) -> Result<Vec<Match>> {
    if a.frames != b.frames {
        return Err(Error::Length {
            what: "frames of the two sets of barcodes",
            left: a.frames,
            right: b.frames,
        });
    }
    if mutual == 0 {
        return Err(Error::Argument { name: "mutual", value: "0".into(), expected: "at least 1" });
    }
    Ok(matches_at(Level::available()[0], a, b, mutual, limit))
}

fn matches_at(level: Level, a: &Barcodes, b: &Barcodes, mutual: usize, limit: usize) -> Vec<Match> {
    let (stats_a, stats_b) = (stats(a), stats(b));
    let (order_a, columns) = (by_ones(&stats_a), Columns::new(b, &stats_b, mutual));
    let tasks: Vec<&[u32]> = order_a.chunks(ROWS).collect();
    // Few and many ones in turn, so that all columns soon know good rows and can be skipped.
    let mut turns: Vec<usize> = (0..tasks.len()).collect();
    turns.sort_by_key(|task| task.reverse_bits());
    let mut scanned: Vec<(usize, BestFew)> = turns
        .into_par_iter()
        .map(|task| {
            let rows: Vec<Row> = tasks[task]
                .iter()
                .map(|&i| Row::new(a.row(i as usize), a.frames, stats_a[i as usize]))
                .collect();
            (task, scan(level, a.frames as f32, tasks[task], &rows, &columns, mutual))
        })
        .collect();
    scanned.sort_by_key(|(task, _)| *task);

    let columns = columns.finish(b.count);
    let mut matches: Vec<Match> = order_a
        .iter()
        .enumerate()
        .flat_map(|(at, &i)| {
            let columns = &columns;
            scanned[at / ROWS].1.of(at % ROWS).enumerate().filter_map(move |(place, (correlation, j))| {
                let other = columns.place(j, i)?;
                Some(Match { a: i, b: j, correlation, rank: place.max(other) as u32 })
            })
        })
        .collect();
    matches.sort_by(|p, q| q.correlation.total_cmp(&p.correlation).then(p.a.cmp(&q.a)).then(p.b.cmp(&q.b)));
    matches.truncate(limit);
    matches
}

fn stats(barcodes: &Barcodes) -> Vec<RowStats> {
    (0..barcodes.count).into_par_iter().map(|i| RowStats::new(barcodes.frames, barcodes.ones(i))).collect()
}

/// The rows that are not constant, fewest ones first.
fn by_ones(stats: &[RowStats]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..stats.len() as u32).filter(|&i| stats[i as usize].scale > 0.0).collect();
    order.sort_by(|&i, &j| stats[i as usize].ones.total_cmp(&stats[j as usize].ones));
    order
}

/// All rows of B, fewest ones first, with the best rows of A for each.
struct Columns {
    order: Vec<u32>,
    blocks: Vec<Block>,
    groups_per_block: usize,
}

/// Some groups that lie next to one another in the order.
struct Block {
    groups: Vec<Group>,
    best: Mutex<BestFew>,
    /// Middle of the block in the order of odds.
    odds: f32,
}

impl Columns {
    fn new(b: &Barcodes, stats: &[RowStats], mutual: usize) -> Self {
        let order = by_ones(stats);
        let groups_per_block = (BLOCK_BYTES / (4 * GROUP * words_of(b.frames).max(1))).max(1);
        let blocks = order
            .par_chunks(groups_per_block * GROUP)
            .map(|rows| Block {
                groups: rows.chunks(GROUP).map(|rows| Group::new(b, rows, stats)).collect(),
                best: Mutex::new(BestFew::new(rows.len(), mutual)),
                odds: stats[rows[rows.len() / 2] as usize].odds,
            })
            .collect();
        Self { order, blocks, groups_per_block }
    }

    /// Row of B at a place of a block.
    fn row(&self, block: usize, place: usize) -> u32 {
        self.order[block * self.groups_per_block * GROUP + place]
    }

    fn finish(self, count: usize) -> FinishedColumns {
        let mut place_of = vec![u32::MAX; count];
        for (at, &j) in self.order.iter().enumerate() {
            place_of[j as usize] = at as u32;
        }
        let best = self.blocks.into_iter().map(|block| block.best.into_inner().expect(UNPOISONED)).collect();
        FinishedColumns { place_of, best, per_block: self.groups_per_block * GROUP }
    }
}

const UNPOISONED: &str = "a task that panics ends the whole scan";

/// The best rows of A for each row of B.
struct FinishedColumns {
    place_of: Vec<u32>,
    best: Vec<BestFew>,
    per_block: usize,
}

impl FinishedColumns {
    fn place(&self, j: u32, i: u32) -> Option<usize> {
        let at = self.place_of[j as usize] as usize;
        self.best[at / self.per_block].place(at % self.per_block, i)
    }
}

/// Best partners of some rows; the columns are told of them on the way.
fn scan(
    level: Level,
    frames: f32,
    indices: &[u32],
    rows: &[Row],
    columns: &Columns,
    mutual: usize,
) -> BestFew {
    let mut best = BestFew::new(rows.len(), mutual);
    let mut asked = Asked::default();
    let mut scores = Lanes([0.0; GROUP]);
    for block in from_the_likest(&rows[rows.len() / 2].stats, &columns.blocks) {
        asked.ask(&columns.blocks[block]);
        for (r, row) in rows.iter().enumerate() {
            let mut threshold = best.threshold(r);
            for (g, group) in columns.blocks[block].groups.iter().enumerate() {
                if group.bound(frames, &row.stats) < threshold.min(asked.least[g]) {
                    continue;
                }
                let thresholds = Thresholds { row: threshold, columns: &asked.thresholds[g] };
                let hits = level.scores(frames, row, group, thresholds, &mut scores);
                for k in ones_of(hits) {
                    let (score, place) = (scores.0[k], g * GROUP + k);
                    if score >= threshold {
                        best.offer(r, score, columns.row(block, place));
                        threshold = best.threshold(r);
                    }
                    if score >= asked.thresholds[g].0[k] {
                        asked.held_back.push((place as u32, indices[r], score));
                    }
                }
            }
            if asked.held_back.len() > HELD_BACK {
                asked.tell(&columns.blocks[block]);
            }
        }
        asked.tell(&columns.blocks[block]);
    }
    best
}

/// Places of the ones of a word.
fn ones_of(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = (bits != 0).then(|| bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        place
    })
}

/// All blocks, those whose odds are like the row's first.
fn from_the_likest(row: &RowStats, blocks: &[Block]) -> impl Iterator<Item = usize> {
    let mut above = blocks.partition_point(|block| block.odds < row.odds);
    let mut below = above;
    let unlike = |block: usize| {
        let ratio = blocks[block].odds / row.odds;
        ratio.max(1.0 / ratio)
    };
    std::iter::from_fn(move || {
        let up = above < blocks.len() && (below == 0 || unlike(above) <= unlike(below - 1));
        if up {
            above += 1;
            Some(above - 1)
        } else {
            below = below.checked_sub(1)?;
            Some(below)
        }
    })
}

/// What a task knows of the columns of one block, and has not yet told them.
#[derive(Default)]
struct Asked {
    /// A score below this does not concern the column. They only rise, so that old ones cost time, not truth.
    thresholds: Vec<Lanes<f32>>,
    /// The least of each group.
    least: Vec<f32>,
    /// Place in the block, row of A, score.
    held_back: Vec<(u32, u32, f32)>,
}

impl Asked {
    fn ask(&mut self, block: &Block) {
        self.held_back.clear();
        self.tell(block);
    }

    /// Offers what was held back, and asks again what they want.
    fn tell(&mut self, block: &Block) {
        let mut best = block.best.lock().expect(UNPOISONED);
        for (place, row, score) in self.held_back.drain(..) {
            best.offer(place as usize, score, row);
        }
        let groups = block.groups.len();
        self.thresholds.resize(groups, Lanes([NONE_YET; GROUP]));
        self.least.resize(groups, NONE_YET);
        let last = block.groups.iter().map(|group| group.rows).sum::<usize>();
        for g in 0..groups {
            // Places beyond the last row score nought and reach no threshold.
            self.thresholds[g].0.fill(f32::INFINITY);
            for (k, threshold) in self.thresholds[g].0.iter_mut().enumerate().take(last - g * GROUP) {
                *threshold = best.threshold(g * GROUP + k);
            }
            self.least[g] = self.thresholds[g].0.iter().copied().fold(f32::INFINITY, f32::min);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_finds_the_same() {
        let mut state = 3u64;
        let mut barcodes = |count| {
            let mut barcodes = Barcodes::zeros(count, 200);
            for row in 0..count {
                let mut moving = 0;
                for frame in 0..200 {
                    state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
                    moving ^= u64::from(state >> 60 == 0);
                    barcodes.bits[row * barcodes.words_per + frame / 64] |= moving << (frame % 64);
                }
            }
            barcodes
        };
        let (a, b) = (barcodes(700), barcodes(900));
        let levels = Level::available();
        let found = levels.iter().map(|&level| matches_at(level, &a, &b, 4, usize::MAX));
        let found: Vec<Vec<Match>> = found.collect();
        assert!(found[0].len() > 100);
        for (other, level) in found.iter().zip(&levels) {
            assert_eq!(*other, found[0], "{level:?} against {:?}", levels[0]);
        }
    }
}
