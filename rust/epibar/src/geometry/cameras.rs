//! Known camera matrices, under which a fundamental matrix is an essential one: `E = K_bᵀ F K_a`.

use nalgebra::{Matrix3, Vector3};

use super::fundamental::Fundamental;
use crate::error::{Error, Result};

/// Camera matrices of A and B, undistorted pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraMatrices {
    pub(crate) a: Matrix3<f64>,
    pub(crate) b: Matrix3<f64>,
}

impl CameraMatrices {
    /// The matrices of the pair with B for A.
    pub(crate) fn swapped(self) -> Self {
        Self { a: self.b, b: self.a }
    }

    /// The matrices of A and of B, `[[fx, s, cx], [0, fy, cy], [0, 0, 1]]` in pixels.
    ///
    /// # Errors
    /// [`Error::Argument`] unless both are finite, with positive focal lengths and a last row of 0, 0, 1.
    pub fn new(a: Matrix3<f64>, b: Matrix3<f64>) -> Result<Self> {
        let last = |k: &Matrix3<f64>| (k.row(2).transpose() - Vector3::z()).norm() < 1e-9;
        let usable =
            |k: &Matrix3<f64>| k.iter().all(|v| v.is_finite()) && k.m11 > 0.0 && k.m22 > 0.0 && last(k);
        if usable(&a) && usable(&b) {
            return Ok(Self { a, b });
        }
        Err(Error::Argument {
            name: "cameras",
            value: format!("{:?} and {:?}", a.transpose().as_slice(), b.transpose().as_slice()),
            expected: "two finite camera matrices [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]",
        })
    }

    /// Of A.
    pub fn a(&self) -> &Matrix3<f64> {
        &self.a
    }

    /// Of B.
    pub fn b(&self) -> &Matrix3<f64> {
        &self.b
    }

    /// `(s₁ − s₂) / (s₁ + s₂)` of the singular values of `E`: 0 for an essential matrix.
    pub fn deviation(&self, f: &Fundamental) -> f64 {
        let e = self.b.tr_mul(&(f.matrix() * self.a));
        // Of rank 2: s₁² + s₂² is the trace of E Eᵀ, s₁² s₂² the sum of its principal minors.
        let square = e * e.transpose();
        let (sum, product) = (square.trace(), 0.5 * (square.trace().powi(2) - square.norm_squared()));
        let twice = 2.0 * product.max(0.0).sqrt();
        ((sum - twice).max(0.0) / (sum + twice)).sqrt()
    }
}
