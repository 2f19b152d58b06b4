//! From a stream of masks to a [`Recording`], in bounded memory.
//!
//! Each mask is read once: its runs set bits of the current [`BitPlanes`] and make the silhouettes. Every 64 frames
//! these become a word of the current [`PixelBlock`], and after 256 frames the block is turned into 256 bits of every
//! barcode and of the heat map. Both are reused, and bits of barcodes wait packed for the end. Memory is 40 bytes per pixel and the recording itself.

use super::barcode::Barcodes;
use super::barcode_words::{BLOCK_FRAMES, PixelBlock};
use super::components::Components;
use super::lens_corners::OutlineFinder;
use super::packed_blocks::PackedBlocks;
use super::recording::Recording;
use super::sampling::border_segments;
use super::silhouettes::Silhouettes;
use super::transposition::BitPlanes;
use crate::error::{Error, Result};
use crate::image::{ImageSize, Segment};
use std::sync::Arc;

/// Most lines a recorder takes: their barcodes are 32 bytes each per 256 frames, before they are packed.
pub const MAX_LINES: usize = 10_000_000;

/// How to record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct RecorderOptions {
    /// Number of lines, 1 to 10,000,000. True candidates grow with it: on twenty flying cubes
    /// 10,000 lines gave 19–29 % true ones, 40,000 gave 67–82 %.
    pub lines: usize,
    /// Seed of the lines.
    pub seed: u64,
    /// Least pixels of a component that becomes a silhouette.
    ///
    /// A smaller one is mostly noise of the foreground, and as a silhouette it would have four tangents like a
    /// walker has, each free to match by chance. Its pixels stay in barcodes and heat: there they weigh
    /// as little as they are, and a far object may be small. With 1 every component is kept.
    pub min_component_area: usize,
}

impl Default for RecorderOptions {
    fn default() -> Self {
        Self { lines: 20_000, seed: 0, min_component_area: 12 }
    }
}

impl RecorderOptions {
    /// The defaults.
    pub fn new() -> Self {
        Self::default()
    }

    /// With a number of [lines](Self::lines).
    #[must_use]
    pub fn lines(self, lines: usize) -> Self {
        Self { lines, ..self }
    }

    /// With a [seed](Self::seed).
    #[must_use]
    pub fn seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// With a [least area of a silhouette](Self::min_component_area), pixels.
    #[must_use]
    pub fn min_component_area(self, pixels: usize) -> Self {
        Self { min_component_area: pixels, ..self }
    }
}

/// Takes the masks of one camera, one after the other.
///
/// ```
/// use epibar::{ImageSize, Recorder, RecorderOptions};
///
/// # fn main() -> epibar::Result<()> {
/// let size = ImageSize::new(64, 48)?;
/// let mut recorder = Recorder::new(size, RecorderOptions::new().lines(500))?;
/// for frame in 0..40 {
///     // A square of 8 × 8 pixels that moves to the right by a pixel per frame.
///     let mut mask = vec![0; size.pixels()];
///     for y in 20..28 {
///         mask[y * 64 + frame..y * 64 + frame + 8].fill(255);
///     }
///     recorder.push(&mask, frame as f64 / 25.0)?;
/// }
/// let recording = recorder.finish()?;
/// assert_eq!(recording.frames(), 40);
/// assert_eq!(recording.barcodes().count(), 500);
/// assert_eq!(recording.silhouettes().hull(0), [[0, 20], [7, 20], [7, 27], [0, 27]]);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Recorder {
    size: ImageSize,
    options: RecorderOptions,
    segments: Vec<Segment>,
    times: Vec<f64>,
    found: Components,
    outlines: OutlineFinder,
    /// Nearly all of the memory, which is first taken when there is a frame: whoever learns a background before that
    /// needs as much.
    pixels: Option<PixelMotion>,
    /// Finished blocks: 256 frames of every line.
    blocks: PackedBlocks,
    silhouettes: Silhouettes,
    heat: Vec<u32>,
    moving_pixels: Vec<u32>,
    visible: Option<Arc<[u8]>>,
}

/// Motion of all pixels on its way into barcodes.
#[derive(Debug, Clone)]
struct PixelMotion {
    /// Frames since the last multiple of 64.
    planes: BitPlanes,
    /// Frames since the last multiple of 256.
    block: PixelBlock,
}

impl PixelMotion {
    fn new(size: ImageSize) -> Self {
        Self { planes: BitPlanes::new(size.pixels()), block: PixelBlock::new(size) }
    }
}

impl Recorder {
    /// A recorder for masks of one size.
    ///
    /// # Errors
    /// [`Error::ImageSize`] for an unusable size, [`Error::Argument`] for a number of lines out of range.
    pub fn new(size: ImageSize, options: RecorderOptions) -> Result<Self> {
        let size = ImageSize::new(size.width, size.height)?;
        if !(1..=MAX_LINES).contains(&options.lines) {
            return Err(Error::Argument {
                name: "lines",
                value: options.lines.to_string(),
                expected: "must be between 1 and 10000000",
            });
        }
        Ok(Self {
            size,
            options,
            segments: border_segments(size, options.lines, options.seed),
            times: Vec::new(),
            found: Components::new(),
            outlines: OutlineFinder::default(),
            pixels: None,
            blocks: PackedBlocks::default(),
            silhouettes: Silhouettes::default(),
            heat: vec![0; size.pixels()],
            moving_pixels: Vec::new(),
            visible: None,
        })
    }

    /// With the area in which this camera can see something move: a row-major mask, 0 where it cannot, because
    /// undistortion left no image there or because motion there is not counted. A silhouette that ends on such a
    /// pixel is cut, as it is on the border of the image, so the area should leave out a pixel or two beside its edge.
    ///
    /// # Errors
    /// [`Error::Length`] for an area of another size, [`Error::Argument`] after the first frame.
    pub fn with_visible(mut self, visible: &[u8]) -> Result<Self> {
        if visible.len() != self.size.pixels() {
            return Err(Error::Length {
                what: "visible must have as many pixels as the recording",
                left: visible.len(),
                right: self.size.pixels(),
            });
        }
        if !self.times.is_empty() {
            return Err(Error::Argument {
                name: "visible",
                value: format!("given after {} frames", self.times.len()),
                expected: "must be given before the first frame",
            });
        }
        let somewhere_not = visible.contains(&0);
        self.visible = somewhere_not.then(|| visible.iter().map(|&v| u8::from(v != 0)).collect());
        Ok(self)
    }

    /// Adds a frame: a row-major mask, non-zero where something moves, and its time in seconds.
    ///
    /// # Errors
    /// [`Error::MaskSize`] for a mask of another size, [`Error::FrameTime`] where the time is not
    /// finite or not after that of the frame before. The recorder is then as it was and takes
    /// further frames. [`Error::Argument`] where the silhouettes outgrow their 2³² points; the
    /// recorder is of no use after that.
    pub fn push(&mut self, mask: &[u8], time: f64) -> Result<()> {
        let frame = self.times.len();
        if mask.len() != self.size.pixels() {
            return Err(Error::MaskSize {
                frame,
                actual: mask.len(),
                width: self.size.width,
                height: self.size.height,
            });
        }
        if !time.is_finite() || self.times.last().is_some_and(|&before| time <= before) {
            return Err(Error::FrameTime { frame, time });
        }
        self.found.find(mask, self.size);
        let least = self.options.min_component_area;
        self.silhouettes.push(&self.found, &mut self.outlines, self.size, self.visible.as_deref(), least)?;
        let bit = frame % BLOCK_FRAMES;
        let pixels = self.pixels.get_or_insert_with(|| PixelMotion::new(self.size));
        let mut moving = 0;
        for run in self.found.runs() {
            let first = usize::from(run.y) * self.size.width + usize::from(run.x_first);
            pixels.planes.set_range(bit % 64, first..first + run.pixels());
            moving += run.pixels();
        }
        self.moving_pixels.push(moving as u32);
        self.times.push(time);
        if bit % 64 == 63 {
            pixels.block.take(bit / 64, &mut pixels.planes);
        }
        if bit + 1 == BLOCK_FRAMES {
            self.flush();
        }
        Ok(())
    }

    /// Number of frames so far.
    pub fn frames(&self) -> usize {
        self.times.len()
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// [`Error::NoFrames`] if there was none.
    pub fn finish(mut self) -> Result<Recording> {
        if self.times.is_empty() {
            return Err(Error::NoFrames);
        }
        if !self.times.len().is_multiple_of(BLOCK_FRAMES) {
            self.flush();
        }
        self.pixels = None;
        let mut barcodes = Barcodes::zeros(self.segments.len(), self.times.len());
        for (number, block) in self.blocks.iter().enumerate() {
            barcodes.put(number, &block);
        }
        Ok(Recording {
            size: self.size,
            barcodes,
            times: self.times,
            segments: self.segments,
            silhouettes: self.silhouettes,
            heat: self.heat,
            moving_pixels: self.moving_pixels,
            visible: self.visible,
            seed: self.options.seed,
        })
    }

    /// Turns the block into bits of the barcodes and the heat map, and empties it.
    fn flush(&mut self) {
        let Some(PixelMotion { planes, block }) = &mut self.pixels else { return };
        // Where the planes are empty this adds nothing.
        block.take((self.times.len() - 1) % BLOCK_FRAMES / 64, planes);
        self.blocks.push(&block.unions(&self.segments));
        block.add_heat(&mut self.heat);
        block.clear();
    }
}
