//! Named arrays in one `.npz` file, written whole or not at all.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufReader, Read, Write};
use std::path::Path;

use npyz::{AutoSerialize, DType, Deserialize, NpyFile, Order, WriterBuilder};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::error::{Error, Result};

/// An array as the bytes of a `.npy` file.
pub(super) type Arrays = BTreeMap<String, Vec<u8>>;

/// [`Error::File`] with a reason.
pub(super) fn failed(path: &Path, reason: impl std::fmt::Display) -> Error {
    Error::File { path: path.to_path_buf(), reason: reason.to_string() }
}

/// Every array of a file.
pub(super) fn read(path: &Path) -> Result<Arrays> {
    let file = File::open(path).map_err(|error| failed(path, error))?;
    let damaged = |error: &dyn std::fmt::Display| failed(path, format!("no .npz file, or damaged ({error})"));
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(|error| damaged(&error))?;
    let mut arrays = Arrays::new();
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).map_err(|error| damaged(&error))?;
        let name = entry.name().map_err(|error| damaged(&error))?.trim_end_matches(".npy").to_string();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).map_err(|error| damaged(&error))?;
        arrays.insert(name, bytes);
    }
    Ok(arrays)
}

/// Writes a temporary file beside `path`, then renames it: no reader ever sees half a file.
pub(super) fn write(path: &Path, arrays: &Arrays) -> Result<()> {
    let name = path.file_name().ok_or_else(|| failed(path, "not the name of a file"))?.to_string_lossy();
    let temporary = path.with_file_name(format!(".{name}.{}.part", std::process::id()));
    let written = write_to(&temporary, arrays).and_then(|()| fs::rename(&temporary, path));
    if written.is_err() {
        // What is left of it, if anything is, is of no use.
        let _ = fs::remove_file(&temporary);
    }
    written.map_err(|error| failed(path, format!("cannot be written ({error})")))
}

fn write_to(path: &Path, arrays: &Arrays) -> std::io::Result<()> {
    let mut archive = ZipWriter::new(File::create(path)?);
    let options =
        SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).large_file(true);
    for (name, bytes) in arrays {
        archive.start_file(format!("{name}.npy"), options)?;
        archive.write_all(bytes)?;
    }
    archive.finish()?.sync_all()
}

/// Something is wrong with an array.
fn damaged(name: &str, what: impl std::fmt::Display) -> Error {
    Error::Damaged(format!("{name} {what}"))
}

/// The values of an array, row by row, and its shape.
///
/// # Errors
/// [`Error::Damaged`] where it is missing, or of another type.
pub(super) fn get<T: Deserialize + Clone>(arrays: &Arrays, name: &str) -> Result<(Vec<T>, Vec<usize>)> {
    let bytes = arrays.get(name).ok_or_else(|| damaged(name, "is missing"))?;
    let file = NpyFile::new(bytes.as_slice()).map_err(|error| damaged(name, error))?;
    let shape: Vec<usize> = file.shape().iter().map(|&side| side as usize).collect();
    let size = file.dtype().num_bytes().unwrap_or(1).max(1);
    let count = shape.iter().try_fold(1usize, |count, &side| count.checked_mul(side));
    if count.and_then(|count| count.checked_mul(size)).is_none_or(|size| size > bytes.len()) {
        return Err(damaged(name, "is shorter than it says"));
    }
    let columns_first = file.order() == Order::Fortran && shape.len() > 1;
    let values: Vec<T> = file.into_vec().map_err(|error| damaged(name, error))?;
    match (columns_first, shape.as_slice()) {
        (false, _) => Ok((values, shape)),
        (true, &[rows, columns]) => {
            let at = |k: usize| values[k % columns * rows + k / columns].clone();
            Ok(((0..rows * columns).map(at).collect(), shape))
        }
        (true, _) => Err(damaged(name, "is stored in an unknown order")),
    }
}

/// The values of an array of a shape in which `None` may be anything.
pub(super) fn shaped<T: Deserialize + Clone>(
    arrays: &Arrays,
    name: &str,
    expected: &[Option<usize>],
) -> Result<Vec<T>> {
    let (values, shape) = get(arrays, name)?;
    let fits = shape.len() == expected.len()
        && shape.iter().zip(expected).all(|(&side, expected)| expected.is_none_or(|e| e == side));
    if fits { Ok(values) } else { Err(damaged(name, format!("has the shape {shape:?}"))) }
}

/// The one value of an array without dimensions.
pub(super) fn scalar<T: Deserialize + Clone>(arrays: &Arrays, name: &str) -> Result<T> {
    shaped::<T>(arrays, name, &[])?.pop().ok_or_else(|| damaged(name, "is empty"))
}

/// Adds an array.
pub(super) fn put<T: AutoSerialize>(
    arrays: &mut Arrays,
    name: &str,
    shape: &[usize],
    values: impl IntoIterator<Item = T>,
) -> Result<()> {
    put_as(arrays, name, shape, T::default_dtype(), values)
}

/// Adds an array of texts.
pub(super) fn put_texts(arrays: &mut Arrays, name: &str, shape: &[usize], texts: &[String]) -> Result<()> {
    let longest = texts.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1);
    let dtype = format!("<U{longest}").parse().map_err(|error| damaged(name, error))?;
    let bytes = serialise(shape, DType::new_scalar(dtype), texts.iter().map(String::as_str));
    arrays.insert(name.to_string(), bytes.map_err(|error| damaged(name, error))?);
    Ok(())
}

fn put_as<T: npyz::Serialize>(
    arrays: &mut Arrays,
    name: &str,
    shape: &[usize],
    dtype: DType,
    values: impl IntoIterator<Item = T>,
) -> Result<()> {
    let bytes = serialise(shape, dtype, values).map_err(|error| damaged(name, error))?;
    arrays.insert(name.to_string(), bytes);
    Ok(())
}

fn serialise<T: npyz::Serialize>(
    shape: &[usize],
    dtype: DType,
    values: impl IntoIterator<Item = T>,
) -> std::io::Result<Vec<u8>> {
    let shape: Vec<u64> = shape.iter().map(|&side| side as u64).collect();
    let mut bytes = Vec::new();
    let options = npyz::WriteOptions::<T>::new().dtype(dtype).shape(&shape).writer(&mut bytes);
    let mut writer = options.begin_nd()?;
    for value in values {
        writer.push(&value)?;
    }
    writer.finish()?;
    Ok(bytes)
}
