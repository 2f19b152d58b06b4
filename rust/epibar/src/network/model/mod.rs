//! What is solved for, and the equations of it.
//!
//! * `optics`: where the pixels of a camera look.
//! * `beliefs`: what is known of a camera before.
//! * `camera`: a camera, as the numbers that are solved for.
//! * `insets`: how far its silhouettes lie inside of the true outlines.
//! * `residual`, `changes`: how far two tangents are from meeting, and how that changes with both cameras.
//! * `joint`: the joint problem over cameras only.
//! * `invertible`: its normal matrix, inverted though nothing says where the whole stands.
//! * `laplace`: what speaks against beliefs about cameras.
//! * `pose`: where one camera stands beside another, by the geometry of their pair.

pub mod beliefs;
pub mod camera;
mod changes;
pub mod insets;
pub mod invertible;
pub mod joint;
pub mod laplace;
pub mod optics;
pub mod pose;
pub mod residual;
