//! Between numpy (row-major) and the crate's types, each direction in one place.

use epibar::nalgebra::Matrix3;
use epibar::{Barcodes, CameraMatrices};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyKeyboardInterrupt, PyMemoryError, PyValueError};
use pyo3::prelude::*;

/// The one place where errors of the crate become Python's.
pub fn to_python_error(error: &epibar::Error) -> PyErr {
    match error {
        epibar::Error::Interrupted => PyKeyboardInterrupt::new_err(error.to_string()),
        other => PyValueError::new_err(other.to_string()),
    }
}

/// Releases the GIL, runs `work`, maps its error: every call into the crate goes through here, or through
/// [`watched`](crate::watch::watched) where it is long.
pub fn enter<T: Send>(py: Python<'_>, work: impl FnOnce() -> epibar::Result<T> + Send) -> PyResult<T> {
    py.detach(work).map_err(|error| to_python_error(&error))
}

/// A 3×3 matrix, rows first (nalgebra stores columns first).
pub fn matrix(m: &Matrix3<f64>) -> Array2<f64> {
    Array2::from_shape_fn((3, 3), |(i, j)| m[(i, j)])
}

/// A 3×3 matrix of nested lists, rows first.
pub fn matrix_of_rows(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

/// A 3×3 matrix of Python's.
pub fn matrix_of(name: &str, array: &PyReadonlyArrayDyn<'_, f64>) -> PyResult<Matrix3<f64>> {
    let entries = slice(name, array, 2)?;
    if array.shape() != [3, 3] {
        return Err(PyValueError::new_err(format!("{name} must be 3x3")));
    }
    Ok(Matrix3::from_row_slice(entries))
}

/// Camera matrices of A and of B.
pub type PythonMatrices<'py> = (PyReadonlyArrayDyn<'py, f64>, PyReadonlyArrayDyn<'py, f64>);

/// Both camera matrices, where they are known.
pub fn camera_matrices(cameras: Option<PythonMatrices<'_>>) -> PyResult<Option<CameraMatrices>> {
    let both = |(a, b): PythonMatrices<'_>| {
        let a = matrix_of("the camera matrix of A", &a)?;
        let b = matrix_of("the camera matrix of B", &b)?;
        CameraMatrices::new(a, b).map_err(|error| to_python_error(&error))
    };
    cameras.map(both).transpose()
}

/// Rows of `N` numbers as an `(n, N)` array.
pub fn rows<T: numpy::Element + Copy, const N: usize>(
    py: Python<'_>,
    rows: impl Iterator<Item = [T; N]>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let flat: Vec<T> = rows.flatten().collect();
    Array2::from_shape_vec((flat.len() / N, N), flat)
        .map(|array| array.into_pyarray(py))
        .map_err(|error| PyMemoryError::new_err(error.to_string()))
}

/// Barcodes as an (n, words) array.
pub fn bits<'py>(py: Python<'py>, barcodes: &Barcodes) -> PyResult<Bound<'py, PyArray2<u64>>> {
    Array2::from_shape_vec((barcodes.count(), barcodes.words_per()), barcodes.words().to_vec())
        .map(|array| array.into_pyarray(py))
        .map_err(|error| PyValueError::new_err(error.to_string()))
}

/// An (n, words) array as barcodes of `frames` frames.
pub fn as_barcodes(name: &str, bits: &PyReadonlyArrayDyn<'_, u64>, frames: usize) -> PyResult<Barcodes> {
    let words = slice(name, bits, 2)?;
    let (count, words_per) = (bits.shape()[0], bits.shape()[1]);
    if words_per != frames.div_ceil(64) {
        return Err(PyValueError::new_err(format!(
            "{name} has {words_per} words per barcode, but {frames} frames need {}",
            frames.div_ceil(64)
        )));
    }
    let tail = frames % 64;
    if tail != 0 && words.chunks_exact(words_per).any(|row| row[words_per - 1] >> tail != 0) {
        return Err(PyValueError::new_err(format!("{name} has bits set beyond its {frames} frames")));
    }
    Barcodes::from_words(count, frames, words.to_vec()).map_err(|error| to_python_error(&error))
}

/// A C-contiguous slice of an argument with the given number of dimensions.
pub fn slice<'a, T: numpy::Element>(
    name: &str,
    array: &'a PyReadonlyArrayDyn<'_, T>,
    dimensions: usize,
) -> PyResult<&'a [T]> {
    if array.ndim() != dimensions {
        return Err(PyValueError::new_err(format!(
            "{name} has {} dimensions, expected {dimensions}",
            array.ndim()
        )));
    }
    // `as_slice` takes Fortran's order as well, and would hand out the transposed array.
    array.as_slice().ok().filter(|_| array.is_c_contiguous()).ok_or_else(|| {
        PyValueError::new_err(format!("{name} must be C-contiguous: use numpy.ascontiguousarray"))
    })
}
