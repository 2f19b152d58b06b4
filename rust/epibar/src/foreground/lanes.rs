//! Pixels side by side, which learn together where the colour of each fits its heaviest mode: what nearly all do.
//!
//! The operations of [`Pixel::learn`], in its order and in single precision, on vectors as wide as the CPU has them, so every width
//! gives the same bits.

use std::ops::{Add, Div, Mul, Sub};

use pulp::Simd;

use super::pixel::{
    BACKGROUND_WEIGHT, DARKEST_SHADOW, FIT, LEAST_VARIANCE, MODES, MOST_VARIANCE, MixtureOptions, Mode,
    PRIOR, Pixel, level,
};

/// Pixels side by side.
pub(super) const LANES: usize = 16;

/// Numbers of pixels side by side.
pub(super) type Numbers = [f32; LANES];

/// What [`Mode`] has of the `m`-th mode of pixels side by side, but for the weight: variance, mean blue, green and red.
pub(super) type Gaussians = [Numbers; 4];

/// Modes of all pixels of a row, block by block: the `m`-th of each lie together, and their weights, which change where nothing else of
/// a mode does, apart from the rest.
pub(super) struct Planes<'m> {
    pub weights: [&'m mut [Numbers]; MODES],
    pub gaussians: [&'m mut [Gaussians]; MODES],
}

impl Planes<'_> {
    /// The modes of one pixel of a row.
    pub fn load(&self, used: u8, x: usize) -> Pixel {
        let mut pixel = Pixel { modes: [[0.0; 5]; MODES], used: usize::from(used) };
        for (m, mode) in pixel.modes.iter_mut().enumerate().take(usize::from(used)) {
            let [variance, blue, green, red] = self.gaussians[m][x / LANES].map(|field| field[x % LANES]);
            *mode = [self.weights[m][x / LANES][x % LANES], variance, blue, green, red];
        }
        pixel
    }

    /// Writes the first modes of one pixel of a row.
    fn store(&mut self, x: usize, modes: &[Mode]) {
        for (m, [weight, rest @ ..]) in modes.iter().enumerate() {
            self.weights[m][x / LANES][x % LANES] = *weight;
            for (field, value) in self.gaussians[m][x / LANES].iter_mut().zip(rest) {
                field[x % LANES] = *value;
            }
        }
    }

    /// [`Pixel::learn`] of one pixel of a row.
    pub fn learn(
        &mut self,
        x: usize,
        used: &mut u8,
        colour: [f32; 3],
        rate: Rate,
        options: MixtureOptions,
    ) -> bool {
        let mut pixel = self.load(*used, x);
        let moves = pixel.learn(colour, rate.rate, options);
        self.store(x, &pixel.modes[..pixel.used.max(usize::from(*used))]);
        *used = pixel.used as u8;
        moves
    }
}

/// A rate of learning, and what follows from it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rate {
    pub rate: f32,
    /// The step of a mode that weighs 1.
    step: f32,
}

impl Rate {
    pub fn new(rate: f32) -> Self {
        Self { rate, step: rate / (1.0 - rate * PRIOR) }
    }
}

/// Learns from the colours of pixels side by side that fit their heaviest modes, and returns which these are: 1, or 0.
/// They are background. Weights of pixels with one mode are 1, and stay so.
#[inline(always)]
pub(super) fn settle<S: Simd>(
    simd: S,
    planes: &mut Planes<'_>,
    block: usize,
    used: &mut [u8; LANES],
    colours: [&[u8; LANES]; 3],
    rate: Rate,
    options: MixtureOptions,
) -> Numbers {
    let mut settled = [0.0; LANES];
    let most = usize::from(used.iter().fold(0, |most, &used| most.max(used)));
    if most == 0 {
        return settled;
    }
    let mut counts = used.map(f32::from);
    let colours = colours.map(|channel| channel.map(f32::from));
    let number = |value: f32| Lane(simd, simd.splat_f32s(value));
    let (keep, prune, lost) =
        (number(1.0 - rate.rate), number(-rate.rate * PRIOR), number(rate.rate * PRIOR));
    for k in 0..LANES / Lane::<S>::WIDTH {
        let at = |values: &Numbers| Lane::at(simd, values, k);
        let [variance, blue, green, red] = &mut planes.gaussians[0][block];
        let weight = &mut planes.weights[0][block];
        let old = at(variance);
        let apart = [at(blue) - at(&colours[0]), at(green) - at(&colours[1]), at(red) - at(&colours[2])];
        let distance2 = squares(apart);
        let mut count = at(&counts);
        let near = distance2.below(number(FIT.min(options.threshold)) * old);
        let ours = simd.and_m32s(near, number(0.5).below(count));
        number(1.0).or(ours, number(0.0)).put(&mut settled, k);
        let several = number(1.5).below(count);
        let heavier = keep * at(weight) + prune + number(rate.rate);
        let step = (number(rate.rate) / heavier).or(several, number(rate.step));
        for (mean, apart) in [blue, green, red].into_iter().zip(apart) {
            (at(mean) - step * apart).or(ours, at(mean)).put(mean, k);
        }
        let moved = old + step * (distance2 - old);
        let moved = number(LEAST_VARIANCE).or(moved.below(number(LEAST_VARIANCE)), moved);
        let moved = number(MOST_VARIANCE).or(number(MOST_VARIANCE).below(moved), moved);
        moved.or(ours, old).put(variance, k);
        if most == 1 {
            continue;
        }
        let ours = simd.and_m32s(ours, several);
        heavier.or(ours, at(weight)).put(weight, k);
        let mut total = heavier;
        for m in 1..most {
            let weight = &mut planes.weights[m][block];
            let left = simd.and_m32s(ours, number(m as f32).below(count));
            let lighter = keep * at(weight) + prune;
            let gone = lighter.below(lost);
            let lighter = number(0.0).or(gone, lighter);
            count = (count - number(1.0)).or(simd.and_m32s(left, gone), count);
            total = (total + lighter).or(left, total);
            lighter.or(left, at(weight)).put(weight, k);
        }
        count.put(&mut counts, k);
        let ours = simd.and_m32s(ours, number(f32::EPSILON).below(total));
        let share = number(1.0) / total;
        for m in 0..most {
            let weight = &mut planes.weights[m][block];
            let left = simd.and_m32s(ours, number(m as f32).below(count));
            (at(weight) * share).or(left, at(weight)).put(weight, k);
        }
    }
    if most > 1 {
        *used = counts.map(level);
    }
    settled
}

/// Which colours of pixels side by side move, as [`Pixel::moves`] says: 1, or 0.
#[inline(always)]
pub(super) fn moving<S: Simd>(
    simd: S,
    planes: &Planes<'_>,
    block: usize,
    used: &[u8; LANES],
    colours: &[Numbers; 3],
    options: MixtureOptions,
) -> Numbers {
    let mut moving = [1.0; LANES];
    let most = usize::from(used.iter().fold(0, |most, &used| most.max(used)));
    let counts = used.map(f32::from);
    let number = |value: f32| Lane(simd, simd.splat_f32s(value));
    let zero = number(0.0);
    let (threshold, fit, heavy) = (number(options.threshold), number(FIT), number(BACKGROUND_WEIGHT));
    for k in 0..LANES / Lane::<S>::WIDTH {
        let at = |values: &Numbers| Lane::at(simd, values, k);
        let count = at(&counts);
        let colour = [at(&colours[0]), at(&colours[1]), at(&colours[2])];
        let (mut asked, mut moves) = (zero.below(number(1.0)), number(1.0));
        let mut total = zero;
        for m in 0..most {
            let there = number(m as f32).below(count);
            asked = simd.and_m32s(asked, simd.and_m32s(there, total.below(heavy)));
            if none(simd, asked) {
                break;
            }
            let [variance, blue, green, red] = &planes.gaussians[m][block];
            let (variance, mean) = (at(variance), [at(blue), at(green), at(red)]);
            let distance2 = squares([mean[0] - colour[0], mean[1] - colour[1], mean[2] - colour[2]]);
            let near = simd.and_m32s(asked, distance2.below(threshold * variance));
            moves = zero.or(near, moves);
            asked = simd.and_m32s(asked, simd.not_m32s(distance2.below(fit * variance)));
            asked = simd.and_m32s(asked, simd.not_m32s(near));
            total = (total + at(&planes.weights[m][block])).or(asked, total);
        }
        let mut asked = zero.below(moves);
        if options.shadows && !none(simd, asked) {
            let mut whole = zero;
            for m in 0..most {
                whole = (whole + at(&planes.weights[m][block])).or(number(m as f32).below(count), whole);
            }
            let whole = number(1.0) / whole;
            let mut total = zero;
            for m in 0..most {
                asked = simd.and_m32s(asked, number(m as f32).below(count));
                if none(simd, asked) {
                    break;
                }
                let [variance, blue, green, red] = &planes.gaussians[m][block];
                let (variance, mean) = (at(variance), [at(blue), at(green), at(red)]);
                let along = mean[0] * colour[0] + mean[1] * colour[1] + mean[2] * colour[2];
                let length = squares(mean);
                asked = simd.and_m32s(asked, zero.below(length));
                let darker = simd
                    .and_m32s(along.not_above(length), (number(DARKEST_SHADOW) * length).not_above(along));
                let share = along / length;
                let distance2 = squares([
                    share * mean[0] - colour[0],
                    share * mean[1] - colour[1],
                    share * mean[2] - colour[2],
                ]);
                let near = distance2.below(threshold * variance * share * share);
                let shadow = simd.and_m32s(asked, simd.and_m32s(darker, near));
                moves = zero.or(shadow, moves);
                total = total + at(&planes.weights[m][block]) * whole;
                asked = simd.and_m32s(asked, simd.not_m32s(heavy.below(total)));
            }
        }
        moves.put(&mut moving, k);
    }
    moving
}

/// Whether a mask is empty.
#[inline(always)]
fn none<S: Simd>(simd: S, mask: S::m32s) -> bool {
    simd.first_true_m32s(mask) == Lane::<S>::WIDTH
}

/// Sum of the squares.
#[inline(always)]
fn squares<S: Simd>([blue, green, red]: [Lane<S>; 3]) -> Lane<S> {
    blue * blue + green * green + red * red
}

/// Levels of pixels side by side near which a colour is background, as what passes them is sure to be.
#[inline(always)]
pub(super) fn screens<S: Simd>(simd: S, modes: &Gaussians, options: MixtureOptions) -> [[u8; LANES]; 4] {
    let number = |value: f32| Lane(simd, simd.splat_f32s(value));
    let mut reaches = [0.0; LANES];
    for k in 0..LANES / Lane::<S>::WIDTH {
        let variance = Lane::at(simd, &modes[0], k);
        let reach = (number(options.threshold) * variance / number(3.0)).sqrt() - number(0.5);
        let reach = number(0.5).or(reach.below(number(0.5)), reach);
        let reach = number(255.0).or(number(255.0).below(reach), reach);
        (reach - number(0.5)).put(&mut reaches, k);
    }
    [&modes[1], &modes[2], &modes[3], &reaches].map(|values| values.map(level))
}

/// A vector of numbers, and what the CPU has to reckon with it.
#[derive(Clone, Copy)]
struct Lane<S: Simd>(S, S::f32s);

impl<S: Simd> Lane<S> {
    const WIDTH: usize = size_of::<S::f32s>() / size_of::<f32>();

    /// The `k`-th vector of numbers side by side.
    #[inline(always)]
    fn at(simd: S, values: &Numbers, k: usize) -> Self {
        Self(simd, S::as_simd_f32s(values).0[k])
    }

    /// Writes it as the `k`-th.
    #[inline(always)]
    fn put(self, values: &mut Numbers, k: usize) {
        S::as_mut_simd_f32s(values).0[k] = self.1;
    }

    /// Where it is less.
    #[inline(always)]
    fn below(self, other: Self) -> S::m32s {
        self.0.less_than_f32s(self.1, other.1)
    }

    /// Where it is less or equal.
    #[inline(always)]
    fn not_above(self, other: Self) -> S::m32s {
        self.0.less_than_or_equal_f32s(self.1, other.1)
    }

    /// Itself where the mask says so, and the other elsewhere.
    #[inline(always)]
    fn or(self, mask: S::m32s, other: Self) -> Self {
        Self(self.0, self.0.select_f32s(mask, self.1, other.1))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0, self.0.sqrt_f32s(self.1))
    }
}

macro_rules! operator {
    ($operator:ident, $method:ident, $of_simd:ident) => {
        impl<S: Simd> $operator for Lane<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0, self.0.$of_simd(self.1, other.1))
            }
        }
    };
}

operator!(Add, add, add_f32s);
operator!(Sub, sub, sub_f32s);
operator!(Mul, mul, mul_f32s);
operator!(Div, div, div_f32s);

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::{Arch, WithSimd};

    struct Screens<'a>(&'a Gaussians, MixtureOptions);

    impl WithSimd for Screens<'_> {
        type Output = [[u8; LANES]; 4];

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            screens(simd, self.0, self.1)
        }
    }

    #[test]
    fn what_passes_the_screen_is_background() {
        for threshold in [0.01, 5.0, 80.0, 1e6] {
            for variance in [4.0, 7.3, 75.0] {
                let options = MixtureOptions { threshold, shadows: false };
                let mode = [variance, 99.5, 128.49, 20.0];
                let found = Arch::new().dispatch(Screens(&mode.map(|value| [value; LANES]), options));
                let [blue, green, red, least] = found.map(|levels| levels[LANES - 1]);
                // All three channels may be off by as much, and the mean by half a level of rounding.
                let reach = (threshold * variance / 3.0).sqrt() - 1.0;
                assert_eq!(
                    f32::from(least),
                    reach.clamp(0.0, 254.5).round_ties_even(),
                    "{threshold}, {variance}"
                );
                if least > 0 {
                    let farthest = [blue, green, red].map(|mean| f32::from(mean) - f32::from(least - 1));
                    let distance2 = mode[1..].iter().zip(farthest).map(|(mean, far)| (mean - far).powi(2));
                    assert!(distance2.sum::<f32>() < threshold * variance, "{threshold}, {variance}");
                }
            }
        }
    }
}
