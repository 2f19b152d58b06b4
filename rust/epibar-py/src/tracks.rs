//! Walkers as tracks over the cameras of a network.

use epibar::nalgebra::Vector3;
use epibar::network::TrackingCamera;
use numpy::IntoPyArray;
use numpy::ndarray::Array2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{matrix_of_rows, rows};
use crate::recording::Recording;
use crate::watch::watched;

/// A camera of a network with its clock.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct PythonTracking {
    matrix: [[f64; 3]; 3],
    distortions: [f64; 5],
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
    clock: (f64, f64),
}

/// Tracks of walkers: arrays by the names of `epibar.network.WalkerTracks`.
#[pyfunction]
pub fn walker_tracks<'py>(
    py: Python<'py>,
    recordings: Vec<PyRef<'py, Recording>>,
    cameras: Vec<PythonTracking>,
    height: f64,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    if cameras.len() != recordings.len() {
        return Err(PyValueError::new_err("a camera for each recording"));
    }
    let inputs: Vec<TrackingCamera> = recordings
        .iter()
        .zip(&cameras)
        .map(|(r, c)| TrackingCamera {
            recording: &r.inner,
            matrix: matrix_of_rows(&c.matrix),
            distortions: c.distortions,
            rotation: matrix_of_rows(&c.rotation),
            translation: Vector3::from(c.translation),
            clock: c.clock,
        })
        .collect();
    let found = watched(py, progress, |watch| epibar::network::walker_tracks(&inputs, height, watch))?;
    let dict = PyDict::new(py);
    dict.set_item("time", found.iter().map(|p| p.time).collect::<Vec<_>>().into_pyarray(py))?;
    dict.set_item("track", found.iter().map(|p| i64::from(p.track)).collect::<Vec<_>>().into_pyarray(py))?;
    dict.set_item("foot", rows(py, found.iter().map(|p| p.foot))?)?;
    dict.set_item("top", rows(py, found.iter().map(|p| p.top))?)?;
    let saw = |(i, k): (usize, usize)| found[i].cameras[k];
    let cameras = Array2::from_shape_fn((found.len(), inputs.len()), saw);
    dict.set_item("cameras", cameras.into_pyarray(py))?;
    dict.set_item("residual", found.iter().map(|p| p.residual).collect::<Vec<_>>().into_pyarray(py))?;
    Ok(dict)
}
