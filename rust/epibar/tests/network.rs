//! Networks of cameras of which nothing is known.

mod common;

use common::cameras::Camera;
use common::flying::Scene;
use common::ring::{self, FRAMES, NAMES, cameras};
use epibar::network::{
    CameraCheck, CameraInput, CameraStatus, CheckStatus, Expected, Ground, Knowledge, Network,
    NetworkOptions, NetworkTime, Offsets, PairFound, PairStatus, calibrate_network, check_network, join,
    pairs_to_search,
};
use epibar::{RecorderOptions, Recording, Unwatched};
use nalgebra::{Matrix3, Rotation3};

/// What a camera whose clock is late by so many frames sees.
fn recorded(scene: &Scene, camera: &Camera, late: f64, seed: u64) -> Recording {
    let options = RecorderOptions::new().lines(2500).seed(seed);
    ring::recorded(scene, camera, options, |frame| frame as f64 - late)
}

fn network(recordings: &[Recording], known: &[Knowledge], time: NetworkTime) -> Network {
    let inputs: Vec<CameraInput> = recordings
        .iter()
        .zip(NAMES)
        .enumerate()
        .map(|(i, (recording, name))| {
            CameraInput::new(name, recording).known(known.get(i).copied().unwrap_or_default())
        })
        .collect();
    calibrate_network(&inputs, &NetworkOptions::new().time(time)).unwrap()
}

fn angle(r: &Matrix3<f64>) -> f64 {
    Rotation3::from_matrix_unchecked(*r).angle().to_degrees()
}

/// The largest error of a rotation between two accepted cameras, degrees, and of a focal length, relative.
fn errors(network: &Network, cameras: &[Camera]) -> (f64, f64) {
    let (mut turned, mut focal) = (0.0f64, 0.0f64);
    let stand = || network.cameras.iter().zip(cameras).filter(|(found, _)| found.accepted());
    for (a, true_a) in stand() {
        focal = focal.max((a.matrix().unwrap().m11 / true_a.matrix().m11 - 1.0).abs());
        for (b, true_b) in stand() {
            let found = b.rotation().unwrap() * a.rotation().unwrap().transpose();
            let right = true_b.rotation() * true_a.rotation().transpose();
            turned = turned.max(angle(&(found * right.transpose())));
        }
    }
    (turned, focal)
}

#[test]
fn four_unknown_cameras_with_clocks_of_their_own() {
    let scene = Scene::new(5, FRAMES, 7);
    let cameras = cameras();
    let late = [0.0, 31.0, -12.0, 5.5];
    let recordings: Vec<Recording> = cameras
        .iter()
        .zip(late)
        .enumerate()
        .map(|(i, (c, late))| recorded(&scene, c, late, i as u64))
        .collect();
    let network = network(&recordings, &[], NetworkTime::Search { seconds: 3.0 });
    assert!(network.accepted, "{}", network.reason);
    let (turned, focal) = errors(&network, &cameras);
    assert!(turned < 0.6 && focal < 0.02, "{turned} degrees, {focal}");
    for (camera, late) in network.cameras.iter().zip(late) {
        let (offset, _) = camera.clock().unwrap();
        assert!((offset - late / 25.0).abs() < 0.004, "{}: {offset}", camera.name);
        let expected = camera.expected.unwrap();
        assert!(expected.focal > 1e-4 && expected.focal < 0.05 && expected.rotation.to_degrees() < 2.0);
    }
    assert_eq!(network.ground, Ground::Cameras, "boxes that fly stand on no floor");
    for pair in &network.pairs {
        assert!(pair.accepted && pair.status == PairStatus::Confirmed);
        let (a, b) = (&cameras[pair.a], &cameras[pair.b]);
        // Undistorted pixels of the network's own matrices, which are those of the cameras to a percent.
        let point = nalgebra::Vector3::new(0.1, 0.2, 1.3);
        let (p, q) = (a.project(&point).unwrap(), b.project(&point).unwrap());
        let line = pair.fundamental.unwrap() * nalgebra::Vector3::new(p[0], p[1], 1.0);
        let distance = (line.x * q[0] + line.y * q[1] + line.z).abs() / line.x.hypot(line.y);
        assert!(distance < 1.5, "{}-{}: {distance} px", pair.a, pair.b);
    }
    // The unit is the distance of the first two cameras, and up is up.
    let position = |i: usize| network.cameras[i].position().unwrap();
    assert!(((position(0) - position(1)).norm() - 1.0).abs() < 1e-9);
    for (found, camera) in network.cameras.iter().zip(&cameras) {
        let up = found.rotation().unwrap().column(2).into_owned();
        let right = camera.rotation().column(2).into_owned();
        assert!(up.angle(&right).to_degrees() < 12.0);
    }
}

#[test]
fn a_camera_that_sees_something_else_is_named_and_the_others_are_right() {
    let (scene, other) = (Scene::new(5, FRAMES, 8), Scene::new(5, FRAMES, 1234));
    let cameras = cameras();
    let mut recordings: Vec<Recording> =
        cameras.iter().enumerate().map(|(i, c)| recorded(&scene, c, 0.0, i as u64)).collect();
    recordings[1] = recorded(&other, &cameras[1], 0.0, 1);
    let network = network(&recordings, &[], NetworkTime::Known(vec![0.0; 4]));
    let status: Vec<CameraStatus> = network.cameras.iter().map(|c| c.status).collect();
    let words: Vec<&str> = network.cameras.iter().map(|c| c.reason.as_str()).collect();
    assert!(!network.accepted && network.reason.contains("cam2"), "{} {words:#?}", network.reason);
    assert_eq!(status[1], CameraStatus::NothingInCommon);
    assert!(network.cameras[1].rotation().is_none() && network.cameras[1].reason.contains("left out"));
    assert!([0, 2, 3].iter().all(|&i| status[i] == CameraStatus::Accepted), "{status:?}");
    let (turned, focal) = errors(&network, &cameras);
    assert!(turned < 0.8 && focal < 0.03, "{turned} degrees, {focal}");
    assert!(network.pairs.iter().all(|p| p.accepted == (p.a != 1 && p.b != 1)));
}

#[test]
fn one_film_by_two_names_has_no_epipolar_geometry() {
    let scene = Scene::new(5, FRAMES, 7);
    let mut recordings: Vec<Recording> =
        cameras()[..3].iter().map(|camera| recorded(&scene, camera, 0.0, 1)).collect();
    recordings.push(recordings[1].clone());
    let network = network(&recordings, &[], NetworkTime::Known(vec![0.0; 4]));
    assert!(network.accepted, "{}", network.reason);
    for pair in &network.pairs {
        let together = (pair.a, pair.b) == (1, 3);
        assert_eq!(pair.accepted, !together, "{pair:?}");
        assert_eq!(pair.status == PairStatus::NoBaseline, together, "{pair:?}");
    }
    assert!(
        network.reason.contains(&format!("by two names: {}-{}", NAMES[1], NAMES[3])),
        "{}",
        network.reason
    );
}

#[test]
fn cameras_that_never_filmed_together_are_no_pair_to_search() {
    let scene = Scene::new(3, FRAMES, 1);
    let recordings: Vec<Recording> = cameras()[..3].iter().map(|c| recorded(&scene, c, 0.0, 1)).collect();
    let searched = |seconds: [f64; 3]| {
        let recordings: Vec<&Recording> = recordings.iter().collect();
        pairs_to_search(&recordings, &Offsets::given(seconds.to_vec())).unwrap()
    };
    // A recording lasts 10.36 s.
    assert_eq!(searched([0.0, 10.0, -10.0]), [(0, 1), (0, 2)]);
    assert_eq!(searched([0.0, 11.0, 12.0]), [(1, 2)]);
    assert_eq!(searched([0.0, f64::NAN, 0.0]), [(0, 2)]);
}

#[test]
fn two_cameras_need_to_be_known() {
    let scene = Scene::new(5, FRAMES, 9);
    let cameras = &cameras()[..2];
    let recordings: Vec<Recording> =
        cameras.iter().enumerate().map(|(i, c)| recorded(&scene, c, 0.0, i as u64)).collect();
    let time = || NetworkTime::Known(vec![0.0; 2]);
    let unknown = network(&recordings, &[], time());
    assert!(!unknown.accepted && unknown.reason.contains("intrinsics"), "{}", unknown.reason);
    assert!(unknown.cameras.iter().all(|c| c.status == CameraStatus::TooFew && !c.stands()));

    let known: Vec<Knowledge> = cameras.iter().map(|c| Knowledge::new().matrix(c.matrix())).collect();
    let known = network(&recordings, &known, time());
    assert!(known.accepted, "{}", known.reason);
    assert!(errors(&known, cameras).0 < 0.3);
    assert!((known.cameras[0].matrix().unwrap() - cameras[0].matrix()).norm() < 1e-9);
    assert_eq!(known.cameras[0].expected.unwrap().focal, 0.0);
    // Nobody found it to be right.
    let said = &known.cameras[0].reason;
    assert!(
        said.contains("with the focal length that is given") && !said.contains("focal length is right"),
        "{said}"
    );
}

#[test]
fn two_known_cameras_are_tried_together_before_an_offset_is_searched_for() {
    let scene = Scene::new(5, FRAMES, 9);
    let cameras = &cameras()[..2];
    let known: Vec<Knowledge> = cameras.iter().map(|c| Knowledge::new().matrix(c.matrix())).collect();
    for late in [0.0, 31.0] {
        let recordings = [recorded(&scene, &cameras[0], 0.0, 0), recorded(&scene, &cameras[1], late, 1)];
        let found = network(&recordings, &known, NetworkTime::Search { seconds: 3.0 });
        assert!(found.accepted, "{late}: {}", found.reason);
        assert!(errors(&found, cameras).0 < 0.3, "{late}");
        let offset = found.cameras[1].clock().unwrap().0;
        assert!((offset - late * recordings[1].frame_interval()).abs() < 0.02, "{late}: {offset}");
    }
    let recordings = [recorded(&scene, &cameras[0], 0.0, 0), recorded(&scene, &cameras[1], 0.0, 1)];
    let unknown = network(&recordings, &[], NetworkTime::Search { seconds: 3.0 });
    assert!(unknown.cameras.iter().all(|c| c.status == CameraStatus::TooFew), "{}", unknown.reason);
}

#[test]
fn a_false_focal_length_is_named_and_the_others_stand() {
    let scene = Scene::new(5, FRAMES, 7);
    let cameras = cameras();
    let recordings: Vec<Recording> =
        cameras.iter().enumerate().map(|(i, c)| recorded(&scene, c, 0.0, i as u64)).collect();
    let mut known: Vec<Knowledge> = cameras.iter().map(|c| Knowledge::new().matrix(c.matrix())).collect();
    known[2] = Knowledge::new().matrix(cameras[2].clone().zoomed(1.15).matrix());
    let found = network(&recordings, &known, NetworkTime::Known(vec![0.0; 4]));
    let status: Vec<CameraStatus> = found.cameras.iter().map(|c| c.status).collect();
    let (right, wrong) = (CameraStatus::Accepted, CameraStatus::Contradicted);
    assert_eq!(status, [right, right, wrong, right], "{}", found.reason);
    assert!(errors(&found, &cameras).0 < 0.3);
    let refused = &found.cameras[2];
    assert!(refused.reason.contains("the focal length that is given, 299.0 px"), "{}", refused.reason);
    let focal = refused.matrix().unwrap().m11;
    assert!((focal / 260.0 - 1.0).abs() < 0.02, "{focal}");
}

#[test]
fn what_cannot_be_is_refused() {
    let scene = Scene::new(2, FRAMES, 3);
    let recording = recorded(&scene, &cameras()[0], 0.0, 0);
    let input = |name, known| CameraInput::new(name, &recording).known(known);
    let unknown = Knowledge::default();
    let of = |inputs: &[CameraInput], time| {
        calibrate_network(inputs, &NetworkOptions::new().time(time)).unwrap_err().to_string()
    };
    let search = || NetworkTime::Search { seconds: 2.0 };
    assert!(of(&[input("a", unknown)], search()).contains("at least two"));
    assert!(of(&[input("a", unknown), input("a", unknown)], search()).contains("differ"));
    let both = [input("a", unknown), input("b", unknown)];
    assert!(of(&both, NetworkTime::Known(vec![0.0])).contains("each camera"));
    assert!(of(&both, NetworkTime::Known(vec![0.0, f64::NAN])).contains("finite"));
    assert!(of(&both, NetworkTime::Search { seconds: f64::NAN }).contains("positive"));
    for known in [
        unknown.matrix(Matrix3::zeros()),
        unknown.distortions([f64::NAN, 0.0, 0.0, 0.0, 0.0]),
        unknown.focal(-5.0, 0.1),
        unknown.principal([f64::INFINITY, 0.0]),
    ] {
        of(&[input("a", known), input("b", unknown)], search());
    }

    let geometry = || vec![(Matrix3::identity(), 1.0)];
    assert!(PairFound::new(1, 1, geometry()).unwrap_err().to_string().contains("smaller"));
    assert!(PairFound::new(0, 1, Vec::new()).unwrap_err().to_string().contains("geometry"));
    let join = |pairs: &[PairFound], seconds: &[f64]| {
        join(&both, pairs, &Offsets::given(seconds.to_vec()), &mut Unwatched).unwrap_err().to_string()
    };
    assert!(join(&[PairFound::new(0, 2, geometry()).unwrap()], &[0.0; 2]).contains("0, 2"));
    assert!(join(&[], &[0.0]).contains("clock for each"));
    let one = pairs_to_search(&both.map(|input| input.recording), &Offsets::given(vec![0.0]));
    assert!(one.unwrap_err().to_string().contains("each camera"));
}

/// New footage of cameras, checked against where they are stored to be.
fn checked(filmed: &[Camera], stored: &[Camera], seed: u64) -> Vec<CameraCheck> {
    let scene = Scene::new(5, FRAMES, seed);
    let recordings: Vec<Recording> =
        filmed.iter().enumerate().map(|(i, c)| recorded(&scene, c, 0.0, i as u64)).collect();
    let stored = ring::stored(stored, &recordings, Expected::new(0.001, 0.001, 0.01));
    check_network(&stored, &Offsets::given(vec![0.0; filmed.len()]), &mut |_, _| true).unwrap()
}

#[test]
fn a_camera_that_was_turned_is_named() {
    let stored = cameras();
    let turned = Rotation3::new(nalgebra::Vector3::new(0.3, 1.0, 0.2).normalize() * 1f64.to_radians());
    let mut filmed = stored.clone();
    filmed[2] = filmed[2].clone().turned(&turned);
    let found = checked(&filmed, &stored, 21);
    let status: Vec<CheckStatus> = found.iter().map(|c| c.status).collect();
    let unmoved = CheckStatus::Unmoved;
    assert_eq!(status, [unmoved, unmoved, CheckStatus::Moved, unmoved], "{found:#?}");
    assert!((found[2].turned.to_degrees() - 1.0).abs() < 0.15, "{:#?}", found[2]);
    assert!(found[2].shifted < 0.1 && found[2].reason.contains("turned"));

    let found = checked(&stored, &stored, 22);
    assert!(found.iter().all(|c| c.status == unmoved), "{found:#?}");
}

#[test]
fn a_zoom_that_was_touched_is_no_turn() {
    let stored = cameras();
    let mut filmed = stored.clone();
    filmed[1] = filmed[1].clone().zoomed(1.03);
    let found = checked(&filmed, &stored, 23);
    let status: Vec<CheckStatus> = found.iter().map(|c| c.status).collect();
    let unmoved = CheckStatus::Unmoved;
    assert_eq!(status, [unmoved, CheckStatus::Moved, unmoved, unmoved], "{found:#?}");
    let zoomed = &found[1];
    assert!((zoomed.focal - 0.03).abs() < 0.006 && zoomed.focal_error < 0.01, "{zoomed:#?}");
    let alone = zoomed.reason.contains("was zoomed") && zoomed.reason.contains("stands and looks as stored");
    assert!(alone, "{zoomed:#?}");
    let place = zoomed.place.as_ref().expect("three cameras that stand confirm it");
    assert!(place.zoomed && !place.reposed);
    assert!((place.matrix.m11 / stored[1].matrix().m11 - 1.0 - zoomed.focal).abs() < 1e-9);
    assert_eq!(place.rotation, stored[1].rotation());
}

#[test]
fn where_a_camera_stands_now() {
    let stored = cameras();
    let turned = Rotation3::new(nalgebra::Vector3::new(1.0, -0.4, 0.2).normalize() * 2f64.to_radians());
    let mut filmed = stored.clone();
    filmed[0] = filmed[0].clone().turned(&turned);
    let found = checked(&filmed, &stored, 24);
    let place = found[0].place.as_ref().unwrap_or_else(|| panic!("{found:#?}"));
    assert!(place.reposed && !place.zoomed && found[1..].iter().all(|c| c.place.is_none()));
    let off = angle(&(place.rotation * filmed[0].rotation().transpose()));
    assert!(off < 0.15 && place.expected.rotation.to_degrees() < 0.3, "{off} {place:#?}");
    assert_eq!(place.expected.focal, 0.0);
    assert_eq!(place.pairs.iter().map(|(other, _)| *other).collect::<Vec<_>>(), [1, 2, 3]);
    // Of two cameras nobody can say how far apart they stand now.
    let found = checked(&filmed[..2], &stored[..2], 24);
    assert!(found.iter().all(|c| c.place.is_none()), "{found:#?}");
    // Nor which of them moved.
    let groups: Vec<(CheckStatus, &[usize])> = found.iter().map(|c| (c.status, &c.rivals[..])).collect();
    assert_eq!(groups, [(CheckStatus::Suspect, &[1][..]), (CheckStatus::Suspect, &[0][..])], "{found:#?}");
}

#[test]
fn of_two_cameras_nothing_tells_how_far_apart_they_are() {
    let stored = cameras();
    let found = checked(&stored[..2], &stored[..2], 25);
    for camera in &found {
        assert_eq!(camera.status, CheckStatus::Unmoved, "{camera:#?}");
        assert!(
            camera.turned_error.to_degrees() < 0.5 && camera.shifted_error == f64::INFINITY,
            "{camera:#?}"
        );
        assert!(camera.reason.contains("not a shift along the line"), "{camera:#?}");
    }
    let found = checked(&stored[..3], &stored[..3], 25);
    for camera in &found {
        assert!(camera.shifted_error < 0.2 && !camera.reason.contains("along the line"), "{camera:#?}");
    }
}
