//! Homographies by DLT (Hartley and Zisserman, *Multiple View Geometry*, 4.1), from points and from lines.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::fundamental::{denormaliser, normaliser};
use super::least_matrix::least_matrix;
use super::pencil::LinePair;
use crate::image::ImageSize;

/// A point of A and its match in B, each with a third entry of 1.
pub type PointMatch = (Vector3<f64>, Vector3<f64>);

/// `x_b ~ H x_a` from four or more matches `(x_a, x_b)` with a third entry of 1, in the coordinates of the matches.
///
/// Coordinates should be of order 1. `None` where the decomposition fails.
pub fn from_points<'m>(matches: impl Iterator<Item = &'m PointMatch>) -> Option<Matrix3<f64>> {
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for (a, b) in matches {
        for (i, s) in [(0, b.x), (1, b.y)] {
            let mut row = SVector::<f64, 9>::zeros();
            for j in 0..3 {
                row[3 * i + j] = a[j];
                row[6 + j] = -s * a[j];
            }
            normal.ger(1.0, &row, &row, 1.0);
        }
    }
    least_matrix(&normal)
}

/// The homography by the plane through three or more matches, of those that `f` allows: `H = A − e' vᵀ` with `A = [e']× F`, least
/// squares over `v` (Hartley and Zisserman §13.1).
///
/// In coordinates of order 1; the matches should lie on their epipolar lines. `None` where they determine no plane.
pub fn compatible(
    f: &Matrix3<f64>,
    epipole_b: &Vector3<f64>,
    matches: &[PointMatch],
) -> Option<Matrix3<f64>> {
    let a = epipole_b.cross_matrix() * f;
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for (x, y) in matches {
        // y × (A x − e' (vᵀ x)) = 0
        let across = y.cross(epipole_b);
        normal += across.norm_squared() * x * x.transpose();
        right += y.cross(&(a * x)).dot(&across) * x;
    }
    let v = normal.try_inverse()? * right;
    let homography = a - epipole_b * v.transpose();
    homography.iter().all(|h| h.is_finite()).then_some(homography)
}

/// How far from its match in B a point of A is sent; infinite where that is not known.
pub fn transfer_distance(h: &Matrix3<f64>, (a, b): &PointMatch) -> f64 {
    let sent = h * a;
    let distance = (sent.x / sent.z - b.x).hypot(sent.y / sent.z - b.y);
    if distance.is_nan() { f64::INFINITY } else { distance }
}

/// `x_b ~ H x_a`, pixels, Frobenius norm 1, from four or more pairs of lines: `l_a × Hᵀ l_b = 0`.
///
/// `None` where the pairs do not determine an invertible map.
pub fn from_line_pairs<'p>(
    pairs: impl Iterator<Item = &'p LinePair>,
    sizes: [ImageSize; 2],
) -> Option<Matrix3<f64>> {
    let (da, db) = (denormaliser(sizes[0]).transpose(), denormaliser(sizes[1]).transpose());
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for pair in pairs {
        let a = (da * pair.a.homogeneous()).normalize();
        let b = (db * pair.b.homogeneous()).normalize();
        for row in a.cross_matrix().row_iter() {
            let mut equation = SVector::<f64, 9>::zeros();
            for i in 0..3 {
                for j in 0..3 {
                    equation[3 * i + j] = row[i] * b[j];
                }
            }
            normal.ger(1.0, &equation, &equation, 1.0);
        }
    }
    let lines = least_matrix(&normal)?;
    if lines.determinant().abs() < 1e-7 {
        return None;
    }
    // Lines of B to lines of A by `lines` = Hᵀ in normalised coordinates.
    let h = denormaliser(sizes[1]) * lines.transpose() * normaliser(sizes[0]);
    let norm = h.norm();
    (norm.is_finite() && norm > 0.0).then(|| h / norm)
}
