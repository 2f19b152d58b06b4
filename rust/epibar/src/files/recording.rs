//! A recording in a file.

use std::path::Path;

use nalgebra::Matrix3;

use super::archive::{self, Arrays, check_format, failed, finite, put, put_texts, scalar, shaped};
use crate::error::{Error, Result};
use crate::geometry::CameraMatrices;
use crate::image::Segment;
use crate::recording::{Recording, RecordingParts};

/// Version of the file; a file of another one is refused.
const FORMAT: i64 = 1;
const MARK: &str = "epibar_recording";
/// Skew up to this is rounding, pixels.
const LEAST_SKEW: f64 = 1e-3;
const KIND: &str = "a recording saved by epibar";

/// A recording with all that its file holds beside it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SavedRecording {
    /// What the camera saw move.
    pub recording: Recording,
    /// Name of the camera.
    pub name: String,
    /// What was wrong with the video but bearable, in plain English.
    pub warnings: Vec<String>,
    /// Camera matrix of the undistorted pixels that all is in, where it is known.
    pub matrix: Option<Matrix3<f64>>,
    /// Distortions of the lens that was taken out of the pixels, in the order of `OpenCV`, where it is known; with a
    /// [`matrix`](Self::matrix) without skew alone.
    pub distortions: Option<Vec<f64>>,
    /// Whether these are of the fisheye model of `OpenCV`.
    pub fisheye: bool,
    /// Width of a pixel over its height, where the video says so.
    pub pixel_aspect: Option<f64>,
    /// What was counted while the video was watched, by name.
    pub health: Vec<(String, f64)>,
    /// Number in the video of frame 0.
    pub first_frame: i64,
}

impl From<Recording> for SavedRecording {
    /// A recording of a camera without a name, whose matrix is not known.
    fn from(recording: Recording) -> Self {
        Self {
            recording,
            name: String::new(),
            warnings: Vec::new(),
            matrix: None,
            distortions: None,
            fisheye: false,
            pixel_aspect: None,
            health: Vec::new(),
            first_frame: 0,
        }
    }
}

impl Recording {
    /// Writes one compressed `.npz` file, whole or not at all, that Python reads as well (`epibar.Recording.load`).
    ///
    /// # Errors
    /// [`Error::File`] where it cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        SavedRecording::from(self.clone()).save(path)
    }

    /// Reads what [`Recording::save`] wrote, or Python's `epibar.Recording.save`.
    ///
    /// # Errors
    /// [`Error::File`] where it is missing, damaged, something else, or of another format.
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        Ok(SavedRecording::load(path)?.recording)
    }
}

impl SavedRecording {
    /// Writes one compressed `.npz` file, whole or not at all.
    ///
    /// # Errors
    /// [`Error::File`] where it cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        archive::write(path.as_ref(), &self.to_arrays()?)
    }

    /// Reads a recording that was saved from Rust or from Python.
    ///
    /// # Errors
    /// [`Error::File`] where it is missing, damaged, something else, or of another format.
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let arrays = archive::read(path)?;
        if !arrays.contains_key(MARK) {
            return Err(failed(path, format!("not {KIND}")));
        }
        Self::from_arrays(&arrays).map_err(|error| failed(path, error))
    }

    pub(super) fn to_arrays(&self) -> Result<Arrays> {
        let parts = RecordingParts::from(self.recording.clone());
        let ([width, height], frames) = (parts.size, parts.times.len());
        let words = frames.div_ceil(64);
        let mut arrays = Arrays::new();
        let a = &mut arrays;
        put(a, MARK, &[], [FORMAT])?;
        put_texts(a, "name", &[], std::slice::from_ref(&self.name))?;
        put_texts(a, "warnings", &[self.warnings.len()], &self.warnings)?;
        let (names, values): (Vec<String>, Vec<f64>) = self.health.iter().cloned().unzip();
        put_texts(a, "health_names", &[names.len()], &names)?;
        put(a, "health_values", &[values.len()], values)?;
        put(a, "first_frame", &[], [self.first_frame])?;
        if let Some(matrix) = &self.matrix {
            put(a, "matrix", &[3, 3], matrix.transpose().iter().copied())?;
        }
        if let Some(distortions) = &self.distortions {
            put(a, "distortions", &[distortions.len()], distortions.iter().copied())?;
            put(a, "fisheye", &[], [self.fisheye])?;
        }
        if let Some(aspect) = self.pixel_aspect {
            put(a, "pixel_aspect", &[], [aspect])?;
        }
        put(a, "core_size", &[2], [width as u64, height as u64])?;
        put(a, "core_seed", &[1], [parts.seed])?;
        put(a, "core_times", &[frames], parts.times)?;
        let ends = parts.segments.iter().flat_map(|s| [s.x0, s.y0, s.x1, s.y1]);
        put(a, "core_segments", &[parts.segments.len(), 4], ends)?;
        put(a, "core_barcodes", &[parts.segments.len(), words], parts.barcodes)?;
        put(a, "core_heat", &[height, width], parts.heat)?;
        put(a, "core_moving_pixels", &[frames], parts.moving_pixels)?;
        if let Some(visible) = parts.visible {
            put(a, "core_visible", &[height, width], visible)?;
        }
        put(a, "core_frame_start", &[parts.frame_start.len()], parts.frame_start)?;
        put(a, "core_hull_start", &[parts.hull_start.len()], parts.hull_start)?;
        let points = &parts.hull_points;
        put(a, "core_hull_points", &[points.len(), 2], points.iter().flatten().copied())?;
        put(a, "core_hull_area", &[parts.hull_area.len()], parts.hull_area)?;
        put(a, "core_hull_border", &[parts.hull_border.len()], parts.hull_border)?;
        put(a, "core_outline_start", &[parts.outline_start.len()], parts.outline_start)?;
        let points = &parts.outline_points;
        put(a, "core_outline_points", &[points.len(), 2], points.iter().flatten().copied())?;
        Ok(arrays)
    }

    pub(super) fn from_arrays(a: &Arrays) -> Result<Self> {
        check_format(scalar(a, MARK)?, FORMAT)?;
        let size: Vec<u64> = shaped(a, "core_size", &[Some(2)])?;
        let size = [size[0] as usize, size[1] as usize];
        let image = [Some(size[1]), Some(size[0])];
        let times: Vec<f64> = shaped(a, "core_times", &[None])?;
        let segments: Vec<f64> = shaped(a, "core_segments", &[None, Some(4)])?;
        let segments: Vec<Segment> =
            segments.as_chunks().0.iter().map(|&[x0, y0, x1, y1]| Segment { x0, y0, x1, y1 }).collect();
        let words = [Some(segments.len()), Some(times.len().div_ceil(64))];
        let points: Vec<u16> = shaped(a, "core_hull_points", &[None, Some(2)])?;
        // Files of older versions have no outlines.
        let (outline_start, outline_points) = if a.contains_key("core_outline_start") {
            let points: Vec<u16> = shaped(a, "core_outline_points", &[None, Some(2)])?;
            (shaped(a, "core_outline_start", &[None])?, points.as_chunks().0.to_vec())
        } else {
            (vec![0], Vec::new())
        };
        let visible = a.contains_key("core_visible");
        let parts = RecordingParts {
            size,
            barcodes: shaped(a, "core_barcodes", &words)?,
            times,
            segments,
            frame_start: shaped(a, "core_frame_start", &[None])?,
            hull_start: shaped(a, "core_hull_start", &[None])?,
            hull_points: points.as_chunks().0.to_vec(),
            hull_area: shaped(a, "core_hull_area", &[None])?,
            hull_border: shaped(a, "core_hull_border", &[None])?,
            outline_start,
            outline_points,
            heat: shaped(a, "core_heat", &image)?,
            moving_pixels: shaped(a, "core_moving_pixels", &[None])?,
            visible: if visible { Some(shaped(a, "core_visible", &image)?) } else { None },
            seed: shaped::<u64>(a, "core_seed", &[Some(1)])?[0],
        };
        let matrix = if a.contains_key("matrix") {
            Some(camera_matrix(&shaped(a, "matrix", &[Some(3), Some(3)])?)?)
        } else {
            None
        };
        let (distortions, fisheye) = lens(a, matrix.as_ref())?;
        let health = if a.contains_key("health_names") {
            let names: Vec<String> = shaped(a, "health_names", &[None])?;
            let values = finite("health_values", shaped(a, "health_values", &[Some(names.len())])?)?;
            names.into_iter().zip(values).collect()
        } else {
            Vec::new()
        };
        Ok(Self {
            recording: parts.try_into()?,
            name: scalar(a, "name")?,
            warnings: shaped(a, "warnings", &[None])?,
            distortions,
            matrix,
            fisheye,
            pixel_aspect: pixel_aspect(a)?,
            health,
            first_frame: first_frame(a)?,
        })
    }
}

fn first_frame(a: &Arrays) -> Result<i64> {
    let first = if a.contains_key("first_frame") { scalar(a, "first_frame")? } else { 0 };
    if first < 0 { Err(Error::Damaged(format!("first_frame is {first}"))) } else { Ok(first) }
}

/// Distortions and whether they are of a fisheye; files of older versions have none, and without a matrix they are of no use.
fn lens(a: &Arrays, matrix: Option<&Matrix3<f64>>) -> Result<(Option<Vec<f64>>, bool)> {
    let Some(matrix) = matrix.filter(|_| a.contains_key("distortions")) else {
        return Ok((None, false));
    };
    if matrix.m12.abs() > LEAST_SKEW {
        return Err(Error::Damaged("matrix has skew, which no lens that is taken out has".into()));
    }
    let distortions = finite("distortions", shaped(a, "distortions", &[None])?)?;
    let fisheye = a.contains_key("fisheye") && scalar(a, "fisheye")?;
    let counts: &[usize] = if fisheye { &[0, 4] } else { &[0, 4, 5, 8, 12, 14] };
    if counts.contains(&distortions.len()) {
        Ok((Some(distortions), fisheye))
    } else {
        Err(Error::Damaged(format!("there are {} distortions", distortions.len())))
    }
}

/// How wide pixels are; files of older versions do not say.
fn pixel_aspect(a: &Arrays) -> Result<Option<f64>> {
    if !a.contains_key("pixel_aspect") {
        return Ok(None);
    }
    let aspect: f64 = scalar(a, "pixel_aspect")?;
    let usable = aspect.is_finite() && aspect > 0.0;
    if usable { Ok(Some(aspect)) } else { Err(Error::Damaged(format!("pixel_aspect is {aspect}"))) }
}

fn camera_matrix(entries: &[f64]) -> Result<Matrix3<f64>> {
    let matrix = Matrix3::from_row_slice(entries);
    let usable = CameraMatrices::new(matrix, matrix);
    usable.map(|cameras| *cameras.a()).map_err(|_| Error::Damaged("matrix is no camera matrix".into()))
}
