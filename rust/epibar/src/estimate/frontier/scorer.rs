//! Scores of many hypotheses on the same frames.

use super::{FrontierOptions, frontier_score};
use crate::estimate::views::Views;
use crate::geometry::Fundamental;

/// One frame in so many is enough for a glance.
const GLANCE_STEP: usize = 4;

/// Scores by tangents, and glances at a few of them.
pub struct Scorer<'a> {
    views: &'a Views,
    few: Views,
    options: FrontierOptions,
}

impl<'a> Scorer<'a> {
    /// Scores on all frames of `views`.
    pub fn new(views: &'a Views, options: FrontierOptions) -> Self {
        let few: Vec<usize> = (0..views.frames()).step_by(GLANCE_STEP).collect();
        Self { views, few: views.chosen(&few), options }
    }

    /// The frames.
    pub fn views(&self) -> &'a Views {
        self.views
    }

    /// Evidence for `f`.
    pub fn score(&self, f: &Fundamental) -> f64 {
        frontier_score(self.views, f, &self.options).total()
    }

    /// About as much, from one frame in four.
    pub fn glance(&self, f: &Fundamental) -> f64 {
        frontier_score(&self.few, f, &self.options).total() * GLANCE_STEP as f64
    }
}
