//! Rows of a mixture, and the passes over them: a row learns, from one frame or from samples of the empty scene, or is looked at.

use pulp::{Simd, WithSimd};

use super::lanes::{LANES, Planes, Rate, moving, screens, settle};
use super::pixel::MixtureOptions;

/// Pixels that are screened together, and their bytes.
const GROUP: usize = 64;
const GROUP_BYTES: usize = 3 * GROUP;

/// One row of a model.
pub(super) struct ModelRow<'m> {
    pub planes: Planes<'m>,
    pub used: &'m mut [[u8; LANES]],
    /// Of each channel of each pixel: the rounded mean of the heaviest mode, and the least difference that is too large.
    pub level: &'m mut [u8],
    pub too_far: &'m mut [u8],
}

/// Colours of a row channel by channel, in whole blocks.
pub(super) struct Channels([Vec<[u8; LANES]>; 3]);

impl Channels {
    pub fn new(width: usize) -> Self {
        Self(std::array::from_fn(|_| vec![[0; LANES]; width.div_ceil(LANES)]))
    }

    #[inline(always)]
    fn take_apart(&mut self, colours: &[u8]) {
        let [blue, green, red] = self.0.each_mut().map(|channel| channel.as_flattened_mut());
        let channels = blue.iter_mut().zip(green).zip(red);
        for (((blue, green), red), colour) in channels.zip(colours.as_chunks::<3>().0) {
            (*blue, *green, *red) = (colour[0], colour[1], colour[2]);
        }
    }
}

/// Pass: a row learns.
pub(super) struct Learning<'p, 'm> {
    pub row: ModelRow<'m>,
    pub colours: &'p [u8],
    pub mask: &'p mut [u8],
    pub channels: &'p mut Channels,
    pub rate: Rate,
    pub options: MixtureOptions,
}

impl WithSimd for Learning<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        self.channels.take_apart(self.colours);
        self.row.learn(simd, self.channels, self.mask, self.rate, self.options);
        self.row.screen(simd, self.channels, self.options);
    }
}

/// Pass: a row learns from samples, one after the other, each of which weighs as much as each of those before.
pub(super) struct Priming<'p, 'm, I> {
    pub row: ModelRow<'m>,
    pub colours: I,
    pub channels: &'p mut Channels,
    pub options: MixtureOptions,
}

impl<'p, I: Iterator<Item = &'p [u8]>> WithSimd for Priming<'_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let mut mask = vec![0; self.row.level.len() / 3];
        for (number, colours) in self.colours.enumerate() {
            let rate = Rate::new((1.0 / (number + 1) as f64) as f32);
            self.channels.take_apart(colours);
            self.row.learn(simd, self.channels, &mut mask, rate, self.options);
        }
        self.row.screen(simd, self.channels, self.options);
    }
}

/// Pass: a row is looked at.
pub(super) struct Looking<'p, 'm> {
    pub row: ModelRow<'m>,
    pub colours: &'p [u8],
    pub mask: &'p mut [u8],
    pub options: MixtureOptions,
}

impl WithSimd for Looking<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.row.look(simd, self.colours, self.mask, self.options);
    }
}

impl ModelRow<'_> {
    #[inline(always)]
    fn learn<S: Simd>(
        &mut self,
        simd: S,
        channels: &Channels,
        mask: &mut [u8],
        rate: Rate,
        options: MixtureOptions,
    ) {
        for (block, mask) in mask.chunks_mut(LANES).enumerate() {
            let colours = channels.0.each_ref().map(|channel| &channel[block]);
            let settled =
                settle(simd, &mut self.planes, block, &mut self.used[block], colours, rate, options);
            if settled.iter().fold(u32::MAX, |all, one| all & one.to_bits()) == 0 {
                self.learn_rest(block, &settled, colours, mask, rate, options);
            }
        }
    }

    /// Learns from the pixels of a block that are not settled, one by one.
    fn learn_rest(
        &mut self,
        block: usize,
        settled: &[f32; LANES],
        colours: [&[u8; LANES]; 3],
        mask: &mut [u8],
        rate: Rate,
        options: MixtureOptions,
    ) {
        let rest = mask.iter_mut().enumerate().filter(|(lane, _)| settled[*lane] == 0.0);
        for (lane, moving) in rest {
            let colour = colours.map(|channel| f32::from(channel[lane]));
            let (x, used) = (block * LANES + lane, &mut self.used[block][lane]);
            *moving = u8::from(self.planes.learn(x, used, colour, rate, options));
        }
    }

    /// Notes what the heaviest modes screen; `channels` is room for it.
    #[inline(always)]
    fn screen<S: Simd>(&mut self, simd: S, channels: &mut Channels, options: MixtureOptions) {
        let [blue, green, red] = &mut channels.0;
        let far = self.too_far.chunks_mut(3 * LANES);
        for (block, (modes, far)) in self.planes.gaussians[0].iter().zip(far).enumerate() {
            let least;
            [blue[block], green[block], red[block], least] = screens(simd, modes, options);
            for (far, least) in far.as_chunks_mut::<3>().0.iter_mut().zip(least) {
                *far = [least; 3];
            }
        }
        let [blue, green, red] = channels.0.each_ref().map(|channel| channel.as_flattened());
        let levels = self.level.as_chunks_mut::<3>().0.iter_mut();
        for (level, ((blue, green), red)) in levels.zip(blue.iter().zip(green).zip(red)) {
            *level = [*blue, *green, *red];
        }
    }

    #[inline(always)]
    fn look<S: Simd>(&self, simd: S, colours: &[u8], mask: &mut [u8], options: MixtureOptions) {
        let (groups, rest) = colours.as_chunks::<GROUP_BYTES>();
        let (levels, rest_levels) = self.level.as_chunks::<GROUP_BYTES>();
        let (bounds, rest_bounds) = self.too_far.as_chunks::<GROUP_BYTES>();
        let mut far = [0; GROUP_BYTES];
        for (g, ((group, level), too_far)) in groups.iter().zip(levels).zip(bounds).enumerate() {
            if screened(&mut far, group, level, too_far) {
                self.ask(simd, g * GROUP, &far, group, mask, options);
            }
        }
        if screened(&mut far, rest, rest_levels, rest_bounds) {
            self.ask(simd, groups.len() * GROUP, &far[..rest.len()], rest, mask, options);
        }
    }

    /// Asks all modes about the pixels from `first` on, block by block of those in which a channel is far.
    #[inline(always)]
    fn ask<S: Simd>(
        &self,
        simd: S,
        first: usize,
        far: &[u8],
        colours: &[u8],
        mask: &mut [u8],
        options: MixtureOptions,
    ) {
        let blocks =
            far.chunks(3 * LANES).zip(colours.chunks(3 * LANES)).zip(mask[first..].chunks_mut(LANES));
        for (block, ((far, colours), mask)) in (first / LANES..).zip(blocks) {
            if far.iter().fold(0, |any, far| any | far) == 0 {
                continue;
            }
            let mut channels = [[0.0; LANES]; 3];
            for (lane, colour) in colours.as_chunks::<3>().0.iter().enumerate() {
                for (channel, value) in channels.iter_mut().zip(colour) {
                    channel[lane] = f32::from(*value);
                }
            }
            let moving = moving(simd, &self.planes, block, &self.used[block], &channels, options);
            for (mask, moving) in mask.iter_mut().zip(moving) {
                *mask = u8::from(moving > 0.0);
            }
        }
    }
}

/// Which channels are too far from their levels, and whether any is. Of a whole group the compiler makes a few vectors.
#[inline(always)]
fn screened(far: &mut [u8; GROUP_BYTES], colours: &[u8], level: &[u8], too_far: &[u8]) -> bool {
    let mut any = 0;
    for (far, ((colour, level), least)) in far.iter_mut().zip(colours.iter().zip(level).zip(too_far)) {
        *far = u8::from(colour.abs_diff(*level) >= *least);
        any |= *far;
    }
    any != 0
}
