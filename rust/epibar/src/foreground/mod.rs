//! What moves in the frames of one camera, at the speed of memory.
//!
//! [`steady_background`] is the empty scene, [`Mixture`] tells moving pixels from background by the equations of MOG2, and [`clean`] makes silhouettes of them.
//! Frames are row-major BGR, three bytes a pixel; a mask is one byte a pixel, 0 or 1.

mod cleaning;
mod empty_scene;
mod mixture;
mod pixel;

pub use cleaning::{Cleaning, clean, close, majority};
pub use empty_scene::steady_background;
pub use mixture::Mixture;
pub use pixel::MixtureOptions;
