//! From candidates to a fundamental matrix: hypotheses, scores, refinement.
//!
//! [`ransac`] is the loop, and knows no geometry; [`line_model`] is the paper's estimator (§3). The frontier
//! method scores with [`frontier`], draws from [`sources`], refines in [`refine`] and puts it together in [`search`].

mod edges;
pub mod essential;
pub mod evidence;
pub mod explore;
pub mod floor;
pub mod frontier;
mod line_arrays;
pub mod line_model;
pub mod optimise;
pub mod ransac;
pub mod refine;
pub mod search;
mod searcher;
pub mod sources;
pub mod standing;
pub mod track_model;
pub mod tracks;
pub mod views;
pub mod volume;
