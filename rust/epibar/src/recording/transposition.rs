//! Up to 64 masks of one bit per pixel, on their way into words of time.
//!
//! A frame sets bits of pixels; a pixel wants bits of frames. In between is the transposition of 64 × 64 bits, tile by
//! tile, so that a pixel's word is written once for 64 frames, and not at all where nothing moves.

use rayon::prelude::*;
use std::ops::Range;

use crate::bits_of_bytes::{gathered, ones_of};

/// Pixels of a tile, which are consecutive.
pub const TILE: usize = 64;

/// Up to 64 masks.
#[derive(Debug, Clone)]
pub struct BitPlanes {
    /// Word `f` of a tile holds its pixels in frame `f`.
    tiles: Vec<[u64; 64]>,
}

/// [`TILE`] pixels in 64 frames.
pub struct Tile<'a>(&'a mut [u64; 64]);

impl BitPlanes {
    /// Masks of some pixels in which nothing moves.
    pub fn new(pixels: usize) -> Self {
        Self { tiles: vec![[0; 64]; pixels.div_ceil(TILE)] }
    }

    /// Adds the non-zero pixels of a row-major mask as frame `bit`.
    ///
    /// # Panics
    /// If `bit` is not below 64, or the mask has more pixels.
    pub fn set_frame(&mut self, bit: usize, mask: &[u8]) {
        assert!(mask.len().div_ceil(TILE) <= self.tiles.len());
        let (whole, rest) = mask.as_chunks::<TILE>();
        for (tile, mask) in self.tiles.iter_mut().zip(whole) {
            if mask.iter().fold(0, |any, v| any | v) != 0 {
                tile[bit] |= non_zero(mask);
            }
        }
        if !rest.is_empty() {
            let mut padded = [0; TILE];
            padded[..rest.len()].copy_from_slice(rest);
            self.tiles[whole.len()][bit] |= non_zero(&padded);
        }
    }

    /// Adds the pixels of a range of row-major indices as moving in frame `bit`.
    ///
    /// # Panics
    /// If `bit` is not below 64 or the range is not inside the mask.
    #[inline]
    pub fn set_range(&mut self, bit: usize, range: Range<usize>) {
        let mut first = range.start;
        while first < range.end {
            let (tile, offset) = (first / TILE, first % TILE);
            let count = (range.end - first).min(TILE - offset);
            self.tiles[tile][bit] |= (u64::MAX >> (TILE - count)) << offset;
            first += count;
        }
    }

    /// Calls `visit` with each pixel of a tile that moves and the frames in which it does, and empties the tile.
    ///
    /// # Panics
    /// If there is no such tile.
    pub fn take(&mut self, tile: usize, visit: impl FnMut(usize, u64)) {
        Tile(&mut self.tiles[tile]).take(visit);
    }

    /// All tiles, in parallel.
    pub fn par_tiles_mut(&mut self) -> impl IndexedParallelIterator<Item = Tile<'_>> {
        self.tiles.par_iter_mut().map(Tile)
    }
}

impl Tile<'_> {
    /// Calls `visit` with each pixel of the tile that moves and the frames in which it does, and empties the tile.
    pub fn take(&mut self, mut visit: impl FnMut(usize, u64)) {
        let moving = self.0.iter().fold(0, |any, word| any | word);
        if moving == 0 {
            return;
        }
        transpose(self.0);
        for pixel in ones_of(moving) {
            visit(pixel, self.0[pixel]);
        }
        self.0.fill(0);
    }
}

/// One bit for each byte: whether it is not zero.
fn non_zero(bytes: &[u8; TILE]) -> u64 {
    const LOW: u64 = 0x7f7f_7f7f_7f7f_7f7f;
    let mut bits = 0;
    for (i, &eight) in bytes.as_chunks::<8>().0.iter().enumerate() {
        let eight = u64::from_le_bytes(eight);
        // The top bit of each byte that is not zero, then these bits side by side.
        let tops = (((eight & LOW) + LOW) | eight) & !LOW;
        bits |= gathered(tops >> 7) << (8 * i);
    }
    bits
}

/// Bit `j` of word `i` becomes bit `i` of word `j` (Warren, Hacker's Delight, §7-3).
fn transpose(words: &mut [u64; 64]) {
    let mut mask = 0x0000_0000_ffff_ffff_u64;
    let mut step = 32;
    while step != 0 {
        for pair in words.chunks_exact_mut(2 * step) {
            let (low, high) = pair.split_at_mut(step);
            for (low, high) in low.iter_mut().zip(high) {
                let change = ((*low >> step) ^ *high) & mask;
                *high ^= change;
                *low ^= change << step;
            }
        }
        step /= 2;
        mask ^= mask << step;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_pixels_become_pixels_of_frames() {
        // 200 pixels: three tiles and a bit.
        let moves = |pixel: usize, frame: usize| (pixel * 31 + frame * frame * 7 + pixel * frame) % 11 < 3;
        let mut planes = BitPlanes::new(200);
        for frame in 0..64 {
            let mask: Vec<u8> = (0..200).map(|p| u8::from(moves(p, frame)) * (1 + (p % 255) as u8)).collect();
            planes.set_frame(frame, &mask);
        }
        for round in 0..2 {
            let mut found = vec![0u64; 200];
            for tile in 0..4 {
                planes.take(tile, |k, frames| found[tile * TILE + k] = frames);
            }
            for (pixel, frames) in found.into_iter().enumerate() {
                for frame in 0..64 {
                    assert_eq!(frames >> frame & 1 == 1, round == 0 && moves(pixel, frame));
                }
            }
        }
    }

    #[test]
    fn ranges_are_masks_of_ones() {
        for (start, end) in [(0, 1), (5, 64), (63, 65), (10, 190), (64, 128), (7, 7)] {
            let (mut ranged, mut masked) = (BitPlanes::new(200), BitPlanes::new(200));
            ranged.set_range(9, start..end);
            let mask: Vec<u8> = (0..200).map(|p| u8::from((start..end).contains(&p))).collect();
            masked.set_frame(9, &mask);
            assert_eq!(ranged.tiles, masked.tiles);
        }
    }
}
