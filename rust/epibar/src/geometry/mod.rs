//! The geometry of two views: fundamental matrices, pencils of epipolar lines, tangents and distances.
//!
//! Equation and convention of the whole crate: `x_bᵀ F x_a = 0`; `F x_a` is a line in B, `Fᵀ x_b` a
//! line in A; `F e = 0` and `Fᵀ e' = 0` (Hartley and Zisserman, *Multiple View Geometry*, ch. 9).

pub mod across;
pub mod area;
pub mod cameras;
pub mod distance;
pub mod eight_point;
pub mod fundamental;
pub mod homography;
pub mod hull;
pub mod least_matrix;
pub mod lens;
pub mod median;
pub mod pencil;
pub mod possible_cameras;
pub mod seven_parameters;
pub mod tangent;

pub use area::area_between;
pub use cameras::CameraMatrices;
pub use distance::{sampson_distance, symmetric_epipolar_distance};
pub use eight_point::eight_point;
pub use fundamental::Fundamental;
pub use pencil::{LinePair, PencilHomography};
pub use seven_parameters::SevenParameters;
pub use tangent::{TangentPoint, epipolar_tangents};
