//! Homogeneous least squares over the nine entries of a matrix (the last step of every DLT).

use nalgebra::{Matrix3, SMatrix};

/// The 3×3 matrix, row by row, of unit norm for which a quadratic form is least.
pub(crate) fn least_matrix(form: &SMatrix<f64, 9, 9>) -> Option<Matrix3<f64>> {
    let eigen = form.try_symmetric_eigen(1e-14, 300)?;
    Some(Matrix3::from_row_slice(eigen.eigenvectors.column(eigen.eigenvalues.imin()).as_slice()))
}
