//! One more camera for a network: which pairs to search, and where it stands.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::enter;
use crate::network::{
    PythonClocks, PythonKnowledge, PythonPair, PythonStored, camera, camera_inputs, offsets, pair,
    pairs_found, stored_cameras,
};
use crate::recording::Recording;
use crate::watch::watched;

/// Pairs of stored and new cameras that are worth a search; the first recordings are those of stored cameras.
#[pyfunction]
pub fn pairs_to_add(
    py: Python<'_>,
    recordings: Vec<PyRef<'_, Recording>>,
    stored: usize,
    clocks: PythonClocks,
) -> PyResult<Vec<(usize, usize)>> {
    let inner: Vec<_> = recordings.iter().map(|r| &r.inner).collect();
    let clocks = offsets(clocks);
    enter(py, || epibar::network::pairs_to_add(&inner, stored, &clocks))
}

/// Adds cameras to a network; recordings and names are those of the stored cameras and then of the new ones.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "what is given of stored and of new cameras")]
pub fn add_cameras<'py>(
    py: Python<'py>,
    recordings: Vec<PyRef<'py, Recording>>,
    names: Vec<String>,
    stored: Vec<PythonStored>,
    known: Vec<PythonKnowledge>,
    pairs: Vec<PythonPair>,
    clocks: PythonClocks,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let n = stored.len();
    if names.len() != recordings.len() || n + known.len() != recordings.len() {
        return Err(PyValueError::new_err("a name, and what is stored or known, for each recording"));
    }
    let held = stored_cameras(&recordings[..n], &names[..n], &stored);
    let new = camera_inputs(&recordings[n..], &names[n..], &known);
    let pairs = pairs_found(&pairs)?;
    let clocks = offsets(clocks);
    let added =
        watched(py, progress, |watch| epibar::network::add_cameras(&held, &new, &pairs, &clocks, watch))?;
    let dict = PyDict::new(py);
    let cameras = added.cameras.iter().map(|c| camera(py, c)).collect::<PyResult<Vec<_>>>()?;
    dict.set_item("cameras", cameras)?;
    dict.set_item("pairs", added.pairs.iter().map(|p| pair(py, p)).collect::<PyResult<Vec<_>>>()?)?;
    Ok(dict)
}
