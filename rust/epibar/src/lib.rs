//! Epipolar geometry of stationary cameras from what moves in front of them.
pub mod error;
pub mod line;
pub mod recording;

pub use error::{Error, Result};
