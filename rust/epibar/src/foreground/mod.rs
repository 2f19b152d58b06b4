//! What moves in the frames of one camera, at the speed of memory.
//!
//! Frames are row-major BGR, three bytes a pixel; a mask is one byte a pixel, 0 or 1.
//!
//! * `empty_scene`: the empty scene from frames that people walk through, [`steady_background`].
//! * `painting`: takes people out of samples of it, [`paint_over`].
//! * `mixture`: tells moving pixels from background by the equations of MOG2, [`Mixture`].
//! * `row`: its rows, which learn in turn, and the passes over them.
//! * `pixel`, `lanes`: the equations for one pixel, and for pixels side by side.
//! * `cleaning`: from a mask of pixels to one of silhouettes, [`clean`].
//! * `covering`: what a disc or a square covers that is moved over a mask.
//! * `light`: how the light changes, [`compare_light`].

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
