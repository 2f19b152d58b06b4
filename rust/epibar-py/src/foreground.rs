//! What moves in frames.

use epibar::ImageSize;
use epibar::internals::{Cleaning, Mixture as Model, MixtureOptions, clean};
use numpy::{IntoPyArray, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::convert::{enter, slice, to_python_error};

/// A background model whose rows learn in turn.
#[pyclass(module = "epibar._core")]
pub struct Mixture {
    inner: Model,
}

#[pymethods]
impl Mixture {
    #[new]
    fn new(width: usize, height: usize, threshold: f32, shadows: bool) -> PyResult<Self> {
        let size = ImageSize::new(width, height).map_err(|error| to_python_error(&error))?;
        let options = MixtureOptions { threshold, shadows };
        let inner = Model::new(size, options).map_err(|error| to_python_error(&error))?;
        Ok(Self { inner })
    }

    /// The mask of a frame, (height, width, 3), from all rows of which it learns.
    fn learn<'py>(
        &mut self,
        py: Python<'py>,
        frame: PyReadonlyArrayDyn<'py, u8>,
        rate: f32,
    ) -> PyResult<Bound<'py, PyArray2<u8>>> {
        self.mask(py, &frame, |model, pixels| model.learn(pixels, rate))
    }

    /// The mask of a frame, (height, width, 3), from some rows of which it learns.
    fn look<'py>(
        &mut self,
        py: Python<'py>,
        frame: PyReadonlyArrayDyn<'py, u8>,
        rate: f32,
    ) -> PyResult<Bound<'py, PyArray2<u8>>> {
        self.mask(py, &frame, |model, pixels| model.look(pixels, rate))
    }
}

impl Mixture {
    /// The mask that the model makes of a frame.
    fn mask<'py>(
        &mut self,
        py: Python<'py>,
        frame: &PyReadonlyArrayDyn<'py, u8>,
        make: impl FnOnce(&mut Model, &[u8]) -> epibar::Result<Vec<u8>> + Send,
    ) -> PyResult<Bound<'py, PyArray2<u8>>> {
        let size = self.inner.size();
        let pixels = colours(frame, size)?;
        let inner = &mut self.inner;
        as_mask(py, size, enter(py, || make(inner, pixels))?)
    }
}

fn colours<'a>(frame: &'a PyReadonlyArrayDyn<'_, u8>, size: ImageSize) -> PyResult<&'a [u8]> {
    let pixels = slice("frame", frame, 3)?;
    if frame.shape() != [size.height(), size.width(), 3] {
        return Err(PyValueError::new_err(format!(
            "frame is {:?}, but the model is of {}x{} pixels with three channels",
            frame.shape(),
            size.width(),
            size.height()
        )));
    }
    Ok(pixels)
}

fn as_mask(py: Python<'_>, size: ImageSize, mask: Vec<u8>) -> PyResult<Bound<'_, PyArray2<u8>>> {
    mask.into_pyarray(py).reshape([size.height(), size.width()])
}

/// A mask, (height, width), without specks, gaps and components of fewer than `min_area` pixels; 0 and 1.
#[pyfunction]
#[pyo3(signature = (mask, median, closing, min_area, ignore=None))]
pub fn clean_mask<'py>(
    py: Python<'py>,
    mask: PyReadonlyArrayDyn<'py, u8>,
    median: usize,
    closing: usize,
    min_area: usize,
    ignore: Option<PyReadonlyArrayDyn<'py, u8>>,
) -> PyResult<Bound<'py, PyArray2<u8>>> {
    let pixels = slice("mask", &mask, 2)?;
    let size = ImageSize::new(mask.shape()[1], mask.shape()[0]).map_err(|error| to_python_error(&error))?;
    let ignore = ignore.as_ref().map(|ignore| slice("ignore", ignore, 2)).transpose()?;
    let how = Cleaning { median, closing, min_area, ignore };
    as_mask(py, size, enter(py, || clean(pixels, size, &how))?)
}

/// The most repeated value of each pixel of frames, (count, height, width, 3): (height, width, 3).
#[pyfunction]
pub fn steady_background<'py>(
    py: Python<'py>,
    samples: PyReadonlyArrayDyn<'py, u8>,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let pixels = slice("samples", &samples, 4)?;
    let [height, width] = [samples.shape()[1], samples.shape()[2]];
    let size = ImageSize::new(width, height).map_err(|error| to_python_error(&error))?;
    if samples.shape()[3] != 3 {
        return Err(PyValueError::new_err("samples must have three channels"));
    }
    let found = enter(py, || epibar::internals::steady_background(pixels, size))?;
    found.into_pyarray(py).reshape([height, width, 3])
}
