//! Epipolar line homographies: from line pairs to a fundamental matrix (paper §3.1).
//!
//! Two pencils of lines, through `e` and `e'`, correspond by a 1-D homography: a line of the first pencil,
//! with coordinates `λ` (2 numbers) in a basis of the pencil, goes to the line with coordinates `h λ` in the
//! other. Three pairs of lines fix the 2×2 matrix `h`, by DLT. (A 3×3 `H` is *not* determined by three
//! concurrent lines, and `F = [e']× H^{-T}` depends only on its action on the pencil.)
//!
//! With bases `P` (3×2, columns are lines through `e`) and `P'`, a point `x` of A lies on the line `e × x`,
//! whose coordinates are `Pᵀ (e × x)` for orthonormal columns, so `F = P' h Pᵀ [e]×`.

use nalgebra::{Matrix2, Matrix3, Matrix3x2, Matrix4, Vector3};

use super::fundamental::{Fundamental, denormaliser, normaliser};
use crate::image::{Homogeneous, ImageSize, Line};

/// A line of A and the line of B that it may correspond to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinePair {
    /// Line in A.
    pub a: Line,
    /// Line in B.
    pub b: Line,
}

/// Orthonormal basis (columns) of the lines through a point.
fn pencil_basis(point: &Homogeneous) -> Matrix3x2<f64> {
    let p = point.normalize();
    // The coordinate axis least aligned with the point gives a well-conditioned first line.
    let axis = Vector3::ith(p.iamin(), 1.0);
    let first = p.cross(&axis).normalize();
    let second = p.cross(&first);
    Matrix3x2::from_columns(&[first, second])
}

/// A 1-D homography between the pencils of two epipoles.
#[derive(Debug, Clone, Copy)]
pub struct PencilHomography {
    epipole_a: Homogeneous,
    epipole_b: Homogeneous,
    basis_a: Matrix3x2<f64>,
    basis_b: Matrix3x2<f64>,
    action: Matrix2<f64>,
    sizes: [ImageSize; 2],
}

impl PencilHomography {
    /// From three or more line pairs through (or near) the epipoles, by DLT.
    ///
    /// Epipoles in pixels, homogeneous. Lines that do not pass through the epipole are first projected onto
    /// the pencil. `None` where the pairs do not determine an invertible map, such as two equal lines.
    pub fn from_line_pairs(
        epipole_a: &Homogeneous,
        epipole_b: &Homogeneous,
        pairs: &[LinePair],
        sizes: [ImageSize; 2],
    ) -> Option<Self> {
        let (ta, tb) = (normaliser(sizes[0]), normaliser(sizes[1]));
        let (ea, eb) = (ta * epipole_a, tb * epipole_b);
        let (ea, eb) = (ea.try_normalize(1e-300)?, eb.try_normalize(1e-300)?);
        let (basis_a, basis_b) = (pencil_basis(&ea), pencil_basis(&eb));
        let (da, db) = (denormaliser(sizes[0]), denormaliser(sizes[1]));
        // μ' × (h μ) = 0 for each pair: one equation in the four entries of h.
        let mut normal = Matrix4::zeros();
        for pair in pairs {
            let mu_a = basis_a.tr_mul(&da.tr_mul(&pair.a.homogeneous())).try_normalize(1e-300)?;
            let mu_b = basis_b.tr_mul(&db.tr_mul(&pair.b.homogeneous())).try_normalize(1e-300)?;
            let row =
                nalgebra::Vector4::new(-mu_b.y * mu_a.x, -mu_b.y * mu_a.y, mu_b.x * mu_a.x, mu_b.x * mu_a.y);
            normal += row * row.transpose();
        }
        let eigen = normal.try_symmetric_eigen(1e-15, 200)?;
        let least = eigen.eigenvalues.imin();
        // A second null direction means that the pairs are not three different ones.
        let second =
            (0..4).filter(|&i| i != least).map(|i| eigen.eigenvalues[i]).fold(f64::INFINITY, f64::min);
        if second < 1e-14 {
            return None;
        }
        let v = eigen.eigenvectors.column(least);
        let action = Matrix2::new(v[0], v[1], v[2], v[3]);
        // Unit norm in orthonormal bases: cameras give some 0.5, one line for two gives rounding, up to 1e-11.
        (action.determinant().abs() > 1e-9).then_some(Self {
            epipole_a: ea,
            epipole_b: eb,
            basis_a,
            basis_b,
            action,
            sizes,
        })
    }

    /// `F = P' h Pᵀ [e]×`, which is `[e']× H^{-T}` for every `H` with this action (paper eq. 3).
    pub fn fundamental(&self) -> Option<Fundamental> {
        let (ta, tb) = (normaliser(self.sizes[0]), normaliser(self.sizes[1]));
        let normalised: Matrix3<f64> =
            self.basis_b * self.action * self.basis_a.transpose() * self.epipole_a.cross_matrix();
        let (da, db) = (denormaliser(self.sizes[0]), denormaliser(self.sizes[1]));
        Fundamental::from_parts(tb.transpose() * normalised * ta, da * self.epipole_a, db * self.epipole_b)
    }
}
