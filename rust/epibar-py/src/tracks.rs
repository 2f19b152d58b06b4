//! Walkers as tracks over the cameras of a network.

use epibar::network::{TrackPoint, TrackSighting, TrackingCamera};
use numpy::IntoPyArray;
use numpy::ndarray::{Array2, Array3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::rows;
use crate::network::PythonPosed;
use crate::recording::Recording;
use crate::watch::watched;

/// A camera of a network with its clock.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct PythonTracking {
    camera: PythonPosed,
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
        .map(|(r, c)| TrackingCamera::new(&r.inner, c.camera.posed()).clock(c.clock.0, c.clock.1))
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
    dict.set_item("sightings", sightings(py, &found)?)?;
    Ok(dict)
}

/// Arrays by the names of `epibar.network.WalkerSightings`.
fn sightings<'py>(py: Python<'py>, found: &[TrackPoint]) -> PyResult<Bound<'py, PyDict>> {
    let all: Vec<(usize, &TrackSighting)> = found
        .iter()
        .enumerate()
        .flat_map(|(row, point)| point.sightings.iter().map(move |s| (row, s)))
        .collect();
    let dict = PyDict::new(py);
    dict.set_item("place", all.iter().map(|(row, _)| *row as i64).collect::<Vec<_>>().into_pyarray(py))?;
    dict.set_item("cameras", rows(py, all.iter().map(|(_, s)| s.cameras.map(|k| k as i64)))?)?;
    let pixels = |of: fn(&TrackSighting) -> [[f64; 2]; 2]| {
        Array3::from_shape_fn((all.len(), 2, 2), |(i, k, axis)| of(all[i].1)[k][axis]).into_pyarray(py)
    };
    dict.set_item("top", pixels(|s| s.top))?;
    dict.set_item("foot", pixels(|s| s.foot))?;
    Ok(dict)
}
