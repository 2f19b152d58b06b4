//! Recordings and calibrations in files: the same `.npz` archives that the Python package reads and writes.
//!
//! [`archive`] is named arrays in a zip file, [`json`] the JSON that Python writes, with numbers that are not finite;
//! [`recording`] and [`calibration`] say which arrays there are, [`saved`] is all of it without a file system. No file is executed: it may come from anyone.

mod archive;
mod calibration;
mod header;
mod json;
mod recording;
pub mod saved;

pub use recording::SavedRecording;
