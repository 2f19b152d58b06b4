//! What coverage-guided fuzzing has come upon, replayed without a fuzzer: every file of `corpus/` through the function
//! of its folder.

mod common;
#[path = "fuzzed/mod.rs"]
mod fuzzed;

use std::fs;
use std::path::{Path, PathBuf};

use common::flying::Scene;
use common::masks::Random;
use epibar::internals::saved::{self, Arrays};
use epibar::{CalibrateOptions, ImageSize, Method, Recorder, RecorderOptions, SavedRecording};

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus")
}

#[test]
fn every_file_of_the_corpus() {
    for (name, _) in fuzzed::ALL {
        let run = fuzzed::target(name);
        let mut paths: Vec<PathBuf> =
            fs::read_dir(corpus().join(name)).unwrap().map(|entry| entry.unwrap().path()).collect();
        paths.sort();
        assert!(!paths.is_empty(), "{name} has no inputs");
        for path in paths {
            // What a panic says is followed by which file it was.
            println!("{}", path.display());
            run(&fs::read(&path).unwrap());
        }
    }
}

/// Makes the inputs that fuzzing begins with: `cargo test --test fuzz_corpus -- --ignored`. What it found since stays.
#[test]
#[ignore = "writes files of the repository"]
fn write_the_first_inputs() {
    let recording = small_recording();
    let calibration = small_calibration();
    put("archive", "recording.npz", &zipped(|path| recording.save(path)));
    put("archive", "calibration.npz", &zipped(|path| calibration.save(path)));
    put(
        "recording",
        "small",
        &list(&saved::recording_arrays(&recording).unwrap(), &fuzzed::files::RECORDING),
    );
    put(
        "calibration",
        "small",
        &list(&saved::calibration_arrays(&calibration).unwrap(), &fuzzed::files::CALIBRATION),
    );
    let mut random = Random(1);
    for name in ["recorder", "matching", "calibrate", "network", "network_add", "network_check"] {
        for length in [60, 300, 1200] {
            let bytes: Vec<u8> = (0..length).map(|_| random.between(0.0, 256.0) as u8).collect();
            put(name, &format!("random_{length}"), &bytes);
        }
    }
}

fn put(target: &str, name: &str, bytes: &[u8]) {
    fs::create_dir_all(corpus().join(target)).unwrap();
    fs::write(corpus().join(target).join(name), bytes).unwrap();
}

fn small_recording() -> SavedRecording {
    let size = ImageSize::new(16, 12).unwrap();
    let mut recorder = Recorder::new(size, RecorderOptions::new().lines(6)).unwrap();
    for frame in 0..10 {
        let mut mask = vec![0; size.pixels()];
        for y in 3..8 {
            mask[y * 16 + frame..y * 16 + frame + 4].fill(1);
        }
        recorder.push(&mask, frame as f64 / 25.0).unwrap();
    }
    let mut recording = SavedRecording::from(recorder.finish().unwrap());
    recording.name = "hall".into();
    recording.warnings = vec!["dark".into()];
    recording
}

/// A calibration of which most is left out, so that the file is small.
fn small_calibration() -> epibar::Calibration {
    let [a, b] = Scene::new(5, 200, 1).recordings(300);
    let options = CalibrateOptions::new().method(Method::Lines).draws(200).candidates(50);
    let mut found = epibar::calibrate(&a, &b, &options).unwrap();
    found.candidates.truncate(3);
    found.frontier_points.truncate(3);
    found.shift_curve.truncate(5);
    found.rivals.truncate(1);
    found.error_maps = None;
    found
}

fn zipped(save: impl FnOnce(&Path) -> epibar::Result<()>) -> Vec<u8> {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("seed.npz");
    save(&path).unwrap();
    fs::read(path).unwrap()
}

/// As `fuzzed::files` reads it.
fn list(arrays: &Arrays, names: &[&str]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (name, data) in arrays {
        let index = names.iter().position(|known| known == name).expect("a name that is listed");
        let data = if name == "header" { text_of(data) } else { data.clone() };
        bytes.push(index as u8);
        bytes.extend(u16::try_from(data.len()).expect("a small array").to_le_bytes());
        bytes.extend(data);
    }
    bytes
}

fn text_of(array: &[u8]) -> Vec<u8> {
    let start = 10 + usize::from(u16::from_le_bytes([array[8], array[9]]));
    let characters = array[start..].as_chunks().0.iter().map(|&c| u32::from_le_bytes(c));
    characters.filter_map(char::from_u32).filter(|&c| c != '\0').collect::<String>().into_bytes()
}
