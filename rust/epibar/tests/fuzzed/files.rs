//! Files from a stranger, as bytes.
//!
//! The check sums of an archive stop nearly every change of its bytes. So `archive` takes these as they are, and the others a plain
//! list of arrays: the number of a name, two bytes of length, and so many bytes of a `.npy` file.

use epibar::internals::saved::{self, Arrays};

/// Names of a recording's arrays, by their number in a list.
pub const RECORDING: [&str; 24] = [
    "epibar_recording",
    "name",
    "warnings",
    "health_names",
    "health_values",
    "first_frame",
    "matrix",
    "core_size",
    "core_seed",
    "core_times",
    "core_segments",
    "core_barcodes",
    "core_heat",
    "core_visible",
    "core_moving_pixels",
    "core_frame_start",
    "core_hull_start",
    "core_hull_points",
    "core_hull_area",
    "core_hull_border",
    "core_outline_start",
    "core_outline_points",
    "",
    "else",
];

/// Names of a calibration's arrays, by their number in a list.
pub const CALIBRATION: [&str; 18] = [
    "epibar_calibration",
    "header",
    "F",
    "floor",
    "tested",
    "candidates.lines_a",
    "candidates.lines_b",
    "candidates.correlation",
    "candidates.inliers",
    "frontier_points.frame",
    "frontier_points.a",
    "frontier_points.b",
    "frontier_points.residual",
    "shift_curve.0",
    "shift_curve.1",
    "error_maps.0",
    "error_maps.1",
    "else",
];

/// The bytes of an archive.
pub fn archive(data: &[u8]) {
    if let Ok(arrays) = saved::arrays(data) {
        // No more than what its size allows.
        let expanded: usize = arrays.values().map(Vec::len).sum();
        assert!(expanded <= (32 << 20) + 64 * data.len());
        read_recording(&arrays);
        read_calibration(&arrays);
    }
}

/// A list of a recording's arrays.
pub fn recording(data: &[u8]) {
    read_recording(&listed(data, &RECORDING));
}

/// A list of a calibration's arrays; its header may be plain text.
pub fn calibration(data: &[u8]) {
    read_calibration(&listed(data, &CALIBRATION));
}

/// What was read is sound, and is read again as it was.
fn read_recording(arrays: &Arrays) {
    let Ok(found) = saved::recording(arrays) else { return };
    let recording = &found.recording;
    assert!(recording.frames() > 0 && recording.times().iter().all(|time| time.is_finite()));
    assert_eq!(recording.barcodes().count(), recording.segments().len());
    assert_eq!(recording.heat().len(), recording.size().pixels());
    let hulls = recording.silhouettes();
    for hull in 0..hulls.len() {
        let inside = |&[x, y]: &[u16; 2]| {
            usize::from(x) < recording.size().width() && usize::from(y) < recording.size().height()
        };
        assert!(hulls.hull(hull).iter().all(inside));
    }
    let written = saved::recording_arrays(&found).unwrap();
    let again = saved::recording(&written).unwrap();
    assert_eq!(saved::recording_arrays(&again).unwrap(), written);
}

fn read_calibration(arrays: &Arrays) {
    let Ok(found) = saved::calibration(arrays) else { return };
    let numbers = found.fundamental.iter().flat_map(|f| f.matrix().iter());
    assert!(numbers.copied().all(f64::is_finite));
    let written = saved::calibration_arrays(&found).unwrap();
    let again = saved::calibration(&written).unwrap();
    assert_eq!(saved::calibration_arrays(&again).unwrap(), written);
}

fn listed(mut data: &[u8], names: &[&str]) -> Arrays {
    let mut arrays = Arrays::new();
    while let [name, low, high, rest @ ..] = data {
        let length = usize::from(u16::from_le_bytes([*low, *high])).min(rest.len());
        let (bytes, rest) = rest.split_at(length);
        let name = names[usize::from(*name) % names.len()];
        let text = name == "header" && !bytes.starts_with(b"\x93NUMPY");
        arrays.insert(name.to_string(), if text { text_array(bytes) } else { bytes.to_vec() });
        data = rest;
    }
    arrays
}

/// A `.npy` file of one text.
fn text_array(text: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(text);
    let count = text.chars().count().max(1);
    let header = format!("{{'descr': '<U{count}', 'fortran_order': False, 'shape': (), }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(text.chars().flat_map(|c| u32::from(c).to_le_bytes()));
    bytes.resize(10 + header.len() + 4 * count, 0);
    bytes
}
