//! Barcodes, their matches, and motion lines.

use epibar::internals::{MotionLineOptions, barcodes_of_segments, mutual_matches};
use epibar::{ImageSize, Segment};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::convert::{as_barcodes, bits, enter, rows, slice, to_python_error};
use crate::recording::Recording;

/// Motion barcodes of segments in masks (T, H, W).
#[pyfunction]
pub fn barcodes<'py>(
    py: Python<'py>,
    masks: PyReadonlyArrayDyn<'py, u8>,
    segments: PyReadonlyArrayDyn<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<u64>>> {
    let pixels = slice("masks", &masks, 3)?;
    let ends = slice("segments", &segments, 2)?;
    if segments.shape()[1] != 4 {
        return Err(PyValueError::new_err("segments must have four columns: x0, y0, x1, y1"));
    }
    let frames = masks.shape()[0];
    let size = ImageSize::new(masks.shape()[2], masks.shape()[1]).map_err(|error| to_python_error(&error))?;
    let segments: Vec<Segment> =
        ends.chunks_exact(4).map(|s| Segment { x0: s[0], y0: s[1], x1: s[2], y1: s[3] }).collect();
    let found = enter(py, || barcodes_of_segments(pixels, frames, size, &segments))?;
    bits(py, &found)
}

type Matches<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<f64>>);

/// Pairs in the mutual top of each other, best first.
#[pyfunction]
pub fn match_barcodes<'py>(
    py: Python<'py>,
    bits_a: PyReadonlyArrayDyn<'py, u64>,
    bits_b: PyReadonlyArrayDyn<'py, u64>,
    frames: usize,
    mutual: usize,
    limit: usize,
) -> PyResult<Matches<'py>> {
    let (a, b) = (as_barcodes("bits_a", &bits_a, frames)?, as_barcodes("bits_b", &bits_b, frames)?);
    let mut found = enter(py, || mutual_matches(&a, &b, mutual))?;
    found.truncate(limit);
    let index_a: Vec<i64> = found.iter().map(|m| i64::from(m.a)).collect();
    let index_b: Vec<i64> = found.iter().map(|m| i64::from(m.b)).collect();
    let correlation: Vec<f64> = found.iter().map(|m| f64::from(m.correlation)).collect();
    Ok((index_a.into_pyarray(py), index_b.into_pyarray(py), correlation.into_pyarray(py)))
}

/// Motion lines of a recording, (n, 3).
#[pyfunction]
pub fn motion_lines<'py>(py: Python<'py>, rec: &Recording) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let found = enter(py, || Ok(epibar::internals::motion_lines(&rec.inner, &MotionLineOptions::default())))?;
    rows(py, found.into_iter().map(|l| [l.a(), l.b(), l.c()]))
}
