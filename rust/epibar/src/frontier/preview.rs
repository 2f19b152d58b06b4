//! Scores of many hypotheses on the same frames.

use super::score::total_score;
use super::views::Views;
use crate::geometry::Fundamental;

/// One frame in so many is enough for a preview.
const PREVIEW_STEP: usize = 4;

/// Scores by tangents, and previews of the score from a few of them.
pub struct Scorer<'a> {
    views: &'a Views,
    few: Views,
    radius: f64,
}

impl<'a> Scorer<'a> {
    /// Scores on all frames of `views`; two tangents meet below a Sampson distance of `radius` pixels.
    pub fn new(views: &'a Views, radius: f64) -> Self {
        let few: Vec<usize> = (0..views.frames()).step_by(PREVIEW_STEP).collect();
        Self { views, few: views.chosen(&few), radius }
    }

    /// The frames.
    pub fn views(&self) -> &'a Views {
        self.views
    }

    /// Score of `f`.
    pub fn score(&self, f: &Fundamental) -> f64 {
        total_score(self.views, f, self.radius)
    }

    /// An estimate of the score from one frame in four.
    pub fn preview(&self, f: &Fundamental) -> f64 {
        total_score(&self.few, f, self.radius) * PREVIEW_STEP as f64
    }
}
