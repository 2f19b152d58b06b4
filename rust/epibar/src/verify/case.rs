//! A geometry and what it is tested on.

use super::second_look::Earlier;
use super::split::Split;
use crate::frontier::Views;
use crate::recording::{FramePair, Recording};
use crate::search::Found;

/// Blocks of frames that a short recording keeps.
const LEAST_BLOCKS: usize = 12;

/// A geometry and what it is tested on.
pub struct Case<'a> {
    /// All common frames.
    pub views: &'a Views,
    /// All frames in which both cameras see something.
    pub busy_views: &'a Views,
    /// Frames in which both cameras see something and that were fitted to.
    pub fitted_views: &'a Views,
    /// Which frames are which.
    pub split: &'a Split,
    /// What the views are of.
    pub recordings: [&'a Recording; 2],
    /// Their silhouettes were cut out, and stand in for nothing else.
    pub masks: bool,
    /// The frames of either that are common.
    pub common: &'a [FramePair],
    /// The winner, what is tested, and the rivals.
    pub found: &'a Found,
    /// What was tested on other frames, without deciding.
    pub earlier: Option<&'a Earlier>,
    /// A larger expected error is refused, pixels.
    pub max_expected_error: f64,
    /// Common frames per second; NaN where unknown.
    pub frame_rate: f64,
    /// Seed of every random draw but those of [`turning`](super::turning).
    pub seed: u64,
}

impl Case<'_> {
    /// Common frames that share their error: those of a second, or for which motion stays where it is; in a short recording
    /// fewer.
    pub(super) fn block(&self) -> usize {
        let rate = self.frame_rate;
        let second = if rate.is_finite() { rate.round().max(1.0) as usize } else { 25 };
        second.max(self.split.gap).min((self.busy_views.frames() / LEAST_BLOCKS).max(1))
    }
}
