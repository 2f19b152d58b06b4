//! Recordings in which nobody moves for much of the time, or one camera films much faster than the other.

mod common;

use common::cameras::error;
use common::flying::Scene;
use epibar::{CalibrateOptions, Recorder, RecorderOptions, Recording, TimeOffset, calibrate};

/// Frames of the scene, at 25 a second.
const MOVING: usize = 240;

/// One camera before the scene, or before nothing where there is no moment.
fn filmed(scene: &Scene, camera: usize, fps: f64, moments: impl Iterator<Item = Option<f64>>) -> Recording {
    let size = scene.cameras[camera].size;
    let options = RecorderOptions::new().lines(3000).seed(camera as u64);
    let mut recorder = Recorder::new(size, options).unwrap();
    for (frame, moment) in moments.enumerate() {
        let mask = moment.map_or_else(|| vec![0; size.pixels()], |moment| scene.mask_at(camera, moment));
        recorder.push(&mask, frame as f64 / fps).unwrap();
    }
    recorder.finish().unwrap()
}

#[test]
fn that_nobody_moves_at_first_in_the_end_or_in_between_changes_nothing() {
    let scene = Scene::new(5, MOVING, 1);
    let all = || (0..MOVING).map(|k| Some(k as f64));
    let idle = |frames: usize| std::iter::repeat_n(None, frames);
    let both = |moments: &dyn Fn() -> Vec<Option<f64>>| {
        let [a, b] = [0, 1].map(|camera| filmed(&scene, camera, 25.0, moments().into_iter()));
        calibrate(&a, &b, &CalibrateOptions::new().draws(2500)).unwrap()
    };
    let plain = both(&|| all().collect());
    assert!(plain.verdict.accepted(), "{:?}", plain.verdict);
    let around = both(&|| idle(360).chain(all()).chain(idle(360)).collect());
    let between = both(&|| all().take(120).chain(idle(200)).chain(all().skip(120)).collect());
    for found in [around, between] {
        assert!(found.verdict.accepted(), "{:?}", found.verdict);
        assert!(error(&found.fundamental.unwrap(), &scene.cameras) < 0.3);
        // Nor is it the less sure for it.
        assert!(found.evidence.z > 0.7 * plain.evidence.z, "{} {}", found.evidence.z, plain.evidence.z);
        assert!(found.expected_error.unwrap() < 1.5 * plain.expected_error.unwrap());
    }
}

#[test]
fn an_offset_is_found_whichever_camera_films_four_times_as_fast() {
    let scene = Scene::new(5, 2400, 3);
    // The slow one starts 30 frames of the scene late.
    let fast = filmed(&scene, 0, 100.0, (0..9600).map(|k| Some(f64::from(k) / 4.0)));
    let slow = filmed(&scene, 1, 25.0, (0..2370).map(|k| Some(f64::from(k) + 30.0)));
    let search = CalibrateOptions::new().draws(2500).time_offset(TimeOffset::Search { seconds: 5.0 });
    let found = calibrate(&fast, &slow, &search).unwrap();
    assert!(found.verdict.accepted(), "{:?} {:?}", found.verdict, found.timing);
    assert!((found.timing.offset + 30.0).abs() < 0.2, "{:?}", found.timing);
}
