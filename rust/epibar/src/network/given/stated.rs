//! A camera as files state it, in the words of `OpenCV`.

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::geometry::lens::Lens;
use crate::image::ImageSize;
use crate::network::model::camera::Camera;

/// What is stated of a camera.
pub struct Stated<'a> {
    /// The camera matrix, pixels.
    pub matrix: &'a Matrix3<f64>,
    /// `k₁ k₂ p₁ p₂ k₃`; the tangential ones are not used.
    pub distortions: &'a [f64; 5],
    /// `R` of `X_c = R X + t`.
    pub rotation: &'a Matrix3<f64>,
    /// `t` of `X_c = R X + t`.
    pub translation: &'a Vector3<f64>,
}

impl Stated<'_> {
    /// Whether it is one: finite numbers, a rotation, positive focal lengths.
    pub fn is_camera(&self) -> bool {
        let numbers = self.matrix.iter().chain(self.rotation).chain(self.translation).chain(self.distortions);
        let finite = numbers.into_iter().all(|v| v.is_finite());
        let r = self.rotation;
        let rotates = (r.transpose() * r - Matrix3::identity()).norm() < 1e-6 && r.determinant() > 0.0;
        finite && rotates && self.matrix.m11 > 0.0 && self.matrix.m22 > 0.0
    }

    /// The camera, its clock and inset not known.
    pub fn camera(&self, size: ImageSize) -> Camera {
        let rotation = Rotation3::from_matrix_unchecked(*self.rotation);
        Camera {
            log_aspect: (self.matrix.m22 / self.matrix.m11).ln(),
            principal: [self.matrix.m13, self.matrix.m23],
            lens: Lens::of_opencv(self.distortions),
            rotation,
            position: -(rotation.inverse() * self.translation),
            ..Camera::new(size, self.matrix.m11)
        }
    }
}

/// What numbers must be that are refused otherwise.
pub const EXPECTED: &str = "finite numbers, a rotation, positive focal lengths";
