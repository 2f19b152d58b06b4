//! The fundamental matrix as a type: rank 2, Frobenius norm 1, with its epipoles.
//!
//! Pitfall: nalgebra's 3×3 SVD loses digits where singular values spread, which they do in pixel
//! coordinates; everything here is decomposed in normalised coordinates (centre of the image at the origin, half
//! its diagonal as the unit).

use nalgebra::Matrix3;

use crate::line::{Homogeneous, ImageSize};

/// A fundamental matrix `F`, `x_bᵀ F x_a = 0`, Frobenius norm 1, with its right and left null vectors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fundamental {
    matrix: Matrix3<f64>,
    epipole_a: Homogeneous,
    epipole_b: Homogeneous,
}

/// Similarity that maps pixels of an image to coordinates of order 1.
pub(crate) fn normaliser(size: ImageSize) -> Matrix3<f64> {
    let scale = 2.0 / size.diagonal();
    Matrix3::new(
        scale,
        0.0,
        -scale * 0.5 * size.x_max(),
        0.0,
        scale,
        -scale * 0.5 * size.y_max(),
        0.0,
        0.0,
        1.0,
    )
}

/// Inverse of [`normaliser`].
pub(crate) fn denormaliser(size: ImageSize) -> Matrix3<f64> {
    let scale = 0.5 * size.diagonal();
    Matrix3::new(scale, 0.0, 0.5 * size.x_max(), 0.0, scale, 0.5 * size.y_max(), 0.0, 0.0, 1.0)
}

impl Fundamental {
    /// From a matrix in pixels that is already of rank 2, with known epipoles.
    ///
    /// `None` where an entry is not finite or the matrix is zero.
    pub fn from_parts(matrix: Matrix3<f64>, epipole_a: Homogeneous, epipole_b: Homogeneous) -> Option<Self> {
        let norm = matrix.norm();
        let (na, nb) = (epipole_a.norm(), epipole_b.norm());
        let ok = [norm, na, nb].iter().all(|v| v.is_finite() && *v > 0.0);
        ok.then(|| Self { matrix: matrix / norm, epipole_a: epipole_a / na, epipole_b: epipole_b / nb })
    }

    /// The nearest rank-2 matrix (in normalised coordinates of the two images) to `matrix` in pixels.
    ///
    /// `None` where an entry is not finite or the rank is below 2.
    pub fn from_matrix(matrix: &Matrix3<f64>, size_a: ImageSize, size_b: ImageSize) -> Option<Self> {
        let (ta, tb) = (normaliser(size_a), normaliser(size_b));
        let (ia, ib) = (denormaliser(size_a), denormaliser(size_b));
        let normalised = ib.transpose() * matrix * ia;
        if !normalised.iter().all(|v| v.is_finite()) || normalised.norm() == 0.0 {
            return None;
        }
        let normalised = normalised / normalised.norm();
        let svd = normalised.try_svd(true, true, 1e-15, 200)?;
        let (u, vt) = (svd.u?, svd.v_t?);
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| svd.singular_values[j].total_cmp(&svd.singular_values[i]));
        let [first, second, third] = order;
        if svd.singular_values[second] < 1e-12 {
            return None;
        }
        let rank_two = u.column(first) * vt.row(first) * svd.singular_values[first]
            + u.column(second) * vt.row(second) * svd.singular_values[second];
        let epipole_a = ia * vt.row(third).transpose();
        let epipole_b = ib * u.column(third);
        Self::from_parts(tb.transpose() * rank_two * ta, epipole_a, epipole_b)
    }

    /// The matrix, pixels, Frobenius norm 1.
    pub fn matrix(&self) -> &Matrix3<f64> {
        &self.matrix
    }

    /// Epipole in A, `F e = 0`: the image of camera B's centre; homogeneous, unit norm.
    pub fn epipole_a(&self) -> &Homogeneous {
        &self.epipole_a
    }

    /// Epipole in B, `Fᵀ e' = 0`: the image of camera A's centre; homogeneous, unit norm.
    pub fn epipole_b(&self) -> &Homogeneous {
        &self.epipole_b
    }

    /// Epipolar line in B of a point of A.
    pub fn line_in_b(&self, a: &Homogeneous) -> Homogeneous {
        self.matrix * a
    }

    /// Epipolar line in A of a point of B.
    pub fn line_in_a(&self, b: &Homogeneous) -> Homogeneous {
        self.matrix.tr_mul(b)
    }

    /// The geometry with A and B exchanged.
    #[must_use]
    pub fn transposed(&self) -> Self {
        Self { matrix: self.matrix.transpose(), epipole_a: self.epipole_b, epipole_b: self.epipole_a }
    }
}
