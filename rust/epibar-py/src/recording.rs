//! Recorder and Recording.

use epibar::{ImageSize, Informative, RecorderOptions, RecordingParts, Segment};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyIndexError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{as_barcodes, bits, enter, rows, slice, to_python_error};

/// Takes masks frame by frame.
#[pyclass(module = "epibar._core")]
pub struct Recorder {
    inner: Option<epibar::Recorder>,
    shape: [usize; 2],
}

fn finished() -> PyErr {
    PyRuntimeError::new_err("this recorder is finished")
}

#[pymethods]
impl Recorder {
    #[new]
    #[pyo3(signature = (width, height, lines, seed, min_component_area, visible=None))]
    fn new(
        width: usize,
        height: usize,
        lines: usize,
        seed: u64,
        min_component_area: usize,
        visible: Option<PyReadonlyArrayDyn<'_, u8>>,
    ) -> PyResult<Self> {
        let size = ImageSize::new(width, height).map_err(|error| to_python_error(&error))?;
        let options = RecorderOptions::new().lines(lines).seed(seed).min_component_area(min_component_area);
        let mut inner = epibar::Recorder::new(size, options).map_err(|error| to_python_error(&error))?;
        if let Some(visible) = visible {
            let pixels = slice("visible", &visible, 2)?;
            if visible.shape() != [height, width] {
                return Err(PyValueError::new_err(format!(
                    "visible is {}x{}, but the recording is {width}x{height}: both must have the same size",
                    visible.shape()[1],
                    visible.shape()[0],
                )));
            }
            inner = inner.with_visible(pixels).map_err(|error| to_python_error(&error))?;
        }
        Ok(Self { inner: Some(inner), shape: [height, width] })
    }

    fn push(&mut self, py: Python<'_>, mask: PyReadonlyArrayDyn<'_, u8>, time: f64) -> PyResult<()> {
        let pixels = slice("mask", &mask, 2)?;
        if mask.shape() != self.shape {
            return Err(PyValueError::new_err(format!(
                "mask is {}x{}, but the recording is {}x{}: every frame must have the same size",
                mask.shape()[1],
                mask.shape()[0],
                self.shape[1],
                self.shape[0]
            )));
        }
        let recorder = self.inner.as_mut().ok_or_else(finished)?;
        enter(py, || recorder.push(pixels, time))
    }

    fn finish(&mut self, py: Python<'_>) -> PyResult<Recording> {
        let recorder = self.inner.take().ok_or_else(finished)?;
        Ok(Recording { inner: enter(py, || recorder.finish())? })
    }
}

/// What one camera saw move.
#[pyclass(module = "epibar._core", frozen)]
pub struct Recording {
    pub inner: epibar::Recording,
}

#[pymethods]
impl Recording {
    #[getter]
    fn width(&self) -> usize {
        self.inner.size().width()
    }

    #[getter]
    fn height(&self) -> usize {
        self.inner.size().height()
    }

    #[getter]
    fn frames(&self) -> usize {
        self.inner.frames()
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.inner.seed()
    }

    #[getter]
    fn informative(&self) -> usize {
        self.inner.barcodes().informative(&Informative::default()).len()
    }

    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.inner.times().to_vec().into_pyarray(py)
    }

    #[getter]
    fn segments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.inner.segments().iter().map(|s| [s.x0, s.y0, s.x1, s.y1]))
    }

    #[getter]
    fn barcodes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u64>>> {
        bits(py, self.inner.barcodes())
    }

    #[getter]
    fn heat<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let size = self.inner.size();
        self.inner.heat().to_vec().into_pyarray(py).reshape([size.height(), size.width()])
    }

    #[getter]
    fn moving_pixels<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.inner.moving_pixels().to_vec().into_pyarray(py)
    }

    #[getter]
    fn visible<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<u8>>>> {
        let size = self.inner.size();
        let area = self.inner.visible();
        area.map(|pixels| pixels.to_vec().into_pyarray(py).reshape([size.height(), size.width()])).transpose()
    }

    fn hulls<'py>(&self, py: Python<'py>, frame: usize) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        if frame >= self.inner.frames() {
            return Err(PyIndexError::new_err(format!(
                "frame {frame} is beyond the last, {}",
                self.inner.frames() - 1
            )));
        }
        let silhouettes = self.inner.silhouettes();
        silhouettes
            .hulls(frame)
            .map(|hull| rows(py, silhouettes.hull(hull).iter().map(|p| p.map(f64::from))))
            .collect()
    }

    fn to_arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let parts = RecordingParts::from(self.inner.clone());
        let arrays = PyDict::new(py);
        arrays.set_item("size", parts.size.map(|side| side as u64).to_vec().into_pyarray(py))?;
        arrays.set_item("seed", vec![parts.seed].into_pyarray(py))?;
        arrays.set_item("times", parts.times.into_pyarray(py))?;
        arrays.set_item("segments", self.segments(py)?)?;
        arrays.set_item("barcodes", self.barcodes(py)?)?;
        arrays.set_item("heat", self.heat(py)?)?;
        arrays.set_item("moving_pixels", parts.moving_pixels.into_pyarray(py))?;
        if let Some(visible) = self.visible(py)? {
            arrays.set_item("visible", visible)?;
        }
        arrays.set_item("frame_start", parts.frame_start.into_pyarray(py))?;
        arrays.set_item("hull_start", parts.hull_start.into_pyarray(py))?;
        arrays.set_item("hull_points", rows(py, parts.hull_points.iter().copied())?)?;
        arrays.set_item("hull_area", parts.hull_area.into_pyarray(py))?;
        arrays.set_item("hull_border", parts.hull_border.into_pyarray(py))?;
        arrays.set_item("outline_start", parts.outline_start.into_pyarray(py))?;
        arrays.set_item("outline_points", rows(py, parts.outline_points.iter().copied())?)?;
        Ok(arrays)
    }

    #[staticmethod]
    fn from_arrays(py: Python<'_>, arrays: &Bound<'_, PyDict>) -> PyResult<Self> {
        let size: Vec<u64> = flat(arrays, "size", 1)?;
        let seed: Vec<u64> = flat(arrays, "seed", 1)?;
        let ([width, height], [seed]) = (size.as_slice(), seed.as_slice()) else {
            return Err(PyValueError::new_err("the stored recording is damaged: size or seed"));
        };
        let times: Vec<f64> = flat(arrays, "times", 1)?;
        let words = array::<u64>(arrays, "barcodes")?;
        let barcodes = as_barcodes("barcodes", &words.readonly(), times.len())?;
        let segments = flat::<f64>(arrays, "segments", 2)?
            .chunks_exact(4)
            .map(|s| Segment { x0: s[0], y0: s[1], x1: s[2], y1: s[3] })
            .collect();
        let mut parts = RecordingParts::new([*width as usize, *height as usize], times);
        parts.segments = segments;
        parts.barcodes = barcodes.words().to_vec();
        parts.frame_start = flat(arrays, "frame_start", 1)?;
        parts.hull_start = flat(arrays, "hull_start", 1)?;
        parts.hull_points = points(arrays, "hull_points")?;
        parts.hull_area = flat(arrays, "hull_area", 1)?;
        parts.hull_border = flat(arrays, "hull_border", 1)?;
        // Files of older versions have no outlines.
        if arrays.contains("outline_start")? {
            parts.outline_start = flat(arrays, "outline_start", 1)?;
            parts.outline_points = points(arrays, "outline_points")?;
        }
        parts.heat = flat(arrays, "heat", 2)?;
        parts.moving_pixels = flat(arrays, "moving_pixels", 1)?;
        if arrays.contains("visible")? {
            parts.visible = Some(flat(arrays, "visible", 2)?);
        }
        parts.seed = *seed;
        Ok(Self { inner: enter(py, || epibar::Recording::try_from(parts))? })
    }
}

fn points(arrays: &Bound<'_, PyDict>, name: &str) -> PyResult<Vec<[u16; 2]>> {
    Ok(flat::<u16>(arrays, name, 2)?.chunks_exact(2).map(|p| [p[0], p[1]]).collect())
}

fn array<'py, T: numpy::Element>(
    arrays: &Bound<'py, PyDict>,
    name: &str,
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let damaged =
        |what: &str| PyValueError::new_err(format!("the stored recording is damaged: {name} {what}"));
    let item = arrays.get_item(name)?.ok_or_else(|| damaged("is missing"))?;
    item.cast_into::<PyArrayDyn<T>>().map_err(|_| damaged("is not an array of the expected type"))
}

fn flat<T: numpy::Element + Copy>(
    arrays: &Bound<'_, PyDict>,
    name: &str,
    dimensions: usize,
) -> PyResult<Vec<T>> {
    let found = array::<T>(arrays, name)?;
    let found = found.readonly();
    Ok(slice(name, &found, dimensions)?.to_vec())
}
