//! Networks in which a camera was turned while it filmed, where nobody moves for some of the time; and two cameras alone.

mod common;

use std::ops::Range;

use common::cameras::{Camera, fundamental_matrix};
use common::flying::Scene;
use common::ring::{self, NAMES, cameras};
use epibar::network::{
    CameraCheck, CameraInput, CameraStatus, CheckStatus, Expected, Knowledge, Network, Offsets, PairFound,
    check_network, join,
};
use epibar::{Recorder, RecorderOptions, Recording, Unwatched};
use nalgebra::{Rotation3, Vector3};

/// Frames of the scene in which something moves, at 25 a second.
const MOVING: usize = 300;
/// Frames in which nothing does.
const IDLE: usize = 300;

/// What a camera films that looks another way from some frame on, where things move in some frames only, of which it shows some.
fn filmed(
    [before, after]: [&Camera; 2],
    turned_at: usize,
    moving: &Range<usize>,
    shown: &Range<usize>,
    frames: usize,
) -> Recording {
    let scene = Scene::new(5, MOVING, 21);
    let options = RecorderOptions::new().lines(600).seed(before.size.width() as u64);
    let mut recorder = Recorder::new(before.size, options).unwrap();
    for frame in 0..frames {
        let camera = if frame < turned_at { before } else { after };
        let mask = if moving.contains(&frame) && shown.contains(&frame) {
            scene.seen_by(camera, (frame - moving.start) as f64)
        } else {
            vec![0; camera.size.pixels()]
        };
        recorder.push(&mask, frame as f64 / 25.0).unwrap();
    }
    recorder.finish().unwrap()
}

/// What all film, the third turned by some degrees from a frame on.
fn all_filmed(degrees: f64, turned_at: usize, moving: &Range<usize>, frames: usize) -> Vec<Recording> {
    all_filmed_but(degrees, turned_at, moving, moving, frames)
}

/// What all film as in [`all_filmed`], and the third shows a part of what moves.
fn all_filmed_but(
    degrees: f64,
    turned_at: usize,
    moving: &Range<usize>,
    shown: &Range<usize>,
    frames: usize,
) -> Vec<Recording> {
    let turn = Rotation3::new(Vector3::new(0.3, 1.0, 0.2).normalize() * degrees.to_radians());
    let film = |(c, camera): (usize, Camera)| {
        let after = if c == 2 { camera.clone().turned(&turn) } else { camera.clone() };
        filmed([&camera, &after], turned_at, moving, if c == 2 { shown } else { moving }, frames)
    };
    cameras().into_iter().enumerate().map(film).collect()
}

fn checked(recordings: &[Recording]) -> Vec<CameraCheck> {
    let stored = ring::stored(&cameras(), recordings, Expected::new(0.001, 0.001, 0.01));
    check_network(&stored, &Offsets::given(vec![0.0; 4]), &mut Unwatched).unwrap()
}

/// The network of cameras whose matrices are known, and the true geometries of whose pairs were accepted or not.
fn joined(recordings: &[Recording], accepted: bool) -> Network {
    let cameras = &cameras()[..recordings.len()];
    let inputs: Vec<CameraInput> = (0..cameras.len())
        .map(|c| {
            CameraInput::new(NAMES[c], &recordings[c]).known(Knowledge::new().matrix(cameras[c].matrix()))
        })
        .collect();
    let mut pairs = Vec::new();
    for b in 0..cameras.len() {
        for a in 0..b {
            let geometry = fundamental_matrix(&cameras[a], &cameras[b]);
            pairs.push(PairFound::new(a, b, vec![(geometry, 1.0)]).unwrap().verdict(8.0, accepted));
        }
    }
    join(&inputs, &pairs, &Offsets::given(vec![0.0; cameras.len()]), &mut Unwatched).unwrap()
}

#[test]
fn a_camera_that_moved_is_found_though_nobody_moves_in_the_end() {
    let found = checked(&all_filmed(1.5, 150, &(0..MOVING), MOVING + IDLE));
    let status: Vec<CheckStatus> = found.iter().map(|c| c.status).collect();
    let unmoved = CheckStatus::Unmoved;
    assert_eq!(status, [unmoved, unmoved, CheckStatus::Moved, unmoved], "{found:#?}");
    let since = found[2].since.expect("it was filmed");
    assert!((since - 6.0).abs() < 1.0, "{since} s, {}", found[2].reason);
}

#[test]
fn when_a_camera_moved_is_told_in_seconds_of_its_film_though_nobody_moves_at_first() {
    let found = checked(&all_filmed(1.5, IDLE + 150, &(IDLE..IDLE + MOVING), IDLE + MOVING));
    assert_eq!(found[2].status, CheckStatus::Moved, "{found:#?}");
    let since = found[2].since.expect("it was filmed");
    assert!((since - 18.0).abs() < 1.0, "{since} s, {}", found[2].reason);
}

#[test]
fn a_camera_that_sees_anything_for_a_part_of_the_time_is_found_too() {
    let found = checked(&all_filmed_but(1.5, 0, &(0..MOVING), &(180..MOVING), MOVING));
    let status: Vec<CheckStatus> = found.iter().map(|c| c.status).collect();
    let unmoved = CheckStatus::Unmoved;
    assert_eq!(status, [unmoved, unmoved, CheckStatus::Moved, unmoved], "{found:#?}");
    assert_eq!(found[2].since, None, "{}", found[2].reason);
}

#[test]
fn a_knock_is_told_in_seconds_of_the_film_though_nobody_moves_at_first_or_in_the_end() {
    for (first, last, seconds) in [(IDLE, 0, 18.0), (0, IDLE, 6.0)] {
        let recordings = all_filmed(4.0, first + 150, &(first..first + MOVING), first + MOVING + last);
        let found = joined(&recordings, true);
        let status: Vec<CameraStatus> = found.cameras.iter().map(|c| c.status).collect();
        assert_eq!(status[2], CameraStatus::Knocked, "{status:?} {}", found.reason);
        assert!([0, 1, 3].iter().all(|&c| status[c] == CameraStatus::Accepted), "{status:?}");
        let reason = &found.cameras[2].reason;
        let stated: f64 = reason.split("about ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!((stated - seconds).abs() < 1.6, "{reason}");
    }
}

#[test]
fn of_two_cameras_alone_their_pair_is_to_be_accepted() {
    let recordings = &all_filmed(0.0, 0, &(0..MOVING), MOVING)[..2];
    assert!(joined(recordings, true).accepted);
    let found = joined(recordings, false);
    assert!(!found.accepted);
    for camera in &found.cameras {
        assert_eq!(camera.status, CameraStatus::PairRefused, "{}", camera.reason);
        assert!(camera.stands() && camera.reason.contains("nothing but their pair"), "{}", camera.reason);
    }
}
