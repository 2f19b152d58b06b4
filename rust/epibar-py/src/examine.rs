//! A matrix that the caller already has, against what moved.

use epibar::{ExamineOptions, Fundamental};
use numpy::{IntoPyArray, PyReadonlyArrayDyn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{PythonMatrices, camera_matrices, enter, matrix, matrix_of, rows};
use crate::recording::Recording;

/// Frontier points and score of a given F, after refining it on the tangents where asked.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the Python layer names them")]
pub fn examine<'py>(
    py: Python<'py>,
    a: &Recording,
    b: &Recording,
    f: PyReadonlyArrayDyn<'py, f64>,
    radius: f64,
    time_offset: f64,
    upright: bool,
    refined: bool,
    cameras: Option<PythonMatrices<'_>>,
) -> PyResult<Bound<'py, PyDict>> {
    let cameras = camera_matrices(cameras)?;
    let (a, b) = (&a.inner, &b.inner);
    let given = Fundamental::from_matrix(&matrix_of("F", &f)?, a.size(), b.size())
        .ok_or_else(|| PyValueError::new_err("F must be finite and of rank 2"))?;
    let mut options =
        ExamineOptions::new().radius(radius).time_offset(time_offset).upright(upright).refine(refined);
    options.cameras = cameras;
    let examined = enter(py, || epibar::examine(a, b, &given, &options))?;
    let found = PyDict::new(py);
    found.set_item("F", matrix(examined.fundamental.matrix()).into_pyarray(py))?;
    found.set_item("evidence", examined.score)?;
    for (name, class) in [("tops", examined.tops), ("bottoms", examined.bottoms)] {
        let entry = PyDict::new(py);
        entry.set_item("tangents", class.tangents)?;
        entry.set_item("matches", class.matches)?;
        entry.set_item("expected", class.expected)?;
        entry.set_item("excess", class.excess)?;
        found.set_item(name, entry)?;
    }
    let points = &examined.frontier_points;
    let frame: Vec<i64> = points.iter().map(|p| p.frame.index() as i64).collect();
    found.set_item("frame", frame.into_pyarray(py))?;
    found.set_item("a", rows(py, points.iter().map(|p| p.a))?)?;
    found.set_item("b", rows(py, points.iter().map(|p| p.b))?)?;
    found.set_item("distance", examined.distances.into_pyarray(py))?;
    Ok(found)
}
