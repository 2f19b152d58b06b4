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

/// Rows of A handled together: their barcodes stay in the first-level cache while B streams by.
const ROW_BLOCK: usize = 64;
/// Rows of B handled together.
const COLUMN_BLOCK: usize = 256;

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

    fn threshold(&self) -> f32 {
        if self.entries.len() < self.k { f32::NEG_INFINITY } else { self.entries[self.k - 1].0 }
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
    let n = a.frames as f32;
    let level = Level::available()[0];
    let mut counts = [0u32; COLUMN_BLOCK];
    let mut scores = [0f32; COLUMN_BLOCK];
    for row_start in range.clone().step_by(ROW_BLOCK) {
        let row_end = (row_start + ROW_BLOCK).min(range.end);
        for column_start in (0..b.count).step_by(COLUMN_BLOCK) {
            let column_end = (column_start + COLUMN_BLOCK).min(b.count);
            let block = &stats_b[column_start..column_end];
            for i in row_start..row_end {
                let sa = stats_a[i];
                if sa.scale == 0.0 {
                    continue;
                }
                level.common_counts(a.row(i), b, column_start, &mut counts[..block.len()]);
                for ((score, &count), sb) in scores.iter_mut().zip(&counts).zip(block) {
                    *score = (n * count as f32 - sa.ones * sb.ones) * (sa.scale * sb.scale);
                }
                let best = &mut rows[i - range.start];
                for (offset, &score) in scores[..block.len()].iter().enumerate() {
                    if score > 0.0 {
                        let j = column_start + offset;
                        if score > best.threshold() {
                            best.offer(score, j as u32);
                        }
                        if score > columns[j].threshold() {
                            columns[j].offer(score, i as u32);
                        }
                    }
                }
            }
        }
    }
    (rows, columns)
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

    /// Popcount of the AND of `row` with consecutive rows of `b`, from `first` on.
    fn common_counts(self, row: &[u64], b: &Barcodes, first: usize, counts: &mut [u32]) {
        match self {
            Self::Plain => common_counts(row, b, first, counts),
            // SAFETY: a level exists only where its features were detected, see `available`.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => unsafe { x86::avx2(row, b, first, counts) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => unsafe { x86::avx512(row, b, first, counts) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Barcodes, Level, common_counts};

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
    pub(super) fn avx512(row: &[u64], b: &Barcodes, first: usize, counts: &mut [u32]) {
        common_counts(row, b, first, counts);
    }

    #[target_feature(enable = "avx2,popcnt")]
    pub(super) fn avx2(row: &[u64], b: &Barcodes, first: usize, counts: &mut [u32]) {
        common_counts(row, b, first, counts);
    }
}

#[inline(always)]
#[allow(clippy::inline_always, reason = "the body must be compiled under each target feature")]
fn common_counts(row: &[u64], b: &Barcodes, first: usize, counts: &mut [u32]) {
    for (offset, count) in counts.iter_mut().enumerate() {
        *count = row.iter().zip(b.row(first + offset)).map(|(x, y)| (x & y).count_ones()).sum();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_counts_what_the_bits_say() {
        let mut state = 1u64;
        let mut word = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            state ^ state >> 29
        };
        let levels = Level::available();
        assert_eq!(levels.last(), Some(&Level::Plain));
        // Fewer words than a vector, exactly one, and every remainder beyond.
        for words in (1..=20).chain([64, 157]) {
            let mut b = Barcodes::zeros(23, 64 * words);
            b.bits.fill_with(&mut word);
            let row: Vec<u64> = (0..words).map(|_| word()).collect();
            let bit = |words: &[u64], i: usize| words[i / 64] >> (i % 64) & 1 == 1;
            let expected: Vec<u32> = (3..23)
                .map(|j| (0..64 * words).filter(|&i| bit(&row, i) && bit(b.row(j), i)).count() as u32)
                .collect();
            for &level in &levels {
                let mut counts = vec![u32::MAX; 20];
                level.common_counts(&row, &b, 3, &mut counts);
                assert_eq!(counts, expected, "{level:?}, {words} words");
            }
        }
    }
}
