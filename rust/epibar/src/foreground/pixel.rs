//! The mixture of Gaussians of one pixel: Zivkovic, *Improved adaptive Gaussian mixture model for background subtraction*,
//! ICPR 2004, with the shadow test of Prati et al. 2003, as `OpenCV`'s MOG2 computes them.
//!
//! Modes are sorted by weight, heaviest first. A colour is background where it is near one of the heaviest modes that
//! together weigh [`BACKGROUND_WEIGHT`].

use std::ops::Deref;

/// Modes of a pixel at most.
pub const MODES: usize = 5;

/// Modes count as background until together they weigh so much: a new thing becomes background when it has shown
/// for 40 % of the memory.
const BACKGROUND_WEIGHT: f32 = 0.6;

/// Squared distance, in variances, within which a mode takes a colour in; farther ones begin a mode.
const FIT: f32 = 9.0;

const INITIAL_VARIANCE: f32 = 15.0;
const LEAST_VARIANCE: f32 = 4.0;
const MOST_VARIANCE: f32 = 75.0;

/// Share of a sample that each mode must earn with every frame to stay (`c_T` of the paper).
const PRIOR: f32 = 0.05;

/// Least brightness of a shadow, as a share of the background's.
const DARKEST_SHADOW: f32 = 0.4;

/// One Gaussian with the same variance for all channels: weight, variance, mean blue, green and red.
///
/// An array, since large arrays of arrays of zeros take no memory before they are written to.
pub type Mode = [f32; 5];

/// How a [`Mixture`](super::Mixture) decides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MixtureOptions {
    /// Squared distance to a mode, in variances, from which on a colour is not its own.
    pub threshold: f32,
    /// Whether what is only darker than the background is no motion.
    pub shadows: bool,
}

/// The modes of one pixel, somewhere in a row's planes: plane `m` holds the `m`-th mode of all pixels.
pub(super) struct Pixel<'a, 'm> {
    pub planes: &'a mut [&'m mut [Mode]; MODES],
    pub used: &'a mut u8,
    pub x: usize,
}

impl Pixel<'_, '_> {
    /// Whether a colour moves; and learn from it at a rate between 0 and 1.
    pub fn learn(&mut self, colour: [f32; 3], rate: f32, options: MixtureOptions) -> bool {
        let prune = -rate * PRIOR;
        let mut background = false;
        let mut fits = false;
        let mut used = usize::from(*self.used);
        let mut total = 0.0;
        let mut m = 0;
        while m < used {
            let mut weight = (1.0 - rate) * self.mode(m)[0] + prune;
            let mut place = m;
            if !fits {
                let mode = self.mode_mut(m);
                let [_, variance, ..] = *mode;
                let (apart, distance2) = difference(mode, colour);
                background |= total < BACKGROUND_WEIGHT && distance2 < options.threshold * variance;
                if distance2 < FIT * variance {
                    fits = true;
                    weight += rate;
                    let step = rate / weight;
                    for (mean, apart) in mode[2..].iter_mut().zip(apart) {
                        *mean -= step * apart;
                    }
                    mode[1] = (variance + step * (distance2 - variance)).clamp(LEAST_VARIANCE, MOST_VARIANCE);
                    place = self.sorted_in(m, weight);
                }
            }
            if weight < -prune {
                weight = 0.0;
                used -= 1;
            }
            self.mode_mut(place)[0] = weight;
            total += weight;
            m += 1;
        }
        if total.abs() > f32::EPSILON {
            for m in 0..used {
                self.mode_mut(m)[0] *= 1.0 / total;
            }
        }
        if !fits && rate > 0.0 {
            used = self.begin(used, colour, rate);
        }
        *self.used = used as u8;
        !(background || options.shadows && is_shadow(|m| *self.mode(m), used, colour, options))
    }

    /// Add a mode, in place of the lightest where there are too many, and return how many there are now.
    fn begin(&mut self, used: usize, colour: [f32; 3], rate: f32) -> usize {
        let used = (used + 1).min(MODES);
        let last = used - 1;
        let weight = if used == 1 { 1.0 } else { rate };
        if used > 1 {
            for m in 0..last {
                self.mode_mut(m)[0] *= 1.0 - rate;
            }
        }
        *self.mode_mut(last) = [weight, INITIAL_VARIANCE, colour[0], colour[1], colour[2]];
        self.sorted_in(last, rate);
        used
    }

    /// Move a mode before those that are not heavier than `weight`, and return its place.
    fn sorted_in(&mut self, m: usize, weight: f32) -> usize {
        let mut place = m;
        while place > 0 && weight >= self.mode(place - 1)[0] {
            let before = *self.mode(place - 1);
            *self.mode_mut(place - 1) = std::mem::replace(self.mode_mut(place), before);
            place -= 1;
        }
        place
    }

    fn mode(&self, m: usize) -> &Mode {
        &self.planes[m][self.x]
    }

    fn mode_mut(&mut self, m: usize) -> &mut Mode {
        &mut self.planes[m][self.x]
    }
}

/// [`Pixel::learn`] of a pixel with one mode, which weighs 1, and a colour that fits it: what nearly all are. Returns
/// whether it is such a one, which does not move, and does nothing otherwise.
#[inline(always)]
pub(super) fn settle(mode: &mut Mode, colour: [f32; 3], rate: f32, options: MixtureOptions) -> bool {
    let variance = mode[1];
    let (apart, distance2) = difference(mode, colour);
    if distance2 >= FIT.min(options.threshold) * variance {
        return false;
    }
    let step = rate / (1.0 - rate * PRIOR);
    for (mean, apart) in mode[2..].iter_mut().zip(apart) {
        *mean -= step * apart;
    }
    mode[1] = (variance + step * (distance2 - variance)).clamp(LEAST_VARIANCE, MOST_VARIANCE);
    true
}

/// Whether a colour moves, by the modes as they are: [`Pixel::learn`] at a rate of 0.
pub(super) fn moves(
    planes: &[impl Deref<Target = [Mode]>; MODES],
    used: u8,
    x: usize,
    colour: [f32; 3],
    options: MixtureOptions,
) -> bool {
    let used = usize::from(used);
    let mut total = 0.0;
    for plane in &planes[..used] {
        if total >= BACKGROUND_WEIGHT {
            break;
        }
        let mode = &plane[x];
        let (_, distance2) = difference(mode, colour);
        if distance2 < options.threshold * mode[1] {
            return false;
        }
        // Behind the mode that a colour fits no other is asked.
        if distance2 < FIT * mode[1] {
            break;
        }
        total += mode[0];
    }
    // Weights add up to less than 1 where a new mode took the place of another; learning mends that before it asks for shadows.
    let whole = 1.0 / planes[..used].iter().map(|plane| plane[x][0]).fold(0.0, |sum, weight| sum + weight);
    let mode = |m: usize| {
        let [weight, rest @ ..] = planes[m][x];
        [weight * whole, rest[0], rest[1], rest[2], rest[3]]
    };
    !(options.shadows && is_shadow(mode, used, colour, options))
}

/// Mean minus colour of each channel, and the sum of their squares.
fn difference(mode: &Mode, colour: [f32; 3]) -> ([f32; 3], f32) {
    let [_, _, blue, green, red] = *mode;
    let apart = [blue - colour[0], green - colour[1], red - colour[2]];
    (apart, apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2])
}

/// Whether a colour is that of a background mode, only darker.
fn is_shadow(mode: impl Fn(usize) -> Mode, used: usize, colour: [f32; 3], options: MixtureOptions) -> bool {
    let mut total = 0.0;
    for m in 0..used {
        let [weight, variance, mean @ ..] = mode(m);
        let along: f32 = mean.iter().zip(colour).map(|(mean, value)| mean * value).sum();
        let whole: f32 = mean.iter().map(|mean| mean * mean).sum();
        if whole == 0.0 {
            return false;
        }
        if along <= whole && along >= DARKEST_SHADOW * whole {
            let share = along / whole;
            let distance2: f32 =
                mean.iter().zip(colour).map(|(mean, value)| (share * mean - value).powi(2)).sum();
            if distance2 < options.threshold * variance * share * share {
                return true;
            }
        }
        total += weight;
        if total > BACKGROUND_WEIGHT {
            return false;
        }
    }
    false
}

/// Near which levels all channels of a colour must lie for it to be background by the heaviest mode alone: its mean, and
/// the least difference that may be too large, 0 where every one may.
#[inline(always)]
pub(super) fn screen(mode: &Mode, options: MixtureOptions) -> ([u8; 3], u8) {
    // All three channels may be off by as much, and the mean by half a level of rounding; rounded down, for distances
    // must be below the threshold.
    let reach = (options.threshold * mode[1] / 3.0).sqrt() - 0.5;
    let least = level(reach.clamp(0.5, 255.0) - 0.5);
    ([level(mode[2]), level(mode[3]), level(mode[4])], least)
}

/// The whole number nearest to a value from 0 to 255. Beside 2²³ a single has no fraction, so its lowest bits are that
/// number; a cast, which checks its range, takes several times as long.
#[inline(always)]
fn level(value: f32) -> u8 {
    (value + 8_388_608.0).to_bits() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_the_nearest() {
        for tenths in 0..=2550u16 {
            let value = f32::from(tenths) / 10.0;
            assert_eq!(level(value), value.round_ties_even() as u8, "{value}");
        }
    }

    #[test]
    fn what_passes_the_screen_is_background() {
        for threshold in [0.01, 5.0, 80.0, 1e6] {
            for variance in [4.0, 7.3, 75.0] {
                let options = MixtureOptions { threshold, shadows: false };
                let mode = [1.0, variance, 99.5, 128.49, 20.0];
                let (means, least) = screen(&mode, options);
                if least > 0 {
                    let farthest = means.map(|mean| f32::from(mean) - f32::from(least - 1));
                    assert!(difference(&mode, farthest).1 < threshold * variance, "{threshold}, {variance}");
                }
            }
        }
    }
}
