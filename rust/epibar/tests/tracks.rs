//! Walkers as tracks over cameras that are known.

mod common;

use common::cameras::{Camera, fundamental};
use common::flying::{fill, hull};
use common::ring;
use epibar::network::{PosedCamera, TrackPoint, TrackingCamera, walker_tracks};
use epibar::{Recorder, RecorderOptions, Recording, Unwatched, symmetric_epipolar_distance};
use nalgebra::{Matrix3, Vector3};

const FRAMES: usize = 200;
const FPS: f64 = 25.0;
const HEIGHTS: [f64; 4] = [1.62, 1.72, 1.78, 1.86];

/// A walker: a spheroid that stands on the floor, on a circle of its own.
fn place(walker: usize, seconds: f64) -> [f64; 2] {
    let (turn, radius) = ([0.5, -0.4, 0.6, -0.7][walker], [2.2, 1.5, 0.9, 2.9][walker]);
    let (sin, cos) = (turn * seconds + 1.7 * walker as f64).sin_cos();
    [radius * cos, radius * sin]
}

fn outline(camera: &Camera, walker: usize, seconds: f64) -> Option<Vec<[f64; 2]>> {
    let ([x, y], height) = (place(walker, seconds), HEIGHTS[walker]);
    let mut points = Vec::new();
    for ring in 0..=24 {
        let (sin, cos) = (std::f64::consts::PI * f64::from(ring) / 24.0).sin_cos();
        for spoke in 0..24 {
            let (s, c) = (std::f64::consts::TAU * f64::from(spoke) / 24.0).sin_cos();
            let point = Vector3::new(x + 0.22 * sin * c, y + 0.22 * sin * s, 0.5 * height * (1.0 - cos));
            points.push(camera.project(&point)?);
        }
    }
    Some(hull(points))
}

fn cameras() -> Vec<Camera> {
    [[7.0, -3.0, 2.6], [-3.0, -7.5, 1.8], [-6.5, 4.0, 3.0], [4.0, 6.5, 2.2]]
        .map(|position| Camera::new(position, [0.0, 0.0, 0.9], (480, 360), 380.0, 0.03))
        .to_vec()
}

/// What a camera films from `late` seconds on, of walkers that it can see.
fn recorded(camera: &Camera, late: f64, walkers: &[usize]) -> Recording {
    let mut recorder = Recorder::new(camera.size, RecorderOptions::new().lines(200)).unwrap();
    for frame in 0..FRAMES {
        let mut mask = vec![0; camera.size.pixels()];
        for &walker in walkers {
            if let Some(outline) = outline(camera, walker, frame as f64 / FPS + late) {
                fill(&mut mask, camera.size.width(), &outline);
            }
        }
        recorder.push(&mask, frame as f64 / FPS).unwrap();
    }
    recorder.finish().unwrap()
}

fn tracked(cameras: &[Camera], recordings: &[Recording], late: &[f64], scale: f64) -> Vec<TrackPoint> {
    let inputs: Vec<TrackingCamera> = cameras
        .iter()
        .zip(recordings)
        .zip(late)
        .map(|((camera, recording), late)| {
            let posed = ring::posed(camera);
            let scaled = PosedCamera { translation: posed.translation * scale, ..posed };
            TrackingCamera::new(recording, scaled).clock(-late, 0.0)
        })
        .collect();
    walker_tracks(&inputs, 1.75 * scale, &mut Unwatched).unwrap()
}

/// The walker at a place, which must be near; distance of the foot, of the top.
fn whose(point: &TrackPoint, seconds: f64, scale: f64) -> (usize, f64, f64) {
    let near = (0..HEIGHTS.len()).map(|walker| {
        let [x, y] = place(walker, seconds);
        let top = Vector3::from(point.top) / scale - Vector3::new(x, y, HEIGHTS[walker]);
        (walker, (point.foot[0] / scale - x).hypot(point.foot[1] / scale - y), top.norm())
    });
    near.min_by(|p, q| p.2.total_cmp(&q.2)).unwrap()
}

#[test]
fn walkers_are_followed_and_nobody_else() {
    let (cameras, late) = (cameras(), [0.0, 0.31, -0.2, 0.107]);
    let everybody = [0, 1, 2, 3];
    let recordings: Vec<Recording> =
        cameras.iter().zip(late).map(|(c, late)| recorded(c, late, &everybody)).collect();
    let points = tracked(&cameras, &recordings, &late, 1.0);
    let mut owners: Vec<Option<usize>> = vec![None; points.len()];
    let (mut feet, mut tops) = (Vec::new(), Vec::new());
    for point in &points {
        let (walker, foot, top) = whose(point, point.time, 1.0);
        // Where two are one silhouette in a camera an end may be the other's.
        assert!(foot < 0.6 && top < 0.5, "nobody is at {point:?}: {foot} {top}");
        assert!(point.residual < 12.0 && point.cameras.iter().filter(|saw| **saw).count() > 1);
        let owner = owners[point.track as usize].get_or_insert(walker);
        assert_eq!(*owner, walker, "track {} has two walkers", point.track);
        feet.push(foot);
        tops.push(top);
    }
    feet.sort_by(f64::total_cmp);
    tops.sort_by(f64::total_cmp);
    let n = points.len();
    let most = n * 97 / 100;
    assert!(feet[most] < 0.25 && tops[most] < 0.15, "{} {}", feet[most], tops[most]);
    assert!(n > FRAMES * 4 * 6 / 10, "only {n} places of {}", FRAMES * 4);
    assert!(feet[n / 2] < 0.06 && tops[n / 2] < 0.04, "{} {}", feet[n / 2], tops[n / 2]);
    let sorted = points.windows(2).all(|w| (w[0].track, w[0].time) < (w[1].track, w[1].time));
    assert!(sorted);
}

#[test]
fn what_two_cameras_saw_is_one_place() {
    let (cameras, late) = (cameras(), [0.0, 0.31, -0.2, 0.107]);
    let recordings: Vec<Recording> =
        cameras.iter().zip(late).map(|(c, late)| recorded(c, late, &[0, 1, 2, 3])).collect();
    let points = tracked(&cameras, &recordings, &late, 1.0);
    let (mut off_line, mut off_place) = (Vec::new(), Vec::new());
    for point in &points {
        assert!(!point.sightings.is_empty());
        let mut pairs: Vec<[usize; 2]> = point.sightings.iter().map(|s| s.cameras).collect();
        pairs.dedup();
        assert_eq!(pairs.len(), point.sightings.len());
        for seen in &point.sightings {
            let [a, b] = seen.cameras;
            assert!(a < b && point.cameras[a] && point.cameras[b]);
            let f = fundamental(&cameras[a], &cameras[b]);
            for ([p, q], place) in [(seen.top, point.top), (seen.foot, point.foot)] {
                off_line.push(symmetric_epipolar_distance(&f, p, q));
                let shown = cameras[a].project(&Vector3::from(place)).unwrap();
                off_place.push((shown[0] - p[0]).hypot(shown[1] - p[1]));
            }
        }
    }
    off_line.sort_by(f64::total_cmp);
    off_place.sort_by(f64::total_cmp);
    let n = off_line.len();
    assert!(
        off_line[n / 2] < 0.5 && off_line[n * 95 / 100] < 2.0,
        "{} {}",
        off_line[n / 2],
        off_line[n * 95 / 100]
    );
    assert!(
        off_place[n / 2] < 1.5 && off_place[n * 95 / 100] < 8.0,
        "{} {}",
        off_place[n / 2],
        off_place[n * 95 / 100]
    );
}

#[test]
fn results_do_not_depend_on_the_unit_nor_on_the_number_of_threads() {
    let (cameras, late) = (cameras(), [0.0; 4]);
    let recordings: Vec<Recording> = cameras.iter().map(|c| recorded(c, 0.0, &[0, 1])).collect();
    let all = tracked(&cameras, &recordings, &late, 1.0);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one.install(|| tracked(&cameras, &recordings, &late, 1.0)), all);
    let small = tracked(&cameras, &recordings, &late, 0.125);
    assert_eq!(small.len(), all.len());
    for (p, q) in small.iter().zip(&all) {
        assert_eq!((p.track, p.time), (q.track, q.time));
        assert!((8.0 * p.top[2] - q.top[2]).abs() < 1e-6);
    }
}

#[test]
fn what_only_two_cameras_see_differently_is_nobody() {
    // Two cameras film other walkers than the other two: what agrees by chance is denied by who looks there.
    let (cameras, late) = (cameras(), [0.0; 4]);
    let recordings: Vec<Recording> = cameras
        .iter()
        .enumerate()
        .map(|(k, camera)| recorded(camera, if k < 2 { 0.0 } else { 9.0 }, &[0, 1, 2, 3]))
        .collect();
    let points = tracked(&cameras, &recordings, &late, 1.0);
    let ghosts = points.iter().filter(|p| {
        let now = whose(p, p.time, 1.0);
        let then = whose(p, p.time + 9.0, 1.0);
        now.1.min(then.1) > 0.3
    });
    assert!(ghosts.count() < FRAMES / 20, "of {} places", points.len());
}

#[test]
fn numbers_that_no_camera_has_are_refused() {
    let camera = &cameras()[0];
    let recording = recorded(camera, 0.0, &[0]);
    let posed = PosedCamera { translation: Vector3::zeros(), ..ring::posed(camera) };
    let input = TrackingCamera::new(&recording, posed);
    let beside = |rotation| PosedCamera { translation: Vector3::x(), rotation, ..posed };
    let other = TrackingCamera::new(&recording, beside(posed.rotation));
    let collapsed = TrackingCamera::new(&recording, beside(Matrix3::zeros()));
    let said = |inputs: &[TrackingCamera], height: f64| {
        walker_tracks(inputs, height, &mut Unwatched).unwrap_err().to_string()
    };
    assert!(said(&[input], 1.0).contains("two cameras"));
    assert!(said(&[input, other], f64::NAN).contains("height"));
    assert!(said(&[input, collapsed], 1.0).contains("rotation"));
    assert!(said(&[input, other.clock(0.0, -1e6)], 1.0).contains("clock"));
    // Clocks that have nothing in common make no work.
    let apart = other.clock(1e300, 0.0);
    assert!(walker_tracks(&[input, apart], 1.0, &mut Unwatched).unwrap().is_empty());
    // A watch that says no ends it.
    let mut no = |_: epibar::Stage, _: f64| false;
    assert!(walker_tracks(&[input, other], 1.0, &mut no).is_err());
}
