//! Silhouettes of both cameras, and which frames of them are kept aside.

use super::split::Split;
use crate::frontier::Views;
use crate::recording::FramePair;

/// Silhouettes of both cameras, and which frames of them are kept aside.
pub struct SplitViews {
    /// Which frames are which.
    pub split: Split,
    /// All common frames.
    pub all: Views,
    /// All frames in which both cameras see something.
    pub busy: Views,
    /// Frames in which both cameras see something and that may be fitted to.
    pub fitted: Views,
}

impl SplitViews {
    /// `views` gives the silhouettes at some of the `common` frames, of which `busy` are some.
    pub fn new(
        split: Split,
        common: &[FramePair],
        busy: &[FramePair],
        views: impl Fn(&[FramePair]) -> Views,
    ) -> Self {
        Self { all: views(common), busy: views(busy), fitted: views(&split.fitted_busy), split }
    }

    /// These views with silhouettes moved outward by so many pixels in A and in B.
    #[must_use]
    pub fn moved_outward(&self, pixels: [f64; 2]) -> Self {
        Self {
            split: self.split.clone(),
            all: self.all.moved_outward(pixels),
            busy: self.busy.moved_outward(pixels),
            fitted: self.fitted.moved_outward(pixels),
        }
    }
}
