//! Where an `F` may come from: hypotheses of every source, each an estimator of one RANSAC loop.
//!
//! * `ransac`: the loop, which knows no geometry.
//! * `sources`: draws from all sources, and scores what they give.
//! * `line_model`: the paper's estimator, from pairs of lines (§3).
//! * `line_arrays`: candidates as flat arrays, for prefilters that are asked of all of them.
//! * `floor`, `floor_epipoles`: the homography of a plane, and hypotheses from it.
//! * `tracks`, `track_model`: silhouettes followed through time, and hypotheses from them.
//! * `single_view`, `top_view`: where figures stand on the floor by either camera alone, and hypotheses from two such maps.

pub mod floor;
mod floor_epipoles;
mod line_arrays;
pub mod line_model;
pub mod ransac;
pub mod single_view;
pub mod sources;
pub mod top_view;
pub mod track_model;
pub mod tracks;

pub use line_model::LineModel;
pub use ransac::{Estimator, ransac};
pub use sources::{Draws, Hypotheses, Hypothesis, Source, hypotheses};
