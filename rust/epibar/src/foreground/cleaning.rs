//! From a mask of pixels to one of silhouettes: specks and gaps go.
//!
//! A median of a mask is a majority, and a majority is counted; what a disc covers is the union of runs. So neither looks
//! at the pixels of its window, and where nothing moves nothing is done. The results are those of `OpenCV`'s `medianBlur` and
//! `morphologyEx`, bit for bit.

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::covering::Bits;
use crate::error::{Error, Result};
use crate::image::ImageSize;
use crate::recording::components::{Components, find_runs};

/// Widest window of the majority: its pixels are counted in 16 bits.
const WIDEST: usize = 255;

/// Rows of one task of the majority.
const TASK_ROWS: usize = 64;

/// What [`clean`] does.
#[derive(Debug, Clone, Copy)]
pub struct Cleaning<'a> {
    /// Side of the square of the median filter, an odd number of pixels; 1 does nothing.
    pub median: usize,
    /// Diameter of the disc of the closing, an odd number of pixels; 1 does nothing.
    pub closing: usize,
    /// Components of fewer pixels go.
    pub min_area: usize,
    /// A mask of where motion does not count, if anywhere.
    pub ignore: Option<&'a [u8]>,
}

/// A mask without what is ignored, specks, gaps and small components, in this order; 0 or 1.
///
/// # Errors
/// [`Error::Length`] where a mask is of another size, [`Error::Argument`] for a diameter that is even or above 255.
pub fn clean(mask: &[u8], size: ImageSize, how: &Cleaning<'_>) -> Result<Vec<u8>> {
    let lengths = [Some(mask), how.ignore].into_iter().flatten().map(<[u8]>::len);
    for length in lengths {
        if length != size.pixels() {
            return Err(Error::Length {
                what: "a mask must have as many pixels as its size says",
                left: length,
                right: size.pixels(),
            });
        }
    }
    for (name, value) in [("median", how.median), ("closing", how.closing)] {
        if value.is_multiple_of(2) || value > WIDEST {
            return Err(Error::Argument {
                name,
                value: value.to_string(),
                expected: "must be an odd number of pixels below 256",
            });
        }
    }
    let mut mask: Vec<u8> = mask.par_iter().with_min_len(1 << 16).map(|&v| u8::from(v != 0)).collect();
    let hide = |mask: &mut [u8]| {
        for (pixel, ignored) in mask.iter_mut().zip(how.ignore.unwrap_or_default()) {
            *pixel &= u8::from(*ignored == 0);
        }
    };
    hide(&mut mask);
    if how.median > 1 {
        mask = majority(&mask, size, how.median);
    }
    if how.closing > 1 {
        mask = close(&mask, size, how.closing);
    }
    hide(&mut mask);
    if how.min_area > 1 {
        Components::new().remove_small(&mut mask, size, how.min_area);
    }
    Ok(mask)
}

/// What most pixels of the square around each are, of a mask of 0 and 1; outside, the image goes on as at its border.
///
/// # Panics
/// If the side is even or above 255.
pub fn majority(mask: &[u8], size: ImageSize, side: usize) -> Vec<u8> {
    assert!(side % 2 == 1 && side <= WIDEST);
    let half = side / 2;
    let rows: Vec<&[u8]> = mask.chunks_exact(size.width).collect();
    let empty: Vec<bool> = rows.par_iter().with_min_len(TASK_ROWS).map(|row| is_empty(row)).collect();
    let mut found = vec![0; size.pixels()];
    let arch = Arch::new();
    found.par_chunks_mut(TASK_ROWS * size.width).enumerate().for_each(|(task, found)| {
        arch.dispatch(Majority { rows: &rows, empty: &empty, half, first: task * TASK_ROWS, found });
    });
    found
}

/// Pass: the majority of some rows.
struct Majority<'p> {
    /// All rows of the mask, and whether nothing moves there.
    rows: &'p [&'p [u8]],
    empty: &'p [bool],
    half: usize,
    /// The first of those that are wanted.
    first: usize,
    found: &'p mut [u8],
}

impl WithSimd for Majority<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { rows, empty, half, first, found } = self;
        let (width, last) = (rows[first].len(), rows.len() - 1);
        let mut columns = WindowColumns::new(width, half);
        for y in 0..=2 * half {
            let y = (first + y).saturating_sub(half).min(last);
            if !empty[y] {
                columns.add(rows[y]);
            }
        }
        for (y, row) in (first..).zip(found.chunks_exact_mut(width)) {
            if y > first {
                let (gone, come) = (y.saturating_sub(half + 1).min(last), (y + half).min(last));
                if gone != come {
                    if !empty[gone] {
                        columns.take(rows[gone]);
                    }
                    if !empty[come] {
                        columns.add(rows[come]);
                    }
                }
            }
            columns.majority(row);
        }
    }
}

fn is_empty(row: &[u8]) -> bool {
    row.chunks(64).all(|part| part.iter().fold(0, |any, v| any | v) == 0)
}

/// Ones of each column among the rows of a window.
struct WindowColumns {
    half: usize,
    counts: Vec<u16>,
    /// The counts with the border repeated, then sums of 1, 2, 4, ... of them; and the sums that are wanted.
    padded: Vec<u16>,
    sums: Vec<u16>,
    /// Ones in the window, in all columns.
    ones: usize,
}

impl WindowColumns {
    fn new(width: usize, half: usize) -> Self {
        let padded = vec![0; width + 2 * half];
        Self { half, counts: vec![0; width], padded, sums: vec![0; width], ones: 0 }
    }

    #[inline(always)]
    fn add(&mut self, row: &[u8]) {
        for (count, &one) in self.counts.iter_mut().zip(row) {
            *count += u16::from(one);
        }
        self.ones += row.iter().map(|&one| usize::from(one)).sum::<usize>();
    }

    #[inline(always)]
    fn take(&mut self, row: &[u8]) {
        for (count, &one) in self.counts.iter_mut().zip(row) {
            *count -= u16::from(one);
        }
        self.ones -= row.iter().map(|&one| usize::from(one)).sum::<usize>();
    }

    /// Write where the square around a pixel has more ones than zeros into a row of zeros.
    #[inline(always)]
    fn majority(&mut self, row: &mut [u8]) {
        if self.ones == 0 {
            return;
        }
        let (width, half) = (self.counts.len(), self.half);
        let side = 2 * half + 1;
        // Columns farther from ones than the square reaches stay 0.
        let first = self.counts.iter().position(|&count| count != 0).unwrap_or(width);
        let end = self.counts.iter().rposition(|&count| count != 0).map_or(0, |last| last + 1);
        let (first, end) = (first.saturating_sub(half), (end + half).min(width));
        let columns = end - first;
        let padded = &mut self.padded[..columns + 2 * half];
        for (k, sum) in padded.iter_mut().enumerate().filter(|(k, _)| *k < half || *k >= columns + half) {
            *sum = self.counts[(first + k).saturating_sub(half).min(width - 1)];
        }
        padded[half..half + columns].copy_from_slice(&self.counts[first..end]);
        let sums = &mut self.sums[..columns];
        sums.fill(0);
        let (mut step, mut offset) = (1, 0);
        loop {
            if side & step != 0 {
                for (sum, part) in sums.iter_mut().zip(&padded[offset..]) {
                    *sum += part;
                }
                offset += step;
            }
            if 2 * step > side {
                break;
            }
            let kept = padded.len() - step;
            for i in 0..kept {
                padded[i] += padded[i + step];
            }
            step *= 2;
        }
        let most = (side * side / 2) as u16;
        for (pixel, &sum) in row[first..end].iter_mut().zip(sums.iter()) {
            *pixel = u8::from(sum > most);
        }
    }
}

/// A mask of 0 and 1 closed with a disc: what no disc reaches that touches nothing of the mask. Outside the image there is
/// room for discs.
///
/// # Panics
/// If the diameter is even.
pub fn close(mask: &[u8], size: ImageSize, diameter: usize) -> Vec<u8> {
    assert!(diameter % 2 == 1);
    let disc = half_widths(diameter / 2);
    let mut runs = Vec::new();
    for (y, row) in mask.chunks_exact(size.width).enumerate() {
        find_runs(row, y as u16, &mut runs);
    }
    if runs.is_empty() {
        return mask.to_vec();
    }
    let mut covered = Bits::new(size);
    covered.cover(&runs, &disc);
    let mut left = Bits::new(size);
    left.cover(&covered.gaps(), &disc);
    let mut closed = vec![0; size.pixels()];
    for run in left.gaps() {
        let row = usize::from(run.y) * size.width;
        closed[row + usize::from(run.x_first)..=row + usize::from(run.x_last)].fill(1);
    }
    closed
}

/// How far a disc reaches to either side, row by row, as `OpenCV` draws it.
fn half_widths(radius: usize) -> Vec<usize> {
    let r = radius as f64;
    let row = |dy: f64| (r * ((r * r - dy * dy) * (1.0 / (r * r))).sqrt()).round_ties_even() as usize;
    (0..=2 * radius).map(|k| row(k as f64 - r)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::generator;
    use rand::RngExt;

    const SIZES: [(usize, usize); 4] = [(131, 47), (64, 30), (9, 70), (2, 2)];

    fn masks(size: ImageSize) -> Vec<Vec<u8>> {
        let mut random = generator(7, 0);
        let mut noise =
            |share: f64| (0..size.pixels()).map(|_| u8::from(random.random_bool(share))).collect();
        let mut masks: Vec<Vec<u8>> = [0.0, 0.003, 0.3, 0.5, 0.9, 1.0].map(&mut noise).into();
        let block = |i: usize| u8::from(i % size.width % 33 < 11 && i / size.width % 26 < 13);
        masks.push((0..size.pixels()).map(block).collect());
        masks
    }

    fn at(mask: &[u8], size: ImageSize, x: i64, y: i64, outside: Option<u8>) -> u8 {
        let inside = |v: i64, sides: usize| v.clamp(0, sides as i64 - 1);
        let (near_x, near_y) = (inside(x, size.width), inside(y, size.height));
        match outside {
            Some(value) if (near_x, near_y) != (x, y) => value,
            _ => mask[near_y as usize * size.width + near_x as usize],
        }
    }

    fn each(size: ImageSize, pixel: impl Fn(i64, i64) -> bool) -> Vec<u8> {
        let place = |i: usize| ((i % size.width) as i64, (i / size.width) as i64);
        (0..size.pixels()).map(|i| u8::from(pixel(place(i).0, place(i).1))).collect()
    }

    #[test]
    fn the_majority_is_what_counting_gives() {
        for size in SIZES.map(|(width, height)| ImageSize::new(width, height).unwrap()) {
            for mask in masks(size) {
                for side in [3, 5, 11, 33] {
                    let half = side as i64 / 2;
                    let plain = each(size, |x, y| {
                        let ones = (-half..=half).flat_map(|dy| (-half..=half).map(move |dx| (dx, dy)));
                        let ones = ones.map(|(dx, dy)| usize::from(at(&mask, size, x + dx, y + dy, None)));
                        2 * ones.sum::<usize>() > side * side
                    });
                    assert_eq!(majority(&mask, size, side), plain, "{size:?}, side {side}");
                }
            }
        }
    }

    #[test]
    fn the_closing_is_a_dilation_and_an_erosion() {
        for size in SIZES.map(|(width, height)| ImageSize::new(width, height).unwrap()) {
            for mask in masks(size) {
                for diameter in [3, 7, 15] {
                    let disc = half_widths(diameter / 2);
                    let radius = diameter as i64 / 2;
                    let around = |mask: &[u8], x: i64, y: i64, outside: u8| {
                        let reach = |dy: i64| disc[(dy + radius) as usize] as i64;
                        let places = (-radius..=radius)
                            .flat_map(|dy| (-reach(dy)..=reach(dy)).map(move |dx| (dx, dy)));
                        places
                            .map(|(dx, dy)| at(mask, size, x + dx, y + dy, Some(outside)))
                            .collect::<Vec<u8>>()
                    };
                    let dilated = each(size, |x, y| around(&mask, x, y, 0).contains(&1));
                    let plain = each(size, |x, y| !around(&dilated, x, y, 1).contains(&0));
                    assert_eq!(close(&mask, size, diameter), plain, "{size:?}, diameter {diameter}");
                }
            }
        }
    }

    #[test]
    fn what_is_ignored_neither_counts_nor_comes_back() {
        let size = ImageSize::new(20, 9).unwrap();
        let mask = vec![9; size.pixels()];
        let ignore = each(size, |x, _| (8..11).contains(&x));
        let how = Cleaning { median: 1, closing: 7, min_area: 0, ignore: Some(&ignore) };
        let kept = each(size, |x, _| !(8..11).contains(&x));
        assert_eq!(clean(&mask, size, &how).unwrap(), kept);
        let less = Cleaning { min_area: 9 * 9, ..how };
        assert_eq!(clean(&mask, size, &less).unwrap(), each(size, |x, _| x >= 11));
        for bad in [Cleaning { median: 4, ..how }, Cleaning { closing: 257, ..how }] {
            assert!(matches!(clean(&mask, size, &bad), Err(Error::Argument { .. })));
        }
        assert!(matches!(clean(&mask[1..], size, &how), Err(Error::Length { .. })));
    }
}
