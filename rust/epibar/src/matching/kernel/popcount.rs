//! Correlations of one barcode with many, by AND and popcount.
//!
//! Barcodes are compared in words of 32 frames, and [`GROUP`] rows of B lie side by side, word by word, so that one
//! vector holds one word of many rows and their counts stay in registers.
//!
//! Words in which nothing moves add nothing, so a row of A is a list of its other words. Where it moves most of
//! the time its complement has fewer: `n₁₁(a, b) = b − n₁₁(¬a, b)`. Both are exact.
//!
//! One body is compiled for what CPUs have ([`Level`]); all count integers and then compute the same single-precision
//! formula, so all give the same bits. Where a CPU counts bits of 32-bit lanes (AVX-512 VPOPCNTDQ) counts are kept as
//! such; the others count the bits of bytes (`pshufb` of AVX2, `cnt` of NEON, which every 64-bit ARM has), in bytes
//! for as long as these hold them.

use crate::recording::Barcodes;

/// Rows of B that are compared at once.
pub(super) const GROUP: usize = 64;

/// Frames per word.
const WORD: usize = 32;

/// Words after which bytes that count bits may overflow.
const BYTES_HOLD: usize = 31;

/// Number of words that hold some frames.
pub(super) fn words_of(frames: usize) -> usize {
    frames.div_ceil(WORD)
}

/// The `i`-th word of 32 frames of a row.
fn word(row: &[u64], i: usize) -> u32 {
    (row[i / 2] >> (i % 2 * WORD)) as u32
}

/// What one row needs for a correlation: `(N·n₁₁ − ones·other) · scale · scale_other`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RowStats {
    pub(super) ones: f32,
    /// One over the standard deviation; 0 where a barcode is constant, which makes all its correlations 0.
    pub(super) scale: f32,
    /// √(ones / zeros), which bounds correlations from the counts alone.
    pub(super) odds: f32,
    /// One over the odds.
    inverse_odds: f32,
}

impl RowStats {
    pub(super) fn new(frames: usize, ones: u32) -> Self {
        let (n, ones) = (frames as f64, f64::from(ones));
        let variance = ones * (n - ones);
        let scale = if variance > 0.0 { (1.0 / variance.sqrt()) as f32 } else { 0.0 };
        let odds = (ones / (n - ones)).sqrt() as f32;
        Self { ones: ones as f32, scale, odds, inverse_odds: 1.0 / odds }
    }

    /// What single precision may add to a score with a column whose scale is one.
    fn rounding(&self, frames: f32) -> f32 {
        4.0 * f32::EPSILON * frames * self.ones * self.scale
    }
}

/// A row of A, as the words that count.
pub(super) struct SparseRow {
    pub(super) stats: RowStats,
    /// Index and bits of each word that is not empty.
    words: Vec<(u32, u32)>,
    /// The words are those of the complement.
    complement: bool,
}

impl SparseRow {
    pub(super) fn new(row: &[u64], frames: usize, stats: RowStats) -> Self {
        let count = words_of(frames);
        let plain = |i: usize| word(row, i);
        // Behind the last frame stand zeros in the complement too.
        let valid = |i: usize| u32::MAX >> (WORD - (frames - i * WORD).min(WORD));
        let (mut filled, mut lacking) = (0, 0);
        for i in 0..count {
            filled += usize::from(plain(i) != 0);
            lacking += usize::from(plain(i) != valid(i));
        }
        let complement = lacking < filled;
        let mut words = Vec::with_capacity(filled.min(lacking));
        for i in 0..count {
            let bits = if complement { plain(i) ^ valid(i) } else { plain(i) };
            if bits != 0 {
                words.push((i as u32, bits));
            }
        }
        Self { stats, words, complement }
    }
}

/// One value for each row of a group. Whole cache lines: a vector that straddles two takes twice as long to load.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(super) struct Lanes<T>(pub(super) [T; GROUP]);

/// [`GROUP`] rows of B side by side: word 0 of all of them, then word 1, and so on.
pub(super) struct RowGroup {
    bits: Vec<Lanes<u32>>,
    ones: Lanes<f32>,
    scales: Lanes<f32>,
    /// How many rows there are.
    pub(super) rows: usize,
    pub(super) most_odds: f32,
    most_inverse_odds: f32,
    most_scale: f32,
}

impl RowGroup {
    /// Of at most [`GROUP`] rows, none of them constant; places beyond have a scale of nought, and so no score.
    pub(super) fn new(b: &Barcodes, rows: &[u32], stats: &[RowStats]) -> Self {
        let mut group = Self {
            bits: vec![Lanes([0; GROUP]); words_of(b.frames)],
            ones: Lanes([0.0; GROUP]),
            scales: Lanes([0.0; GROUP]),
            rows: rows.len(),
            most_odds: 0.0,
            most_inverse_odds: 0.0,
            most_scale: 0.0,
        };
        for (k, &row) in rows.iter().enumerate() {
            let RowStats { ones, scale, odds, inverse_odds } = stats[row as usize];
            (group.ones.0[k], group.scales.0[k]) = (ones, scale);
            group.most_odds = group.most_odds.max(odds);
            group.most_inverse_odds = group.most_inverse_odds.max(inverse_odds);
            group.most_scale = group.most_scale.max(scale);
            for (i, words) in group.bits.iter_mut().enumerate() {
                words.0[k] = word(b.row(row as usize), i);
            }
        }
        group
    }

    /// No score of the row with one of the group is above this, rounding included.
    ///
    /// The rarer barcode's ones can at most all be common, which gives r ≤ √(odds / odds') for the smaller over the larger.
    pub(super) fn bound(&self, frames: f32, row: &RowStats) -> f32 {
        let of_counts = (row.odds * self.most_inverse_odds).min(self.most_odds * row.inverse_odds).min(1.0);
        of_counts * (1.0 + 1e-5) + row.rounding(frames) * self.most_scale
    }
}

/// How the kernel is compiled: one for what the CPU has, of which the plain one is the oracle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::matching) enum Level {
    /// What every CPU of the target has.
    Plain,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

/// What a pair's score must reach to count: the threshold of its row or that of its column.
#[derive(Clone, Copy)]
pub(super) struct Thresholds<'a> {
    pub(super) row: f32,
    pub(super) columns: &'a Lanes<f32>,
}

impl Level {
    /// The levels that this CPU has, best first. No other way leads to a level but [`Level::Plain`].
    pub(in crate::matching) fn available() -> Vec<Self> {
        #[cfg(target_arch = "x86_64")]
        let mut levels = x86::available();
        #[cfg(not(target_arch = "x86_64"))]
        let mut levels = Vec::new();
        levels.push(Self::Plain);
        levels
    }

    /// Correlations of `row` with the rows of a group. Bit `k` of the result is set where the `k`-th reaches a
    /// threshold.
    pub(super) fn scores(
        self,
        frames: f32,
        row: &SparseRow,
        group: &RowGroup,
        thresholds: Thresholds,
        scores: &mut Lanes<f32>,
    ) -> u64 {
        match self {
            Self::Plain => compare(frames, row, group, thresholds, scores),
            // SAFETY: a level exists only where its features were detected, see `available`.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => unsafe { x86::avx2(frames, row, group, thresholds, scores) },
            // SAFETY: see `available`, which detects the features of each level.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => unsafe { x86::avx512(frames, row, group, thresholds, scores) },
        }
    }
}

/// Compiled once as it is and once for AVX2.
#[inline(always)]
fn compare(
    frames: f32,
    row: &SparseRow,
    group: &RowGroup,
    thresholds: Thresholds,
    scores: &mut Lanes<f32>,
) -> u64 {
    let counts = count(row, group);
    for (k, score) in scores.0.iter_mut().enumerate() {
        // A count fits into 31 bits, and those convert faster.
        let count = counts[k] as i32 as f32;
        let ones = group.ones.0[k];
        let common = if row.complement { ones - count } else { count };
        *score = (frames * common - row.stats.ones * ones) * (row.stats.scale * group.scales.0[k]);
    }
    let mut hits = 0;
    for (k, (score, column)) in scores.0.iter().zip(&thresholds.columns.0).enumerate() {
        hits |= u64::from(*score >= column.min(thresholds.row)) << k;
    }
    hits
}

/// Common bits of the row's words with each of the group, counted in bytes, which are added up before they overflow.
#[inline(always)]
fn count(row: &SparseRow, group: &RowGroup) -> [u32; GROUP] {
    let mut counts = [0u32; GROUP];
    for words in row.words.chunks(BYTES_HOLD) {
        let mut bytes = [[0u8; 4]; GROUP];
        for &(i, word) in words {
            for (bytes, column) in bytes.iter_mut().zip(&group.bits[i as usize].0) {
                let common = (column & word).to_ne_bytes();
                for (count, byte) in bytes.iter_mut().zip(common) {
                    *count += byte.count_ones() as u8;
                }
            }
        }
        for (count, bytes) in counts.iter_mut().zip(bytes) {
            *count += bytes.iter().map(|&n| u32::from(n)).sum::<u32>();
        }
    }
    counts
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::{
        _CMP_GE_OQ, _mm512_add_epi32, _mm512_and_si512, _mm512_cmp_ps_mask, _mm512_cvtepi32_ps,
        _mm512_load_ps, _mm512_load_si512, _mm512_min_ps, _mm512_mul_ps, _mm512_popcnt_epi32,
        _mm512_set1_epi32, _mm512_set1_ps, _mm512_setzero_si512, _mm512_store_ps, _mm512_sub_ps,
    };

    use super::{GROUP, Lanes, Level, RowGroup, SparseRow, Thresholds, compare};

    /// 32-bit lanes of a register.
    const WIDE: usize = 16;

    pub(super) fn available() -> Vec<Level> {
        let avx512 = is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vpopcntdq");
        let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("popcnt");
        let levels = [(avx512, Level::Avx512), (avx2, Level::Avx2)];
        levels.into_iter().filter_map(|(has, level)| has.then_some(level)).collect()
    }

    #[target_feature(enable = "avx2,popcnt")]
    pub(super) fn avx2(
        frames: f32,
        row: &SparseRow,
        group: &RowGroup,
        thresholds: Thresholds,
        scores: &mut Lanes<f32>,
    ) -> u64 {
        compare(frames, row, group, thresholds, scores)
    }

    /// [`compare`] in registers of 16 lanes, whose bits this CPU counts in one instruction.
    ///
    /// Written out because the compiler finds the counting by itself, but not the rest.
    #[target_feature(enable = "avx512f,avx512vpopcntdq")]
    pub(super) fn avx512(
        frames: f32,
        row: &SparseRow,
        group: &RowGroup,
        thresholds: Thresholds,
        scores: &mut Lanes<f32>,
    ) -> u64 {
        let mut counts = [_mm512_setzero_si512(); GROUP / WIDE];
        for &(i, word) in &row.words {
            let (columns, word) = (&group.bits[i as usize].0, _mm512_set1_epi32(word as i32));
            for (count, lanes) in counts.iter_mut().zip(columns.as_chunks::<WIDE>().0) {
                // SAFETY: 16 aligned values, as `Lanes` begins with a cache line.
                let column = unsafe { _mm512_load_si512(lanes.as_ptr().cast()) };
                *count = _mm512_add_epi32(*count, _mm512_popcnt_epi32(_mm512_and_si512(column, word)));
            }
        }
        let (frames, limit) = (_mm512_set1_ps(frames), _mm512_set1_ps(thresholds.row));
        let (ones_a, scale_a) = (_mm512_set1_ps(row.stats.ones), _mm512_set1_ps(row.stats.scale));
        let mut hits = 0;
        for (g, count) in counts.into_iter().enumerate() {
            let at = g * WIDE;
            // SAFETY: 16 aligned values each, as `Lanes` begins with a cache line.
            let load = |lanes: &Lanes<f32>| unsafe { _mm512_load_ps(lanes.0[at..at + WIDE].as_ptr()) };
            let (ones, scales, columns) = (load(&group.ones), load(&group.scales), load(thresholds.columns));
            let count = _mm512_cvtepi32_ps(count);
            let common = if row.complement { _mm512_sub_ps(ones, count) } else { count };
            let covariance = _mm512_sub_ps(_mm512_mul_ps(frames, common), _mm512_mul_ps(ones_a, ones));
            let score = _mm512_mul_ps(covariance, _mm512_mul_ps(scale_a, scales));
            // SAFETY: 16 aligned values, as `Lanes` begins with a cache line.
            unsafe { _mm512_store_ps(scores.0[at..at + WIDE].as_mut_ptr(), score) };
            let reached = _mm512_cmp_ps_mask::<_CMP_GE_OQ>(score, _mm512_min_ps(columns, limit));
            hits |= u64::from(reached) << at;
        }
        hits
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::correlation::correlation;

    /// Barcodes of which some words are empty, some full and some mixed.
    fn barcodes(count: usize, frames: usize, state: &mut u64) -> Barcodes {
        let mut next = || {
            *state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            *state ^ *state >> 29
        };
        let mut barcodes = Barcodes::zeros(count, frames);
        for (i, word) in barcodes.bits.iter_mut().enumerate() {
            let valid = u64::MAX >> (64 - (frames - i % frames.div_ceil(64) * 64).min(64));
            *word = valid
                & match (next() >> 40) % 5 {
                    0 => 0,
                    1 => u64::MAX,
                    2 => next() | 0xffff_ffff,
                    _ => next(),
                };
        }
        barcodes
    }

    #[test]
    fn every_level_scores_what_the_bits_say() {
        let mut state = 1;
        let levels = Level::available();
        assert_eq!(levels.last(), Some(&Level::Plain));
        let (mut plain, mut flipped) = (0, 0);
        for frames in (2..100).step_by(7).chain([128, 800, 2048, 5001]) {
            let a = barcodes(12, frames, &mut state);
            let b = barcodes(70, frames, &mut state);
            let of = |barcodes: &Barcodes, i| RowStats::new(frames, barcodes.ones(i));
            let stats: Vec<_> = (0..70).map(|j| of(&b, j)).collect();
            let rows: Vec<u32> = (0..70).filter(|&j| stats[j as usize].scale > 0.0).take(61).collect();
            let group = RowGroup::new(&b, &rows, &stats);
            let bit = |words: &[u64], i: usize| words[i / 64] >> (i % 64) & 1 == 1;
            for i in (0..12).filter(|&i| of(&a, i).scale > 0.0) {
                let row = SparseRow::new(a.row(i), frames, of(&a, i));
                *if row.complement { &mut flipped } else { &mut plain } += 1;
                let limits = Lanes([0.3; GROUP]);
                let mut first: Option<[u32; GROUP]> = None;
                for &level in &levels {
                    let mut scores = Lanes([f32::NAN; GROUP]);
                    let thresholds = Thresholds { row: 0.2, columns: &limits };
                    let hits = level.scores(frames as f32, &row, &group, thresholds, &mut scores);
                    let Lanes(scores) = scores;
                    for (k, &j) in rows.iter().enumerate() {
                        let j = j as usize;
                        let common = (0..frames).filter(|&t| bit(a.row(i), t) && bit(b.row(j), t)).count();
                        let expected = correlation(frames as u32, a.ones(i), b.ones(j), common as u32);
                        assert!((f64::from(scores[k]) - expected).abs() < 1e-4, "{level:?}, {frames} frames");
                        assert!(scores[k] <= group.bound(frames as f32, &row.stats));
                    }
                    assert!(scores[rows.len()..].iter().all(|s| *s == 0.0));
                    for (k, score) in scores.iter().enumerate() {
                        assert_eq!(hits >> k & 1 == 1, *score >= 0.2);
                    }
                    let bits = scores.map(f32::to_bits);
                    assert_eq!(*first.get_or_insert(bits), bits, "{level:?} against {:?}", levels[0]);
                }
            }
        }
        assert!(plain > 20 && flipped > 20);
    }
}
