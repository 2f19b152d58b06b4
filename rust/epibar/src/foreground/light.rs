//! The light of a frame: its green on a grid of 8×8 pixels, where noise hardly shows, and how that changes.

use pulp::{Arch, Simd, WithSimd};

use crate::error::{Error, Result};
use crate::image::ImageSize;

/// Pixels on a side that are one of the grid.
pub const SHRUNK: usize = 8;

/// Horizontal bands of the image whose light is told apart.
pub const BANDS: usize = 8;

/// Mean green of each 8×8 pixels of a BGR frame, rounded, ties to even, row by row.
///
/// # Errors
/// [`Error::Length`] for a frame of another size, [`Error::Argument`] for sides that are not whole eights of pixels.
pub fn shrunk_green(frame: &[u8], size: ImageSize) -> Result<Vec<u8>> {
    if frame.len() != 3 * size.pixels() {
        return Err(Error::Length {
            what: "a frame must have three bytes a pixel",
            left: frame.len(),
            right: 3 * size.pixels(),
        });
    }
    if !size.width.is_multiple_of(SHRUNK) || !size.height.is_multiple_of(SHRUNK) {
        return Err(Error::Argument {
            name: "size",
            value: format!("{}x{}", size.width, size.height),
            expected: "must be a multiple of 8 pixels each way",
        });
    }
    let mut shrunk = vec![0; size.pixels() / (SHRUNK * SHRUNK)];
    Arch::new().dispatch(Shrink { frame, width: size.width, shrunk: &mut shrunk });
    Ok(shrunk)
}

/// Pass: [`shrunk_green`]. Rows are added byte by byte, all channels, since adding side by side is quicker than picking.
struct Shrink<'p> {
    frame: &'p [u8],
    width: usize,
    shrunk: &'p mut [u8],
}

impl WithSimd for Shrink<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        const PIXELS: u16 = (SHRUNK * SHRUNK) as u16;
        let mut sums = vec![0u16; 3 * self.width];
        let strips = self.frame.chunks_exact(3 * self.width * SHRUNK);
        for (strip, shrunk) in strips.zip(self.shrunk.chunks_exact_mut(self.width / SHRUNK)) {
            sums.fill(0);
            for row in strip.chunks_exact(3 * self.width) {
                for (sum, value) in sums.iter_mut().zip(row) {
                    *sum += u16::from(*value);
                }
            }
            for (mean, sums) in shrunk.iter_mut().zip(sums.as_chunks::<{ 3 * SHRUNK }>().0) {
                let sum: u16 = sums.iter().skip(1).step_by(3).sum();
                // The last bit of what is rounded down tells which way a tie goes.
                *mean = ((sum + PIXELS / 2 - 1 + ((sum / PIXELS) & 1)) / PIXELS) as u8;
            }
        }
    }
}

/// How the light of a frame differs from that of others, on the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightChange {
    /// Variance over the image.
    pub variance: f64,
    /// Whether any pixel differs from the frame before.
    pub changed: bool,
    /// Pixels that count and differ by more than the jump from the frame before.
    pub jumped: usize,
    /// Pixels that count.
    pub compared: usize,
    /// Mean of the middle half of the differences to the first frame, in each band from top to bottom; 0 where a band is empty.
    pub levels: [f64; BANDS],
}

/// Compares the light of a frame with that of the frame before and of the first one, on grids of some width. `counted` is not 0 where
/// pixels count for jumps; None is everywhere.
///
/// # Errors
/// [`Error::Length`] where one is of another size, or not whole rows.
pub fn compare_light(
    now: &[u8],
    before: &[u8],
    first: &[u8],
    counted: Option<&[u8]>,
    width: usize,
    jump: u8,
) -> Result<LightChange> {
    for other in [Some(before), Some(first), counted].into_iter().flatten() {
        if other.len() != now.len() || width == 0 || !now.len().is_multiple_of(width) {
            return Err(Error::Length {
                what: "light is compared on grids of one size",
                left: now.len(),
                right: other.len(),
            });
        }
    }
    let (mut sum, mut squares) = (0u64, 0u64);
    for &value in now {
        sum += u64::from(value);
        squares += u64::from(value) * u64::from(value);
    }
    let count = now.len() as f64;
    // Whole numbers: the difference is exact.
    let variance = (now.len() as u64 * squares - sum * sum) as f64 / (count * count);
    let apart = || now.iter().zip(before).map(|(now, before)| now.abs_diff(*before));
    let (jumped, compared) = match counted {
        None => (apart().filter(|apart| *apart > jump).count(), now.len()),
        Some(counted) => {
            let counted = || apart().zip(counted).filter(|(_, counted)| **counted != 0);
            (counted().filter(|(apart, _)| *apart > jump).count(), counted().count())
        }
    };
    let rows = now.len() / width;
    let mut levels = [0.0; BANDS];
    let mut start = 0;
    for (band, level) in levels.iter_mut().enumerate() {
        let end = start + width * (rows / BANDS + usize::from(band < rows % BANDS));
        *level = middle_half(&now[start..end], &first[start..end]);
        start = end;
    }
    Ok(LightChange { variance, changed: now != before, jumped, compared, levels })
}

/// Mean of the middle half of the differences, which are counted instead of sorted.
fn middle_half(now: &[u8], first: &[u8]) -> f64 {
    let mut counts = [0usize; 511];
    for (now, first) in now.iter().zip(first) {
        counts[255 + usize::from(*now) - usize::from(*first)] += 1;
    }
    let quarter = now.len() / 4;
    let (begin, end) = (quarter, now.len() - quarter);
    let (mut sum, mut seen) = (0i64, 0);
    for (difference, count) in (-255..).zip(counts) {
        let inside = (seen + count).min(end).saturating_sub(seen.max(begin));
        sum += difference * inside as i64;
        seen += count;
    }
    if begin < end { sum as f64 / (end - begin) as f64 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::generator;
    use rand::RngExt;

    #[test]
    fn green_is_the_mean_of_eight_by_eight() {
        let mut random = generator(11, 0);
        for (width, height) in [(8, 8), (1040, 16), (520, 24)] {
            let size = ImageSize::new(width, height).unwrap();
            let frame: Vec<u8> =
                (0..3 * size.pixels()).map(|i| random.random_range(0..=((i % 7) as u8 * 36))).collect();
            let found = shrunk_green(&frame, size).unwrap();
            for (i, mean) in found.iter().enumerate() {
                let (x, y) = (8 * (i % (width / 8)), 8 * (i / (width / 8)));
                let green = |k: usize| f64::from(frame[3 * ((y + k / 8) * width + x + k % 8) + 1]);
                let expected = ((0..64).map(green).sum::<f64>() / 64.0).round_ties_even();
                assert_eq!(f64::from(*mean), expected);
            }
        }
        let size = ImageSize::new(8, 12).unwrap();
        assert!(matches!(shrunk_green(&[0; 288], size), Err(Error::Argument { name: "size", .. })));
        assert!(matches!(shrunk_green(&[0; 287], size), Err(Error::Length { .. })));
    }

    #[test]
    fn light_is_compared_as_sorting_does() {
        let mut random = generator(12, 0);
        for (width, rows) in [(9, 21), (3, 5), (1, 1), (40, 16)] {
            let mut grid = || (0..width * rows).map(|_| random.random_range(0..=255)).collect::<Vec<u8>>();
            let (now, before, first, counted) = (grid(), grid(), grid(), grid());
            let counted: Vec<u8> = counted.into_iter().map(|v| v & 2).collect();
            let found = compare_light(&now, &before, &first, Some(&counted), width, 8).unwrap();
            let mut start = 0;
            for (band, level) in found.levels.into_iter().enumerate() {
                let end = start + width * (rows / 8 + usize::from(band < rows % 8));
                let pairs = now[start..end].iter().zip(&first[start..end]);
                let mut differences: Vec<i32> = pairs.map(|(a, b)| i32::from(*a) - i32::from(*b)).collect();
                differences.sort_unstable();
                let quarter = differences.len() / 4;
                let middle = &differences[quarter..differences.len() - quarter];
                let mean = f64::from(middle.iter().sum::<i32>()) / middle.len() as f64;
                assert_eq!(level, if middle.is_empty() { 0.0 } else { mean });
                start = end;
            }
            let mean = now.iter().map(|v| f64::from(*v)).sum::<f64>() / now.len() as f64;
            let variance = now.iter().map(|v| (f64::from(*v) - mean).powi(2)).sum::<f64>() / now.len() as f64;
            assert!((found.variance - variance).abs() < 1e-9);
            let counting = (0..now.len()).filter(|&i| counted[i] > 0).collect::<Vec<_>>();
            assert_eq!(found.compared, counting.len());
            assert_eq!(found.jumped, counting.iter().filter(|&&i| now[i].abs_diff(before[i]) > 8).count());
            assert!(found.changed || now == before);
            let same = compare_light(&now, &now, &now, None, width, 8).unwrap();
            assert!(!same.changed && same.jumped == 0 && same.levels == [0.0; BANDS]);
            assert_eq!(same.compared, now.len());
            assert!(compare_light(&now, &before[1..], &first, None, width, 8).is_err());
        }
    }
}
