//! The evidence on frames kept aside: it owes nothing to what was fitted, and its standard score is one; and depth.

mod common;

use common::cameras::{error, fundamental, random_pair};
use common::flying::Scene;
use common::masks::Random;
use common::pairs;
use epibar::internals::{
    CandidateOptions, Class, CommonFrame, HeldOut, TangentMatch, Views, Winner, compare, may_turn,
    moving_correspondences, normal_deviate, plane_residual, shift_curve,
};
use epibar::{CalibrateOptions, Calibration, Fundamental, Informative, Method, Recording, calibrate};
use nalgebra::Vector3;

const LINES: usize = 4000;
const FRAMES: usize = 240;

/// With the frames of camera B in a given order.
fn run(scene: &Scene, a: &Recording, order: &[usize], method: Method) -> Calibration {
    let moments: Vec<f64> = order.iter().map(|&k| k as f64).collect();
    let b = scene.record_moments(1, LINES, 25.0, &moments);
    // What is left of a line's information when frames change places does not depend on the order.
    let mut informative = Informative::default();
    informative.min_transitions = 0;
    let matching = CandidateOptions { informative, ..Default::default() };
    let options = CalibrateOptions::new().draws(2500).method(method).matching(matching);
    calibrate(a, &b, &options).unwrap()
}

fn bits(f: Option<Fundamental>) -> Vec<u64> {
    f.unwrap().matrix().iter().map(|v| v.to_bits()).collect()
}

#[test]
fn frames_kept_aside_have_no_part_in_what_is_tested() {
    let scene = Scene::new(5, FRAMES, 1);
    let a = scene.record(0, LINES);
    let order: Vec<usize> = (0..FRAMES).collect();
    // The last frames are tested, however many stretches there are; the first are fitted.
    let (mut late, mut early) = (order.clone(), order.clone());
    late[FRAMES - 26..].reverse();
    early[..26].reverse();
    for method in [Method::Frontier, Method::Lines] {
        let as_it_was = run(&scene, &a, &order, method);
        let tested_changed = run(&scene, &a, &late, method);
        assert_eq!(bits(as_it_was.tested), bits(tested_changed.tested), "{method:?}");
        let (before, after) = (as_it_was.shift_curve[0], tested_changed.shift_curve[0]);
        assert!(after.score < 0.9 * before.score, "{method:?}: they are what it is tested on");
        let fitted_changed = run(&scene, &a, &early, method);
        assert_ne!(bits(as_it_was.tested), bits(fitted_changed.tested), "{method:?}");
        // The answer is that of all frames.
        assert_ne!(bits(as_it_was.fundamental), bits(as_it_was.tested), "{method:?}");
        assert_ne!(bits(as_it_was.fundamental), bits(tested_changed.fundamental), "{method:?}");
    }
}

#[test]
fn a_standard_score_is_one() {
    // Geometries that nobody fitted, before recordings that have nothing to do with each other.
    let mut random = Random(77);
    let (mut scores, mut most) = (Vec::new(), f64::NEG_INFINITY);
    for seed in 0..36 {
        let frames = 300;
        let (a, b) = (Scene::new(5, frames, 100 + seed), Scene::new(5, frames, 200 + seed));
        let pairs = pairs(frames as u32);
        let (a_recording, b_recording) = (a.record(0, 50), b.record(1, 50));
        let views = Views::new(&a_recording, &b_recording, &pairs);
        let fitted = Views::new(&a_recording, &b_recording, &pairs[..110]);
        let held_out = HeldOut {
            views: &views,
            fitted: &fitted,
            tested: &[120..150, 270..frames],
            stay: 10,
            radius: 4.0,
        };
        for _ in 0..16 {
            let [p, q] = random_pair(&mut random);
            let f = fundamental(&p, &q);
            let f = Fundamental::from_matrix(f.matrix(), a.cameras[0].size, a.cameras[1].size).unwrap();
            let curve = shift_curve(&held_out, &f, 60);
            let z = curve.evidence().z;
            most = z.max(most);
            // Where next to nothing ever meets the deviation has a floor, and the score is less than one.
            let totals: Vec<f64> = curve.scores.iter().skip(1).map(|s| s.score.total()).collect();
            let range = totals.iter().copied().fold(f64::NEG_INFINITY, f64::max)
                - totals.iter().copied().fold(f64::INFINITY, f64::min);
            if range > 40.0 {
                scores.push(z);
            }
        }
    }
    let n = scores.len() as f64;
    let mean = scores.iter().sum::<f64>() / n;
    let deviation = (scores.iter().map(|z| z * z).sum::<f64>() / n).sqrt();
    let above_two = scores.iter().filter(|z| **z > 2.0).count();
    println!("mean {mean:.2}, deviation {deviation:.2}, above two {above_two} of {n}, most {most:.2}");
    assert!(mean.abs() < 0.2 && (0.8..1.2).contains(&deviation), "{mean} {deviation}");
    // Chance is skewed: a few silhouettes that meet by luck say much. So the largest of all is more than that of a normal
    // deviate, but stays clear of what is asked for, 5.
    assert!(n > 200.0 && above_two as f64 <= 0.05 * n && most < 4.5, "{n} {above_two} {most}");
}

#[test]
fn it_does_not_matter_which_camera_comes_first() {
    let frames = 200;
    let scene = Scene::new(6, frames, 9);
    let [a, b] = scene.recordings(50);
    let f = fundamental(&scene.cameras[0], &scene.cameras[1]);
    let f = Fundamental::from_matrix(f.matrix(), scene.cameras[0].size, scene.cameras[1].size).unwrap();
    let evidence = |views: &Views, f: &Fundamental| {
        let fitted = views.chosen(&(0..120).collect::<Vec<_>>());
        let stretch = 140..frames;
        let tested = std::slice::from_ref(&stretch);
        let held_out = HeldOut { views, fitted: &fitted, tested, stay: 10, radius: 3.0 };
        shift_curve(&held_out, f, 60).evidence()
    };
    let there = evidence(&Views::new(&a, &b, &pairs(frames as u32)), &f);
    let back = evidence(&Views::new(&b, &a, &pairs(frames as u32)), &f.transposed());
    for (of, p, q) in [
        ("explained", there.explained, back.explained),
        ("tops", there.explained_tops, back.explained_tops),
        ("bottoms", there.explained_bottoms, back.explained_bottoms),
        ("both ends", there.both_ends, back.both_ends),
    ] {
        assert!(p > 0.1 && (p - q).abs() < 1e-9, "{of}: {p} {q}");
    }
    // The shifts are not quite the same ones, and how many of them are independent is estimated from them.
    for (p, q) in [(there.z, back.z), (there.z_whole, back.z_whole)] {
        assert!(p.min(q) > 8.0 && (p / q).ln().abs() < 0.3, "{p} {q}");
    }
}

#[test]
fn students_t_as_a_normal_deviate() {
    // Quantiles from tables: one-sided 0.025 and 0.0005.
    for (t, freedom, expected) in
        [(12.706, 1.0, 1.960), (2.228, 10.0, 1.960), (4.587, 10.0, 3.2905), (3.646, 30.0, 3.2905)]
    {
        let z = normal_deviate(t, freedom);
        assert!((z / expected - 1.0).abs() < if freedom > 1.0 { 0.01 } else { 0.1 }, "{t} {freedom}: {z}");
        assert!((normal_deviate(-t, freedom) + z).abs() < 1e-12);
    }
    assert!((normal_deviate(5.0, 1e9) - 5.0).abs() < 1e-3);
}

fn all_frames(a: &Recording, b: &Recording) -> Views {
    Views::new(a, b, &pairs(a.frames() as u32))
}

#[test]
fn a_plane_is_known_from_a_volume() {
    let scene = Scene::new(4, 60, 3);
    let [a, b] = scene.recordings(50);
    let views = all_frames(&a, &b);
    let f = fundamental(&scene.cameras[0], &scene.cameras[1]);
    assert!(error(&f, &scene.cameras) < 1e-6);
    let mut random = Random(5);
    let mut matched = |depth: f64| -> Vec<TangentMatch> {
        (0..400)
            .filter_map(|frame| {
                let point = Vector3::new(
                    random.between(-1.5, 1.5),
                    random.between(-depth, depth),
                    random.between(0.2, 2.2),
                );
                let (a, b) = (scene.cameras[0].see(&point)?, scene.cameras[1].see(&point)?);
                let frame = CommonFrame(frame);
                Some(TangentMatch { frame, a, b, distance: 0.0, surprise: 1.0, class: Class::Top })
            })
            .collect()
    };
    let volume = matched(1.5);
    let exchanged: Vec<TangentMatch> = volume.iter().map(|m| TangentMatch { a: m.b, b: m.a, ..*m }).collect();
    let there = plane_residual(&views, &volume, 1);
    let back = plane_residual(&all_frames(&b, &a), &exchanged, 1);
    assert!((there / back - 1.0).abs() < 0.1, "{there} {back}");
    let (path, volume) =
        (plane_residual(&views, &matched(0.03), 1), plane_residual(&views, &matched(1.5), 1));
    assert!(path < 0.2, "{path}");
    assert!(volume > 3.0 * path, "{path} {volume}");
    assert!(plane_residual(&views, &matched(1.5)[..10], 1).is_nan());
}

/// How far a geometry may turn about its plane, of which matched points are said to keep so many widths.
fn turns(scene: &Scene, f: &Fundamental, plane_residual: f64) -> f64 {
    let [a, b] = scene.recordings(50);
    let views = all_frames(&a, &b);
    let matches = compare(&views, f, 2.0).matches;
    assert!(matches.len() > 200, "{}", matches.len());
    let volume = moving_correspondences(&views, f, 200, 1);
    let turned = may_turn(&views, &Winner::new(&views, f, 12), &matches, plane_residual, &volume);
    // Where things moved they are nearer than over all of the images, and no nearer than not at all.
    assert!(turned.volume >= 0.0 && turned.volume <= turned.image + 2.0, "{turned:?}");
    turned.image
}

#[test]
fn only_what_lies_off_a_plane_holds_the_epipole() {
    let mut scene = Scene::new(6, 120, 3);
    // What matches by chance leaves any plane: that the points do is no proof that anything holds the epipole.
    for plane_residual in [0.1, 4.0] {
        let free = turns(&scene, &fundamental(&scene.cameras[0], &scene.cameras[1]), plane_residual);
        assert!(free < 2.0, "{free}");
    }

    // Without a baseline every plane is one, and [e']× H explains everything for any e'.
    let turn = nalgebra::Rotation3::from_euler_angles(0.05, -0.1, 0.03);
    scene.cameras[1] = scene.cameras[0].clone().turned(&turn);
    let k = scene.cameras[0].matrix();
    let homography = k * turn.matrix() * k.try_inverse().unwrap();
    let [a, b] = [0, 1].map(|camera| scene.cameras[camera].size);
    let any = Vector3::new(900.0, -300.0, 1.0).cross_matrix() * homography;
    for plane_residual in [0.1, 4.0] {
        let none = turns(&scene, &Fundamental::from_matrix(&any, a, b).unwrap(), plane_residual);
        assert!(none > 8.0, "{plane_residual}: {none}");
    }
}

#[test]
fn frames_that_say_too_little_are_followed_by_others() {
    let scene = Scene::new(5, FRAMES, 1);
    let a = scene.record(0, LINES);
    // Of the two stretches that are kept aside first, the last tenths of both halves, so many frames show what happened at another time.
    let with_others = |wrong: usize| {
        let mut order: Vec<usize> = (0..FRAMES).collect();
        for end in [FRAMES / 2, FRAMES] {
            order[end - FRAMES / 10..][..wrong].iter_mut().for_each(|k| *k = (*k + 40) % FRAMES);
        }
        run(&scene, &a, &order, Method::Frontier)
    };
    let first = with_others(0);
    let second = with_others(20);
    assert!(second.accepted() && second.evidence.z > 6.0, "{:?} {:?}", second.verdict, second.evidence);
    assert_ne!(bits(first.tested), bits(second.tested), "other frames were kept aside");
    assert!(second.evidence.tested_distance < 0.5, "{:?}", second.evidence);
    // What shows nothing at all calls for no second look.
    let none = with_others(FRAMES / 10);
    assert_eq!(none.verdict.kind, epibar::Kind::NoCommonScene, "{:?}", none.verdict);
}
