//! Time packed into the bits of a word: 512 frames are one 64-byte cache line per pixel.
//!
//! The barcode of a line over these frames is the OR of the cache lines of its pixels (§2 of the
//! paper asks for the OR of the pixels, frame by frame; here 512 frames are one step). A recording is
//! streamed block by block, so memory is 64 bytes per pixel whatever its length.

use super::traversal::for_each_pixel;
use crate::line::{ImageSize, Segment};
use rayon::prelude::*;
use std::ops::Range;

/// Frames per block.
pub const BLOCK_FRAMES: usize = 512;

/// Words per pixel and block.
pub const BLOCK_WORDS: usize = BLOCK_FRAMES / 64;

/// Pixels that one task fills in [`PixelBlock::set_frames`]: 256 KiB of block, which stays in cache.
const FILL_PIXELS: usize = 4096;

/// The motion of one pixel in 512 frames: bit `i % 64` of word `i / 64` is frame `i` of the block.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct PixelWords([u64; BLOCK_WORDS]);

/// The motion of all pixels in 512 frames.
#[derive(Debug, Clone)]
pub struct PixelBlock {
    size: ImageSize,
    pixels: Vec<PixelWords>,
}

impl PixelBlock {
    /// A block in which nothing moves.
    pub fn new(size: ImageSize) -> Self {
        Self { size, pixels: vec![PixelWords([0; BLOCK_WORDS]); size.pixels()] }
    }

    /// Adds the non-zero pixels of a row-major mask as frame `bit` of the block and returns how many
    /// there are. Bits that are set stay set: [`clear`](Self::clear) before the next 512 frames.
    ///
    /// # Panics
    /// If `bit` is not below [`BLOCK_FRAMES`].
    pub fn set_frame(&mut self, bit: usize, mask: &[u8]) -> usize {
        set_frame(&mut self.pixels, bit, mask)
    }

    /// Adds up to 512 masks, one after the other in `masks`, as the frames from 0 on.
    ///
    /// # Panics
    /// If there are more than [`BLOCK_FRAMES`] masks.
    pub fn set_frames(&mut self, masks: &[u8]) {
        let per_frame = self.size.pixels();
        let tasks = self.pixels.par_chunks_mut(FILL_PIXELS).enumerate();
        tasks.for_each(|(task, pixels)| {
            let first = task * FILL_PIXELS;
            for (bit, mask) in masks.chunks_exact(per_frame).enumerate() {
                set_frame(pixels, bit, &mask[first..first + pixels.len()]);
            }
        });
    }

    /// Adds the pixels of a range of row-major indices as moving in frame `bit`.
    ///
    /// # Panics
    /// If `bit` is not below [`BLOCK_FRAMES`] or the range not inside the image.
    #[inline]
    pub fn set_range(&mut self, bit: usize, range: Range<usize>) {
        let (word, value) = (bit / 64, 1 << (bit % 64));
        for pixel in &mut self.pixels[range] {
            pixel.0[word] |= value;
        }
    }

    /// Forgets all frames.
    pub fn clear(&mut self) {
        self.pixels.fill(PixelWords([0; BLOCK_WORDS]));
    }

    /// Adds to each pixel of a heat map the number of frames in which it moves.
    pub fn add_heat(&self, heat: &mut [u32]) {
        for (sum, pixel) in heat.iter_mut().zip(&self.pixels) {
            *sum += pixel.0.iter().map(|word| word.count_ones()).sum::<u32>();
        }
    }

    /// The frames in which any pixel of the segment moves.
    #[inline]
    pub fn union_along(&self, segment: &Segment) -> [u64; BLOCK_WORDS] {
        let mut union = [0; BLOCK_WORDS];
        for_each_pixel(segment, self.size, |index| {
            for (sum, word) in union.iter_mut().zip(self.pixels[index].0) {
                *sum |= word;
            }
        });
        union
    }

    /// [`union_along`](Self::union_along) for many segments, in parallel.
    pub fn unions(&self, segments: &[Segment]) -> Vec<[u64; BLOCK_WORDS]> {
        segments.par_iter().map(|segment| self.union_along(segment)).collect()
    }
}

fn set_frame(pixels: &mut [PixelWords], bit: usize, mask: &[u8]) -> usize {
    let (word, value) = (bit / 64, 1 << (bit % 64));
    let mut moving = 0;
    // Most of a mask is zero: look at eight pixels at a time.
    for (pixels, mask) in pixels.chunks_mut(8).zip(mask.chunks(8)) {
        if mask.iter().any(|&v| v != 0) {
            for (pixel, _) in pixels.iter_mut().zip(mask).filter(|(_, v)| **v != 0) {
                pixel.0[word] |= value;
                moving += 1;
            }
        }
    }
    moving
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_become_bits_and_are_forgotten() {
        let size = ImageSize::new(13, 7).unwrap();
        let mut block = PixelBlock::new(size);
        let mask = |first: usize| -> Vec<u8> { (0..91).map(|i| u8::from(i % 7 == first) * 255).collect() };
        assert_eq!(block.set_frame(0, &mask(0)), 13);
        assert_eq!(block.set_frame(511, &mask(3)), 13);
        block.set_range(64, 3..5);
        let mut heat = vec![0; 91];
        block.add_heat(&mut heat);
        assert_eq!(heat[..8], [1, 0, 0, 2, 1, 0, 0, 1]);
        assert_eq!(block.pixels[3].0, [0, 1, 0, 0, 0, 0, 0, 1 << 63]);

        let mut same = PixelBlock::new(size);
        same.set_frames(&[mask(1), mask(2)].concat());
        assert_eq!(same.pixels[1].0[0], 1);
        assert_eq!(same.pixels[2].0[0], 2);

        block.clear();
        block.add_heat(&mut heat);
        assert_eq!(heat.iter().sum::<u32>(), 28);
    }

    #[test]
    fn pixels_are_cache_lines() {
        assert_eq!((size_of::<PixelWords>(), align_of::<PixelWords>()), (64, 64));
    }
}
