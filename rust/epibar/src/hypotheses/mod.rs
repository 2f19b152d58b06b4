//! Where an `F` may come from: hypotheses of every source, each an estimator of one RANSAC loop.
//!
//! [`mod@ransac`] is the loop, and knows no geometry. [`line_model`] is the paper's estimator (§3), [`floor`] draws from the
//! homography of a plane and [`track_model`] from silhouettes followed through time ([`tracks`]), and [`top_view`] from where figures stand on
//! the floor by either camera alone ([`single_view`]); [`sources`] draws from all.

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
