//! Named arrays in one `.npz` file, written whole or not at all.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufReader, Read, Seek, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

use npyz::{AutoSerialize, DType, Deserialize, NpyFile, Order, WriterBuilder};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::error::{Error, Result};

/// An array as the bytes of a `.npy` file.
pub type Arrays = BTreeMap<String, Vec<u8>>;

/// [`Error::File`] with a reason.
pub(super) fn failed(path: &Path, reason: impl std::fmt::Display) -> Error {
    Error::File { path: path.to_path_buf(), reason: reason.to_string() }
}

/// How many bytes a file of so many may expand to. Recordings of real videos expand 4 to 11 times, those in which
/// nothing moves some hundred times; a file that was made to fill the memory, a thousand times.
const fn room(file_bytes: u64) -> u64 {
    (32 << 20) + file_bytes.saturating_mul(64)
}

const MOST_ENTRIES: usize = 10_000;

/// Every array of a file, which may come from anyone: what it says of its size is checked before it is expanded.
pub(super) fn read(path: &Path) -> Result<Arrays> {
    let file = File::open(path).map_err(|error| failed(path, error))?;
    let bytes = file.metadata().map_err(|error| failed(path, error))?.len();
    read_from(BufReader::new(file), bytes).map_err(|reason| failed(path, reason))
}

/// Every array of an archive of so many bytes, or what is wrong with it.
pub(super) fn read_from(source: impl Read + Seek, file_bytes: u64) -> std::result::Result<Arrays, String> {
    let damaged = |error: &dyn std::fmt::Display| format!("no .npz file, or damaged ({error})");
    let mut archive = ZipArchive::new(source).map_err(|error| damaged(&error))?;
    if archive.len() > MOST_ENTRIES {
        return Err(damaged(&format!("{} arrays", archive.len())));
    }
    let mut expanded = 0u64;
    for index in 0..archive.len() {
        let entry = archive.by_index_raw(index).map_err(|error| damaged(&error))?;
        if !matches!(entry.compression(), CompressionMethod::Stored | CompressionMethod::Deflated) {
            return Err(damaged(&"compressed in a way that epibar never uses"));
        }
        expanded = expanded.saturating_add(entry.size());
    }
    if expanded > room(file_bytes) {
        return Err(format!(
            "{file_bytes} bytes that say they expand to {expanded}; no file that epibar wrote does, so it is damaged or \
             made to fill the memory"
        ));
    }
    let mut arrays = Arrays::new();
    for index in 0..archive.len() {
        let entry = archive.by_index(index).map_err(|error| damaged(&error))?;
        let name = entry.name().map_err(|error| damaged(&error))?.trim_end_matches(".npy").to_string();
        let size = entry.size();
        let mut bytes = Vec::new();
        // One byte more than it says, to find out that it says too little.
        entry.take(size + 1).read_to_end(&mut bytes).map_err(|error| damaged(&error))?;
        if bytes.len() as u64 != size {
            return Err(damaged(&format!("{name} is not as long as it says")));
        }
        if arrays.insert(name, bytes).is_some() {
            return Err(damaged(&"two arrays of one name"));
        }
    }
    Ok(arrays)
}

/// Writes a temporary file beside `path`, then renames it: no reader ever sees half a file, and after a power cut it
/// is the old file or the new one.
pub(super) fn write(path: &Path, arrays: &Arrays) -> Result<()> {
    let name = path.file_name().ok_or_else(|| failed(path, "not the name of a file"))?.to_string_lossy();
    // Like those of the Python package, which removes what a killed writer left.
    let own = u64::from(std::process::id()) << 32 | u64::from(COUNT.fetch_add(1, Ordering::Relaxed));
    let temporary = path.with_file_name(format!(".{name}.{own:016x}.epibar-part"));
    let written = write_to(&temporary, arrays).and_then(|()| fs::rename(&temporary, path));
    if written.is_err() {
        // What is left of it, if anything is, is of no use.
        let _ = fs::remove_file(&temporary);
    }
    sync_folder(path);
    written.map_err(|error| failed(path, format!("cannot be written ({error})")))
}

/// Of the temporary files of this process.
static COUNT: AtomicU32 = AtomicU32::new(0);

/// Makes the new name of a file last, where the system has such a thing.
fn sync_folder(file: &Path) {
    if cfg!(unix) {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
        if let Ok(folder) = File::open(folder.unwrap_or(Path::new("."))) {
            let _ = folder.sync_all();
        }
    }
}

fn write_to(path: &Path, arrays: &Arrays) -> std::io::Result<()> {
    let expanded: u64 = arrays.values().map(|bytes| bytes.len() as u64).sum();
    let file = compressed(path, arrays, CompressionMethod::Deflated)?;
    // What reads it would take it for a file that is made to fill the memory.
    let file = if expanded > room(file.metadata()?.len()) {
        compressed(path, arrays, CompressionMethod::Stored)?
    } else {
        file
    };
    file.sync_all()
}

fn compressed(path: &Path, arrays: &Arrays, method: CompressionMethod) -> std::io::Result<File> {
    let mut archive = ZipWriter::new(File::create(path)?);
    let options = SimpleFileOptions::default().compression_method(method).large_file(true);
    for (name, bytes) in arrays {
        archive.start_file(format!("{name}.npy"), options)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?)
}

/// Something is wrong with an array.
fn damaged(name: &str, what: impl std::fmt::Display) -> Error {
    Error::Damaged(format!("{name} {what}"))
}

/// Whether a file is of the one format that is read.
///
/// # Errors
/// [`Error::Damaged`] where an older or a newer epibar wrote it.
pub(super) fn check_format(found: i64, known: i64) -> Result<()> {
    let (older, remedy) = match found.cmp(&known) {
        std::cmp::Ordering::Equal => return Ok(()),
        std::cmp::Ordering::Less => ("an older", "make it again"),
        std::cmp::Ordering::Greater => ("a newer", "update epibar"),
    };
    Err(Error::Damaged(format!(
        "format {found}, but this epibar reads format {known}: {older} epibar wrote it; {remedy}"
    )))
}

/// Whether all of some numbers are finite.
///
/// # Errors
/// [`Error::Damaged`] with the name of their array.
pub(super) fn finite(name: &str, values: Vec<f64>) -> Result<Vec<f64>> {
    if values.iter().all(|value| value.is_finite()) {
        Ok(values)
    } else {
        Err(damaged(name, "is not finite"))
    }
}

/// Whether the header of a `.npy` file is one that its parser can be given: of numbers or texts, without structures,
/// which it would follow as deep as they go, and of a shape whose product does not overflow.
fn check_header(bytes: &[u8]) -> std::result::Result<(), &'static str> {
    const LONGEST: usize = 10_000;
    let start = match bytes.get(6) {
        Some(1) => 10,
        _ => 12,
    };
    let text = &bytes[start.min(bytes.len())..(start + LONGEST).min(bytes.len())];
    let end = text.iter().position(|&c| c == b'}').ok_or("has a header without an end")?;
    let text = std::str::from_utf8(&text[..end]).map_err(|_| "has a header that is no text")?;
    let count = |sign: char| text.chars().filter(|&c| c == sign).count();
    if ['(', ')', '{'].map(count) != [1, 1, 1] || count('[') > 0 {
        return Err("holds something else than numbers or texts");
    }
    let sides =
        text.split_once('(').and_then(|(_, rest)| rest.split_once(')')).map_or("", |(sides, _)| sides);
    let mut product = Some(1u64);
    for side in sides.split(',').map(str::trim).filter(|side| !side.is_empty()) {
        let side: u64 = side.parse().map_err(|_| "has a side that is no number")?;
        product = product.and_then(|product| product.checked_mul(side));
    }
    product.map(|_| ()).ok_or("has more numbers than can be counted")
}

/// The values of an array, row by row, and its shape.
///
/// # Errors
/// [`Error::Damaged`] where it is missing, or of another type.
pub(super) fn get<T: Deserialize + Clone>(arrays: &Arrays, name: &str) -> Result<(Vec<T>, Vec<usize>)> {
    let bytes = arrays.get(name).ok_or_else(|| damaged(name, "is missing"))?;
    check_header(bytes).map_err(|what| damaged(name, what))?;
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
