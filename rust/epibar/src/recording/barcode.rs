//! Motion barcodes: for each line, in which frames something moves on it (paper §2).
//!
//! Bit `i` of a row is frame `i`, packed little-endian: bit `i % 64` of word `i / 64`. Bits beyond the
//! last frame are zero, always, so that whole words can be counted.

use super::barcode_words::{BLOCK_FRAMES, BLOCK_WORDS, PixelBlock};
use super::traversal::is_walkable;
use crate::error::{Error, Result};
use crate::image::{ImageSize, Segment};
use rayon::prelude::*;

/// The barcodes of many lines over the same frames, packed into words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Barcodes {
    pub(crate) count: usize,
    pub(crate) frames: usize,
    pub(crate) words_per: usize,
    /// `count × words_per` words, line after line.
    pub(crate) bits: Vec<u64>,
}

impl Barcodes {
    /// Of words, line after line: bit `i % 64` of word `i / 64` of a line is frame `i`.
    ///
    /// # Errors
    /// [`Error::Damaged`] where there are too many words or too few, or bits behind the last frame.
    pub fn from_words(count: usize, frames: usize, words: Vec<u64>) -> Result<Self> {
        let barcodes = Self { count, frames, words_per: frames.div_ceil(64), bits: words };
        barcodes.validate()?;
        Ok(barcodes)
    }

    /// Something moves on line `i` in frame `k` where `moves(i, k)`; asked line by line.
    pub fn from_fn(count: usize, frames: usize, mut moves: impl FnMut(usize, usize) -> bool) -> Self {
        let mut barcodes = Self::zeros(count, frames);
        for line in 0..count {
            let row = &mut barcodes.bits[line * barcodes.words_per..(line + 1) * barcodes.words_per];
            for frame in 0..frames {
                row[frame / 64] |= u64::from(moves(line, frame)) << (frame % 64);
            }
        }
        barcodes
    }

    /// Number of lines.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Words per line: `frames / 64`, rounded up.
    pub fn words_per(&self) -> usize {
        self.words_per
    }

    /// All words, line after line.
    pub fn words(&self) -> &[u64] {
        &self.bits
    }

    /// Barcodes of lines on which nothing moves.
    pub fn zeros(count: usize, frames: usize) -> Self {
        let words_per = frames.div_ceil(64);
        Self { count, frames, words_per, bits: vec![0; count * words_per] }
    }

    /// Takes over the frames of the `number`-th block of a stream: 256, or those that are left, of every line.
    pub(super) fn put(&mut self, number: usize, lines: &[[u64; BLOCK_WORDS]]) {
        let rows = self.bits.par_chunks_mut(self.words_per.max(1)).zip_eq(lines);
        rows.for_each(|(row, line)| {
            let words = row.chunks_mut(BLOCK_WORDS).nth(number);
            words.into_iter().flatten().zip(line).for_each(|(to, from)| *to = *from);
        });
    }

    /// The words of line `i`.
    ///
    /// # Panics
    /// If there is no such line.
    pub fn row(&self, i: usize) -> &[u64] {
        &self.bits[i * self.words_per..(i + 1) * self.words_per]
    }

    /// In how many frames something moves on line `i`.
    ///
    /// # Panics
    /// If there is no such line.
    pub fn ones(&self, i: usize) -> u32 {
        self.row(i).iter().map(|word| word.count_ones()).sum()
    }

    /// How often the barcode of line `i` changes from one frame to the next.
    ///
    /// # Panics
    /// If there is no such line.
    pub fn transitions(&self, i: usize) -> u32 {
        let row = self.row(i);
        let mut changes = 0;
        let mut before = row.first().map_or(0, |word| word & 1);
        for &word in row {
            changes += (word ^ (word << 1 | before)).count_ones();
            before = word >> 63;
        }
        // Behind the last frame stand zeros, which are not a change of the barcode.
        let last_frame = row.last().map_or(0, |word| word >> ((self.frames + 63) % 64) & 1);
        let padded = !self.frames.is_multiple_of(64);
        changes - u32::from(padded && last_frame == 1)
    }

    /// The barcodes over the given frames, in the given order; frames may repeat.
    ///
    /// Runs of consecutive frames are moved by words, so a range costs no more than a copy.
    ///
    /// # Panics
    /// If there is no such frame.
    #[must_use]
    pub fn select_frames(&self, frames: &[u32]) -> Self {
        let runs: Vec<(usize, usize)> = frames
            .chunk_by(|a, b| a.checked_add(1) == Some(*b))
            .map(|run| (run[0] as usize, run.len()))
            .collect();
        assert!(
            runs.iter().all(|(start, len)| start + len <= self.frames),
            "frame out of range: the barcodes have {} frames",
            self.frames
        );
        let mut selected = Self::zeros(self.count, frames.len());
        let rows = selected.bits.par_chunks_mut(selected.words_per.max(1));
        rows.enumerate().for_each(|(line, target)| {
            let source = self.row(line);
            let mut at = 0;
            for &(start, len) in &runs {
                copy_bits(source, start, target, at, len);
                at += len;
            }
        });
        selected
    }

    /// The barcodes of the given lines, in the given order; lines may repeat.
    ///
    /// # Panics
    /// If there is no such line.
    #[must_use]
    pub fn select_rows(&self, rows: &[u32]) -> Self {
        let mut bits = Vec::with_capacity(rows.len() * self.words_per);
        for &row in rows {
            bits.extend_from_slice(self.row(row as usize));
        }
        Self { count: rows.len(), bits, ..*self }
    }

    /// The lines whose barcodes say enough to be matched, in ascending order.
    pub fn informative(&self, criteria: &Informative) -> Vec<u32> {
        let least = criteria.least(self.frames);
        (0..self.count)
            .into_par_iter()
            .filter(|&i| {
                let ones = self.ones(i) as usize;
                ones >= least.ones
                    && self.frames - ones >= least.zeros
                    && self.transitions(i) >= least.transitions
            })
            .map(|i| i as u32)
            .collect()
    }
}

/// Copies `len` bits into bits that are zero.
fn copy_bits(source: &[u64], start: usize, target: &mut [u64], at: usize, len: usize) {
    let mut done = 0;
    while done < len {
        let (from, to) = (start + done, at + done);
        // Up to the end of the target's word; the source may straddle two.
        let step = (64 - to % 64).min(len - done);
        let shift = from % 64;
        let mut word = source[from / 64] >> shift;
        if shift + step > 64 {
            word |= source[from / 64 + 1] << (64 - shift);
        }
        target[to / 64] |= (word & (u64::MAX >> (64 - step))) << (to % 64);
        done += step;
    }
}

/// What a barcode must have to be worth matching (paper §2).
///
/// The correlation of a barcode that is nearly constant rests on a handful of frames, and one
/// that changes once or twice is matched by any other that changes then. A constant barcode has no correlation at
/// all and is never informative, whatever the criteria.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Informative {
    /// Least share of frames with motion on the line.
    pub min_ones_fraction: f64,
    /// Least share of frames without.
    pub min_zeros_fraction: f64,
    /// Least number of changes from one frame to the next. Short recordings have seen less: no
    /// more than one in 25 frames is asked for, so that 100 frames ask for 4.
    pub min_transitions: u32,
}

impl Default for Informative {
    /// 5 % ones, 5 % zeros (10 frames of 200), 8 transitions (four passages over the line).
    fn default() -> Self {
        Self { min_ones_fraction: 0.05, min_zeros_fraction: 0.05, min_transitions: 8 }
    }
}

/// [`Informative`] for a given number of frames.
struct Least {
    ones: usize,
    zeros: usize,
    transitions: u32,
}

impl Informative {
    fn least(&self, frames: usize) -> Least {
        let share = |fraction: f64| ((fraction * frames as f64).ceil() as usize).max(1);
        Least {
            ones: share(self.min_ones_fraction),
            zeros: share(self.min_zeros_fraction),
            transitions: self.min_transitions.min((frames / 25).max(1) as u32),
        }
    }
}

/// The barcodes of segments over masks in memory, through the same blocks as a streamed recording.
///
/// `masks` holds `frames` row-major masks one after the other, non-zero where something moves. What
/// of a segment lies outside the image is ignored; ends that are not pixel centres are rounded
/// (see [`traversal`](super::traversal)).
///
/// # Errors
/// [`Error::ImageSize`] for an unusable size, [`Error::Length`] where `masks` has another length,
/// [`Error::Argument`] for a segment with an end that is not finite, or absurdly far away.
pub fn barcodes_of_segments(
    masks: &[u8],
    frames: usize,
    size: ImageSize,
    segments: &[Segment],
) -> Result<Barcodes> {
    let size = ImageSize::new(size.width, size.height)?;
    let expected = frames.saturating_mul(size.pixels());
    if masks.len() != expected {
        return Err(Error::Length {
            what: "bytes of masks against frames times pixels",
            left: masks.len(),
            right: expected,
        });
    }
    if let Some(segment) = segments.iter().find(|segment| !is_walkable(segment)) {
        return Err(Error::Argument {
            name: "segments",
            value: format!("{segment:?}"),
            expected: "both ends must be finite and near the image",
        });
    }
    let mut barcodes = Barcodes::zeros(segments.len(), frames);
    let mut block = PixelBlock::new(size);
    for (number, masks) in masks.chunks(BLOCK_FRAMES * size.pixels()).enumerate() {
        block.clear();
        block.set_frames(masks);
        barcodes.put(number, &block.unions(segments));
    }
    Ok(barcodes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn barcodes(rows: &[&[u8]]) -> Barcodes {
        let mut barcodes = Barcodes::zeros(rows.len(), rows[0].len());
        let words_per = barcodes.words_per;
        for (i, row) in rows.iter().enumerate() {
            for (frame, &bit) in row.iter().enumerate() {
                barcodes.bits[i * words_per + frame / 64] |= u64::from(bit) << (frame % 64);
            }
        }
        barcodes
    }

    /// Bits that look random but are the same on every run.
    fn bits(frames: usize, salt: usize) -> Vec<u8> {
        (0..frames)
            .map(|i| ((((i + 7 * salt) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 61) < 3) as u8)
            .collect()
    }

    #[test]
    fn counts_equal_those_of_bits() {
        for frames in [1, 2, 63, 64, 65, 127, 128, 513] {
            for row in [bits(frames, frames), vec![1; frames], vec![0; frames]] {
                let packed = barcodes(&[&bits(frames, 1), &row]);
                let ones: u32 = row.iter().map(|&bit| u32::from(bit)).sum();
                let transitions = row.windows(2).filter(|pair| pair[0] != pair[1]).count();
                assert_eq!(packed.ones(1), ones);
                assert_eq!(packed.transitions(1), transitions as u32, "{frames} frames");
            }
        }
        let none = Barcodes::zeros(3, 0);
        assert_eq!((none.row(2).len(), none.ones(2), none.transitions(2)), (0, 0, 0));
    }

    #[test]
    fn selected_frames_are_those_frames() {
        let rows = [bits(300, 3), bits(300, 4), vec![1; 300]];
        let packed = barcodes(&rows.each_ref().map(Vec::as_slice));
        let choices: [Vec<u32>; 6] = [
            (0..300).collect(),
            (37..261).collect(),
            (0..300).rev().collect(),
            (0..300).filter(|frame| frame % 5 != 2).collect(),
            vec![299, 0, 1, 2, 2, 3, 64, 63],
            vec![],
        ];
        for frames in choices {
            let gathered = rows
                .each_ref()
                .map(|row| -> Vec<u8> { frames.iter().map(|&frame| row[frame as usize]).collect() });
            assert_eq!(packed.select_frames(&frames), barcodes(&gathered.each_ref().map(Vec::as_slice)));
        }
        let rows_too = packed.select_rows(&[2, 0, 2]);
        assert_eq!(rows_too, barcodes(&[&rows[2], &rows[0], &rows[2]]));
    }

    #[test]
    #[should_panic(expected = "the barcodes have 300 frames")]
    fn a_frame_that_is_not_there() {
        let _ = Barcodes::zeros(1, 300).select_frames(&[299, 300]);
    }

    #[test]
    fn what_is_informative() {
        let passages = |frames: usize, length: usize, count: usize| -> Vec<u8> {
            let mut row = vec![0; frames];
            for i in 0..count {
                let start = i * frames / count + 1;
                row[start..start + length].fill(1);
            }
            row
        };
        let inverse = |row: &[u8]| -> Vec<u8> { row.iter().map(|bit| 1 - bit).collect() };
        let rows = [
            passages(1000, 13, 4),           // 52 ones, 8 transitions
            passages(1000, 12, 4),           // 48 ones: too few
            passages(1000, 40, 3),           // 6 transitions: too few
            inverse(&passages(1000, 13, 4)), // 52 zeros
            inverse(&passages(1000, 12, 4)), // too few zeros
        ];
        let packed = barcodes(&rows.each_ref().map(Vec::as_slice));
        assert_eq!(packed.informative(&Informative::default()), [0, 3]);

        // A hundred frames: two passages are enough, one is not, nor is a constant, ever.
        let rows = [passages(100, 3, 2), passages(100, 20, 1), vec![0; 100], vec![1; 100]];
        let packed = barcodes(&rows.each_ref().map(Vec::as_slice));
        assert_eq!(packed.informative(&Informative::default()), [0]);
        let anything = Informative { min_ones_fraction: 0.0, min_zeros_fraction: 0.0, min_transitions: 0 };
        assert_eq!(packed.informative(&anything), [0, 1]);
    }
}
