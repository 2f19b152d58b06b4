//! Time packed into the bits of a word: 256 frames are half a cache line per pixel.
//!
//! The barcode of a line over these frames is the OR of the words of its pixels (§2 of the
//! paper asks for the OR of the pixels, frame by frame; here 256 frames are one step). A recording is
//! streamed block by block, so memory is 32 bytes per pixel whatever its length.

use super::transposition::{BitPlanes, TILE};
use super::traversal::Walk;
use crate::image::{ImageSize, Segment};
use rayon::prelude::*;

/// Frames per block. Twice as many take half the steps along lines, a two-hundredth of the time of recording, and 64 MB more for 1920×1080 pixels.
pub const BLOCK_FRAMES: usize = 256;

/// Words per pixel and block.
pub const BLOCK_WORDS: usize = BLOCK_FRAMES / 64;

/// Pixels that one task fills in [`PixelBlock::set_frames`]. Each of its frames is elsewhere in memory, so fewer pixels
/// would change pages more often.
const FILL_PIXELS: usize = 1024 * TILE;

/// Bytes of block whose lines are followed together in [`PixelBlock::unions`]: they stay in the second-level cache.
const BAND_BYTES: usize = 512 << 10;

/// Fewest lines of one task.
const LEAST_LINES: usize = 256;

/// The motion of one pixel in the frames of a block: bit `i % 64` of word `i / 64` is frame `i` of the block.
type PixelWords = [u64; BLOCK_WORDS];

/// Bytes of a cache line; the words of a pixel lie within one.
const CACHE_LINE: usize = 64;

/// The motion of all pixels in the frames of a block.
///
/// Where nothing moves no memory is used: the system gives pages of zeros when they are first written to. That takes plain
/// zeros, as those of an aligned type are written at once, so the first cache line is found by hand.
#[derive(Debug)]
pub struct PixelBlock {
    size: ImageSize,
    words: Vec<u64>,
    /// The word where a cache line begins.
    first: usize,
}

impl Clone for PixelBlock {
    fn clone(&self) -> Self {
        let mut clone = Self::new(self.size);
        clone.pixels_mut().copy_from_slice(self.pixels());
        clone
    }
}

impl PixelBlock {
    /// A block in which nothing moves.
    pub fn new(size: ImageSize) -> Self {
        let words = vec![0u64; size.pixels() * BLOCK_WORDS + CACHE_LINE / size_of::<u64>()];
        let first = words.as_ptr().align_offset(CACHE_LINE).min(CACHE_LINE / size_of::<u64>());
        Self { size, words, first }
    }

    fn pixels(&self) -> &[PixelWords] {
        &self.words[self.first..].as_chunks().0[..self.size.pixels()]
    }

    fn pixels_mut(&mut self) -> &mut [PixelWords] {
        &mut self.words[self.first..].as_chunks_mut().0[..self.size.pixels()]
    }

    /// Adds up to [`BLOCK_FRAMES`] masks, one after the other in `masks`, as the frames from 0 on.
    ///
    /// # Panics
    /// If there are more than [`BLOCK_FRAMES`] masks.
    pub fn set_frames(&mut self, masks: &[u8]) {
        let per_frame = self.size.pixels();
        assert!(masks.len() <= BLOCK_FRAMES * per_frame);
        let tasks = self.pixels_mut().par_chunks_mut(FILL_PIXELS).enumerate();
        tasks.for_each_init(
            || BitPlanes::new(FILL_PIXELS),
            |planes, (task, pixels)| {
                let first = task * FILL_PIXELS;
                for (word, masks) in masks.chunks(64 * per_frame).enumerate() {
                    for (bit, mask) in masks.chunks_exact(per_frame).enumerate() {
                        planes.set_frame(bit, &mask[first..first + pixels.len()]);
                    }
                    for (tile, pixels) in pixels.chunks_mut(TILE).enumerate() {
                        planes.take(tile, |k, frames| pixels[k][word] |= frames);
                    }
                }
            },
        );
    }

    /// Adds 64 frames, as the `word`-th of the block, and empties them.
    ///
    /// # Panics
    /// If the planes are those of another number of pixels, or `word` is not below [`BLOCK_WORDS`].
    pub fn take(&mut self, word: usize, planes: &mut BitPlanes) {
        planes.par_tiles_mut().zip_eq(self.pixels_mut().par_chunks_mut(TILE)).for_each(
            |(mut tile, pixels)| {
                tile.take(|k, frames| pixels[k][word] |= frames);
            },
        );
    }

    /// Forgets all frames.
    pub fn clear(&mut self) {
        self.words = Vec::new();
        *self = Self::new(self.size);
    }

    /// Adds to each pixel of a heat map the number of frames in which it moves.
    pub fn add_heat(&self, heat: &mut [u32]) {
        for (sum, pixel) in heat.iter_mut().zip(self.pixels()) {
            *sum += pixel.iter().map(|word| word.count_ones()).sum::<u32>();
        }
    }

    /// For each segment the frames in which any of its pixels moves.
    ///
    /// Pixels one above the other are far apart in memory, so the lines are followed together through one band of
    /// rows after the other: those that go down from the top, then those that go up from the bottom.
    pub fn unions(&self, segments: &[Segment]) -> Vec<[u64; BLOCK_WORDS]> {
        let mut unions = vec![[0; BLOCK_WORDS]; segments.len()];
        let lines = segments.len().div_ceil(rayon::current_num_threads()).max(LEAST_LINES);
        unions.par_chunks_mut(lines).zip(segments.par_chunks(lines)).for_each(|(unions, segments)| {
            let mut down = Vec::new();
            let mut up = Vec::new();
            for (union, segment) in unions.iter_mut().zip(segments) {
                if let Some(walk) = Walk::new(segment, self.size) {
                    if walk.is_downwards() { &mut down } else { &mut up }.push((walk, union));
                }
            }
            let rows = (BAND_BYTES / (size_of::<PixelWords>() * self.size.width)).max(1);
            let starts = || (0..self.size.height).step_by(rows);
            for first in starts() {
                // Those that begin or end outside the image go with its last band.
                let end = if first + rows < self.size.height { (first + rows) as i64 } else { i64::MAX };
                self.follow(&mut down, |row| row < end);
            }
            for first in starts().rev() {
                let first = if first > 0 { first as i64 } else { i64::MIN };
                self.follow(&mut up, |row| row >= first);
            }
        });
        unions
    }

    /// Follows lines as far as `inside` holds.
    fn follow(&self, lines: &mut [(Walk, &mut [u64; BLOCK_WORDS])], inside: impl Fn(i64) -> bool) {
        let pixels = self.pixels();
        for (walk, union) in lines {
            let mut sum = **union;
            walk.visit_while(&inside, |index| {
                for (sum, word) in sum.iter_mut().zip(pixels[index]) {
                    *sum |= word;
                }
            });
            **union = sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::traversal::for_each_pixel;
    use super::*;

    #[test]
    fn frames_become_bits_and_are_forgotten() {
        let size = ImageSize::new(13, 7).unwrap();
        let mut block = PixelBlock::new(size);
        let mask = |first: usize| -> Vec<u8> { (0..91).map(|i| u8::from(i % 7 == first) * 255).collect() };
        let mut masks = vec![0; BLOCK_FRAMES * 91];
        masks[..91].copy_from_slice(&mask(0));
        masks[(BLOCK_FRAMES - 1) * 91..].copy_from_slice(&mask(3));
        block.set_frames(&masks);
        let mut planes = BitPlanes::new(91);
        planes.set_range(0, 3..5);
        block.take(1, &mut planes);
        block.take(2, &mut planes);
        let mut heat = vec![0; 91];
        block.add_heat(&mut heat);
        assert_eq!(heat[..8], [1, 0, 0, 2, 1, 0, 0, 1]);
        assert_eq!(block.pixels()[3], [0, 1, 0, 1 << 63]);

        let mut same = PixelBlock::new(size);
        same.set_frames(&[mask(1), mask(2)].concat());
        assert_eq!(same.pixels()[1][0], 1);
        assert_eq!(same.pixels()[2][0], 2);

        block.clear();
        block.add_heat(&mut heat);
        assert_eq!(heat.iter().sum::<u32>(), 28);
    }

    /// The frames in which any pixel of a segment moves, pixel by pixel.
    fn union_along(block: &PixelBlock, segment: &Segment) -> [u64; BLOCK_WORDS] {
        let mut union = [0; BLOCK_WORDS];
        for_each_pixel(segment, block.size, |index| {
            for (sum, word) in union.iter_mut().zip(block.pixels()[index]) {
                *sum |= word;
            }
        });
        union
    }

    #[test]
    fn unions_band_by_band_are_those_along_each_line() {
        let size = ImageSize::new(300, 180).unwrap();
        assert!(BAND_BYTES < size_of::<PixelWords>() * size.pixels() / 3, "several bands");
        let mut block = PixelBlock::new(size);
        let mut state = 1u64;
        let mut next = |n: u64| {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (state >> 33) % n
        };
        for _ in 0..3000 {
            let (pixel, bit) = (next(54000) as usize, next(BLOCK_FRAMES as u64) as usize);
            block.pixels_mut()[pixel][bit / 64] |= 1 << (bit % 64);
        }
        // Also from and to places outside the image.
        let mut end = |n: u64| next(n + 40) as f64 - 20.0;
        let segments: Vec<Segment> =
            (0..700).map(|_| Segment { x0: end(300), y0: end(180), x1: end(300), y1: end(180) }).collect();
        let unions = block.unions(&segments);
        assert!(unions.iter().filter(|union| **union != [0; BLOCK_WORDS]).count() > 600);
        for (segment, union) in segments.iter().zip(unions) {
            assert_eq!(union_along(&block, segment), union, "{segment:?}");
        }
    }

    #[test]
    fn pixels_lie_within_cache_lines() {
        for width in [9, 13, 640] {
            let block = PixelBlock::new(ImageSize::new(width, 7).unwrap());
            for block in [&block, &block.clone()] {
                assert_eq!(block.pixels().len(), 7 * width);
                assert_eq!(CACHE_LINE % size_of_val(&block.pixels()[0]), 0);
                assert_eq!(block.pixels().as_ptr().addr() % CACHE_LINE, 0);
            }
        }
    }
}
