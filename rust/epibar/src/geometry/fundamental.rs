//! The fundamental matrix as a type: rank 2, Frobenius norm 1, with its epipoles.
//!
//! Pitfall: nalgebra's 3×3 SVD loses digits where singular values spread, which they do in pixel
//! coordinates; everything here is decomposed in normalised coordinates (centre of the image at the origin, half
//! its diagonal as the unit).

use nalgebra::Matrix3;

use crate::image::{Homogeneous, ImageSize};

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

/// The vector that a matrix of rank 2 sends to nought, `None` where the rank is another.
///
/// Each pair of rows has it as their cross product; the longest of the three loses fewest digits. The third entry of a
/// point in pixels is smaller than the others by the size of the image, so columns are brought to one scale first.
fn null_vector(matrix: &Matrix3<f64>) -> Option<Homogeneous> {
    const PIXELS: f64 = 1000.0;
    const RANK_TWO: f64 = 1e-6;
    let scaled = matrix * Matrix3::from_diagonal(&Homogeneous::new(PIXELS, PIXELS, 1.0));
    let rows = [0, 1, 2].map(|i| scaled.row(i).transpose());
    let rows = rows.map(|row| row.try_normalize(0.0).unwrap_or(row));
    let crosses = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| rows[i].cross(&rows[j]));
    let longest = crosses.into_iter().max_by(|p, q| p.norm().total_cmp(&q.norm()))?;
    let null = longest.try_normalize(1e-9)?;
    let of_rank_two = rows.iter().all(|row| row.dot(&null).abs() < RANK_TWO);
    (of_rank_two && null.iter().all(|v| v.is_finite()))
        .then(|| Homogeneous::new(PIXELS * null.x, PIXELS * null.y, null.z))
}

impl Fundamental {
    /// From a matrix in pixels that is already of rank 2, with its epipoles, which nobody checks.
    ///
    /// `None` where an entry is not finite or the matrix is zero.
    pub(crate) fn from_parts(
        matrix: Matrix3<f64>,
        epipole_a: Homogeneous,
        epipole_b: Homogeneous,
    ) -> Option<Self> {
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

    /// From a matrix in pixels that is of rank 2 up to rounding, such as one that was saved: its entries are kept but for
    /// their scale.
    ///
    /// `None` where an entry is not finite, or the rank is not 2.
    pub fn from_rank_two(matrix: &Matrix3<f64>) -> Option<Self> {
        let (epipole_a, epipole_b) = (null_vector(matrix)?, null_vector(&matrix.transpose())?);
        let found = Self::from_parts(*matrix, epipole_a, epipole_b)?;
        // What is of unit norm already is kept to the last bit.
        let of_unit_norm = (matrix.norm() - 1.0).abs() < 1e-12;
        Some(if of_unit_norm { Self { matrix: *matrix, ..found } } else { found })
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

    /// Epipolar line `F a` in B of a homogeneous point of A: `(a, b, c)` of any length.
    pub fn line_in_b(&self, a: &Homogeneous) -> Homogeneous {
        self.matrix * a
    }

    /// Epipolar line `Fᵀ b` in A of a homogeneous point of B: `(a, b, c)` of any length.
    pub fn line_in_a(&self, b: &Homogeneous) -> Homogeneous {
        self.matrix.tr_mul(b)
    }

    /// The geometry with A and B exchanged.
    #[must_use]
    pub fn transposed(&self) -> Self {
        Self { matrix: self.matrix.transpose(), epipole_a: self.epipole_b, epipole_b: self.epipole_a }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_saved_matrix_is_what_it_was() {
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(1920, 1080).unwrap()];
        for k in 0..50 {
            let entry = |i: usize, j: usize| {
                ((3 * i + 7 * j + 11 * k) as f64).sin() * [1e-3, 1e-3, 1.0][i] * [1e-3, 1e-3, 1.0][j]
            };
            let f = Fundamental::from_matrix(&Matrix3::from_fn(entry), sizes[0], sizes[1]).unwrap();
            let saved = Fundamental::from_rank_two(f.matrix()).unwrap();
            assert!((saved.matrix() - f.matrix()).norm() < 1e-15);
            assert!(
                saved.epipole_a().cross(f.epipole_a()).norm() < 1e-9,
                "{} {}",
                saved.epipole_a(),
                f.epipole_a()
            );
            assert!(saved.epipole_b().cross(f.epipole_b()).norm() < 1e-9);
        }
        let rank_one = Homogeneous::new(0.3, -0.2, 40.0) * Homogeneous::new(0.1, 0.7, -90.0).transpose();
        for bad in [Matrix3::identity(), Matrix3::zeros(), rank_one, Matrix3::from_element(f64::NAN)] {
            assert!(Fundamental::from_rank_two(&bad).is_none(), "{bad}");
        }
        assert!(
            Fundamental::from_parts(Matrix3::identity(), Homogeneous::zeros(), Homogeneous::x()).is_none()
        );
    }
}
