//! What one camera saw move, over all of its frames.

use std::sync::Arc;

use super::barcode::{Barcodes, Informative};
use super::silhouettes::Silhouettes;
use crate::image::{ImageSize, Segment};

/// A frame of A and a frame of B that show one moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FramePair {
    /// Frame of A.
    pub a: RecordedFrame,
    /// Frame of B.
    pub b: RecordedFrame,
}

impl FramePair {
    /// By the indices of both frames.
    pub fn new(a: u32, b: u32) -> Self {
        Self { a: RecordedFrame(a), b: RecordedFrame(b) }
    }

    /// Indices of the frames of A and of the frames of B in some pairs.
    pub(crate) fn indices(pairs: &[Self]) -> [Vec<u32>; 2] {
        [pairs.iter().map(|p| p.a.0).collect(), pairs.iter().map(|p| p.b.0).collect()]
    }

    /// This moment with B for A.
    pub(crate) fn swapped(self) -> Self {
        Self { a: self.b, b: self.a }
    }
}

/// Index of a frame of one recording, from 0: not that of a moment which two recordings have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RecordedFrame(pub(crate) u32);

impl RecordedFrame {
    /// The index.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Frames further apart than so many frame intervals have others missing between them.
pub(crate) const LONG_STEP: f64 = 1.6;

/// What one camera saw move. It holds no image, and no frame of it is needed again.
///
/// Made by a [`Recorder`](crate::Recorder), or of [`RecordingParts`](crate::RecordingParts); the parts of one always fit together.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    pub(crate) size: ImageSize,
    pub(crate) times: Vec<f64>,
    pub(crate) segments: Vec<Segment>,
    pub(crate) barcodes: Barcodes,
    pub(crate) silhouettes: Silhouettes,
    pub(crate) heat: Vec<u32>,
    pub(crate) moving_pixels: Vec<u32>,
    pub(crate) visible: Option<Arc<[u8]>>,
    pub(crate) seed: u64,
}

impl Recording {
    /// Size of the images.
    pub fn size(&self) -> ImageSize {
        self.size
    }

    /// Whether anything moves in a frame that is larger than specks.
    pub(crate) fn shows(&self, frame: RecordedFrame) -> bool {
        !self.silhouettes.hulls(frame.index()).is_empty()
    }

    /// The lines that inform over those of some frames in which anything shows: however long a camera films, what its lines see they see
    /// while something is there.
    pub(crate) fn informative_lines(&self, frames: impl Iterator<Item = u32>) -> Vec<u32> {
        let busy: Vec<u32> = frames.filter(|&frame| self.shows(RecordedFrame(frame))).collect();
        self.barcodes.select_frames(&busy).informative(&Informative::default())
    }

    /// Number of frames, at least 1.
    pub fn frames(&self) -> usize {
        self.times.len()
    }

    /// Time of each frame in seconds, increasing.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The lines, from border to border of the image.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// In which frames something moves on which line.
    pub fn barcodes(&self) -> &Barcodes {
        &self.barcodes
    }

    /// The convex hulls of what moves.
    pub fn silhouettes(&self) -> &Silhouettes {
        &self.silhouettes
    }

    /// For each pixel, row-major, the number of frames in which it moves.
    pub fn heat(&self) -> &[u32] {
        &self.heat
    }

    /// For each frame the number of moving pixels.
    pub fn moving_pixels(&self) -> &[u32] {
        &self.moving_pixels
    }

    /// For each pixel, row-major, 0 where the camera does not see what moves; `None` where it sees all of the image.
    /// Silhouettes that end there have no tangents there.
    pub fn visible(&self) -> Option<&[u8]> {
        self.visible.as_deref()
    }

    /// Seed of the lines.
    pub fn seed(&self) -> u64 {
        self.seed
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

    /// Seconds from one frame to the next, over the whole recording: neither a dropped frame nor time stamps in whole
    /// milliseconds move it. One second for fewer than two frames.
    pub fn frame_interval(&self) -> f64 {
        let times = &self.times;
        let step = 1.0 / self.frame_rate();
        if !step.is_finite() {
            return 1.0;
        }
        let steps: f64 = times.windows(2).map(|t| ((t[1] - t[0]) / step).round().max(1.0)).sum();
        (times[times.len() - 1] - times[0]) / steps
    }
}
