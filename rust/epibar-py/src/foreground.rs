//! What moves in frames.

use epibar::ImageSize;
use epibar::internals::{Cleaning, Mixture as Model, MixtureOptions, Painting, SHRUNK, clean};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArrayDyn, PyReadwriteArrayDyn,
    PyUntypedArrayMethods,
};
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

    /// Learns from samples, (count, height, width, 3), in an order, each of which weighs as much as each before.
    fn prime(
        &mut self,
        py: Python<'_>,
        samples: PyReadonlyArrayDyn<'_, u8>,
        order: Vec<usize>,
    ) -> PyResult<()> {
        let (pixels, size) = frames(&samples)?;
        if size != self.inner.size() {
            return Err(PyValueError::new_err("samples are of another size than the model"));
        }
        let inner = &mut self.inner;
        enter(py, || inner.prime(pixels, &order))
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

/// Pixels of a frame, (height, width, 3), of a size that is known.
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
    let (pixels, size) = frames(&samples)?;
    let found = enter(py, || epibar::internals::steady_background(pixels, size))?;
    found.into_pyarray(py).reshape([size.height(), size.width(), 3])
}

/// Pixels and size of frames, (count, height, width, 3).
fn frames<'a>(samples: &'a PyReadonlyArrayDyn<'_, u8>) -> PyResult<(&'a [u8], ImageSize)> {
    let pixels = slice("samples", samples, 4)?;
    Ok((pixels, size_of_frames(samples.shape())?))
}

fn size_of_frames(shape: &[usize]) -> PyResult<ImageSize> {
    let &[_, height, width, 3] = shape else {
        return Err(PyValueError::new_err("samples must be (count, height, width, 3)"));
    };
    ImageSize::new(width, height).map_err(|error| to_python_error(&error))
}

/// Paints people in samples, (count, height, width, 3), over with the background, (height, width, 3), in place: where a channel differs
/// by more than `most`, cleaned as masks are, and a margin around it.
#[pyfunction]
pub fn paint_over(
    py: Python<'_>,
    mut samples: PyReadwriteArrayDyn<'_, u8>,
    background: PyReadonlyArrayDyn<'_, u8>,
    most: u8,
    cleaning: (usize, usize, usize),
    margin: usize,
) -> PyResult<()> {
    let size = size_of_frames(samples.shape())?;
    let background = colours(&background, size)?;
    if !samples.is_c_contiguous() {
        return Err(PyValueError::new_err("samples must be C-contiguous"));
    }
    let pixels = samples.as_slice_mut()?;
    let (median, closing, min_area) = cleaning;
    let how = Painting { most, cleaning: Cleaning { median, closing, min_area, ignore: None }, margin };
    enter(py, || epibar::internals::paint_over(pixels, background, size, &how))
}

/// Mean green of each 8×8 pixels of a frame, (height, width, 3), whose sides are multiples of 8: (height / 8, width / 8).
#[pyfunction]
pub fn shrunk_green<'py>(
    py: Python<'py>,
    frame: PyReadonlyArrayDyn<'py, u8>,
) -> PyResult<Bound<'py, PyArray2<u8>>> {
    let pixels = slice("frame", &frame, 3)?;
    let &[height, width, 3] = frame.shape() else {
        return Err(PyValueError::new_err("a frame must have three channels"));
    };
    let size = ImageSize::new(width, height).map_err(|error| to_python_error(&error))?;
    let found = enter(py, || epibar::internals::shrunk_green(pixels, size))?;
    found.into_pyarray(py).reshape([height / SHRUNK, width / SHRUNK])
}

/// Variance, whether anything changed, how many pixels jumped, how many were compared, the levels of bands.
type Light<'py> = (f64, bool, usize, usize, Bound<'py, PyArray1<f64>>);

/// The light of a frame beside that of the one before and of the first, each (height, width): its variance, whether anything changed,
/// how many pixels jumped by more than `jump` and how many were compared, and the levels of bands.
#[pyfunction]
#[pyo3(signature = (now, before, first, jump, counted=None))]
pub fn compare_light<'py>(
    py: Python<'py>,
    now: PyReadonlyArrayDyn<'py, u8>,
    before: PyReadonlyArrayDyn<'py, u8>,
    first: PyReadonlyArrayDyn<'py, u8>,
    jump: u8,
    counted: Option<PyReadonlyArrayDyn<'py, u8>>,
) -> PyResult<Light<'py>> {
    let width = now.shape().last().copied().unwrap_or_default();
    let (now, before) = (slice("now", &now, 2)?, slice("before", &before, 2)?);
    let first = slice("first", &first, 2)?;
    let counted = counted.as_ref().map(|counted| slice("counted", counted, 2)).transpose()?;
    let found = enter(py, || epibar::internals::compare_light(now, before, first, counted, width, jump))?;
    let levels = found.levels.to_vec().into_pyarray(py);
    Ok((found.variance, found.changed, found.jumped, found.compared, levels))
}
