//! Which frame of A is which moment of B.
//!
//! A [`Clock`] is a line: where A's first frame falls in B, and how fast B's time runs against A's. From it each frame
//! of A gets a *position* in B, a frame number that need not be whole: [`between`] draws the silhouettes of B as they were
//! at such a position, and [`aligned`] puts both recordings on one time line. [`offset`] finds the offset before any `F`
//! is known, [`offset_and_drift`] measures both to a fraction of a frame once there is one ([`equations`] are what it
//! solves), and [`alternate`] goes from one to the other, as neither can be had without the other.

pub mod aligned;
pub mod alternate;
pub mod between;
#[allow(clippy::module_inception, reason = "the clock itself, beside what is done with it")]
pub mod clock;
mod equations;
pub mod offset;
pub mod offset_and_drift;
pub mod timing;

pub use aligned::Aligned;
pub use alternate::Clocks;
pub use clock::{Clock, common_frames};
pub use offset::{find_offset, score_at_offset};
pub use timing::{RunnerUp, TimeOffset, Timing};
