//! Networks of cameras: their clocks, which pairs to search, and all pairs joined.

use epibar::ImageSize;
use epibar::internals::{Lens, Optics};
use epibar::nalgebra::Vector3;
use epibar::network::{
    Aspect, CameraInput, Expected, Ground, Knowledge, Network, NetworkCamera, NetworkPair, NetworkTime,
    Offsets, PairFound, Place, PosedCamera, StoredCamera,
};
use numpy::{IntoPyArray, PyArray2, PyReadonlyArrayDyn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{enter, matrix, matrix_of, matrix_of_rows, rows, to_python_error};
use crate::recording::Recording;
use crate::watch::watched;

/// What is known of a camera before.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct PythonKnowledge {
    matrix: Option<[[f64; 3]; 3]>,
    distortions: Option<[f64; 5]>,
    focal: Option<(f64, f64)>,
    principal: Option<[f64; 2]>,
    /// `None` where pixels are square, NaN where it is not known.
    aspect: Option<f64>,
}

impl PythonKnowledge {
    fn knowledge(&self) -> Knowledge {
        let aspect = match self.aspect {
            None => Aspect::Square,
            Some(ratio) if ratio.is_nan() => Aspect::Unknown,
            Some(ratio) => Aspect::Known(ratio),
        };
        let mut known = Knowledge::new().aspect(aspect);
        known.matrix = self.matrix.as_ref().map(matrix_of_rows);
        known.distortions = self.distortions;
        known.focal = self.focal;
        known.principal = self.principal;
        known
    }
}

/// What was found of a pair by itself.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct PythonPair {
    a: usize,
    b: usize,
    /// Geometries with their scores as shares of the best one's.
    geometries: Vec<([[f64; 3]; 3], f64)>,
    offset: f64,
    frames_per_frame: f64,
    z: f64,
    accepted: bool,
}

impl PythonPair {
    fn found(&self) -> epibar::Result<PairFound> {
        let geometry = |(rows, share): &([[f64; 3]; 3], f64)| (matrix_of_rows(rows), *share);
        let found = PairFound::new(self.a, self.b, self.geometries.iter().map(geometry).collect())?;
        Ok(found.timing(self.offset, self.frames_per_frame).verdict(self.z, self.accepted))
    }
}

/// Seconds of each clock, whether all started together, whether they were given.
pub type PythonClocks = (Vec<f64>, bool, bool);

pub fn offsets((seconds, together, given): PythonClocks) -> Offsets {
    let mut offsets = if given { Offsets::given(seconds) } else { Offsets::found(seconds) };
    offsets.together = together;
    offsets
}

/// Offsets of all clocks by the barcodes, within so many seconds.
#[pyfunction]
pub fn clock_offsets(
    py: Python<'_>,
    recordings: Vec<PyRef<'_, Recording>>,
    seconds: f64,
    progress: Option<Py<PyAny>>,
) -> PyResult<PythonClocks> {
    let inner: Vec<_> = recordings.iter().map(|r| &r.inner).collect();
    let time = NetworkTime::Search { seconds };
    let found = watched(py, progress, |watch| epibar::network::clock_offsets(&inner, &time, watch))?;
    Ok((found.seconds, found.together, found.given))
}

/// Pairs of cameras that are worth a search.
#[pyfunction]
pub fn pairs_to_search(
    py: Python<'_>,
    recordings: Vec<PyRef<'_, Recording>>,
    clocks: PythonClocks,
) -> PyResult<Vec<(usize, usize)>> {
    let inner: Vec<_> = recordings.iter().map(|r| &r.inner).collect();
    let clocks = offsets(clocks);
    enter(py, || epibar::network::pairs_to_search(&inner, &clocks))
}

/// Cameras with what they saw and what is known of them.
pub fn camera_inputs<'r>(
    recordings: &'r [PyRef<'_, Recording>],
    names: &'r [String],
    known: &[PythonKnowledge],
) -> Vec<CameraInput<'r>> {
    let input = |((r, name), known): ((&'r PyRef<'_, Recording>, &'r String), &PythonKnowledge)| {
        CameraInput::new(name, &r.inner).known(known.knowledge())
    };
    recordings.iter().zip(names).zip(known).map(input).collect()
}

/// What was found of pairs, as the crate takes it.
pub fn pairs_found(pairs: &[PythonPair]) -> PyResult<Vec<PairFound>> {
    let found: epibar::Result<_> = pairs.iter().map(PythonPair::found).collect();
    found.map_err(|error| to_python_error(&error))
}

/// One network of what was found of the pairs.
#[pyfunction]
pub fn join_network<'py>(
    py: Python<'py>,
    recordings: Vec<PyRef<'py, Recording>>,
    names: Vec<String>,
    known: Vec<PythonKnowledge>,
    pairs: Vec<PythonPair>,
    clocks: PythonClocks,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let n = recordings.len();
    if names.len() != n || known.len() != n {
        return Err(PyValueError::new_err("a name and what is known for each recording"));
    }
    let inputs = camera_inputs(&recordings, &names, &known);
    let pairs = pairs_found(&pairs)?;
    let clocks = offsets(clocks);
    let network = watched(py, progress, |watch| epibar::network::join(&inputs, &pairs, &clocks, watch))?;
    dict_of(py, &network)
}

fn dict_of<'py>(py: Python<'py>, network: &Network) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let cameras = network.cameras.iter().map(|c| camera(py, c)).collect::<PyResult<Vec<_>>>()?;
    let pairs = network.pairs.iter().map(|p| pair(py, p)).collect::<PyResult<Vec<_>>>()?;
    dict.set_item("cameras", cameras)?;
    dict.set_item("pairs", pairs)?;
    dict.set_item("accepted", network.accepted)?;
    dict.set_item("reason", &network.reason)?;
    dict.set_item("radius", network.radius)?;
    let ground = PyDict::new(py);
    ground.set_item("source", network.ground.name())?;
    if let Ground::Floor { height, vertical_error, level_error, figures, diversity, breadth, .. } =
        network.ground
    {
        ground.set_item("height", height)?;
        ground.set_item("vertical_error", vertical_error.to_degrees())?;
        ground.set_item("level_error", level_error)?;
        ground.set_item("figures", figures)?;
        ground.set_item("diversity", diversity)?;
        ground.set_item("breadth", breadth)?;
    }
    dict.set_item("ground", ground)?;
    Ok(dict)
}

/// How far from the principal point a camera shows anything, pixels; None where that is all of its images.
#[pyfunction]
pub fn lens_reach(
    camera_matrix: PyReadonlyArrayDyn<'_, f64>,
    distortions: [f64; 5],
    size: (usize, usize),
) -> PyResult<Option<f64>> {
    let size = ImageSize::new(size.0, size.1).map_err(|error| to_python_error(&error))?;
    Ok(optics(&camera_matrix, distortions)?.reach(size))
}

/// Where pixels look, x and y of a ray whose z is 1; NaN where the lens shows nothing.
#[pyfunction]
pub fn lens_directions<'py>(
    py: Python<'py>,
    camera_matrix: PyReadonlyArrayDyn<'py, f64>,
    distortions: [f64; 5],
    pixels: Vec<[f64; 2]>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let optics = optics(&camera_matrix, distortions)?;
    rows(py, pixels.into_iter().map(|pixel| optics.direction(pixel).unwrap_or([f64::NAN; 2])))
}

/// What the pixels of a camera show.
fn optics(camera_matrix: &PyReadonlyArrayDyn<'_, f64>, distortions: [f64; 5]) -> PyResult<Optics> {
    let matrix = matrix_of("matrix", camera_matrix)?;
    Ok(Optics {
        focal: [matrix[(0, 0)], matrix[(1, 1)]],
        principal: [matrix[(0, 2)], matrix[(1, 2)]],
        lens: Lens::of_opencv(&distortions),
    })
}

pub fn camera<'py>(py: Python<'py>, camera: &NetworkCamera) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("name", &camera.name)?;
    dict.set_item("accepted", camera.accepted())?;
    dict.set_item("status", camera.status.name())?;
    dict.set_item("reason", &camera.reason)?;
    dict.set_item("matrix", camera.matrix().map(|m| matrix(&m).into_pyarray(py)))?;
    dict.set_item("distortions", camera.distortions().map(|d| d.to_vec().into_pyarray(py)))?;
    dict.set_item("rotation", camera.rotation().map(|m| matrix(&m).into_pyarray(py)))?;
    dict.set_item("translation", camera.translation().map(|t| t.as_slice().to_vec().into_pyarray(py)))?;
    dict.set_item("expected", camera.expected.map(|e| errors(py, &e)).transpose()?)?;
    let covariance = camera.expected.map(|e| matrix(&e.position_covariance).into_pyarray(py));
    dict.set_item("position_covariance", covariance)?;
    dict.set_item("deviates", (camera.deviates.tangents, camera.deviates.whole))?;
    dict.set_item("clock", camera.clock())?;
    dict.set_item("offset_error", camera.offset_error)?;
    Ok(dict)
}

pub fn pair<'py>(py: Python<'py>, pair: &NetworkPair) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("a", pair.a)?;
    dict.set_item("b", pair.b)?;
    dict.set_item("status", pair.status.name())?;
    dict.set_item("accepted", pair.accepted)?;
    dict.set_item("F", pair.fundamental.map(|f| matrix(&f).into_pyarray(py)))?;
    dict.set_item("deviates", (pair.deviates.tangents, pair.deviates.whole))?;
    Ok(dict)
}

/// A camera with its pose, as files state it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct PythonPosed {
    matrix: [[f64; 3]; 3],
    distortions: [f64; 5],
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
}

impl PythonPosed {
    /// This camera as the crate takes it.
    pub fn posed(&self) -> PosedCamera {
        PosedCamera {
            matrix: matrix_of_rows(&self.matrix),
            distortions: self.distortions,
            rotation: matrix_of_rows(&self.rotation),
            translation: Vector3::from(self.translation),
        }
    }
}

/// A camera of a network as it is stored.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct PythonStored {
    camera: PythonPosed,
    expected: PythonExpected,
}

/// Errors to expect of it: relative, degrees, and in the network's unit.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct PythonExpected {
    focal: f64,
    rotation: f64,
    position: f64,
}

/// Stored cameras with what they saw.
pub fn stored_cameras<'r>(
    recordings: &'r [PyRef<'_, Recording>],
    names: &'r [String],
    cameras: &[PythonStored],
) -> Vec<StoredCamera<'r>> {
    let stored = |((r, name), c): ((&'r PyRef<'_, Recording>, &'r String), &PythonStored)| {
        let e = &c.expected;
        let expected = Expected::new(e.focal, e.rotation.to_radians(), e.position);
        StoredCamera::new(name, &r.inner, c.camera.posed(), expected)
    };
    recordings.iter().zip(names).zip(cameras).map(stored).collect()
}

/// Which cameras of a stored network have moved, by new footage.
#[pyfunction]
pub fn check_network<'py>(
    py: Python<'py>,
    recordings: Vec<PyRef<'py, Recording>>,
    names: Vec<String>,
    cameras: Vec<PythonStored>,
    clocks: PythonClocks,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    if names.len() != recordings.len() || cameras.len() != recordings.len() {
        return Err(PyValueError::new_err("a name and a stored camera for each recording"));
    }
    let stored = stored_cameras(&recordings, &names, &cameras);
    let clocks = offsets(clocks);
    let found = watched(py, progress, |watch| epibar::network::check_network(&stored, &clocks, watch))?;
    let number = |v: f64| Some(v).filter(|v| v.is_finite());
    found
        .iter()
        .map(|c| {
            let dict = PyDict::new(py);
            dict.set_item("name", &c.name)?;
            dict.set_item("status", c.status.name())?;
            dict.set_item("reason", &c.reason)?;
            dict.set_item("turned", number(c.turned.to_degrees()))?;
            dict.set_item("turned_error", number(c.turned_error.to_degrees()))?;
            dict.set_item("shifted", number(c.shifted))?;
            dict.set_item("shifted_error", number(c.shifted_error))?;
            dict.set_item("focal", number(c.focal))?;
            dict.set_item("focal_error", number(c.focal_error))?;
            dict.set_item("deviate", c.deviate)?;
            dict.set_item("since", c.since)?;
            dict.set_item("place", c.place.as_ref().map(|p| place(py, p, &names)).transpose()?)?;
            dict.set_item("rivals", c.rivals.iter().map(|&r| &names[r]).collect::<Vec<_>>())?;
            Ok(dict)
        })
        .collect()
}

fn place<'py>(py: Python<'py>, place: &Place, names: &[String]) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("matrix", matrix(&place.matrix).into_pyarray(py))?;
    dict.set_item("rotation", matrix(&place.rotation).into_pyarray(py))?;
    dict.set_item("translation", place.translation.as_slice().to_vec().into_pyarray(py))?;
    dict.set_item("zoomed", place.zoomed)?;
    dict.set_item("reposed", place.reposed)?;
    dict.set_item("expected", errors(py, &place.expected)?)?;
    dict.set_item("position_covariance", matrix(&place.expected.position_covariance).into_pyarray(py))?;
    let pairs = PyDict::new(py);
    for (other, d) in &place.pairs {
        pairs.set_item(&names[*other], (d.tangents, d.whole))?;
    }
    dict.set_item("pairs", pairs)?;
    Ok(dict)
}

fn errors<'py>(py: Python<'py>, expected: &Expected) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("focal", expected.focal)?;
    dict.set_item("rotation", expected.rotation.to_degrees())?;
    dict.set_item("position", expected.position)?;
    Ok(dict)
}
