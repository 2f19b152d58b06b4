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
//! 6. [`mod@calibrate`]: the whole job, two recordings in and one [`Calibration`] out.
//!
//! Balls that fly before two cameras far away and at a right angle to one another: a ball is a disc at the same height
//! in both, and the epipolar lines are horizontal.
//!
//! ```
//! use epibar::{CalibrateOptions, ImageSize, Recorder, RecorderOptions, Recording, calibrate};
//! use epibar::estimate::ransac::Unwatched;
//! use epibar::geometry::symmetric_epipolar_distance;
//!
//! /// What a camera sees of the balls: how high they fly is common to both cameras, where across the image is not.
//! fn record(size: ImageSize, across: fn(f64) -> f64) -> epibar::Result<Recording> {
//!     let mut recorder = Recorder::new(size, RecorderOptions { lines: 2000, ..Default::default() })?;
//!     for frame in 0..200 {
//!         let mut mask = vec![0; size.pixels()];
//!         for ball in 0..4 {
//!             let phase = 0.05 * f64::from(frame) * (1.0 + 0.3 * f64::from(ball)) + f64::from(ball);
//!             let (u, v, radius) = (across(phase), 70.0 + 45.0 * phase.cos(), 6.0 + f64::from(ball));
//!             for (pixel, value) in mask.iter_mut().enumerate() {
//!                 let (x, y) = ((pixel % size.width) as f64, (pixel / size.width) as f64);
//!                 *value |= u8::from((x - u).hypot(y - v) < radius);
//!             }
//!         }
//!         recorder.push(&mask, f64::from(frame) / 25.0)?;
//!     }
//!     recorder.finish()
//! }
//!
//! # fn main() -> epibar::Result<()> {
//! let a = record(ImageSize::new(160, 140)?, |phase| 80.0 + 60.0 * (1.7 * phase).sin())?;
//! let b = record(ImageSize::new(180, 140)?, |phase| 90.0 + 65.0 * (2.3 * phase).cos())?;
//! let calibration = calibrate(&a, &b, &CalibrateOptions::default(), &mut Unwatched)?;
//! assert!(calibration.verdict.accepted(), "{}", calibration.verdict.reason);
//! let f = calibration.fundamental.unwrap();
//! assert!(symmetric_epipolar_distance(&f, [40.0, 50.0], [120.0, 50.0]) < 0.5);
//! # Ok(())
//! # }
//! ```

mod bits;
pub mod calibrate;
pub mod error;
pub mod estimate;
pub mod geometry;
pub mod line;
pub mod matching;
pub mod planarity;
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
