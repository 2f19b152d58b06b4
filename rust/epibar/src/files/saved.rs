//! What is in a file, from bytes instead of from a path: for tests that try very many.

use std::io::Cursor;

use super::archive;
pub use super::archive::Arrays;
use super::recording::SavedRecording;
use crate::calibration::Calibration;
use crate::error::{Error, Result};

/// The arrays of the bytes of an archive.
///
/// # Errors
/// [`Error::Damaged`].
pub fn arrays(bytes: &[u8]) -> Result<Arrays> {
    archive::read_from(Cursor::new(bytes), bytes.len() as u64).map_err(Error::Damaged)
}

/// The recording that arrays are.
///
/// # Errors
/// [`Error::Damaged`].
pub fn recording(arrays: &Arrays) -> Result<SavedRecording> {
    SavedRecording::from_arrays(arrays)
}

/// The arrays of a recording.
///
/// # Errors
/// None that input can cause.
pub fn recording_arrays(recording: &SavedRecording) -> Result<Arrays> {
    recording.to_arrays()
}

/// The calibration that arrays are.
///
/// # Errors
/// [`Error::Damaged`].
pub fn calibration(arrays: &Arrays) -> Result<Calibration> {
    Calibration::from_arrays(arrays)
}

/// The arrays of a calibration.
///
/// # Errors
/// None that input can cause.
pub fn calibration_arrays(calibration: &Calibration) -> Result<Arrays> {
    calibration.to_arrays()
}
