//! Epipolar tangents of two cameras' silhouettes, and the score of an `F` by how they meet.
//!
//! * `views`: the silhouettes of both cameras on one time line.
//! * `edges`: edges of all hulls, laid out so that one pass finds on which side of each an epipole lies.
//! * `up`: which way silhouettes stand.
//! * `score`: compares tangents under an `F`.
//! * `matches`: tangents that meet, and scores summed over them.
//! * `meeting`: within which radius they meet.
//! * `symmetric`: takes both cameras in turn, at the radius that suits the masks.
//! * `preview`: scores many hypotheses on few frames.
//! * `volume`: how far two geometries are apart where things moved.

mod edges;
pub mod matches;
mod meeting;
pub mod preview;
pub mod score;
pub mod symmetric;
pub mod up;
pub mod views;
pub mod volume;

pub use matches::{Class, ClassScore, CommonFrame, FrontierScore, TangentMatch};
pub use meeting::meeting_radius;
pub use preview::Scorer;
pub use score::{Comparer, compare, frontier_score, tangent_matches, total_score};
pub use symmetric::symmetric_score;
pub use up::Up;
pub use views::{View, Views, busy_frames};
