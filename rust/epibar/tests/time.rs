//! The clocks of two cameras: offset, frame rates, drift; and the geometry that depends on them.

mod common;

use std::sync::OnceLock;

use common::cameras::error;
use common::flying::Scene;
use epibar::internals::{
    Clock, Clocks, FoundOffset, FramePair, common_frames, find_offset, outstanding_offset,
};
use epibar::{
    CalibrateOptions, Calibration, Kind, Recording, RecordingParts, Stage, TimeOffset, Unwatched, calibrate,
    calibrate_watched,
};

const LINES: usize = 4000;
const FRAMES: usize = 240;

/// The scene that most tests share, recorded once.
fn shared() -> &'static (Scene, [Recording; 2]) {
    static SHARED: OnceLock<(Scene, [Recording; 2])> = OnceLock::new();
    SHARED.get_or_init(|| {
        let scene = Scene::new(5, FRAMES, 1);
        let recordings = scene.recordings(LINES);
        (scene, recordings)
    })
}

fn run(a: &Recording, b: &Recording, time_offset: TimeOffset) -> Calibration {
    calibrate(a, b, &CalibrateOptions::new().draws(2500).time_offset(time_offset)).unwrap()
}

/// Moments from `start` on, `step` frames of the scene apart.
fn moments(start: f64, step: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| start + step * k as f64).collect()
}

/// Camera A started nine frames late: its frame i is B's frame i + 9.
fn late() -> Recording {
    shared().0.record_frames(0, LINES, 9..FRAMES)
}

#[test]
fn barcodes_find_the_offset_to_a_frame_or_so() {
    let (_, [_, b]) = shared();
    let late = late();
    for (a, b, expected) in [(&late, b, 9.0), (b, &late, -9.0)] {
        let found = find_offset(a, b, 1.0, &mut Unwatched).unwrap().unwrap();
        assert!((found.offset - expected).abs() < 1.5, "{found:?} for {expected}");
        assert_eq!(found.trials, 51);
        let second = found.runner_up.unwrap();
        assert!((second.offset - found.offset).abs() > 25.0 && second.share < 0.9, "{found:?}");
    }
    // Nothing to compare at any shift.
    let short = shared().0.record_frames(0, LINES, 0..5);
    assert_eq!(find_offset(&short, b, 1.0, &mut Unwatched).unwrap(), None);
}

#[test]
fn of_the_offsets_that_barcodes_propose_a_geometry_stands_out_at_the_true_one_alone() {
    let (_, [_, b]) = shared();
    let late = late();
    let barcodes = find_offset(&late, b, 1.0, &mut Unwatched).unwrap().unwrap();
    assert!(barcodes.others.iter().all(|o| (o - barcodes.offset).abs() > 10.0), "{barcodes:?}");
    let chosen = |offset: f64, others: &[f64]| {
        let found = FoundOffset { offset, others: others.to_vec(), ..barcodes.clone() };
        let clocks = Clocks::from_found(&late, b, found, true).unwrap();
        outstanding_offset(&clocks, &CalibrateOptions::new(), &mut Unwatched).unwrap()
    };
    // The true one, and one a step beside it, is chosen whatever barcodes say.
    for (offset, others) in [(9.0, &[-30.0, 40.0][..]), (-30.0, &[40.0, 9.0]), (-30.0, &[40.0, 8.0])] {
        let chosen = chosen(offset, others).unwrap();
        assert!(
            (chosen.offset - 9.0).abs() <= 1.0 && chosen.runner_up < 0.4,
            "{chosen:?} of {offset} {others:?}"
        );
    }
    assert_eq!(chosen(-30.0, &[40.0, 70.0, -50.0, 25.0]), None);
}

#[test]
fn a_known_offset_gives_the_geometry() {
    let (scene, [_, b]) = shared();
    let found = run(&late(), b, TimeOffset::Known(9.0));
    assert!(found.verdict.accepted() && found.counts.frames == FRAMES - 9, "{:?}", found.verdict);
    assert!(error(&found.fundamental.unwrap(), &scene.cameras) < 0.3);
    assert!(found.timing.offset_error.is_nan() && found.timing.trials == 1);
    assert!((found.timing.frames_per_frame - 1.0).abs() < 1e-12);
}

#[test]
fn a_searched_offset_is_exact_to_a_fraction_of_a_frame() {
    let (scene, [_, b]) = shared();
    for fraction in [0.0, 0.37] {
        let a = scene.record_moments(0, LINES, 25.0, &moments(9.0 + fraction, 1.0, FRAMES - 10));
        let found = run(&a, b, TimeOffset::Search { seconds: 0.6 });
        assert!(found.verdict.accepted(), "{:?}", found.verdict);
        let off = found.timing.offset - 9.0 - fraction;
        assert!(off.abs() < 0.03, "{off}");
        assert!(found.timing.offset_error < 0.03, "{:?}", found.timing);
        let off = error(&found.fundamental.unwrap(), &scene.cameras);
        assert!(off < 0.3, "{off} px");
    }
}

#[test]
fn a_fraction_of_a_frame_counts() {
    let (scene, [_, b]) = shared();
    let a = scene.record_moments(0, LINES, 25.0, &moments(9.5, 1.0, FRAMES - 10));
    let off =
        |offset: f64| error(&run(&a, b, TimeOffset::Known(offset)).fundamental.unwrap(), &scene.cameras);
    let (between, whole) = (off(9.5), off(9.0));
    assert!(between < 0.3 && between < 0.5 * whole, "{between} px between frames, {whole} px at a whole one");
}

#[test]
fn different_frame_rates_meet() {
    let (scene, [_, b]) = shared();
    // A films 30 frames a second where B films 25, and starts 5.3 frames of B later.
    let a = scene.record_moments(0, LINES, 30.0, &moments(5.3, 25.0 / 30.0, 270));
    let found = run(&a, b, TimeOffset::Search { seconds: 0.6 });
    assert!(found.verdict.accepted(), "{:?}", found.verdict);
    let timing = found.timing;
    assert!((timing.offset - 5.3).abs() < 0.03, "{timing:?}");
    assert!((timing.frames_per_frame - 25.0 / 30.0).abs() < 1e-9, "{timing:?}");
    assert!(error(&found.fundamental.unwrap(), &scene.cameras) < 0.3);
    // The other way round: B's first frame is 5.3 frames, of 25 a second, before A's: −6.36 of A's.
    let found = run(b, &a, TimeOffset::Search { seconds: 0.6 });
    assert!((found.timing.offset + 5.3 * 1.2).abs() < 0.03, "{:?}", found.timing);
    assert!((found.timing.frames_per_frame - 1.2).abs() < 1e-9, "{:?}", found.timing);
    assert!(error(&found.fundamental.unwrap().transposed(), &scene.cameras) < 0.3);
}

#[test]
fn a_drift_is_found_and_used() {
    let scene = Scene::new(5, 1200, 3);
    let a = scene.record(0, LINES);
    // 2000 ppm: over 1200 frames B is 2.4 frames ahead in the end.
    let b = scene.record_moments(1, LINES, 25.0, &moments(0.0, 1.0 / 1.002, 1200));
    for time_offset in [TimeOffset::Search { seconds: 0.6 }, TimeOffset::Known(0.0)] {
        let found = run(&a, &b, time_offset);
        assert!(found.verdict.accepted(), "{:?}", found.verdict);
        let timing = found.timing;
        assert!(timing.drift_used && timing.drift_error < 60.0, "{timing:?}");
        assert!((timing.drift - 2000.0).abs() < 4.0 * timing.drift_error, "{timing:?}");
        assert!((timing.frames_per_frame - 1.002).abs() < 3e-4, "{timing:?}");
        assert!(timing.offset.abs() < 0.1, "{timing:?}");
        assert!(error(&found.fundamental.unwrap(), &scene.cameras) < 0.3);
    }
    // Where there is none, none is reported as significant.
    let b = scene.record(1, LINES);
    let timing = run(&a, &b, TimeOffset::Known(0.0)).timing;
    assert!(!timing.drift_used && timing.drift.abs() < 4.0 * timing.drift_error, "{timing:?}");
}

#[test]
fn unequal_lengths_use_their_overlap() {
    let (scene, [_, b]) = shared();
    let a = scene.record_frames(0, LINES, 60..200);
    let found = run(&a, b, TimeOffset::Search { seconds: 4.0 });
    assert!(
        found.verdict.accepted() && found.counts.frames == 140,
        "{:?} {}",
        found.verdict,
        found.counts.frames
    );
    assert!((found.timing.offset - 60.0).abs() < 0.05, "{:?}", found.timing);
    assert!(error(&found.fundamental.unwrap(), &scene.cameras) < 0.5);
    assert!(found.frontier_points.iter().all(|p| p.frame.index() < 140));
}

#[test]
fn unrelated_recordings_have_no_offset() {
    let (_, [a, _]) = shared();
    for seed in [2, 3] {
        let other = Scene::new(5, FRAMES, seed).record(1, LINES);
        let found = run(a, &other, TimeOffset::Search { seconds: 5.0 });
        assert_eq!(found.verdict.kind, Kind::NoCommonScene, "{:?}", found.verdict);
        assert_eq!(found.timing.trials, 251);
    }
    // No more than they are long, whatever is asked for.
    let other = Scene::new(5, FRAMES, 2).record(1, LINES);
    let found = run(a, &other, TimeOffset::Search { seconds: 1e9 });
    assert_eq!(found.verdict.kind, Kind::NoCommonScene, "{:?}", found.verdict);
    assert_eq!(found.timing.trials, 2 * FRAMES + 1);
}

#[test]
fn no_search_is_done_twice_by_the_same_clock() {
    let (_, [a, b]) = shared();
    let searches = |b: &Recording| {
        let mut begun = 0;
        let mut watch = |stage: Stage, _: f64| {
            begun += usize::from(stage == Stage::Candidates);
            true
        };
        let options = CalibrateOptions::new().draws(2500).time_offset(TimeOffset::About(0.3));
        let found = calibrate_watched(a, b, &options, &mut watch).unwrap();
        (begun, found.verdict.kind)
    };
    // Nothing is learned of the clock, and so few frames are all of them at once.
    let other = Scene::new(5, FRAMES, 2).record(1, LINES);
    assert_eq!(searches(&other), (1, Kind::NoCommonScene));
    let (begun, kind) = searches(b);
    assert!(begun > 1 && kind == Kind::Accepted, "{begun} {kind:?}");
}

#[test]
fn where_cameras_may_have_been_started_together_that_is_tried_first() {
    let ([a, b], seconds) = (&shared().1, 5.0);
    let auto = TimeOffset::Auto { seconds };
    let geometry = |c: &Calibration| (c.fundamental, c.timing.offset, c.verdict.clone());
    let together = run(a, b, TimeOffset::Known(0.0));
    assert!(together.accepted());
    assert_eq!(geometry(&run(a, b, auto)), geometry(&together));
    let searched = run(&late(), b, TimeOffset::Search { seconds });
    assert!(searched.accepted() && searched.timing.offset > 8.0);
    assert_eq!(geometry(&run(&late(), b, auto)), geometry(&searched));
    // Where neither is accepted it is the one for which more speaks.
    let other = Scene::new(5, FRAMES, 2).record(1, LINES);
    let (together, found) = (run(a, &other, TimeOffset::Known(0.0)), run(a, &other, auto));
    assert!(!found.accepted() && found.evidence.z >= together.evidence.z);
}

#[test]
fn an_offset_that_every_part_finds_is_no_best_of_many() {
    let (scene, [a, b]) = shared();
    let search = |seconds| TimeOffset::Search { seconds };
    let trials = |a: &Recording, b: &Recording, given| {
        let clocks = Clocks::new(a, b, given, true, &mut Unwatched).unwrap();
        clocks.trials_by_parts(&mut Unwatched).unwrap()
    };
    assert_eq!(trials(&late(), b, search(5.0)), 7);
    assert_eq!(trials(&late(), b, TimeOffset::Known(9.0)), 1);
    for seed in [2, 3] {
        let other = Scene::new(5, FRAMES, seed).record(1, LINES);
        assert_eq!(trials(a, &other, search(5.0)), 251);
    }
    // So few frames that one of 201 offsets would be too little.
    let (a, b) = (scene.record_frames(0, LINES, 9..122), scene.record_frames(1, LINES, 0..113));
    let z = run(&a, &b, TimeOffset::Known(9.0)).evidence.z;
    assert!(z * z - 2.0 * 201_f64.ln() < 25.0, "{z} says nothing here");
    let found = run(&a, &b, search(4.0));
    assert!(found.verdict.accepted() && found.timing.trials == 201, "{:?}", found.verdict);
}

#[test]
fn frames_meet_by_time() {
    let (scene, [a, b]) = shared();
    let ends = |p: FramePair| (p.a.index(), p.b.index());
    let frames = |pairs: &[FramePair]| (pairs.len(), ends(pairs[0]), ends(pairs[pairs.len() - 1]));
    assert_eq!(frames(&common_frames(a, b, 0.0)), (240, (0, 0), (239, 239)));
    assert_eq!(frames(&common_frames(a, b, 30.0)), (210, (0, 30), (209, 239)));
    assert_eq!(frames(&common_frames(a, b, -30.0)), (210, (30, 0), (239, 209)));
    assert!(common_frames(a, b, 300.0).is_empty());
    // Clocks that start elsewhere: each counts from its own first frame.
    let shifted = at_times(a, |k| a.times()[k] + 1000.0);
    assert_eq!(common_frames(&shifted, b, 5.0), common_frames(a, b, 5.0));
    // Half the rate in A: its frame i is B's frame 2 i.
    let slow = scene.record_frames(0, 1, 0..50);
    let slow = at_times(&slow, |k| 2.0 * slow.times()[k]);
    let pairs = common_frames(&slow, b, 0.0);
    assert!(pairs.len() == 50 && pairs.iter().all(|p| p.b.index() == 2 * p.a.index()), "{pairs:?}");
    let back = common_frames(b, &slow, 0.0);
    assert!(back.iter().all(|p| p.a.index().abs_diff(2 * p.b.index()) <= 1), "{back:?}");
    assert!((0..49).all(|j| back.contains(&FramePair::new(2 * j, j))), "{back:?}");
}

/// A recording of these frames at other times.
fn at_times(recording: &Recording, time: impl Fn(usize) -> f64) -> Recording {
    let mut parts = RecordingParts::from(recording.clone());
    parts.times = (0..recording.frames()).map(time).collect();
    parts.try_into().unwrap()
}

#[test]
fn positions_follow_the_frame_times() {
    let (_, [a, b]) = shared();
    // 25 against 30: frame i of A is frame 1.2 i + 4 of B.
    let fast = at_times(b, |k| k as f64 / 30.0);
    let clock = Clock::at(4.0);
    assert!((clock.frames_per_frame(a, &fast) - 1.2).abs() < 1e-9);
    for (i, p) in clock.positions(a, &fast).into_iter().enumerate() {
        let expected = 1.2 * i as f64 + 4.0;
        assert!(
            if expected < 239.4 { (p - expected.min(239.0)).abs() < 1e-6 } else { p.is_nan() },
            "{i}: {p}"
        );
    }
    // 29.97 against 30: a frame more in 33 seconds.
    let ntsc = at_times(a, |k| k as f64 * 1.001 / 30.0);
    let last = Clock::at(0.0).positions(&ntsc, &fast)[200];
    assert!((last - 200.2).abs() < 1e-6, "{last}");
    // A rate difference acts from A's first frame on.
    let drifting = Clock { offset: 1.5, rate: 1.001 };
    assert!((drifting.positions(a, b)[100] - 101.6).abs() < 1e-9);
    // Time stamps in whole milliseconds are no frame rate of their own.
    let rounded = at_times(b, |k| (k as f64 * 1000.0 / 30.0).round() / 1000.0);
    assert!((rounded.frame_interval() * 30.0 - 1.0).abs() < 1e-4);
    // Frames 100 to 109 of B are missing: what A saw then has no place in B.
    let torn = at_times(b, |k| (if k < 100 { k } else { k + 10 }) as f64 / 25.0);
    assert!((torn.frame_interval() * 25.0 - 1.0).abs() < 1e-9);
    let positions = Clock::at(0.0).positions(a, &torn);
    assert!((positions[99] - 99.0).abs() < 1e-6 && (positions[110] - 100.0).abs() < 1e-6);
    assert!(positions[101..109].iter().all(|p| p.is_nan()), "{:?}", &positions[99..111]);
}

#[test]
fn a_rate_that_varies_goes_by_the_frame_times() {
    let (_, [a, b]) = shared();
    // Light, then dark: 30 frames a second, then 24. No step is far from the mean one, and both have the same mean.
    let moment = |k: usize| k.min(120) as f64 / 30.0 + k.saturating_sub(120) as f64 / 24.0;
    let (dark, later) = (at_times(a, moment), at_times(b, moment));
    let offset = 48.0; // in A's first frame B is 48 mean intervals on
    let clock = Clock::at(offset);
    let positions = clock.positions(&dark, &later);
    let start = offset * later.frame_interval();
    for (i, p) in positions.iter().enumerate().filter(|(_, p)| p.is_finite()) {
        let (j, share) = (p.floor() as usize, p.fract());
        let shown = if share > 0.0 { (1.0 - share) * moment(j) + share * moment(j + 1) } else { moment(j) };
        // The last is that frame for half a frame more.
        let within = if j == 239 { 0.5 * later.frame_interval() } else { 1e-6 };
        assert!((shown - moment(i) - start).abs() < within, "{i}: {p}");
    }
    assert!(positions.iter().filter(|p| p.is_finite()).count() > 180);
}
