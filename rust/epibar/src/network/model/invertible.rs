//! The normal matrix of the joint problem, inverted though nothing says where the whole stands.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// What nothing determines is held by next to nothing: by this share of the diagonal.
pub const HELD: f64 = 1e-9;

/// A normal matrix that can be inverted.
pub struct Invertible {
    root: Cholesky<f64, Dyn>,
    /// One over the roots of its diagonal, by which rows and columns were multiplied.
    scale: DVector<f64>,
}

impl Invertible {
    /// `None` where the matrix is not usable.
    pub fn of(normal: &DMatrix<f64>) -> Option<Self> {
        let n = normal.nrows();
        let scale = DVector::from_fn(n, |k, _| 1.0 / normal[(k, k)].max(1e-300).sqrt());
        let scaled = DMatrix::from_fn(n, n, |i, j| normal[(i, j)] * scale[i] * scale[j]);
        let held = scaled + DMatrix::identity(n, n) * HELD;
        Some(Self { root: held.cholesky()?, scale })
    }

    /// The inverse.
    pub fn inverse(&self) -> DMatrix<f64> {
        let scaled = self.root.inverse();
        DMatrix::from_fn(scaled.nrows(), scaled.ncols(), |i, j| {
            scaled[(i, j)] * self.scale[i] * self.scale[j]
        })
    }

    /// Logarithm of the determinant.
    pub fn log_determinant(&self) -> f64 {
        let root = self.root.l_dirty();
        2.0 * self.scale.iter().enumerate().map(|(k, scale)| (root[(k, k)] / scale).ln()).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_determined_is_inverted() {
        let normal = DMatrix::from_row_slice(2, 2, &[4e8, 2e2, 2e2, 9e-4]);
        let found = Invertible::of(&normal).unwrap();
        // In units that differ as those of a lens and of a pixel, so that each number is compared by itself.
        let inverse = normal.clone().try_inverse().unwrap();
        assert!(found.inverse().iter().zip(&inverse).all(|(p, q)| (p / q - 1.0).abs() < 1e-6));
        assert!((found.log_determinant() - normal.determinant().ln()).abs() < 1e-6);
    }

    #[test]
    fn what_nothing_determines_is_held() {
        let only_the_sum = DMatrix::from_element(2, 2, 3.0);
        assert!(Invertible::of(&only_the_sum).unwrap().inverse().iter().all(|v| v.abs() > 1e6));
        assert!(Invertible::of(&DMatrix::from_element(2, 2, f64::NAN)).is_none());
    }
}
