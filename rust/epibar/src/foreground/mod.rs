//! What moves in the frames of one camera, at the speed of memory.
//!
//! [`steady_background`] is the empty scene, [`paint_over`] takes people out of samples of it, [`Mixture`] tells moving pixels from background by the equations of MOG2, and [`clean`] makes silhouettes of them.
//! [`compare_light`] is how the light changes.
//! Frames are row-major BGR, three bytes a pixel; a mask is one byte a pixel, 0 or 1.

mod cleaning;
mod covering;
mod empty_scene;
mod lanes;
mod light;
mod mixture;
mod painting;
mod pixel;
mod row;

pub use cleaning::{Cleaning, clean};
pub use empty_scene::steady_background;
pub use light::{BANDS, LightChange, SHRUNK, compare_light, shrunk_green};
pub use mixture::Mixture;
pub use painting::{Painting, paint_over};
pub use pixel::MixtureOptions;
