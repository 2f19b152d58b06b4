//! Two recordings in, one calibration out.

use epibar::{CalibrateOptions, CandidatePair, FrontierPoint, Line, Method, TimeOffset};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{PythonMatrices, camera_matrices, matrix, rows};
use crate::recording::Recording;
use crate::watch::watched;

type ErrorMaps<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// What is known about a pair of cameras.
#[pyclass(module = "epibar._core", frozen)]
pub struct Calibration {
    inner: epibar::Calibration,
}

/// An offset, or how it is found.
#[derive(FromPyObject)]
pub enum FramesOrWord {
    Frames(f64),
    Word(String),
}

/// Runs the whole job with the GIL released; Python's signals are looked at between batches.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the Python layer names them")]
pub fn calibrate(
    py: Python<'_>,
    a: &Recording,
    b: &Recording,
    method: &str,
    seed: u64,
    time_offset: FramesOrWord,
    sharpen_offset: bool,
    search_seconds: f64,
    upright: bool,
    cameras: Option<PythonMatrices<'_>>,
    candidates: usize,
    draws: usize,
    max_expected_error: f64,
    progress: Option<Py<PyAny>>,
) -> PyResult<Calibration> {
    let method = match method {
        "frontier" => Method::Frontier,
        "lines" => Method::Lines,
        other => {
            return Err(PyValueError::new_err(format!(
                "method = {other:?}: expected \"frontier\" or \"lines\""
            )));
        }
    };
    let time_offset = match time_offset {
        FramesOrWord::Frames(offset) if sharpen_offset => TimeOffset::About(offset),
        FramesOrWord::Frames(offset) => TimeOffset::Known(offset),
        FramesOrWord::Word(word) => match word.as_str() {
            "search" => TimeOffset::Search { seconds: search_seconds },
            "auto" => TimeOffset::Auto { seconds: search_seconds },
            other => {
                return Err(PyValueError::new_err(format!(
                    "time_offset = {other:?}: expected a number of frames, \"search\" or \"auto\""
                )));
            }
        },
    };
    let cameras = camera_matrices(cameras)?;
    let mut options = CalibrateOptions::new()
        .method(method)
        .seed(seed)
        .time_offset(time_offset)
        .upright(upright)
        .candidates(candidates)
        .draws(draws)
        .max_expected_error(max_expected_error);
    options.cameras = cameras;
    let (a, b) = (&a.inner, &b.inner);
    let inner = watched(py, progress, |watch| epibar::calibrate_watched(a, b, &options, watch))?;
    Ok(Calibration { inner })
}

impl Calibration {
    fn lines<'py>(
        &self,
        py: Python<'py>,
        of: impl Fn(&CandidatePair) -> Line,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.inner.candidates.iter().map(of).map(|l| [l.a(), l.b(), l.c()]))
    }

    fn points<T>(&self, of: impl Fn(&FrontierPoint) -> T) -> Vec<T> {
        self.inner.frontier_points.iter().map(of).collect()
    }
}

#[pymethods]
impl Calibration {
    #[getter(F)]
    fn fundamental<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<f64>>> {
        self.inner.fundamental.map(|f| matrix(f.matrix()).into_pyarray(py))
    }

    #[getter]
    fn accepted(&self) -> bool {
        self.inner.verdict.accepted()
    }

    #[getter]
    fn kind(&self) -> &'static str {
        self.inner.verdict.kind.name()
    }

    #[getter]
    fn reason(&self) -> &str {
        &self.inner.verdict.reason
    }

    #[getter]
    fn expected_error(&self) -> Option<f64> {
        self.inner.expected_error
    }

    #[getter]
    fn time_offset(&self) -> f64 {
        self.inner.timing.offset
    }

    /// Numbers of the clocks; None where one is not known.
    #[getter]
    fn timing<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let timing = PyDict::new(py);
        let t = &self.inner.timing;
        let known = |value: f64| Some(value).filter(|v| v.is_finite());
        timing.set_item("frames_per_frame", t.frames_per_frame)?;
        timing.set_item("offset_uncertainty", known(t.offset_error))?;
        timing.set_item("drift", known(t.drift))?;
        timing.set_item("drift_uncertainty", known(t.drift_error))?;
        timing.set_item("drift_used", t.drift_used)?;
        timing.set_item("runner_up", t.runner_up.map(|r| r.offset))?;
        timing.set_item("runner_up_share", t.runner_up.map(|r| r.share))?;
        timing.set_item("offsets_tried", t.trials)?;
        Ok(timing)
    }

    /// Expected error over each image, (rows, columns).
    #[getter]
    fn error_maps<'py>(&self, py: Python<'py>) -> PyResult<Option<ErrorMaps<'py>>> {
        let Some(maps) = &self.inner.error_maps else { return Ok(None) };
        let [a, b] =
            maps.each_ref().map(|map| map.values.clone().into_pyarray(py).reshape([map.rows, map.columns]));
        Ok(Some((a?, b?)))
    }

    #[getter]
    fn source(&self) -> &'static str {
        self.inner.source.map_or("none", epibar::Source::name)
    }

    #[getter]
    fn lines_a<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.lines(py, |c| c.a)
    }

    #[getter]
    fn lines_b<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.lines(py, |c| c.b)
    }

    #[getter]
    fn correlation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let values: Vec<f64> = self.inner.candidates.iter().map(|c| c.correlation).collect();
        values.into_pyarray(py)
    }

    #[getter]
    fn inliers<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.inner.candidates.iter().map(|c| c.inlier).collect::<Vec<_>>().into_pyarray(py)
    }

    #[getter]
    fn frontier_frame<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.points(|p| p.frame.index() as i64).into_pyarray(py)
    }

    #[getter]
    fn frontier_a<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.inner.frontier_points.iter().map(|p| p.a))
    }

    #[getter]
    fn frontier_b<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.inner.frontier_points.iter().map(|p| p.b))
    }

    /// Symmetric epipolar distances, pixels.
    #[getter]
    fn frontier_residual<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.points(|p| p.residual).into_pyarray(py)
    }

    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let counts = PyDict::new(py);
        let found = &self.inner.counts;
        for (name, value) in [
            ("frames", found.frames),
            ("informative_a", found.informative_a),
            ("informative_b", found.informative_b),
            ("on_motion_lines", found.on_motion_lines),
            ("mutual_pairs", found.mutual_pairs),
            ("candidates", found.candidates),
            ("line_inliers", found.line_inliers),
            ("frontier_points", found.frontier_points),
        ] {
            counts.set_item(name, value)?;
        }
        Ok(counts)
    }

    #[getter]
    fn floor<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<f64>>> {
        self.inner.floor.map(|h| matrix(&h).into_pyarray(py))
    }

    #[getter]
    fn rivals<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.inner
            .rivals
            .iter()
            .map(|rival| {
                let entry = PyDict::new(py);
                entry.set_item("F", matrix(rival.fundamental.matrix()).into_pyarray(py))?;
                entry.set_item("evidence_share", rival.share)?;
                entry.set_item("evidence_z", rival.z)?;
                entry.set_item("distance", rival.distance)?;
                entry.set_item("source", rival.source.name())?;
                Ok(entry)
            })
            .collect()
    }

    #[getter]
    fn evidence<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let evidence = PyDict::new(py);
        let e = &self.inner.evidence;
        for (name, value) in [
            ("z", e.z),
            ("z_tops", e.z_tops),
            ("z_bottoms", e.z_bottoms),
            ("z_whole", e.z_whole),
            ("both_ends", e.both_ends),
            ("on_all_frames", f64::from(u8::from(e.on_all_frames))),
            ("explained", e.explained),
            ("explained_tops", e.explained_tops),
            ("explained_bottoms", e.explained_bottoms),
            ("explained_by_chance", e.explained_by_chance),
        ] {
            evidence.set_item(name, value)?;
        }
        for (name, value) in [
            ("tested_distance", e.tested_distance),
            ("plane_residual", e.plane_residual),
            ("spread_of_bottoms", e.spread_of_bottoms),
            ("tops_off_floor", e.tops_off_floor),
            ("may_turn", e.may_turn),
            ("holds", e.holds),
            ("halves_apart", e.halves_apart),
            ("repeats", e.repeats),
            ("essential_deviation", e.essential_deviation),
        ] {
            if !value.is_nan() {
                evidence.set_item(name, value)?;
            }
        }
        Ok(evidence)
    }

    /// Shifts in frames and the score at each.
    #[getter]
    fn shift_curve<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>) {
        let shifts: Vec<f64> = self.inner.shift_curve.iter().map(|s| s.shift as f64).collect();
        let scores: Vec<f64> = self.inner.shift_curve.iter().map(|s| s.score).collect();
        (shifts.into_pyarray(py), scores.into_pyarray(py))
    }
}
