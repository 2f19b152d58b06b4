//! Recordings and calibrations in files: they come back as they were, and what is no such file is refused.

mod common;

use std::path::{Path, PathBuf};

use common::flying::Scene;
use epibar::{
    CalibrateOptions, Calibration, Error, Method, Recorder, RecorderOptions, Recording, SavedRecording,
    calibrate,
};
use nalgebra::Matrix3;

/// A file of this test, in a folder that the build throws away.
fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn refused<T: std::fmt::Debug>(result: epibar::Result<T>, words: &str) {
    let error = result.unwrap_err();
    assert!(matches!(error, Error::File { .. }) && error.to_string().contains(words), "{error}");
}

/// With a hidden corner.
fn recording() -> Recording {
    let scene = Scene::new(3, 1, 5);
    let size = scene.cameras[0].size;
    let recorder = Recorder::new(size, RecorderOptions::new().lines(150).seed(u64::MAX)).unwrap();
    let mut visible = vec![1; size.pixels()];
    visible[0] = 0;
    let mut recorder = recorder.with_visible(&visible).unwrap();
    for frame in 0..70 {
        recorder.push(&scene.mask(0, frame), frame as f64 / 29.97).unwrap();
    }
    recorder.finish().unwrap()
}

#[test]
fn a_recording_comes_back_as_it_was() {
    let (recording, path) = (recording(), file("recording.npz"));
    recording.save(&path).unwrap();
    assert_eq!(Recording::load(&path).unwrap(), recording);

    let mut saved = SavedRecording::from(recording);
    saved.name = "Küche 2".into();
    saved.warnings = vec!["it was dark".into(), String::new()];
    saved.matrix = Some(Matrix3::new(500.0, 0.5, 160.0, 0.0, 510.0, 120.0, 0.0, 0.0, 1.0));
    saved.health = vec![("flicker".into(), 0.1), ("shift_px".into(), 2.5)];
    saved.first_frame = 42;
    saved.save(&path).unwrap();
    assert_eq!(SavedRecording::load(&path).unwrap(), saved);
    saved.pixel_aspect = Some(16.0 / 11.0);
    saved.matrix = Some(Matrix3::new(500.0, 0.0, 160.0, 0.0, 510.0, 120.0, 0.0, 0.0, 1.0));
    for (distortions, fisheye) in
        [(vec![-0.3, 0.1, 1e-4, 0.0, -0.02], false), (vec![0.01, 0.0, 0.0, 0.0], true)]
    {
        saved.distortions = Some(distortions);
        saved.fisheye = fisheye;
        saved.save(&path).unwrap();
        assert_eq!(SavedRecording::load(&path).unwrap(), saved);
    }
}

#[test]
fn a_lens_that_none_has_is_refused() {
    let path = file("lens.npz");
    let mut saved = SavedRecording::from(recording());
    saved.matrix = Some(Matrix3::new(500.0, 0.0, 160.0, 0.0, 510.0, 120.0, 0.0, 0.0, 1.0));
    let mut refused = |distortions: &[f64], fisheye, aspect: f64| {
        saved.distortions = Some(distortions.to_vec());
        (saved.fisheye, saved.pixel_aspect) = (fisheye, Some(aspect));
        saved.save(&path).unwrap();
        SavedRecording::load(&path).unwrap_err().to_string()
    };
    assert!(refused(&[0.1; 3], false, 1.0).contains("3 distortions"));
    assert!(refused(&[0.1; 5], true, 1.0).contains("5 distortions"));
    assert!(refused(&[0.1, f64::NAN, 0.0, 0.0], false, 1.0).contains("distortions"));
    for aspect in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(refused(&[0.1; 5], false, aspect).contains("pixel_aspect"));
    }
    (saved.pixel_aspect, saved.matrix.as_mut().unwrap().m12) = (None, 0.5);
    saved.save(&path).unwrap();
    assert!(SavedRecording::load(&path).unwrap_err().to_string().contains("skew"));
}

fn matrix(f: Option<epibar::Fundamental>) -> Option<Matrix3<f64>> {
    f.map(|f| *f.matrix())
}

/// Everything of two calibrations is equal, bit for bit.
fn assert_equal(found: &Calibration, expected: &Calibration) {
    assert_eq!(matrix(found.fundamental), matrix(expected.fundamental));
    assert_eq!(matrix(found.tested), matrix(expected.tested));
    // NaN is not equal to itself, but prints as it is; the epipoles of a saved matrix are found anew.
    let of = |c: &Calibration| {
        let rivals: Vec<_> =
            c.rivals.iter().map(|r| (*r.fundamental.matrix(), r.share, r.z, r.distance, r.source)).collect();
        let lines = (&c.candidates, &c.frontier_points, &c.floor, &c.shift_curve, &c.error_maps);
        let numbers =
            (&c.verdict, c.expected_error, &c.timing, &c.evidence, &c.counts, c.source, c.method, c.seed);
        format!("{rivals:?} {lines:?} {numbers:?}")
    };
    assert_eq!(of(found), of(expected));
}

#[test]
fn a_calibration_comes_back_as_it_was() {
    let scene = Scene::new(5, 200, 1);
    let [a, b] = scene.recordings(3000);
    let path = file("calibration.npz");
    for options in
        [CalibrateOptions::new().draws(1500), CalibrateOptions::new().method(Method::Lines).seed(7)]
    {
        let found = calibrate(&a, &b, &options).unwrap();
        assert!(found.fundamental.is_some() && !found.candidates.is_empty());
        found.save(&path).unwrap();
        assert_equal(&Calibration::load(&path).unwrap(), &found);
    }
    // A refusal holds next to nothing.
    let short = scene.record_frames(0, 200, 0..5);
    let found = calibrate(&short, &b, &CalibrateOptions::new()).unwrap();
    found.save(&path).unwrap();
    assert_equal(&Calibration::load(&path).unwrap(), &found);
    refused(Recording::load(&path), "not a recording saved by epibar");
}

#[test]
fn what_is_no_such_file_is_refused() {
    refused(Recording::load(file("nowhere.npz")), "nowhere.npz");
    let path = file("text.npz");
    std::fs::write(&path, "not an archive").unwrap();
    refused(Recording::load(&path), "damaged");
    refused(Calibration::load(&path), "damaged");
    let good = file("whole.npz");
    recording().save(&good).unwrap();
    refused(Calibration::load(&good), "not a calibration saved by epibar");
    // Cut off, and with a byte changed here and there: refused, or as it was.
    let bytes = std::fs::read(&good).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    refused(Recording::load(&path), "text.npz");
    let whole = Recording::load(&good).unwrap();
    for at in (0..bytes.len()).step_by(997) {
        let mut changed = bytes.clone();
        changed[at] ^= 0x55;
        std::fs::write(&path, &changed).unwrap();
        match Recording::load(&path) {
            Ok(same) => assert_eq!(same, whole, "byte {at}"),
            Err(error) => assert!(matches!(error, Error::File { .. }), "{error}"),
        }
    }
    refused(recording().save(file("no/such/folder/recording.npz")), "cannot be written");
}
