//! A calibration in a file: each array an entry of its own, all the rest one JSON text.

use std::path::Path;

use nalgebra::Matrix3;

use super::archive::{self, Arrays, check_format, failed, finite, get, put, put_texts, scalar, shaped};
use super::{header, json};
use crate::calibration::{Calibration, CandidatePair, FrontierPoint, ShiftScore};
use crate::error::{Error, Result};
use crate::geometry::Fundamental;
use crate::image::Line;
use crate::recording::RecordedFrame;
use crate::verify::ErrorMap;

/// Version of the file; a file of another one is refused.
const FORMAT: i64 = 1;
const MARK: &str = "epibar_calibration";
const KIND: &str = "a calibration saved by epibar";
/// The matrix that was tested, which Python's calibrations do not have.
const TESTED: &str = "tested";

impl Calibration {
    /// Writes one compressed `.npz` file, whole or not at all, that Python reads as well (`epibar.Calibration.load`).
    ///
    /// # Errors
    /// [`Error::File`] where it cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        archive::write(path.as_ref(), &self.to_arrays()?)
    }

    /// Reads what [`Calibration::save`] wrote, or Python's `epibar.Calibration.save`, whose calibrations do not have
    /// [`tested`](Calibration::tested).
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
        let mut arrays = Arrays::new();
        let a = &mut arrays;
        put(a, MARK, &[], [FORMAT])?;
        put_texts(a, "header", &[], &[json::write(&header::of(self))])?;
        for (name, matrix) in [
            ("F", self.fundamental.as_ref().map(Fundamental::matrix)),
            ("floor", self.floor.as_ref()),
            (TESTED, self.tested.as_ref().map(Fundamental::matrix)),
        ] {
            if let Some(matrix) = matrix {
                put(a, name, &[3, 3], matrix.transpose().iter().copied())?;
            }
        }
        let (pairs, points) = (&self.candidates, &self.frontier_points);
        let line = |line: Line| [line.a, line.b, line.c];
        put(a, "candidates.lines_a", &[pairs.len(), 3], pairs.iter().flat_map(|c| line(c.a)))?;
        put(a, "candidates.lines_b", &[pairs.len(), 3], pairs.iter().flat_map(|c| line(c.b)))?;
        put(a, "candidates.correlation", &[pairs.len()], pairs.iter().map(|c| c.correlation))?;
        put(a, "candidates.inliers", &[pairs.len()], pairs.iter().map(|c| c.inlier))?;
        put(a, "frontier_points.frame", &[points.len()], points.iter().map(|p| i64::from(p.frame.0)))?;
        put(a, "frontier_points.a", &[points.len(), 2], points.iter().flat_map(|p| p.a))?;
        put(a, "frontier_points.b", &[points.len(), 2], points.iter().flat_map(|p| p.b))?;
        put(a, "frontier_points.residual", &[points.len()], points.iter().map(|p| p.residual))?;
        let curve = &self.shift_curve;
        put(a, "shift_curve.0", &[curve.len()], curve.iter().map(|s| s.shift as f64))?;
        put(a, "shift_curve.1", &[curve.len()], curve.iter().map(|s| s.score))?;
        for (index, map) in self.error_maps.iter().flatten().enumerate() {
            put(a, &format!("error_maps.{index}"), &[map.rows, map.columns], map.values.iter().copied())?;
        }
        Ok(arrays)
    }

    pub(super) fn from_arrays(a: &Arrays) -> Result<Self> {
        check_format(scalar(a, MARK)?, FORMAT)?;
        let text: String = scalar(a, "header")?;
        let mut calibration = header::read(&text)?;
        calibration.fundamental = fundamental(a, "F")?;
        calibration.tested = fundamental(a, TESTED)?;
        calibration.floor = matrix(a, "floor")?;

        let numbers = |name, sides: &[_]| finite(name, shaped(a, name, sides)?);
        let correlation = numbers("candidates.correlation", &[None])?;
        let pairs = Some(correlation.len());
        let lines_a = lines(a, "candidates.lines_a", pairs)?;
        let lines_b = lines(a, "candidates.lines_b", pairs)?;
        let inliers: Vec<bool> = shaped(a, "candidates.inliers", &[pairs])?;
        let candidates = lines_a.into_iter().zip(lines_b).zip(correlation).zip(inliers);
        calibration.candidates = candidates
            .map(|(((a, b), correlation), inlier)| CandidatePair { a, b, correlation, inlier })
            .collect();

        let frames: Vec<i64> = shaped(a, "frontier_points.frame", &[None])?;
        let points = Some(frames.len());
        let in_a = numbers("frontier_points.a", &[points, Some(2)])?;
        let in_b = numbers("frontier_points.b", &[points, Some(2)])?;
        let residuals = numbers("frontier_points.residual", &[points])?;
        let places = in_a.as_chunks().0.iter().zip(in_b.as_chunks().0);
        calibration.frontier_points = (frames.into_iter().zip(places).zip(residuals))
            .map(|((frame, (&a, &b)), residual)| {
                let frame = u32::try_from(frame).map_err(|_| Error::Damaged("a frame is negative".into()))?;
                Ok(FrontierPoint { frame: RecordedFrame(frame), a, b, residual })
            })
            .collect::<Result<_>>()?;

        let shifts: Vec<f64> = shaped(a, "shift_curve.0", &[None])?;
        let scores: Vec<f64> = shaped(a, "shift_curve.1", &[Some(shifts.len())])?;
        let curve = shifts.into_iter().zip(scores);
        calibration.shift_curve =
            curve.map(|(shift, score)| ShiftScore { shift: shift as usize, score }).collect();
        calibration.error_maps = error_maps(a)?;
        Ok(calibration)
    }
}

fn matrix(arrays: &Arrays, name: &str) -> Result<Option<Matrix3<f64>>> {
    if !arrays.contains_key(name) {
        return Ok(None);
    }
    let entries = finite(name, shaped(arrays, name, &[Some(3), Some(3)])?)?;
    Ok(Some(Matrix3::from_row_slice(&entries)))
}

fn fundamental(arrays: &Arrays, name: &str) -> Result<Option<Fundamental>> {
    let Some(matrix) = matrix(arrays, name)? else { return Ok(None) };
    let found = Fundamental::from_rank_two(&matrix);
    found.map(Some).ok_or_else(|| Error::Damaged(format!("{name} is no matrix of rank 2")))
}

fn lines(arrays: &Arrays, name: &str, count: Option<usize>) -> Result<Vec<Line>> {
    let entries: Vec<f64> = shaped(arrays, name, &[count, Some(3)])?;
    let line = |&[a, b, c]: &[f64; 3]| {
        let unit = (a * a + b * b - 1.0).abs() < 1e-9 && c.is_finite();
        if unit {
            Ok(Line { a, b, c })
        } else {
            Err(Error::Damaged(format!("{name} has a line without a unit normal")))
        }
    };
    entries.as_chunks().0.iter().map(line).collect()
}

fn error_maps(arrays: &Arrays) -> Result<Option<[ErrorMap; 2]>> {
    let map = |name: &str| -> Result<ErrorMap> {
        let (values, shape) = get(arrays, name)?;
        let &[rows, columns] = shape.as_slice() else {
            return Err(Error::Damaged(format!("{name} has the shape {shape:?}")));
        };
        Ok(ErrorMap { rows, columns, values })
    };
    if !arrays.contains_key("error_maps.0") {
        return Ok(None);
    }
    Ok(Some([map("error_maps.0")?, map("error_maps.1")?]))
}
