//! Epipolar geometry of stationary cameras from what moves in front of them.
//!
//! Two stationary cameras that look at one scene from very different sides share no texture, but both see the same
//! things move. This crate takes masks of what moves and gives the fundamental matrix, by the method of
//! *Fundamental Matrices from Moving Objects Using Line Motion Barcodes* (Kasten, Ben-Artzi, Peleg and Werman,
//! ECCV 2016; "the paper") and by frontier points, which are more exact.
//!
//! The words: the *motion barcode* of a line is one bit for each frame, whether something moves on the line; epipolar
//! lines of one plane have nearly the same. A *silhouette* is what moves in one mask, as its convex hull. An *epipolar tangent* is
//! an epipolar line that touches a silhouette, and where it does is a *frontier point*: a point in space that both cameras show.
//!
//! A [`Recorder`] takes the masks of one camera, frame by frame; its [`Recording`] holds lines with their motion
//! barcodes, silhouettes and a heat map, and no image. [`calibrate()`] takes two recordings, and its [`Calibration`] has
//! the matrix, a [`Verdict`] whether it can be relied on, and the numbers behind it: look at [`Calibration::accepted`]
//! before the matrix, as a refused one is there too. [`examine()`] asks what speaks for a matrix that you already have.
//! Of three cameras and more, [`network`] finds focal lengths, lenses, poses and clocks from the same recordings. The
//! feature `files` adds `save` and `load` to recordings and calibrations, in the files of the Python package.
//!
//! Conventions: a mask is row-major and non-zero where something moves; points are `(x, y)` in pixels with pixel centres at
//! integers; `x_bᵀ F x_a = 0`. Results depend on the recordings, the options and their seed, and not on the number of threads.
//!
//! Balls that fly before two cameras far away and at a right angle to one another: a ball is a disc at the same height
//! in both, and the epipolar lines are horizontal.
//!
//! ```
//! use epibar::{CalibrateOptions, ImageSize, Recorder, RecorderOptions, Recording, calibrate};
//! use epibar::symmetric_epipolar_distance;
//!
//! /// What a camera sees of the balls: how high they fly is common to both cameras, where across the image is not.
//! fn record(size: ImageSize, across: fn(f64) -> f64) -> epibar::Result<Recording> {
//!     let mut recorder = Recorder::new(size, RecorderOptions::new().lines(2000))?;
//!     for frame in 0..200 {
//!         let mut mask = vec![0; size.pixels()];
//!         for ball in 0..4 {
//!             let phase = 0.05 * f64::from(frame) * (1.0 + 0.3 * f64::from(ball)) + f64::from(ball);
//!             let (u, v, radius) = (across(phase), 70.0 + 45.0 * phase.cos(), 6.0 + f64::from(ball));
//!             for (pixel, value) in mask.iter_mut().enumerate() {
//!                 let (x, y) = ((pixel % size.width()) as f64, (pixel / size.width()) as f64);
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
//! let calibration = calibrate(&a, &b, &CalibrateOptions::default())?;
//! assert!(calibration.accepted(), "{}", calibration.verdict.reason);
//! let f = calibration.fundamental.unwrap();
//! assert!(symmetric_epipolar_distance(&f, [40.0, 50.0], [120.0, 50.0]) < 0.5);
//! # Ok(())
//! # }
//! ```

// What the door alone leads to, nobody reaches where it is closed.
#![cfg_attr(not(feature = "internals"), allow(dead_code, unused_imports))]

mod bits_of_bytes;
mod calibrate;
mod calibration;
mod clock;
mod error;
mod examine;
#[cfg(feature = "files")]
mod files;
mod foreground;
mod frontier;
mod geometry;
mod hypotheses;
mod image;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod internals;
mod matching;
pub mod network;
mod options;
mod random;
mod recording;
mod refine;
mod search;
mod verify;
mod watch;

pub use nalgebra;

pub use calibrate::{calibrate, calibrate_watched};
pub use calibration::{Calibration, CandidatePair, Counts, FrontierPoint, ShiftScore};
pub use clock::{RunnerUp, TimeOffset, Timing};
pub use error::{Error, Result};
#[cfg(feature = "files")]
pub use files::SavedRecording;

pub use examine::{ExamineOptions, Examined, TangentCounts, examine};
pub use geometry::{CameraMatrices, Fundamental, sampson_distance, symmetric_epipolar_distance};
pub use hypotheses::Source;
pub use image::{Homogeneous, ImageSize, Line, Segment};
pub use options::{CalibrateOptions, Method};
pub use recording::{
    Barcodes, Informative, RecordedFrame, Recorder, RecorderOptions, Recording, RecordingParts, Silhouettes,
};
pub use verify::{ErrorMap, Evidence, Kind, Rival, Verdict};
pub use watch::{Stage, Unwatched, Watch};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadMe;
