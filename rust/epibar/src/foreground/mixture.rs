//! A mixture of Gaussians for every pixel of a camera, as `OpenCV`'s MOG2 has, with rows that learn in turn.
//!
//! MOG2 learns from every pixel of every frame, and reading and writing all modes is most of its time. With a memory of
//! thousands of frames that is more than it takes: here each row learns from every seventeenth frame at seventeen times the rate,
//! and in between is only looked at. Looking is a comparison of bytes: where each channel is within reach of the heaviest mode the
//! pixel is background, and only the others, mostly those that move, are asked of all modes. The screen changes
//! nothing: a pixel that passes it is background by the equations of [`super::pixel`] as well.

use pulp::Arch;
use rayon::prelude::*;

use super::lanes::{Gaussians, LANES, Numbers, Planes, Rate};
use super::pixel::{MODES, MixtureOptions};
use super::row::{Channels, Learning, Looking, ModelRow, Priming};
use crate::error::{Error, Result};
use crate::image::ImageSize;

/// Frames in which each row learns once, at most. A prime number: light that flickers with a period of 2, 4 or 8 frames would show each row
/// always the same phase of it otherwise, and the others would be forgotten.
const MOST_TURNS: usize = 17;

/// The rate at which a row learns at most, about, if it does not learn from every frame.
const MOST_RATE: f32 = 0.01;

/// Rows of one task at least.
const TASK_ROWS: usize = 16;

/// A background model that knows nothing at first.
#[derive(Debug, Clone)]
pub struct Mixture {
    arch: Arch,
    size: ImageSize,
    options: MixtureOptions,
    /// The `m`-th modes of all pixels, row by row, each of whole blocks. Most pixels use one or two, and memory is taken where a mode is
    /// written for the first time, so those of one number are one allocation of zeros.
    weights: [Vec<Numbers>; MODES],
    gaussians: [Vec<Gaussians>; MODES],
    used: Vec<[u8; LANES]>,
    level: Vec<u8>,
    too_far: Vec<u8>,
    /// Frames that were looked at.
    seen: usize,
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
        let (pixels, blocks) = (size.pixels(), size.width.div_ceil(LANES) * size.height);
        Ok(Self {
            arch: Arch::new(),
            size,
            options,
            weights: std::array::from_fn(|_| vec![[0.0; LANES]; blocks]),
            gaussians: std::array::from_fn(|_| vec![[[0.0; LANES]; 4]; blocks]),
            used: vec![[0; LANES]; blocks],
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

    /// Learns the empty scene from samples of it, whole frames one after the other: those that `order` names, in this order, each of which
    /// weighs as much as each of those before. The same as [`Mixture::learn`] of each at rates of 1, 1/2, 1/3 and so on, but row by row,
    /// so that modes stay in the cache.
    ///
    /// # Errors
    /// [`Error::Length`] for samples that are no whole frames, or where `order` names another one.
    pub fn prime(&mut self, samples: &[u8], order: &[usize]) -> Result<()> {
        let (width, options, arch) = (self.size.width, self.options, self.arch);
        let frames: Vec<&[u8]> = samples.chunks_exact(3 * self.size.pixels()).collect();
        let needed = order.iter().max().map_or(0, |last| last + 1);
        if !samples.len().is_multiple_of(3 * self.size.pixels()) || frames.len() < needed {
            return Err(Error::Length {
                what: "samples must be whole frames of three bytes for each pixel of the model, as many as are named",
                left: samples.len(),
                right: 3 * self.size.pixels() * needed,
            });
        }
        let rows = self.rows().into_par_iter().enumerate().with_min_len(TASK_ROWS);
        rows.for_each_init(
            || Channels::new(width),
            |channels, (y, row)| {
                let colours = order.iter().map(|&n| &frames[n][3 * y * width..3 * (y + 1) * width]);
                arch.dispatch(Priming { row, colours, channels, options });
            },
        );
        Ok(())
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
        let (width, options, arch) = (self.size.width, self.options, self.arch);
        let mut mask = vec![0; self.size.pixels()];
        let rows = self.rows().into_par_iter().zip(frame.par_chunks_exact(3 * width));
        let rows = rows.zip(mask.par_chunks_exact_mut(width)).enumerate().with_min_len(TASK_ROWS);
        rows.for_each_init(
            || Channels::new(width),
            |channels, (y, ((row, colours), mask))| match rate_of(y) {
                Some(rate) => {
                    arch.dispatch(Learning { row, colours, mask, channels, rate: Rate::new(rate), options });
                }
                None => arch.dispatch(Looking { row, colours, mask, options }),
            },
        );
        Ok(mask)
    }

    fn rows(&mut self) -> Vec<ModelRow<'_>> {
        let (width, blocks) = (self.size.width, self.size.width.div_ceil(LANES));
        let mut weights = self.weights.each_mut().map(|plane| plane.chunks_exact_mut(blocks));
        let mut gaussians = self.gaussians.each_mut().map(|plane| plane.chunks_exact_mut(blocks));
        let screens = self.level.chunks_exact_mut(3 * width).zip(self.too_far.chunks_exact_mut(3 * width));
        let rows = self.used.chunks_exact_mut(blocks).zip(screens);
        rows.map(|(used, (level, too_far))| {
            let weights = weights.each_mut().map(|plane| plane.next().unwrap_or_default());
            let gaussians = gaussians.each_mut().map(|plane| plane.next().unwrap_or_default());
            let planes = Planes { weights, gaussians };
            ModelRow { planes, used, level, too_far }
        })
        .collect()
    }
}

/// Frames in which each row learns once.
fn turns(rate: f32) -> usize {
    ((MOST_RATE / rate).round() as usize).clamp(1, MOST_TURNS)
}

#[cfg(test)]
mod tests {
    use super::super::pixel::{Pixel, learn_plainly};
    use super::*;
    use crate::random::generator;
    use rand::RngExt;

    const SIZE: (usize, usize) = (70, 24);

    fn levels() -> Vec<Arch> {
        let mut levels = vec![Arch::Scalar];
        #[cfg(target_arch = "x86_64")]
        {
            levels.extend(pulp::x86::V3::try_new().map(Arch::V3));
            levels.extend(pulp::x86::V4::try_new().map(Arch::V4));
        }
        levels
    }

    fn made(options: MixtureOptions, arch: Arch) -> Mixture {
        let size = ImageSize::new(SIZE.0, SIZE.1).unwrap();
        Mixture { arch, ..Mixture::new(size, options).unwrap() }
    }

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

    /// All modes of a model, pixel by pixel; of what no pixel uses nothing is asked.
    fn pixels(model: &mut Mixture) -> Vec<Pixel> {
        let rows = model.rows();
        let of_row = |row: &ModelRow<'_>| {
            let used = row.used.as_flattened()[..SIZE.0].iter().enumerate();
            used.map(|(x, &used)| row.planes.load(used, x)).collect::<Vec<_>>()
        };
        rows.iter().flat_map(of_row).collect()
    }

    fn colours(frame: &[u8]) -> impl Iterator<Item = [f32; 3]> {
        frame.as_chunks::<3>().0.iter().map(|colour| colour.map(f32::from))
    }

    /// Pixels learn side by side what each learns by itself, bit for bit, whatever the CPU has; and are asked as each is by itself.
    #[test]
    fn every_level_finds_what_the_definition_says() {
        for (threshold, shadows) in [(80.0, true), (16.0, false), (5.0, true), (0.01, false), (1e6, true)] {
            let options = MixtureOptions { threshold, shadows };
            let mut models: Vec<Mixture> = levels().into_iter().map(|arch| made(options, arch)).collect();
            let mut plain = vec![Pixel::default(); SIZE.0 * SIZE.1];
            let (mut moving, mut several) = (0, 0);
            for (t, frame) in frames(60).iter().enumerate() {
                let learns = t < 30 || t % 3 == 0;
                let rate = if t < 20 { 1.0 / (t + 1) as f32 } else { 0.02 };
                let expected: Vec<u8> = plain
                    .iter_mut()
                    .zip(colours(frame))
                    .map(|(pixel, colour)| {
                        u8::from(if learns {
                            learn_plainly(pixel, colour, rate, options)
                        } else {
                            pixel.moves(colour, options)
                        })
                    })
                    .collect();
                moving += expected.iter().map(|&v| usize::from(v)).sum::<usize>();
                several += plain.iter().filter(|pixel| pixel.used > 2).count();
                for model in &mut models {
                    let rate_of = |_| learns.then_some(rate);
                    assert_eq!(
                        model.apply(frame, rate_of, rate).unwrap(),
                        expected,
                        "{options:?}, frame {t}"
                    );
                    for (found, plain) in pixels(model).iter().zip(&plain) {
                        let bits = |p: &Pixel| {
                            p.modes[..p.used].iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>()
                        };
                        assert_eq!(bits(found), bits(plain), "{options:?}, frame {t}, {:?}", model.arch);
                    }
                }
            }
            assert!(threshold > 1000.0 || moving > 1000, "{moving}");
            assert!(several > 1000, "{several}");
        }
    }

    #[test]
    fn priming_is_learning_frame_by_frame() {
        let (samples, order) = (frames(5).concat(), [3, 0, 4, 2, 1, 3, 0]);
        let frame_bytes = 3 * SIZE.0 * SIZE.1;
        for arch in levels() {
            let options = MixtureOptions { threshold: 80.0, shadows: true };
            let (mut primed, mut plain) = (made(options, arch), made(options, arch));
            primed.prime(&samples, &order).unwrap();
            for (k, n) in order.into_iter().enumerate() {
                plain.learn(&samples[n * frame_bytes..][..frame_bytes], 1.0 / (k + 1) as f32).unwrap();
            }
            assert_eq!(primed.used, plain.used);
            assert_eq!((&primed.level, &primed.too_far), (&plain.level, &plain.too_far));
            assert_eq!((&primed.weights, &primed.gaussians), (&plain.weights, &plain.gaussians));
        }
        let mut model = made(MixtureOptions { threshold: 80.0, shadows: true }, Arch::new());
        for (samples, order) in [(&samples[1..], &order[1..]), (&samples[..frame_bytes], &[0, 1])] {
            assert!(matches!(model.prime(samples, order), Err(Error::Length { .. })));
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
