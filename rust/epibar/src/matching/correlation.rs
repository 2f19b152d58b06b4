//! Normalised correlation of packed barcodes and the mutual best pairs (paper §1.3 and §2).
//!
//! For two bit vectors of `N` frames with `a` and `b` ones of which `n₁₁` are common,
//! `r = (N·n₁₁ − a·b) / √(a(N−a)·b(N−b))`: three counts decide it, so the kernel is AND and popcount.
//! The `n₁ × n₂` matrix never exists: each block of rows of A keeps the best few of B and, at the
//! same time, offers itself to the best few of each column.
//!
//! A constant barcode has no variance; its correlation is defined as 0 and it is never matched.

use rayon::prelude::*;

use crate::recording::Barcodes;
use crate::{Error, Result};

/// Rows of A by which the work is divided.
const ROW_BLOCK: usize = 64;
/// Rows of B handled together.
const COLUMN_BLOCK: usize = 256;
/// Rows of B whose counts are in registers at a time.
const GROUP: usize = 32;

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

/// What one row needs for a correlation: `(N·n₁₁ − ones·other) · scale · scale_other`.
#[derive(Clone, Copy)]
struct RowStats {
    ones: f32,
    scale: f32,
}

fn stats(barcodes: &Barcodes) -> Vec<RowStats> {
    let n = barcodes.frames as f64;
    (0..barcodes.count)
        .map(|i| {
            let ones = f64::from(barcodes.ones(i));
            let variance = ones * (n - ones);
            RowStats {
                ones: ones as f32,
                scale: if variance > 0.0 { (1.0 / variance.sqrt()) as f32 } else { 0.0 },
            }
        })
        .collect()
}

/// The best `k` partners of one row, best first; ties go to the lower index.
#[derive(Clone)]
struct Best {
    k: usize,
    entries: Vec<(f32, u32)>,
}

impl Best {
    fn new(k: usize) -> Self {
        Self { k, entries: Vec::with_capacity(k + 1) }
    }

    fn offer(&mut self, score: f32, index: u32) {
        let at = self.entries.partition_point(|&(s, i)| s > score || (s == score && i < index));
        if at < self.k {
            self.entries.insert(at, (score, index));
            self.entries.truncate(self.k);
        }
    }

    /// Scores up to this are of no interest; only positive ones are.
    fn threshold(&self) -> f32 {
        if self.entries.len() < self.k { 0.0 } else { self.entries[self.k - 1].0 }
    }

    fn place(&self, index: u32) -> Option<usize> {
        self.entries.iter().position(|&(_, i)| i == index)
    }
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
    let (stats_a, stats_b) = (stats(a), stats(b));
    let blocks = a.count.div_ceil(ROW_BLOCK).max(1);
    // A few long tasks: each carries its own column table, merged at the end.
    let tasks = (rayon::current_num_threads() * 4).min(blocks);
    let per_task = blocks.div_ceil(tasks);
    let parts: Vec<(Vec<Best>, Vec<Best>)> = (0..tasks)
        .into_par_iter()
        .map(|task| {
            let first = task * per_task * ROW_BLOCK;
            let last = ((task + 1) * per_task * ROW_BLOCK).min(a.count);
            scan(a, b, &stats_a, &stats_b, first.min(last)..last, mutual)
        })
        .collect();

    let mut columns = vec![Best::new(mutual); b.count];
    let mut rows = Vec::with_capacity(a.count);
    for (part_rows, part_columns) in parts {
        rows.extend(part_rows);
        for (column, part) in columns.iter_mut().zip(part_columns) {
            for (score, index) in part.entries {
                column.offer(score, index);
            }
        }
    }
    let mut matches: Vec<Match> = rows
        .iter()
        .enumerate()
        .flat_map(|(i, best)| {
            let columns = &columns;
            best.entries.iter().enumerate().filter_map(move |(place, &(correlation, j))| {
                let other = columns[j as usize].place(i as u32)?;
                Some(Match { a: i as u32, b: j, correlation, rank: place.max(other) as u32 })
            })
        })
        .collect();
    matches.sort_by(|p, q| q.correlation.total_cmp(&p.correlation).then(p.a.cmp(&q.a)).then(p.b.cmp(&q.b)));
    matches.truncate(limit);
    Ok(matches)
}

/// Best partners of the rows in `range` and, for every row of B, its best partners among them.
fn scan(
    a: &Barcodes,
    b: &Barcodes,
    stats_a: &[RowStats],
    stats_b: &[RowStats],
    range: std::ops::Range<usize>,
    mutual: usize,
) -> (Vec<Best>, Vec<Best>) {
    let mut rows = vec![Best::new(mutual); range.len()];
    let mut columns = vec![Best::new(mutual); b.count];
    let level = Level::available()[0];
    let mut block = ColumnBlock::new(b.words_per);
    let mut scores = [0f32; COLUMN_BLOCK];
    for first in (0..b.count).step_by(COLUMN_BLOCK) {
        block.load(b, stats_b, first);
        for i in range.clone() {
            if stats_a[i].scale == 0.0 {
                continue;
            }
            let best = &mut rows[i - range.start];
            let hits =
                level.scores(a.row(i), a.frames as f32, stats_a[i], &block, best.threshold(), &mut scores);
            for group in (0..COLUMN_BLOCK / GROUP).filter(|g| hits >> g & 1 == 1) {
                let start = group * GROUP;
                for (offset, &score) in scores.iter().enumerate().skip(start).take(GROUP) {
                    let j = first + offset;
                    if score > best.threshold() {
                        best.offer(score, j as u32);
                    }
                    if score > block.thresholds[offset] {
                        columns[j].offer(score, i as u32);
                        block.thresholds[offset] = columns[j].threshold();
                    }
                }
            }
        }
    }
    (rows, columns)
}

/// Rows of B side by side: word `w` of all of them, then word `w + 1`, so that one vector holds one word of many.
struct ColumnBlock {
    words: usize,
    bits: Vec<u64>,
    ones: [f32; COLUMN_BLOCK],
    scales: [f32; COLUMN_BLOCK],
    /// A score up to this does not concern the column: none but positive ones count.
    thresholds: [f32; COLUMN_BLOCK],
}

impl ColumnBlock {
    fn new(words: usize) -> Self {
        Self {
            words,
            bits: vec![0; words * COLUMN_BLOCK],
            ones: [0.0; COLUMN_BLOCK],
            scales: [0.0; COLUMN_BLOCK],
            thresholds: [0.0; COLUMN_BLOCK],
        }
    }

    /// Takes the rows from `first` on; places beyond the last row get a scale of nought, and so never a score.
    fn load(&mut self, b: &Barcodes, stats: &[RowStats], first: usize) {
        self.thresholds.fill(0.0);
        for offset in 0..COLUMN_BLOCK {
            let j = first + offset;
            let (ones, scale) = stats.get(j).map_or((0.0, 0.0), |s| (s.ones, s.scale));
            (self.ones[offset], self.scales[offset]) = (ones, scale);
            for w in 0..self.words {
                self.bits[w * COLUMN_BLOCK + offset] = if j < b.count { b.row(j)[w] } else { 0 };
            }
        }
    }
}

/// How the popcount kernel is compiled: one body for what the CPU has, of which the plain one is the oracle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Level {
    /// What every CPU of the target has.
    Plain,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Level {
    /// The levels that this CPU has, best first. No other way leads to a level but [`Level::Plain`].
    fn available() -> Vec<Self> {
        #[cfg(target_arch = "x86_64")]
        let mut levels = x86::available();
        #[cfg(not(target_arch = "x86_64"))]
        let mut levels = Vec::new();
        levels.push(Self::Plain);
        levels
    }

    /// Correlations of `row` with the rows of a block. Bit `g` of the result is set where group `g` of columns has a
    /// score above `threshold` or above that of its column.
    fn scores(
        self,
        row: &[u64],
        frames: f32,
        stats: RowStats,
        block: &ColumnBlock,
        threshold: f32,
        scores: &mut [f32; COLUMN_BLOCK],
    ) -> u64 {
        match self {
            Self::Plain => correlations(row, frames, stats, block, threshold, scores),
            // SAFETY: a level exists only where its features were detected, see `available`.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => unsafe { x86::avx2(row, frames, stats, block, threshold, scores) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => unsafe { x86::avx512(row, frames, stats, block, threshold, scores) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{COLUMN_BLOCK, ColumnBlock, Level, RowStats, correlations};

    pub(super) fn available() -> Vec<Level> {
        let avx512 = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512vpopcntdq");
        let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("popcnt");
        let levels = [(avx512, Level::Avx512), (avx2, Level::Avx2)];
        levels.into_iter().filter_map(|(has, level)| has.then_some(level)).collect()
    }

    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512vpopcntdq")]
    pub(super) fn avx512(
        row: &[u64],
        frames: f32,
        stats: RowStats,
        block: &ColumnBlock,
        threshold: f32,
        scores: &mut [f32; COLUMN_BLOCK],
    ) -> u64 {
        correlations(row, frames, stats, block, threshold, scores)
    }

    #[target_feature(enable = "avx2,popcnt")]
    pub(super) fn avx2(
        row: &[u64],
        frames: f32,
        stats: RowStats,
        block: &ColumnBlock,
        threshold: f32,
        scores: &mut [f32; COLUMN_BLOCK],
    ) -> u64 {
        correlations(row, frames, stats, block, threshold, scores)
    }
}

#[inline(always)]
#[allow(clippy::inline_always, reason = "the body must be compiled under each target feature")]
fn correlations(
    row: &[u64],
    frames: f32,
    stats: RowStats,
    block: &ColumnBlock,
    threshold: f32,
    scores: &mut [f32; COLUMN_BLOCK],
) -> u64 {
    let mut hits = 0;
    for group in 0..COLUMN_BLOCK / GROUP {
        let at = group * GROUP;
        let mut counts = [0u64; GROUP];
        for (w, word) in row.iter().enumerate() {
            let columns = &block.bits[w * COLUMN_BLOCK + at..][..GROUP];
            for (count, column) in counts.iter_mut().zip(columns) {
                *count += u64::from((word & column).count_ones());
            }
        }
        let mut hit = false;
        for (k, &count) in counts.iter().enumerate() {
            let score = (frames * count as f32 - stats.ones * block.ones[at + k])
                * (stats.scale * block.scales[at + k]);
            scores[at + k] = score;
            hit |= score > threshold.min(block.thresholds[at + k]);
        }
        hits |= u64::from(hit) << group;
    }
    hits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_scores_what_the_bits_say() {
        let mut state = 1u64;
        let mut word = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            state ^ state >> 29
        };
        let levels = Level::available();
        assert_eq!(levels.last(), Some(&Level::Plain));
        for words in (1..=20).chain([64, 157]) {
            // Fewer rows than a block holds.
            let mut b = Barcodes::zeros(83, 64 * words);
            b.bits.fill_with(&mut word);
            let mut a = Barcodes::zeros(1, 64 * words);
            a.bits.fill_with(&mut word);
            let mut block = ColumnBlock::new(words);
            block.load(&b, &stats(&b), 3);
            let bit = |words: &[u64], i: usize| words[i / 64] >> (i % 64) & 1 == 1;
            let frames = 64 * words;
            for &level in &levels {
                let mut scores = [f32::NAN; COLUMN_BLOCK];
                let hits = level.scores(a.row(0), frames as f32, stats(&a)[0], &block, 0.0, &mut scores);
                for j in 3..83 {
                    let common = (0..frames).filter(|&i| bit(a.row(0), i) && bit(b.row(j), i)).count() as u32;
                    let expected = correlation(frames as u32, a.ones(0), b.ones(j), common);
                    assert!((f64::from(scores[j - 3]) - expected).abs() < 1e-4, "{level:?}, {words} words");
                    if expected > 1e-4 {
                        assert_eq!(hits >> ((j - 3) / GROUP) & 1, 1);
                    }
                }
                assert!(scores[80..].iter().all(|s| *s == 0.0));
            }
        }
    }
}
