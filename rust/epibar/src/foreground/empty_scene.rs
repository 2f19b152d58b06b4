//! The empty scene from frames that people walk through: the most repeated value of each pixel.
//!
//! At each pixel the shortest interval that holds a quarter of the samples' grey levels (a robust estimate of the mode,
//! after the *shorth*) tells which samples are background, and their mean is its colour. Pixels side by side are sorted
//! together: a sorting network (Batcher's, Knuth 5.3.4) compares whole vectors.

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::image::ImageSize;

/// The first share of the samples must be background; a larger one that agrees nearly as well wins over somebody who
/// stood still.
const STEADY_SHARES: [f64; 4] = [0.25, 0.375, 0.5, 0.625];

/// Pixels that are sorted together.
const LANES: usize = 32;
/// Groups of so many pixels that are read from one sample before the next one: of sixty samples in turn caches lose track.
const STRIP: usize = 16;
/// Samples whose sums 16 bits hold.
const SUMMED: usize = 257;

/// The most repeated value of each pixel of BGR samples, one frame after the other; as large as one of them.
///
/// # Errors
/// [`Error::Length`] where the samples are not at least two whole frames.
pub fn steady_background(samples: &[u8], size: ImageSize) -> Result<Vec<u8>> {
    let bytes = 3 * size.pixels();
    let count = samples.len() / bytes;
    if count < 2 || count * bytes != samples.len() {
        return Err(Error::Length {
            what: "samples must be at least two whole frames of three bytes a pixel",
            left: samples.len(),
            right: bytes,
        });
    }
    let windows =
        STEADY_SHARES.map(|share| ((count as f64 * share).round_ties_even() as usize).max(2).min(count));
    let network = sorting_network(count);
    let mut background = vec![0; bytes];
    let arch = Arch::new();
    background.par_chunks_mut(3 * size.width).enumerate().for_each(|(y, row)| {
        let start = 3 * y * size.width;
        let samples = samples.chunks_exact(bytes).map(|sample| &sample[start..start + row.len()]).collect();
        arch.dispatch(SteadyRow { samples, windows, network: &network, row });
    });
    Ok(background)
}

/// Pass: a row of the background from the same row of all samples.
struct SteadyRow<'p> {
    samples: Vec<&'p [u8]>,
    windows: [usize; 4],
    network: &'p [(usize, usize)],
    row: &'p mut [u8],
}

impl WithSimd for SteadyRow<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { samples, windows, network, row } = self;
        let count = samples.len();
        let mut all_colours = vec![[[0; LANES]; 3]; count * STRIP];
        let mut all_greys = vec![[0; LANES]; count * STRIP];
        let mut ordered = vec![[0; LANES]; count];
        for (strip, found) in row.chunks_mut(3 * LANES * STRIP).enumerate() {
            let start = 3 * LANES * STRIP * strip;
            for (n, sample) in samples.iter().enumerate() {
                let groups = sample[start..start + found.len()].chunks(3 * LANES);
                let places = all_colours.iter_mut().zip(&mut all_greys).skip(n).step_by(count);
                for (group, (colours, greys)) in groups.zip(places) {
                    take_apart(group.as_chunks::<3>().0, colours, greys);
                }
            }
            let groups = all_colours.chunks(count).zip(all_greys.chunks(count));
            for (found, (colours, greys)) in found.chunks_mut(3 * LANES).zip(groups) {
                ordered.copy_from_slice(greys);
                steady_group(found, colours, greys, &mut ordered, network, windows);
            }
        }
    }
}

/// The background of pixels side by side, of the colours and grey levels of all samples; `ordered` is the grey levels.
#[inline(always)]
fn steady_group(
    found: &mut [u8],
    colours: &[[[u8; LANES]; 3]],
    greys: &[[u8; LANES]],
    ordered: &mut [[u8; LANES]],
    network: &[(usize, usize)],
    windows: [usize; 4],
) {
    for &(low, high) in network {
        let (a, b) = (ordered[low], ordered[high]);
        for lane in 0..LANES {
            ordered[low][lane] = a[lane].min(b[lane]);
            ordered[high][lane] = a[lane].max(b[lane]);
        }
    }
    let (low, width) = steady_range(ordered, windows);
    let (sums, inside) = sums_within(colours, greys, &low, &width);
    for (lane, colour) in found.as_chunks_mut::<3>().0.iter_mut().enumerate() {
        for (value, sums) in colour.iter_mut().zip(&sums) {
            let mean = f64::from(sums[lane]) / f64::from(inside[lane]);
            *value = mean.round_ties_even() as u8;
        }
    }
}

/// Blue, green and red of pixels side by side, and their grey levels.
#[inline(always)]
fn take_apart(pixels: &[[u8; 3]], colours: &mut [[u8; LANES]; 3], greys: &mut [u8; LANES]) {
    let mut padded = [[0; 3]; LANES];
    let pixels: &[[u8; 3]; LANES] = pixels.first_chunk().unwrap_or_else(|| {
        padded[..pixels.len()].copy_from_slice(pixels);
        &padded
    });
    let (mut blue, mut green, mut red) = ([0; LANES], [0; LANES], [0; LANES]);
    for (lane, pixel) in pixels.iter().enumerate() {
        (blue[lane], green[lane], red[lane]) = (pixel[0], pixel[1], pixel[2]);
    }
    for lane in 0..LANES {
        let twice_green = 2 * u16::from(green[lane]);
        greys[lane] = ((u16::from(blue[lane]) + twice_green + u16::from(red[lane])) >> 2) as u8;
    }
    *colours = [blue, green, red];
}

/// Sums of the colours of the samples whose grey level is at most `width` above `low`, and their number.
#[inline(always)]
fn sums_within(
    colours: &[[[u8; LANES]; 3]],
    greys: &[[u8; LANES]],
    low: &[u8; LANES],
    width: &[u8; LANES],
) -> ([[u32; LANES]; 3], [u32; LANES]) {
    let (mut sums, mut inside) = ([[0; LANES]; 3], [0; LANES]);
    let add = |all: &mut [u32; LANES], some: [u16; LANES]| {
        for (all, some) in all.iter_mut().zip(some) {
            *all += u32::from(some);
        }
    };
    for (colours, greys) in colours.chunks(SUMMED).zip(greys.chunks(SUMMED)) {
        let (mut part, mut counted) = ([[0u16; LANES]; 3], [0u16; LANES]);
        for (colours, greys) in colours.iter().zip(greys) {
            let mut steady = [0; LANES];
            for lane in 0..LANES {
                let inside = greys[lane].wrapping_sub(low[lane]) <= width[lane];
                steady[lane] = if inside { u8::MAX } else { 0 };
            }
            for (part, plane) in part.iter_mut().zip(colours) {
                for lane in 0..LANES {
                    part[lane] += u16::from(plane[lane] & steady[lane]);
                }
            }
            for lane in 0..LANES {
                counted[lane] += u16::from(steady[lane] & 1);
            }
        }
        for (sums, part) in sums.iter_mut().zip(part) {
            add(sums, part);
        }
        add(&mut inside, counted);
    }
    (sums, inside)
}

/// Lowest grey level that counts as background, and how far above it the highest is, of sorted samples.
#[inline(always)]
fn steady_range(ordered: &[[u8; LANES]], windows: [usize; 4]) -> ([u8; LANES], [u8; LANES]) {
    let (mut low, mut chosen, mut narrowest) = ([0; LANES], [0; LANES], [0; LANES]);
    for (number, window) in windows.into_iter().enumerate() {
        let (mut lowest, mut width) = ([0; LANES], [u8::MAX; LANES]);
        for (n, (first, last)) in ordered.iter().zip(&ordered[window - 1..]).enumerate() {
            // The first of equals; the very first also where nothing is narrower than all.
            let always = if n == 0 { u8::MAX } else { 0 };
            for lane in 0..LANES {
                let wide = last[lane].wrapping_sub(first[lane]);
                let narrower = if wide < width[lane] { u8::MAX } else { 0 } | always;
                lowest[lane] ^= narrower & (lowest[lane] ^ first[lane]);
                width[lane] = width[lane].min(wide);
            }
        }
        if number == 0 {
            (low, chosen, narrowest) = (lowest, width, width);
            continue;
        }
        let before = low.iter_mut().zip(&mut chosen).zip(&narrowest);
        for (((low, chosen), &narrowest), (&lowest, &width)) in before.zip(lowest.iter().zip(&width)) {
            // 2.8 times is what the noise alone gives at 62.5 %.
            if u16::from(width) <= 3 * u16::from(narrowest) + 6 {
                (*low, *chosen) = (lowest, width);
            }
        }
    }
    (low, chosen)
}

/// Which of so many values are compared, one after the other, the smaller to go first: after all of it they are sorted.
fn sorting_network(count: usize) -> Vec<(usize, usize)> {
    let mut network = Vec::new();
    let mut p = 1;
    while p < count {
        let mut k = p;
        while k > 0 {
            for j in (k % p..count.saturating_sub(k)).step_by(2 * k) {
                for i in j..(j + k).min(count - k) {
                    if i / (2 * p) == (i + k) / (2 * p) {
                        network.push((i, i + k));
                    }
                }
            }
            k /= 2;
        }
        p *= 2;
    }
    network
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::generator;
    use rand::RngExt;

    #[test]
    fn the_network_sorts() {
        let mut random = generator(5, 0);
        for count in 1..70 {
            let network = sorting_network(count);
            for _ in 0..20 {
                let mut values: Vec<u8> = (0..count).map(|_| random.random_range(0..9)).collect();
                for &(low, high) in &network {
                    if values[low] > values[high] {
                        values.swap(low, high);
                    }
                }
                assert!(values.is_sorted(), "{count}: {values:?}");
            }
        }
    }

    #[test]
    fn what_is_repeated_wins() {
        let size = ImageSize::new(37, 3).unwrap();
        let bytes = 3 * size.pixels();
        let mut samples = Vec::new();
        for n in 0..9u8 {
            // A third of the time the background, and otherwise never twice the same.
            let colour = if n % 3 == 0 { [50, 60, 70] } else { [20 * n, 20 * n, 255 - n] };
            samples.extend(colour.iter().copied().cycle().take(bytes));
        }
        let found = steady_background(&samples, size).unwrap();
        assert!(found.as_chunks::<3>().0.iter().all(|colour| *colour == [50, 60, 70]));
        assert!(matches!(steady_background(&samples[1..], size), Err(Error::Length { .. })));
    }
}
