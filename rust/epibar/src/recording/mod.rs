//! One camera over time: from masks of what moves to all that a pair of cameras needs.
//!
//! In the order of the data:
//!
//! * `sampling`: chooses lines, from border to border of the image.
//! * `components`, `convex_hull`: the connected components of each mask, and their convex hulls.
//! * `silhouettes`: keeps the hulls, frame by frame.
//! * `lens_corners`: what a lens needs of a silhouette beyond its hull.
//! * `fill`, `stand_ins`: how much of its hull a silhouette fills, and which are boxes and ellipses in the place of something else.
//! * `transposition`, `barcode_words`: turns masks into words of time, and packs 256 frames into half a cache line per pixel.
//! * `traversal`, `barcode`: walks the lines over these words; the OR along a line is its motion barcode.
//! * `recorder`, `packed_blocks`: streams masks through all of this, and keeps finished frames packed.
//! * `recording`, `parts`: what comes out, a [`Recording`], and one taken apart for a file.
//! * `tracker`, `at_moment`: follows silhouettes from frame to frame, and tells which there are between two.
//! * `visible`, `fullest`: where the view ends, and in which stretch most moves.
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
