//! Epipolar geometry of stationary cameras from what moves in front of them.
pub mod error;
pub mod line;
pub mod recording;

pub use error::{Error, Result};
pub use line::{ImageSize, Line, Segment};
pub use recording::{
    Barcodes, Informative, Recorder, RecorderOptions, Recording, Silhouettes, barcodes_of_segments,
    border_segments,
};
