//! Epipolar geometry of stationary cameras from what moves in front of them.
//!
//! Two stationary cameras that look at one scene from very different sides share no texture, but both see the same
//! things move. This crate takes masks of what moves and gives the fundamental matrix, by the method of
//! *Fundamental Matrices from Moving Objects Using Line Motion Barcodes* (Kasten, Ben-Artzi, Peleg and Werman,
//! ECCV 2016; "the paper") and by frontier points, which go further.
//!
//! In the order of the data:
//!
//! 1. [`recording`]: one camera. A [`Recorder`] takes masks frame by frame; the [`Recording`] holds lines with their
//!    motion barcodes, silhouettes and a heat map, and no image.
//! 2. [`matching`]: two cameras, lines only. Which line of A moves like which line of B.
//! 3. [`geometry`]: fundamental matrices, pencils of lines, epipolar tangents, distances.
//! 4. [`estimate`]: hypotheses, scores, refinement.
//! 5. [`verify`]: is it true, and how far off may it be.
//! 6. [`calibrate`]: the whole job, two recordings in and one [`Calibration`] out.

pub mod calibrate;
pub mod error;
pub mod estimate;
pub mod geometry;
pub mod line;
pub mod matching;
pub mod recording;
pub mod verify;

pub use calibrate::{CalibrateOptions, Calibration, Method, calibrate};
pub use error::{Error, Result};
pub use geometry::Fundamental;
pub use line::{ImageSize, Line, Segment};
pub use recording::{
    Barcodes, Informative, Recorder, RecorderOptions, Recording, Silhouettes, barcodes_of_segments,
    border_segments,
};
