//! The geometry of two views: fundamental matrices, pencils of epipolar lines, tangents and distances.
//!
//! Equation and convention of the whole crate: `x_bᵀ F x_a = 0`; `F x_a` is a line in B, `Fᵀ x_b` a
//! line in A; `F e = 0` and `Fᵀ e' = 0` (Hartley and Zisserman, *Multiple View Geometry*, ch. 9).
//!
//! * `fundamental`: the matrix as a type, of rank 2 and with its epipoles.
//! * `seven_parameters`: the seven numbers of one, in which it is refined.
//! * `pencil`: from pairs of epipolar lines to a fundamental matrix.
//! * `eight_point`, `homography`, `least_matrix`: from points to a fundamental matrix, from points and lines to a homography, and the least squares under both.
//! * `cameras`, `possible_cameras`: camera matrices that are known, and how far a fundamental matrix is from any two that somebody may have.
//! * `lens`: radial distortion of points, there and back.
//! * `hull`, `tangent`: convex polygons, and where epipolar lines touch them.
//! * `distance`, `area`: how far points are from an epipolar geometry, and how much image lies between two lines.
//! * `across`, `median`: two directions across a third; quantiles of numbers.

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
