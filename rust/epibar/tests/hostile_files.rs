//! Files from a stranger: they cost no more than what they are, and end in an error or in a sound result.
//!
//! `PROPTEST_CASES` says how many are tried of each kind.

mod common;

use std::io::Write;
use std::path::{Path, PathBuf};

use common::flying::Scene;
use epibar::{CalibrateOptions, Calibration, Error, Method, Recorder, RecorderOptions, Recording, calibrate};
use proptest::prelude::*;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn refused<T: std::fmt::Debug>(result: epibar::Result<T>, words: &str) {
    let error = result.unwrap_err();
    assert!(matches!(error, Error::File { .. }) && error.to_string().contains(words), "{error}");
}

fn write_entries(path: &Path, entries: &[(&str, Vec<u8>)]) {
    let mut archive = ZipWriter::new(std::fs::File::create(path).unwrap());
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    for (name, bytes) in entries {
        archive.start_file(format!("{name}.npy"), options).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap();
}

/// The bytes of a `.npy` file.
fn array(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn a_file_that_expands_beyond_all_measure() {
    let path = file("bomb.npz");
    write_entries(&path, &[("epibar_recording", array("<i8", "()", &[1; 8])), ("x", vec![0; 300 << 20])]);
    assert!(std::fs::metadata(&path).unwrap().len() < 400_000);
    refused(Recording::load(&path), "say they expand to");
    refused(Calibration::load(&path), "say they expand to");
}

#[test]
fn a_recording_in_which_nothing_moves_is_no_such_file() {
    // A thousand times as long as it is compressed.
    let size = epibar::ImageSize::new(64, 48).unwrap();
    let mut recorder = Recorder::new(size, RecorderOptions::new().lines(40_000)).unwrap();
    for frame in 0..20_000 {
        recorder.push(&vec![0; size.pixels()], f64::from(frame)).unwrap();
    }
    let recording = recorder.finish().unwrap();
    let path = file("still.npz");
    recording.save(&path).unwrap();
    assert_eq!(Recording::load(&path).unwrap(), recording);
}

#[test]
fn older_and_newer_formats_are_told_apart() {
    let path = file("format.npz");
    for (version, words) in
        [(2i64, "a newer epibar wrote it; update epibar"), (0, "an older epibar wrote it")]
    {
        for (mark, recording) in [("epibar_recording", true), ("epibar_calibration", false)] {
            write_entries(&path, &[(mark, array("<i8", "()", &version.to_le_bytes()))]);
            if recording {
                refused(Recording::load(&path), words);
            } else {
                refused(Calibration::load(&path), words);
            }
        }
    }
}

#[test]
fn arrays_that_say_what_they_are_not() {
    let path = file("arrays.npz");
    let one = array("<i8", "()", &1i64.to_le_bytes());
    for (descr, shape) in [
        ("<i8", "(9223372036854775807,)"),
        ("<i8", "(4294967296, 4294967296)"),
        ("<u8", "(0, 9223372036854775807)"),
        ("|O", "(2,)"),
        ("<U4000000000", "()"),
        ("<U0", "(9223372036854775807,)"),
        ("[('a', '<i8')]", "(2,)"),
        ("<c16", "(2,)"),
        ("<f8", "(2"),
        ("<f8", &"(".repeat(5000)),
        ("<f8", &format!("{}2{}", "(".repeat(60_000 / 2 - 100), ")".repeat(60_000 / 2 - 100))),
        ("<f8", "(-1,)"),
        ("<f8", "(1e3,)"),
    ] {
        let size = array(descr, shape, &[1; 16]);
        write_entries(&path, &[("epibar_recording", one.clone()), ("core_size", size)]);
        refused(Recording::load(&path), "arrays.npz");
    }
}

/// A small recording and a calibration, as the bytes of their files.
fn samples() -> [Vec<u8>; 2] {
    let scene = Scene::new(5, 200, 1);
    let [a, b] = scene.recordings(300);
    let options = CalibrateOptions::new().method(Method::Lines).draws(200).candidates(50);
    let calibration = calibrate(&a, &b, &options).unwrap();
    let (recording, path) = (file("sample_recording.npz"), file("sample_calibration.npz"));
    a.save(&recording).unwrap();
    calibration.save(&path).unwrap();
    [recording, path].map(|path| std::fs::read(path).unwrap())
}

/// The arrays of an archive, so that damage is not stopped by its check sums.
fn entries(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(bytes)).unwrap();
    (0..archive.len())
        .map(|index| {
            let mut entry = archive.by_index(index).unwrap();
            let name = entry.name().unwrap().trim_end_matches(".npy").to_string();
            let mut data = Vec::new();
            std::io::Read::read_to_end(&mut entry, &mut data).unwrap();
            (name, data)
        })
        .collect()
}

fn loads(path: &Path) {
    // Whether it is refused does not matter; that it comes back, and sound, does.
    if let Ok(recording) = Recording::load(path) {
        assert!(recording.frames() > 0);
    }
    if let Ok(calibration) = Calibration::load(path) {
        assert!(calibration.verdict.reason.len() < 1 << 30);
    }
}

/// Places, as a share of the whole, and what to do there: another byte, or a cut.
fn damages() -> impl Strategy<Value = Vec<(f64, u8, bool)>> {
    prop::collection::vec((0.0..1.0, any::<u8>(), prop::bool::weighted(0.02)), 1..6)
}

fn damaged(bytes: &mut Vec<u8>, damages: &[(f64, u8, bool)]) {
    for &(place, byte, cut) in damages {
        let at = (place * bytes.len() as f64) as usize;
        if cut {
            bytes.truncate(at);
        } else if let Some(old) = bytes.get_mut(at) {
            *old = byte;
        }
    }
}

#[test]
fn damaged_archives() {
    let samples = samples();
    let path = file("damaged.npz");
    proptest!(|(which in 0..2usize, damages in damages())| {
        let mut bytes = samples[which].clone();
        damaged(&mut bytes, &damages);
        std::fs::write(&path, &bytes).unwrap();
        loads(&path);
    });
}

#[test]
fn damaged_arrays_in_sound_archives() {
    let samples = samples().map(|bytes| entries(&bytes));
    let path = file("damaged_arrays.npz");
    // Headers of arrays are short, and damage there is worth more than in the numbers.
    let place = prop_oneof![(0usize..130).boxed(), (0usize..1 << 20).boxed()];
    proptest!(|(which in 0..2usize, array in any::<prop::sample::Index>(), place in place, bytes in prop::collection::vec(any::<u8>(), 1..9))| {
        let mut entries = samples[which].clone();
        let index = array.index(entries.len());
        let data = &mut entries[index].1;
        let at = place % data.len();
        let end = (at + bytes.len()).min(data.len());
        data[at..end].copy_from_slice(&bytes[..end - at]);
        let entries: Vec<_> = entries.iter().map(|(name, data)| (name.as_str(), data.clone())).collect();
        write_entries(&path, &entries);
        loads(&path);
    });
}

#[test]
fn headers_of_calibrations_with_other_values() {
    let sample = entries(&samples()[1]);
    let path = file("damaged_header.npz");
    let values = prop::sample::select(vec![
        "null",
        "true",
        "-1",
        "1e999",
        "NaN",
        "-Infinity",
        "\"\"",
        "[]",
        "{}",
        "18446744073709551616",
        "[[NaN]]",
        "{\"ndarray\": [[1, 2], 3]}",
        "[{\"F\": null}]",
        "\"\\u0000number NaN\"",
    ]);
    let header = &sample.iter().find(|(name, _)| name == "header").unwrap().1;
    // Behind 128 bytes of header come characters of four bytes each.
    let text: String = header[128..]
        .chunks_exact(4)
        .filter_map(|c| char::from_u32(u32::from_le_bytes(c.try_into().unwrap())))
        .collect();
    let colons: Vec<usize> = text.match_indices(':').map(|(at, _)| at).collect();
    proptest!(|(colon in any::<prop::sample::Index>(), value in values)| {
        let at = colons[colon.index(colons.len())] + 1;
        let end = at + text[at..].find([',', '}', ']']).unwrap();
        let changed = format!("{}{value}{}", &text[..at], &text[end..]);
        let characters: Vec<u8> = changed.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
        let header = array(&format!("<U{}", changed.chars().count()), "()", &characters);
        let entries: Vec<_> = sample.iter().map(|(name, data)| {
            (name.as_str(), if name == "header" { header.clone() } else { data.clone() })
        }).collect();
        write_entries(&path, &entries);
        loads(&path);
    });
}
