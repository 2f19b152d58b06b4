//! One camera over time: from masks of what moves to all that a pair of cameras needs.
//!
//! In the order of the data:
//!
//! 1. [`sampling`] chooses lines, from border to border of the image.
//! 2. [`components`] finds the connected components of each mask, [`mod@convex_hull`] their convex hulls, and
//!    [`silhouettes`] keeps the hulls; [`lens_corners`] adds what a lens needs beyond them, [`mod@fill`] tells people from what is convex, and
//!    [`stand_ins`] which of that are boxes and ellipses.
//! 3. [`transposition`] turns masks into words of time, [`barcode_words`] packs 256 frames into half a cache line per pixel, and
//!    [`traversal`] walks the lines over it: the OR along a line is its motion [`barcode`].
//! 4. [`recorder`] streams masks through all of this, keeps finished frames as [`packed_blocks`], and ends in a [`Recording`];
//!    [`parts`] takes one apart for a file.
//! 5. [`tracker`] follows silhouettes from frame to frame, [`mod@at_moment`] tells which there are between two, [`visible`] says where a view ends, [`mod@fullest`] in which stretch most moves.
//!
//! Points are `(x, y)` in pixels, pixel centres at integers; bit `i` of a barcode is frame `i`.

pub mod at_moment;
pub mod barcode;
pub mod barcode_words;
pub mod components;
pub mod convex_hull;
pub mod fill;
pub mod fullest;
pub mod lens_corners;
mod packed_blocks;
pub mod parts;
pub mod recorder;
#[allow(clippy::module_inception, reason = "the recording itself, beside what makes one")]
pub mod recording;
pub mod sampling;
pub mod silhouettes;
pub mod stand_ins;
pub mod tracker;
pub mod transposition;
pub mod traversal;
pub mod visible;

pub use barcode::{Barcodes, Informative};
pub(crate) use fullest::fullest;
pub use parts::RecordingParts;
pub use recorder::{Recorder, RecorderOptions};
pub(crate) use recording::LONG_STEP;
pub use recording::{FramePair, RecordedFrame, Recording};
pub use silhouettes::Silhouettes;
