//! One more camera for a network that stands.

mod common;

use common::cameras::Camera;
use common::flying::Scene;
use common::ring::{self, FRAMES, cameras, stored};
use epibar::nalgebra::Rotation3;
use epibar::network::{
    Added, CameraInput, CameraStatus, Expected, Knowledge, Offsets, PairFound, PairStatus, StoredCamera,
    add_cameras, pairs_to_add,
};
use epibar::{RecorderOptions, Recording, Unwatched};

fn recorded(scene: &Scene, camera: &Camera, moment: impl Fn(usize) -> f64) -> Recording {
    ring::recorded(scene, camera, RecorderOptions::new().lines(50), moment)
}

/// The true geometry of a pair, as a search that went well brings it.
fn pair(a: usize, b: usize, cameras: &[Camera]) -> PairFound {
    let geometry = common::cameras::fundamental_matrix(&cameras[a], &cameras[b]);
    PairFound::new(a, b, vec![(geometry, 1.0)]).unwrap().verdict(9.0, true)
}

/// Adds the fourth camera, which saw what it is told to see, to the three others; two of its pairs were searched.
fn added(new: &Recording, scene: &Scene, expected: Expected, known: Knowledge) -> Added {
    let cameras = cameras();
    let recordings: Vec<Recording> = cameras[..3].iter().map(|c| recorded(scene, c, |f| f as f64)).collect();
    let stored = stored(&cameras, &recordings, expected);
    let input = CameraInput::new("cam9", new).known(known);
    let pairs = [pair(0, 3, &cameras), pair(1, 3, &cameras)];
    let clocks = Offsets::found(vec![0.0; 4]);
    add_cameras(&stored, &[input], &pairs, &clocks, &mut Unwatched).unwrap()
}

fn exact() -> Expected {
    Expected::new(0.0, 0.0, 0.0)
}

#[test]
fn a_new_camera_stands_in_the_world_of_the_network() {
    let (scene, truth) = (Scene::new(5, FRAMES, 31), &cameras()[3]);
    let late = recorded(&scene, truth, |f| f as f64 - 1.5);
    let found = added(&late, &scene, exact(), Knowledge::new());
    let camera = &found.cameras[0];
    assert!(camera.accepted(), "{}", camera.reason);
    let turned = Rotation3::from_matrix_unchecked(camera.rotation().unwrap() * truth.rotation().transpose());
    let off = (camera.position().unwrap() - truth.centre()).norm();
    let focal = camera.matrix().unwrap().m11 / truth.matrix().m11 - 1.0;
    let stated = camera.expected.unwrap();
    assert!(turned.angle() < stated.rotation && stated.rotation.to_degrees() < 1.0, "{}", turned.angle());
    assert!(off < stated.position && stated.position < 0.2, "{off} {stated:?}");
    assert!(focal.abs() < stated.focal && stated.focal < 0.02, "{focal} {stated:?}");
    let (offset, _) = camera.clock().unwrap();
    assert!((offset - 0.06).abs() < 0.004 && camera.offset_error < 0.01, "{offset}");
    let pairs: Vec<_> = found.pairs.iter().map(|p| (p.a, p.b, p.status, p.accepted)).collect();
    let confirmed = PairStatus::Confirmed;
    assert_eq!(pairs, [(0, 3, confirmed, true), (1, 3, confirmed, true), (2, 3, confirmed, true)]);

    // What is stored is uncertain itself, and a given focal length is not.
    let unsure = Expected::new(0.01, 0.01, 0.3);
    let known = added(&late, &scene, unsure, Knowledge::new().matrix(truth.matrix()));
    let camera = &known.cameras[0];
    let stated = camera.expected.unwrap();
    assert!(stated.rotation > 0.01 && stated.position > 0.3 && stated.focal == 0.0, "{stated:?}");
    let useless = added(&late, &scene, Expected::new(0.01, 0.01, f64::NAN), Knowledge::new());
    assert_eq!(useless.cameras[0].status, CameraStatus::Position, "{}", useless.cameras[0].reason);
    assert!(!useless.pairs.iter().any(|p| p.accepted));
}

#[test]
fn a_stranger_is_refused_and_so_is_one_that_ran_backwards() {
    let (scene, other) = (Scene::new(5, FRAMES, 32), Scene::new(5, FRAMES, 4321));
    let camera = &cameras()[3];
    let stranger = recorded(&other, camera, |f| f as f64);
    let backwards = recorded(&scene, camera, |f| (FRAMES - 1 - f) as f64);
    for new in [stranger, backwards] {
        let found = added(&new, &scene, exact(), Knowledge::new());
        let camera = &found.cameras[0];
        assert_eq!(camera.status, CameraStatus::NothingInCommon, "{}", camera.reason);
        assert!(!camera.stands() && camera.reason.starts_with("left out"));
        assert!(found.pairs.iter().all(|p| p.status == PairStatus::Outside && !p.accepted));
    }
}

#[test]
fn what_cannot_be_added_to_is_refused() {
    let (scene, cameras) = (Scene::new(2, FRAMES, 33), cameras());
    let recordings: Vec<Recording> = cameras.iter().map(|c| recorded(&scene, c, |f| f as f64)).collect();
    let held = stored(&cameras[..3], &recordings, exact());
    let input = |name| CameraInput::new(name, &recordings[3]);
    let of = |stored: &[StoredCamera], new: CameraInput, pairs: &[PairFound], seconds: &[f64]| {
        let clocks = Offsets::found(seconds.to_vec());
        add_cameras(stored, &[new], pairs, &clocks, &mut Unwatched).unwrap_err().to_string()
    };
    assert!(of(&held[..1], input("new"), &[], &[0.0; 2]).contains("at least two"));
    assert!(of(&held, input("cam2"), &[], &[0.0; 4]).contains("differ"));
    assert!(of(&held, input("new"), &[], &[0.0; 3]).contains("clock for each"));
    assert!(of(&held, input("new"), &[], &[0.0, f64::NAN, 0.0, 0.0]).contains("every stored camera"));
    assert!(
        add_cameras(
            &held[..2],
            &[input("new")],
            &[pair(0, 3, &cameras)],
            &Offsets::found(vec![0.0; 3]),
            &mut Unwatched
        )
        .is_err()
    );
    let films: Vec<&Recording> = recordings.iter().collect();
    let offsets = Offsets::found(vec![0.0; 4]);
    assert_eq!(pairs_to_add(&films, 3, &offsets).unwrap(), [(0, 3), (1, 3), (2, 3)]);
    assert!(pairs_to_add(&films, 3, &Offsets::found(vec![0.0])).is_err());
    // Nothing tells when it was started.
    let lost = Offsets::found(vec![0.0, 0.0, 0.0, f64::NAN]);
    assert!(pairs_to_add(&films, 3, &lost).unwrap().is_empty());
    let found = add_cameras(&held, &[input("new")], &[], &lost, &mut Unwatched).unwrap();
    assert_eq!(found.cameras[0].status, CameraStatus::NothingInCommon);
}
