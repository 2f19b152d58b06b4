//! One camera over time: from masks of what moves to all that a pair of cameras needs.
//!
//! In the order of the data:
//!
//! 1. [`sampling`] chooses lines, from border to border of the image.
//! 2. [`components`] finds the connected components of each mask, [`hull`] their convex hulls, and
//!    [`silhouettes`] keeps the hulls.
//! 3. [`bit_planes`] turns masks into words of time, [`block`] packs 512 frames into one cache line per pixel, and [`traversal`] walks the lines over it:
//!    the OR along a line is its motion [`barcode`].
//! 4. [`recorder`] streams masks through all of this and ends in a [`Recording`].
//!
//! Points are `(x, y)` in pixels, pixel centres at integers; bit `i` of a barcode is frame `i`.

pub mod barcode;
pub mod bit_planes;
pub mod block;
pub mod components;
pub mod hull;
pub mod recorder;
pub mod sampling;
pub mod silhouettes;
pub mod traversal;
mod validate;
pub mod visible;

pub use barcode::{Barcodes, Informative, barcodes_of_segments};
pub use recorder::{Recorder, RecorderOptions};
pub use sampling::border_segments;
pub use silhouettes::Silhouettes;

use crate::line::{ImageSize, Segment};
use std::sync::Arc;

/// What one camera saw move. It holds no image, and no frame of it is needed again.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Size of the images.
    pub size: ImageSize,
    /// Time of each frame in seconds, increasing.
    pub times: Vec<f64>,
    /// The lines, from border to border.
    pub segments: Vec<Segment>,
    /// In which frames something moves on which line.
    pub barcodes: Barcodes,
    /// The convex hulls of what moves.
    pub silhouettes: Silhouettes,
    /// For each pixel, row-major, the number of frames in which it moves.
    pub heat: Vec<u32>,
    /// For each frame the number of moving pixels.
    pub moving_pixels: Vec<u32>,
    /// For each pixel, row-major, 0 where the camera does not see what moves; `None` where it sees all of the
    /// image. Silhouettes that end there have no tangents there.
    pub visible: Option<Arc<[u8]>>,
    /// The seed of the lines.
    pub seed: u64,
}

impl Recording {
    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.times.len()
    }

    /// Frames per second, from the median time between frames, which neither a dropped frame nor
    /// a pause moves. NaN for fewer than two frames.
    pub fn frame_rate(&self) -> f64 {
        let mut steps: Vec<f64> = self.times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if steps.is_empty() {
            return f64::NAN;
        }
        let middle = steps.len() / 2;
        let (below, median, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
        let upper = *median;
        let lower = if self.times.len() % 2 == 1 {
            // An even number of steps has two in the middle.
            below.iter().copied().fold(f64::NEG_INFINITY, f64::max)
        } else {
            upper
        };
        2.0 / (lower + upper)
    }
}
