//! Scores of matrices that the caller already has, many at a time.

use epibar::internals::{
    Candidate, Estimator, FrontierScore, LineModel, LinePair, Views, busy_frames, common_frames,
    frontier_score,
};
use epibar::nalgebra::{Matrix3, Vector3};
use epibar::{Error, Fundamental, ImageSize, Line};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::convert::{enter, slice, to_python_error};
use crate::recording::Recording;

/// For each matrix (m, 3, 3) how many pairs of lines (n, 3) are its inliers by the area between them.
#[pyfunction]
pub fn score_lines<'py>(
    py: Python<'py>,
    lines_a: PyReadonlyArrayDyn<'py, f64>,
    lines_b: PyReadonlyArrayDyn<'py, f64>,
    sizes: [(usize, usize); 2],
    matrices: PyReadonlyArrayDyn<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let size = |(width, height)| ImageSize::new(width, height).map_err(|error| to_python_error(&error));
    let sizes = [size(sizes[0])?, size(sizes[1])?];
    let (a, b) = (lines("lines_a", &lines_a)?, lines("lines_b", &lines_b)?);
    if a.len() != b.len() {
        return Err(PyValueError::new_err(format!("{} lines in A, but {} in B", a.len(), b.len())));
    }
    let models = fundamentals(&matrices, sizes)?;
    let counts = enter(py, || {
        let candidates = a.iter().zip(&b).map(|(a, b)| candidate(a, b, sizes));
        let candidates = candidates.collect::<epibar::Result<Vec<_>>>()?;
        let model = LineModel::new(&candidates, sizes);
        Ok(models.par_iter().map(|f| model.score(f) as i64).collect::<Vec<i64>>())
    })?;
    Ok(counts.into_pyarray(py))
}

type Evidence<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<i64>>);

/// For each matrix (m, 3, 3) its score over chance and the number of tangents that meet.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the Python layer names them")]
pub fn score_tangents<'py>(
    py: Python<'py>,
    a: &Recording,
    b: &Recording,
    matrices: PyReadonlyArrayDyn<'py, f64>,
    radius: f64,
    time_offset: f64,
    upright: bool,
    frames: usize,
) -> PyResult<Evidence<'py>> {
    let (a, b) = (&a.inner, &b.inner);
    let models = fundamentals(&matrices, [a.size(), b.size()])?;
    let scores = enter(py, || {
        let busy = busy_frames(a, b, &common_frames(a, b, time_offset), Some(frames));
        let views = Views::new(a, b, &busy).with_upright(upright);
        Ok(models.par_iter().map(|f| frontier_score(&views, f, radius)).collect::<Vec<_>>())
    })?;
    let excess: Vec<f64> = scores.iter().map(FrontierScore::total).collect();
    let matches: Vec<i64> = scores.iter().map(|score| score.matches() as i64).collect();
    Ok((excess.into_pyarray(py), matches.into_pyarray(py)))
}

fn lines(name: &str, lines: &PyReadonlyArrayDyn<'_, f64>) -> PyResult<Vec<Line>> {
    let values = slice(name, lines, 2)?;
    if lines.shape()[1] != 3 {
        return Err(PyValueError::new_err(format!("{name} must have three columns: a, b, c")));
    }
    let made = values.chunks_exact(3).map(|l| Line::from_homogeneous(&Vector3::from_column_slice(l)));
    made.collect::<Option<_>>()
        .ok_or_else(|| PyValueError::new_err(format!("{name} must be finite and not at infinity")))
}

fn fundamentals(
    matrices: &PyReadonlyArrayDyn<'_, f64>,
    [size_a, size_b]: [ImageSize; 2],
) -> PyResult<Vec<Fundamental>> {
    let entries = slice("matrices", matrices, 3)?;
    if matrices.shape()[1..] != [3, 3] {
        return Err(PyValueError::new_err("matrices must be (m, 3, 3)"));
    }
    let made = entries
        .chunks_exact(9)
        .map(|f| Fundamental::from_matrix(&Matrix3::from_row_slice(f), size_a, size_b));
    made.collect::<Option<_>>().ok_or_else(|| PyValueError::new_err("matrices must be finite and of rank 2"))
}

fn candidate(a: &Line, b: &Line, [size_a, size_b]: [ImageSize; 2]) -> epibar::Result<Candidate> {
    let inside = |line: &Line, size| {
        line.clip(size).ok_or_else(|| Error::Argument {
            name: "lines",
            value: format!("{line:?}"),
            expected: "must cross the image",
        })
    };
    Ok(Candidate {
        lines: LinePair { a: *a, b: *b },
        segment_a: inside(a, size_a)?,
        segment_b: inside(b, size_b)?,
        correlation: 1.0,
    })
}
