//! Two cameras, lines only: which line of A moves like which line of B (paper §2 and §4.2).
//!
//! [`mod@correlation`] says how alike two barcodes are, [`mutual`] finds the pairs that are among the best of each other,
//! with the loops of [`kernel`], and [`candidates`] keeps those that may be epipolar. [`densify`] draws more lines where
//! lines inform, whose barcodes come from hulls ([`hull_barcodes`]); [`mod@motion_lines`] finds straight paths with heavy
//! traffic, whose images correlate without being epipolar; [`pencils`] says how alike all lines through two epipoles are.

pub mod candidates;
pub mod correlation;
mod densify;
mod hull_barcodes;
mod kernel;
pub mod motion_lines;
pub mod mutual;
pub mod pencils;

pub use candidates::{Candidate, CandidateOptions, Candidates, find_candidates};
pub use correlation::{Match, correlation};
pub use motion_lines::{MotionLineOptions, motion_lines};
pub use mutual::mutual_matches;
pub use pencils::Pencils;
