//! Which frame of B shows the moment of a frame of A.

use epibar::internals::Clock;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::convert::{enter, rows};
use crate::recording::Recording;

/// Seconds from one frame to the next.
#[pyfunction]
pub fn frame_interval(recording: &Recording) -> f64 {
    recording.inner.frame_interval()
}

/// Seconds by B's clock for each second by A's.
#[pyfunction]
pub fn clock_rate(a: &Recording, b: &Recording, frames_per_frame: f64) -> f64 {
    Clock::of_frames(0.0, frames_per_frame, &a.inner, &b.inner).rate
}

/// For each frame of A its position in B, NaN where B saw nothing of that moment.
#[pyfunction]
pub fn positions<'py>(
    py: Python<'py>,
    a: &Recording,
    b: &Recording,
    time_offset: f64,
    frames_per_frame: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (a, b) = (&a.inner, &b.inner);
    enter(py, || Ok(Clock::of_frames(time_offset, frames_per_frame, a, b).positions(a, b)))
        .map(|positions| positions.into_pyarray(py))
}

/// Pairs (frame of A, nearest frame of B) that show the same moment.
#[pyfunction]
pub fn common_frames<'py>(
    py: Python<'py>,
    a: &Recording,
    b: &Recording,
    time_offset: f64,
    frames_per_frame: f64,
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let (a, b) = (&a.inner, &b.inner);
    let pairs = enter(py, || Ok(Clock::of_frames(time_offset, frames_per_frame, a, b).common_frames(a, b)))?;
    rows(py, pairs.into_iter().map(|p| [p.a, p.b].map(|frame| frame.index() as i64)))
}
