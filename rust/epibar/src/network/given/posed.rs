//! A camera with its pose as files state it, in the words of `OpenCV`.

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::geometry::lens::Lens;
use crate::image::ImageSize;
use crate::network::model::camera::Camera;

/// A camera whose matrix, lens and pose are known, as in the files of a network. Any numbers may stand here: whoever takes
/// one refuses what no camera has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PosedCamera {
    /// The camera matrix, pixels.
    pub matrix: Matrix3<f64>,
    /// `k₁ k₂ p₁ p₂ k₃` of `OpenCV`; the tangential ones are not used.
    pub distortions: [f64; 5],
    /// `R` of `X_c = R X + t`.
    pub rotation: Matrix3<f64>,
    /// `t` of `X_c = R X + t`, in the unit of the network.
    pub translation: Vector3<f64>,
}

impl PosedCamera {
    /// Whether it is one: finite numbers, a rotation, positive focal lengths.
    pub(crate) fn is_camera(&self) -> bool {
        let Self { matrix, distortions, rotation: r, translation } = self;
        let finite = matrix.iter().chain(r).chain(translation).chain(distortions).all(|v| v.is_finite());
        let rotates = (r.transpose() * r - Matrix3::identity()).norm() < 1e-6 && r.determinant() > 0.0;
        finite && rotates && matrix.m11 > 0.0 && matrix.m22 > 0.0
    }

    /// What is solved for, its clock and inset not known.
    pub(crate) fn solvable(&self, size: ImageSize) -> Camera {
        let rotation = Rotation3::from_matrix_unchecked(self.rotation);
        Camera {
            log_aspect: (self.matrix.m22 / self.matrix.m11).ln(),
            principal: [self.matrix.m13, self.matrix.m23],
            lens: Lens::of_opencv(&self.distortions),
            rotation,
            position: -(rotation.inverse() * self.translation),
            ..Camera::new(size, self.matrix.m11)
        }
    }
}

/// What numbers must be that are refused otherwise.
pub const EXPECTED: &str = "finite numbers, a rotation, positive focal lengths";
