//! Two cameras, lines only: which line of A moves like which line of B (paper §2 and §4.2).
//!
//! [`mod@correlation`] compares barcodes by popcount, [`candidates`] keeps the mutual best, and
//! [`mod@motion_lines`] finds straight paths with heavy traffic, whose images correlate without being epipolar.

mod best;
pub mod candidates;
mod columns;
pub mod correlation;
mod densify;
mod hull_barcodes;
pub mod motion_lines;
mod popcount;
mod rows;

pub use candidates::{Candidate, CandidateOptions, Candidates};
pub use correlation::{correlation, mutual_matches};
pub use motion_lines::{MotionLineOptions, motion_lines};
