//! The mixture of Gaussians of one pixel: Zivkovic, *Improved adaptive Gaussian mixture model for background subtraction*,
//! ICPR 2004, with the shadow test of Prati et al. 2003, as `OpenCV`'s MOG2 computes them.
//!
//! Modes are sorted by weight, heaviest first. A colour is background where it is near one of the heaviest modes that
//! together weigh [`BACKGROUND_WEIGHT`].

/// Modes of a pixel at most.
pub const MODES: usize = 5;

/// Modes count as background until together they weigh so much: a new thing becomes background when it has shown
/// for 40 % of the memory.
pub(super) const BACKGROUND_WEIGHT: f32 = 0.6;

/// Squared distance, in variances, within which a mode takes a colour in; farther ones begin a mode.
pub(super) const FIT: f32 = 9.0;

const INITIAL_VARIANCE: f32 = 15.0;
pub(super) const LEAST_VARIANCE: f32 = 4.0;
pub(super) const MOST_VARIANCE: f32 = 75.0;

/// Share of a sample that each mode must earn with every frame to stay (`c_T` of the paper).
pub(super) const PRIOR: f32 = 0.05;

/// Least brightness of a shadow, as a share of the background's.
pub(super) const DARKEST_SHADOW: f32 = 0.4;

/// One Gaussian with the same variance for all channels: weight, variance, mean blue, green and red.
pub type Mode = [f32; 5];

/// How a [`Mixture`](super::Mixture) decides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MixtureOptions {
    /// Squared distance to a mode, in variances, from which on a colour is not its own.
    pub threshold: f32,
    /// Whether what is only darker than the background is no motion.
    pub shadows: bool,
}

/// The modes of one pixel.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct Pixel {
    pub modes: [Mode; MODES],
    pub used: usize,
}

impl Pixel {
    /// Whether a colour moves; and learn from it at a rate between 0 and 1.
    pub fn learn(&mut self, colour: [f32; 3], rate: f32, options: MixtureOptions) -> bool {
        let prune = -rate * PRIOR;
        let mut background = false;
        let mut fits = false;
        let mut used = self.used;
        let mut total = 0.0;
        let mut m = 0;
        while m < used {
            let mut weight = (1.0 - rate) * self.modes[m][0] + prune;
            let mut place = m;
            if !fits {
                let mode = &mut self.modes[m];
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
            self.modes[place][0] = weight;
            total += weight;
            m += 1;
        }
        if total.abs() > f32::EPSILON {
            for mode in &mut self.modes[..used] {
                mode[0] *= 1.0 / total;
            }
        }
        if !fits && rate > 0.0 {
            used = self.begin(used, colour, rate);
        }
        self.used = used;
        !(background || options.shadows && is_shadow(|m| self.modes[m], used, colour, options))
    }

    /// Add a mode, in place of the lightest where there are too many, and return how many there are now.
    fn begin(&mut self, used: usize, colour: [f32; 3], rate: f32) -> usize {
        let used = (used + 1).min(MODES);
        let last = used - 1;
        let weight = if used == 1 { 1.0 } else { rate };
        if used > 1 {
            for mode in &mut self.modes[..last] {
                mode[0] *= 1.0 - rate;
            }
        }
        self.modes[last] = [weight, INITIAL_VARIANCE, colour[0], colour[1], colour[2]];
        self.sorted_in(last, rate);
        used
    }

    /// Move a mode before those that are not heavier than `weight`, and return its place.
    fn sorted_in(&mut self, m: usize, weight: f32) -> usize {
        let mut place = m;
        while place > 0 && weight >= self.modes[place - 1][0] {
            self.modes.swap(place - 1, place);
            place -= 1;
        }
        place
    }

    /// Whether a colour moves, by the modes as they are: [`Pixel::learn`] at a rate of 0, which `lanes` does with many pixels at once.
    #[cfg(test)]
    pub fn moves(&self, colour: [f32; 3], options: MixtureOptions) -> bool {
        let modes = &self.modes[..self.used];
        let mut total = 0.0;
        for mode in modes {
            if total >= BACKGROUND_WEIGHT {
                break;
            }
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
        let whole = 1.0 / modes.iter().map(|mode| mode[0]).fold(0.0, |sum, weight| sum + weight);
        let mode = |m: usize| {
            let [weight, rest @ ..] = modes[m];
            [weight * whole, rest[0], rest[1], rest[2], rest[3]]
        };
        !(options.shadows && is_shadow(mode, self.used, colour, options))
    }
}

/// What `lanes` does with many pixels at once: whether a colour moves; and learn from it. A pixel with one mode, which weighs 1 and which the
/// colour fits, keeps its weight.
#[cfg(test)]
pub(super) fn learn_plainly(pixel: &mut Pixel, colour: [f32; 3], rate: f32, options: MixtureOptions) -> bool {
    let mode = &mut pixel.modes[0];
    let variance = mode[1];
    let (apart, distance2) = difference(mode, colour);
    if pixel.used != 1 || distance2 >= FIT.min(options.threshold) * variance {
        return pixel.learn(colour, rate, options);
    }
    let step = rate / (1.0 - rate * PRIOR);
    for (mean, apart) in mode[2..].iter_mut().zip(apart) {
        *mean -= step * apart;
    }
    mode[1] = (variance + step * (distance2 - variance)).clamp(LEAST_VARIANCE, MOST_VARIANCE);
    false
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

/// The whole number nearest to a value from 0 to 255. Beside 2²³ a single has no fraction, so its lowest bits are that
/// number; a cast, which checks its range, takes several times as long.
#[inline(always)]
pub(super) fn level(value: f32) -> u8 {
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
}
