//! The whole job on a small scene: what is accepted, how far off it is, and what is refused.

mod common;

use std::sync::OnceLock;

use common::cameras::error;
use common::flying::Scene;
use epibar::{
    CalibrateOptions, Calibration, Error, Fundamental, Kind, Method, Recorder, RecorderOptions, Recording,
    Stage, TimeOffset, Watch, calibrate, calibrate_watched,
};

const LINES: usize = 4000;

/// The scene that most tests share, recorded once.
fn shared() -> &'static (Scene, [Recording; 2]) {
    static SHARED: OnceLock<(Scene, [Recording; 2])> = OnceLock::new();
    SHARED.get_or_init(|| {
        let scene = Scene::new(5, 240, 1);
        let recordings = scene.recordings(LINES);
        (scene, recordings)
    })
}

/// Fewer draws than by default, for time.
fn options() -> CalibrateOptions {
    CalibrateOptions::new().draws(2500)
}

fn run(a: &Recording, b: &Recording, options: &CalibrateOptions) -> Calibration {
    calibrate(a, b, options).unwrap()
}

#[test]
fn a_small_scene_is_accepted_and_right() {
    let (scene, [a, b]) = shared();
    let found = run(a, b, &CalibrateOptions::default());
    assert!(found.verdict.accepted(), "{:?}", found.verdict);
    let f = found.fundamental.unwrap();
    let off = error(&f, &scene.cameras);
    assert!(off < 0.3, "{off} px");
    assert!(
        error(&f.transposed(), &scene.cameras) > 10.0,
        "a transposed matrix must not pass for the right one"
    );
    // What it expects of itself is of the size of what it is; cubes fill their hulls, so for all it knows they stand in for something else.
    let expected = found.expected_error.unwrap();
    assert!(expected > off / 8.0 && expected < 1.5, "{expected}");
    assert!(found.evidence.z > 8.0 && found.evidence.z_tops > 5.0 && found.evidence.z_bottoms > 5.0);
    assert_eq!((found.counts.frames, found.counts.candidates), (240, found.candidates.len()));
    assert!(found.timing.offset.abs() < f64::EPSILON);
    // The frontier points are correspondences of the true geometry, too.
    assert!(found.frontier_points.len() > 500);
    let truth = common::cameras::fundamental(&scene.cameras[0], &scene.cameras[1]);
    let mut distances: Vec<f64> =
        found.frontier_points.iter().map(|p| epibar::symmetric_epipolar_distance(&truth, p.a, p.b)).collect();
    distances.sort_by(f64::total_cmp);
    assert!(distances[distances.len() / 2] < 0.6, "{}", distances[distances.len() / 2]);
    assert!(found.frontier_points.iter().all(|p| p.frame.index() < scene.frames));
    // The curve has its peak at shift 0.
    let (first, rest) = found.shift_curve.split_first().unwrap();
    assert!(first.shift == 0 && rest.len() > 20);
    assert!(rest.iter().all(|s| s.score < 0.3 * first.score));
}

#[test]
fn exchanged_cameras_give_the_transpose() {
    let (scene, [a, b]) = shared();
    let found = run(b, a, &options());
    assert!(found.verdict.accepted(), "{:?}", found.verdict);
    let f = found.fundamental.unwrap();
    assert!(error(&f.transposed(), &scene.cameras) < 0.3);
    assert!(error(&f, &scene.cameras) > 10.0);
}

#[test]
fn line_pairs_alone_are_near() {
    let (scene, [a, b]) = shared();
    let found = run(a, b, &options().method(Method::Lines));
    let off = error(&found.fundamental.unwrap(), &scene.cameras);
    assert!(off < 6.0, "{off} px");
    let inliers = found.candidates.iter().filter(|pair| pair.inlier).count();
    assert!(inliers > 20, "{inliers}");
    // What else lines led to is compared with it, and far ones are told from it.
    assert!(!found.rivals.is_empty());
    let far: Vec<_> = found.rivals.iter().filter(|rival| rival.distance > 20.0).collect();
    assert!(far.iter().all(|rival| rival.share < 0.5), "{:?}", found.rivals);
}

#[test]
fn unrelated_recordings_are_refused() {
    let (_, [a, _]) = shared();
    let other = Scene::new(5, 240, 2).record(1, LINES);
    let found = run(a, &other, &options());
    assert_eq!(found.verdict.kind, Kind::NoCommonScene, "{:?}", found.verdict);
    // One scene at two times is as unrelated.
    let scene = Scene::new(5, 400, 4);
    let (early, late) = (scene.record_frames(0, LINES, 0..200), scene.record_frames(1, LINES, 200..400));
    let found = run(&early, &late, &options());
    assert!(!found.verdict.accepted(), "{:?}", found.verdict);
}

fn bits(f: &Fundamental) -> Vec<u64> {
    f.matrix().iter().map(|v| v.to_bits()).collect()
}

#[test]
fn a_seed_is_a_result_whatever_the_number_of_threads() {
    let (scene, [a, b]) = shared();
    let with = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(a, b, &options().seed(seed)))
    };
    let (one, two) = (with(1, 5), with(2, 5));
    assert_eq!(bits(&one.fundamental.unwrap()), bits(&two.fundamental.unwrap()));
    assert_eq!(one.verdict, two.verdict);
    assert_eq!(one.expected_error.map(f64::to_bits), two.expected_error.map(f64::to_bits));
    assert_eq!(one.frontier_points, two.frontier_points);
    assert_eq!(one.candidates, two.candidates);
    // Another seed draws anew and arrives at the same geometry.
    let other = with(2, 6);
    assert!(error(&other.fundamental.unwrap(), &scene.cameras) < 0.3);
}

/// Goes on until a stage, and counts.
struct StopAt {
    stage: Option<Stage>,
    stages: Vec<Stage>,
}

impl Watch for StopAt {
    fn keep_going(&mut self, stage: Stage, done: f64) -> bool {
        assert!((0.0..=1.0).contains(&done), "{stage:?}: {done}");
        if self.stages.last() != Some(&stage) {
            self.stages.push(stage);
        }
        Some(stage) != self.stage
    }
}

#[test]
fn every_stage_can_be_interrupted() {
    let (_, [a, b]) = shared();
    let options = options().draws(600).time_offset(TimeOffset::Search { seconds: 0.1 });
    let mut watch = StopAt { stage: None, stages: Vec::new() };
    calibrate_watched(a, b, &options, &mut watch).unwrap();
    let stages = watch.stages;
    assert!(stages.len() >= 4 && stages[..2] == [Stage::TimeOffset, Stage::Candidates], "{stages:?}");
    for stage in stages {
        let mut watch = StopAt { stage: Some(stage), stages: Vec::new() };
        let stopped = calibrate_watched(a, b, &options, &mut watch).unwrap_err();
        assert_eq!(stopped, Error::Interrupted, "{stage:?}");
        assert_eq!(watch.stages.last(), Some(&stage), "nothing happens after that");
    }
    let mut watch = StopAt { stage: Some(Stage::Lines), stages: Vec::new() };
    let stopped = calibrate_watched(a, b, &options.method(Method::Lines), &mut watch);
    assert_eq!(stopped.unwrap_err(), Error::Interrupted);
}

#[test]
fn where_a_geometry_stands_out_no_more_hypotheses_are_drawn() {
    let (scene, [a, b]) = shared();
    let stages = |a: &Recording, b: &Recording| {
        let mut watch = StopAt { stage: None, stages: Vec::new() };
        let found = calibrate_watched(a, b, &options(), &mut watch).unwrap();
        (watch.stages, found)
    };
    let (entered, found) = stages(a, b);
    assert_eq!(entered, [Stage::Candidates, Stage::Few, Stage::Settle]);
    assert!(error(&found.fundamental.unwrap(), &scene.cameras) < 0.3);
    let other = Scene::new(5, 240, 2).recordings(LINES);
    let (entered, _) = stages(a, &other[1]);
    assert_eq!(entered[..3], [Stage::Candidates, Stage::Few, Stage::BestLines]);
}

#[test]
fn the_method_of_lines_tells_a_share_that_never_goes_back() {
    let (_, [a, b]) = shared();
    let mut shares = Vec::new();
    let mut watch = |stage: Stage, done: f64| {
        shares.extend((stage == Stage::Lines).then_some(done));
        true
    };
    calibrate_watched(a, b, &options().method(Method::Lines), &mut watch).unwrap();
    assert!(shares.windows(2).all(|two| two[0] <= two[1]), "{shares:?}");
    assert!(shares[0] < 0.05 && *shares.last().unwrap() > 0.85, "{shares:?}");
}

/// A recording without motion.
fn still(like: &Recording) -> Recording {
    let mut recorder = Recorder::new(like.size(), RecorderOptions::new().lines(LINES)).unwrap();
    for &time in like.times() {
        recorder.push(&vec![0; like.size().pixels()], time).unwrap();
    }
    recorder.finish().unwrap()
}

#[test]
fn no_motion_is_too_little() {
    let (_, [a, b]) = shared();
    let (still_a, still_b) = (still(a), still(b));
    for (a, b, which) in
        [(&still_a, b, "camera A"), (a, &still_b, "camera B"), (&still_a, &still_b, "either")]
    {
        let found = run(a, b, &options());
        assert_eq!(found.verdict.kind, Kind::TooLittleMotion);
        assert!(found.verdict.reason.contains(which), "{}", found.verdict.reason);
        assert!(found.fundamental.is_none() && found.expected_error.is_none());
        assert!(found.frontier_points.is_empty() && found.candidates.is_empty());
    }
}

#[test]
fn too_few_frames_are_too_little() {
    let (scene, [a, b]) = shared();
    let short = scene.record_frames(0, LINES, 0..10);
    let found = run(&short, b, &options());
    assert_eq!(found.verdict.kind, Kind::TooLittleMotion);
    assert!(found.verdict.reason.contains("10 frames"), "{}", found.verdict.reason);
    assert!(found.fundamental.is_none() && found.counts.frames == 10);
    // Enough frames in each, but not at the same time.
    let apart = options().time_offset(TimeOffset::Known(235.0));
    assert_eq!(run(a, b, &apart).verdict.kind, Kind::TooLittleMotion);
}

#[test]
fn options_out_of_range() {
    let (_, [a, b]) = shared();
    let refused = |options: CalibrateOptions, argument: &str| {
        let error = calibrate(a, b, &options).unwrap_err();
        assert!(matches!(error, Error::Argument { name, .. } if name == argument), "{error}");
    };
    refused(options().draws(0), "draws");
    refused(options().candidates(2), "candidates");
    for max_expected_error in [0.0, -1.0, f64::NAN] {
        refused(options().max_expected_error(max_expected_error), "max_expected_error");
    }
    for time_offset in [
        TimeOffset::Known(f64::NAN),
        TimeOffset::Known(f64::INFINITY),
        TimeOffset::Search { seconds: 0.0 },
        TimeOffset::Search { seconds: f64::NAN },
    ] {
        refused(options().time_offset(time_offset), "time_offset");
    }
    // An accuracy that cannot be met is refused with the matrix, not without.
    let strict = options().max_expected_error(1e-4);
    let found = run(a, b, &strict);
    assert_eq!(found.verdict.kind, Kind::Inaccurate);
    assert!(found.fundamental.is_some());
}
