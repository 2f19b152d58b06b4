//! Samples of the empty scene without the people in them.

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::cleaning::{Cleaning, clean};
use super::covering::Bits;
use crate::error::{Error, Result};
use crate::image::ImageSize;
use crate::recording::components::find_runs;

/// What [`paint_over`] takes for people.
#[derive(Debug, Clone, Copy)]
pub struct Painting<'a> {
    /// Largest difference to the background, of the channel that differs most, that flicker and noise make.
    pub most: u8,
    /// How the mask of what differs more is cleaned.
    pub cleaning: Cleaning<'a>,
    /// Side of the square that each of its pixels grows to, an odd number of pixels.
    pub margin: usize,
}

/// Paints people in samples over with the background: three bytes a pixel, one frame after the other.
///
/// # Errors
/// [`Error::Length`] where the samples are not whole frames or the background is not one, [`Error::Argument`] for a margin that is even,
/// and whatever [`clean`] says.
pub fn paint_over(samples: &mut [u8], background: &[u8], size: ImageSize, how: &Painting<'_>) -> Result<()> {
    let bytes = 3 * size.pixels();
    if !samples.len().is_multiple_of(bytes) || background.len() != bytes {
        return Err(Error::Length {
            what: "samples must be whole frames of three bytes a pixel, as the background is one",
            left: samples.len(),
            right: background.len(),
        });
    }
    if how.margin.is_multiple_of(2) {
        return Err(Error::Argument {
            name: "margin",
            value: how.margin.to_string(),
            expected: "must be an odd number of pixels",
        });
    }
    let square = vec![how.margin / 2; how.margin];
    let arch = Arch::new();
    samples.par_chunks_exact_mut(bytes).try_for_each(|sample| {
        let mut far = vec![0; size.pixels()];
        arch.dispatch(Far { sample, background, most: how.most, found: &mut far });
        let people = clean(&far, size, &how.cleaning)?;
        let mut runs = Vec::new();
        for (y, row) in people.chunks_exact(size.width).enumerate() {
            find_runs(row, y as u16, &mut runs);
        }
        let mut around = Bits::new(size);
        around.cover(&runs, &square);
        for run in around.runs() {
            let row = usize::from(run.y) * size.width;
            let painted = 3 * (row + usize::from(run.x_first))..3 * (row + usize::from(run.x_last) + 1);
            sample[painted.clone()].copy_from_slice(&background[painted]);
        }
        Ok(())
    })
}

/// Pass: where a channel differs by more than the most.
struct Far<'p> {
    sample: &'p [u8],
    background: &'p [u8],
    most: u8,
    found: &'p mut [u8],
}

impl WithSimd for Far<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let colours = self.sample.as_chunks::<3>().0.iter().zip(self.background.as_chunks::<3>().0);
        for (far, (a, b)) in self.found.iter_mut().zip(colours) {
            let apart = a[0].abs_diff(b[0]).max(a[1].abs_diff(b[1])).max(a[2].abs_diff(b[2]));
            *far = u8::from(apart > self.most);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_are_painted_over_and_flicker_stays() {
        let size = ImageSize::new(70, 12).unwrap();
        let background = vec![100; 3 * size.pixels()];
        let mut sample = background.clone();
        sample[3 * 3] = 130; // within the most
        for pixel in [2 * 70 + 68, 11 * 70] {
            sample[3 * pixel + 1] = 131;
        }
        sample[3 * (70 + 67) + 2] = 90; // beside one
        sample[3 * (70 + 60) + 2] = 90;
        let cleaning = Cleaning { median: 1, closing: 1, min_area: 0, ignore: None };
        let how = Painting { most: 30, cleaning, margin: 3 };
        let mut samples = [sample, background.clone()].concat();
        paint_over(&mut samples, &background, size, &how).unwrap();
        let mut expected = background.clone();
        expected[3 * 3] = 130;
        expected[3 * (70 + 60) + 2] = 90;
        assert_eq!(samples, [expected, background.clone()].concat());
        let even = Painting { margin: 4, ..how };
        assert!(matches!(
            paint_over(&mut samples, &background, size, &even),
            Err(Error::Argument { name: "margin", .. })
        ));
        for (samples, background) in
            [(&mut samples[1..], &background[..]), (&mut [0; 0][..], &background[1..])]
        {
            assert!(matches!(paint_over(samples, background, size, &how), Err(Error::Length { .. })));
        }
    }
}
