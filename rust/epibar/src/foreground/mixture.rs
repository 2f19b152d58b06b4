//! A mixture of Gaussians for every pixel of a camera, as `OpenCV`'s MOG2 has, with rows that learn in turn.
//!
//! MOG2 learns from every pixel of every frame, and reading and writing all modes is most of its time. With a memory of
//! thousands of frames that is more than it takes: here each row learns from every seventeenth frame at seventeen times the rate,
//! and in between is only looked at. Looking is a comparison of bytes: where each channel is within reach of the heaviest mode the
//! pixel is background, and only the others, mostly those that move, are asked of all modes. The screen changes
//! nothing: a pixel that passes it is background by the equations of [`super::pixel`] as well.

use rayon::prelude::*;

use super::pixel::{MODES, MixtureOptions, Mode, Pixel, moves, screen, settle};
use crate::error::{Error, Result};
use crate::image::ImageSize;

/// Frames in which each row learns once, at most. A prime number: light that flickers with a period of 2, 4 or 8 frames would show each row
/// always the same phase of it otherwise, and the others would be forgotten.
const MOST_TURNS: usize = 17;

/// The rate at which a row learns at most, about, if it does not learn from every frame.
const MOST_RATE: f32 = 0.01;

/// Rows of one task at least.
const TASK_ROWS: usize = 16;

/// Pixels that are screened together, and their bytes.
const GROUP: usize = 64;
const GROUP_BYTES: usize = 3 * GROUP;

/// A background model that knows nothing at first.
#[derive(Debug, Clone)]
pub struct Mixture {
    size: ImageSize,
    options: MixtureOptions,
    /// The `m`-th modes of all pixels. Most pixels use one or two, and memory is taken where a mode is written for the first time,
    /// so one plane is one allocation of zeros.
    planes: [Vec<Mode>; MODES],
    used: Vec<u8>,
    level: Vec<u8>,
    too_far: Vec<u8>,
    /// Frames that were looked at.
    seen: usize,
}

/// One row of a model.
struct ModelRow<'m> {
    planes: [&'m mut [Mode]; MODES],
    used: &'m mut [u8],
    /// Of each channel of each pixel: the rounded mean of the heaviest mode, and the least difference that is too large.
    level: &'m mut [u8],
    too_far: &'m mut [u8],
}

impl Mixture {
    /// A model of frames of some size.
    ///
    /// # Errors
    /// [`Error::Argument`] for a threshold that is not positive and finite.
    pub fn new(size: ImageSize, options: MixtureOptions) -> Result<Self> {
        if !(options.threshold > 0.0 && options.threshold.is_finite()) {
            return Err(Error::Argument {
                name: "threshold",
                value: options.threshold.to_string(),
                expected: "must be positive and finite",
            });
        }
        let pixels = size.pixels();
        Ok(Self {
            size,
            options,
            planes: std::array::from_fn(|_| vec![[0.0; 5]; pixels]),
            used: vec![0; pixels],
            level: vec![0; 3 * pixels],
            too_far: vec![0; 3 * pixels],
            seen: 0,
        })
    }

    /// Size of the frames.
    pub fn size(&self) -> ImageSize {
        self.size
    }

    /// Learns from all rows of a frame at a rate between 0 and 1, and gives the mask of what moves.
    ///
    /// # Errors
    /// [`Error::Length`] for a frame of another size, [`Error::Argument`] for another rate.
    pub fn learn(&mut self, frame: &[u8], rate: f32) -> Result<Vec<u8>> {
        self.apply(frame, |_| Some(rate), rate)
    }

    /// The mask of what moves. Rows take turns to learn, so many times faster, as far as the rate is low.
    ///
    /// # Errors
    /// [`Error::Length`] for a frame of another size, [`Error::Argument`] for a rate that is not between 0 and 1.
    pub fn look(&mut self, frame: &[u8], rate: f32) -> Result<Vec<u8>> {
        let turns = turns(rate);
        let turn = self.seen % turns;
        self.seen += 1;
        self.apply(frame, |y| (y % turns == turn).then_some(rate * turns as f32), rate)
    }

    fn apply(
        &mut self,
        frame: &[u8],
        rate_of: impl Fn(usize) -> Option<f32> + Sync,
        rate: f32,
    ) -> Result<Vec<u8>> {
        if frame.len() != 3 * self.size.pixels() {
            return Err(Error::Length {
                what: "a frame must have three bytes for each pixel of the model",
                left: frame.len(),
                right: 3 * self.size.pixels(),
            });
        }
        if !(0.0..=1.0).contains(&rate) {
            return Err(Error::Argument {
                name: "rate",
                value: rate.to_string(),
                expected: "must be between 0 and 1",
            });
        }
        let (width, options) = (self.size.width, self.options);
        let mut mask = vec![0; self.size.pixels()];
        let rows = self.rows().into_par_iter().zip(frame.par_chunks_exact(3 * width));
        let rows = rows.zip(mask.par_chunks_exact_mut(width)).enumerate().with_min_len(TASK_ROWS);
        rows.for_each(|(y, ((mut row, colours), mask))| match rate_of(y) {
            Some(rate) => row.learn(colours, mask, rate, options),
            None => row.look(colours, mask, options),
        });
        Ok(mask)
    }

    fn rows(&mut self) -> Vec<ModelRow<'_>> {
        let width = self.size.width;
        let mut planes = self.planes.each_mut().map(|plane| plane.chunks_exact_mut(width));
        let screens = self.level.chunks_exact_mut(3 * width).zip(self.too_far.chunks_exact_mut(3 * width));
        let rows = self.used.chunks_exact_mut(width).zip(screens);
        rows.map(|(used, (level, too_far))| {
            let planes = planes.each_mut().map(|plane| plane.next().unwrap_or_default());
            ModelRow { planes, used, level, too_far }
        })
        .collect()
    }
}

/// Frames in which each row learns once.
fn turns(rate: f32) -> usize {
    ((MOST_RATE / rate).round() as usize).clamp(1, MOST_TURNS)
}

impl ModelRow<'_> {
    fn learn(&mut self, colours: &[u8], mask: &mut [u8], rate: f32, options: MixtureOptions) {
        let pixels = colours.as_chunks::<3>().0.iter().zip(mask);
        let screens = self.level.as_chunks_mut::<3>().0.iter_mut().zip(self.too_far.as_chunks_mut::<3>().0);
        for (x, (((colour, moving), used), (level, too_far))) in
            pixels.zip(&mut *self.used).zip(screens).enumerate()
        {
            let colour = colour.map(f32::from);
            if *used != 1 || !settle(&mut self.planes[0][x], colour, rate, options) {
                let mut pixel = Pixel { planes: &mut self.planes, used, x };
                *moving = u8::from(pixel.learn(colour, rate, options));
            }
            let (means, least) = screen(&self.planes[0][x], options);
            *level = means;
            *too_far = [least; 3];
        }
    }

    fn look(&self, colours: &[u8], mask: &mut [u8], options: MixtureOptions) {
        let (groups, rest) = colours.as_chunks::<GROUP_BYTES>();
        let (levels, rest_levels) = self.level.as_chunks::<GROUP_BYTES>();
        let (bounds, rest_bounds) = self.too_far.as_chunks::<GROUP_BYTES>();
        let mut far = [0; GROUP_BYTES];
        for (g, ((group, level), too_far)) in groups.iter().zip(levels).zip(bounds).enumerate() {
            if screened(&mut far, group, level, too_far) {
                self.ask(g * GROUP, &far, group, mask, options);
            }
        }
        if screened(&mut far, rest, rest_levels, rest_bounds) {
            self.ask(groups.len() * GROUP, &far[..rest.len()], rest, mask, options);
        }
    }

    /// Asks all modes about the pixels from `first` on of which a channel is far.
    fn ask(&self, first: usize, far: &[u8], colours: &[u8], mask: &mut [u8], options: MixtureOptions) {
        let pixels = far.as_chunks::<3>().0.iter().zip(colours.as_chunks::<3>().0);
        for (x, (far, colour)) in (first..).zip(pixels) {
            if *far != [0; 3] {
                mask[x] = u8::from(moves(&self.planes, self.used[x], x, colour.map(f32::from), options));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::generator;
    use rand::RngExt;

    const SIZE: (usize, usize) = (70, 24);

    fn frames(count: usize) -> Vec<Vec<u8>> {
        let mut random = generator(3, 0);
        let bytes = 3 * SIZE.0 * SIZE.1;
        let empty: Vec<f32> = (0..bytes).map(|_| random.random_range(0.0..255.0)).collect();
        (0..count)
            .map(|t| {
                let light = 1.0 - 0.3 * f32::from(t % 3 == 0);
                let noisy = |(i, level): (usize, &f32)| {
                    let x = i / 3 % SIZE.0;
                    let level = if (x + t) % 35 < 9 { 255.0 - level } else { *level };
                    (light * level + random.random_range(-9.0..9.0f32)).clamp(0.0, 255.0) as u8
                };
                empty.iter().enumerate().map(noisy).collect()
            })
            .collect()
    }

    #[test]
    fn the_screen_changes_nothing() {
        let size = ImageSize::new(SIZE.0, SIZE.1).unwrap();
        for (threshold, shadows) in [(80.0, true), (16.0, false), (0.01, false), (1e6, true)] {
            let mut model = Mixture::new(size, MixtureOptions { threshold, shadows }).unwrap();
            let mut moving = 0;
            for (t, frame) in frames(60).iter().enumerate() {
                let rate = if t < 10 { 1.0 / (t + 1) as f32 } else { 0.002 };
                if t < 10 {
                    model.learn(frame, rate).unwrap();
                    continue;
                }
                let before = model.clone();
                let mask = model.look(frame, rate).unwrap();
                for (i, colour) in frame.as_chunks::<3>().0.iter().enumerate() {
                    let (x, y) = (i % SIZE.0, i / SIZE.0);
                    // Rows whose turn it is learn, and are not screened.
                    let asked =
                        moves(&before.planes, before.used[i], i, colour.map(f32::from), model.options);
                    let learns = y % 5 == (t - 10) % 5;
                    assert!(
                        learns || mask[i] == u8::from(asked),
                        "threshold {threshold}, frame {t}, {x} {y}"
                    );
                }
                moving += mask.iter().map(|&v| usize::from(v)).sum::<usize>();
            }
            assert!(threshold > 1000.0 || moving > 1000, "{moving}");
        }
    }

    #[test]
    fn rows_take_turns_where_the_rate_is_low() {
        assert_eq!([0.0, 0.0005, 0.002, 0.009, 0.05, 1.0].map(turns), [17, 17, 5, 1, 1, 1]);
    }

    #[test]
    fn bad_input_is_refused() {
        let size = ImageSize::new(4, 4).unwrap();
        let options = MixtureOptions { threshold: 80.0, shadows: true };
        let mut model = Mixture::new(size, options).unwrap();
        assert!(matches!(model.look(&[0; 47], 0.1), Err(Error::Length { .. })));
        for rate in [-0.1, 1.5, f32::NAN] {
            assert!(matches!(model.learn(&[0; 48], rate), Err(Error::Argument { name: "rate", .. })));
        }
        for threshold in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(Mixture::new(size, MixtureOptions { threshold, shadows: true }).is_err());
        }
    }
}
