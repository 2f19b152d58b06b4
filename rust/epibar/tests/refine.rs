//! Seven parameters of a fundamental matrix, and refinement over them.

mod common;

use common::cameras::{error, fundamental, random_pair};
use common::flying::Scene;
use common::masks::Random;
use common::pairs;
use epibar::internals::{SevenParameters, Step, Views, insets, refine, resampled};
use epibar::{Recorder, RecorderOptions, Recording};
use nalgebra::Matrix3;

/// Norm of the difference of two matrices of norm 1 that may differ in sign.
fn difference(p: &Matrix3<f64>, q: &Matrix3<f64>) -> f64 {
    let (p, q) = (p / p.norm(), q / q.norm());
    (p - q).norm().min((p + q).norm())
}

#[test]
fn seven_parameters_there_and_back() {
    let mut random = Random(31);
    for _ in 0..300 {
        let cameras = random_pair(&mut random);
        let f = fundamental(&cameras[0], &cameras[1]);
        let parameters = SevenParameters::new(&f, [cameras[0].size, cameras[1].size]).unwrap();
        let back = parameters.fundamental().unwrap();
        assert!(error(&back, &cameras) < 1e-7);
        assert!(difference(f.matrix(), back.matrix()) < 1e-12);
        assert!(difference(f.matrix(), &parameters.unscaled()) < 1e-12);
        assert!(f.epipole_a().cross(back.epipole_a()).norm() < 1e-9);
        assert!(f.epipole_b().cross(back.epipole_b()).norm() < 1e-9);
        // A step leads to another matrix of rank 2 with matching epipoles.
        let step = Step::from_fn(|_, _| random.between(-0.1, 0.1));
        let moved = parameters.stepped(&step).fundamental().unwrap();
        assert!(difference(f.matrix(), moved.matrix()) > 1e-6);
        assert!((moved.matrix() * moved.epipole_a()).norm() < 1e-12);
        assert!((moved.matrix().tr_mul(moved.epipole_b())).norm() < 1e-12);
    }
}

#[test]
fn derivatives_are_those_of_small_steps() {
    const H: f64 = 1e-6;
    let mut random = Random(32);
    for _ in 0..50 {
        let cameras = random_pair(&mut random);
        let f = fundamental(&cameras[0], &cameras[1]);
        let parameters = SevenParameters::new(&f, [cameras[0].size, cameras[1].size]).unwrap();
        for (k, derivative) in parameters.derivatives().iter().enumerate() {
            let mut step = Step::zeros();
            step[k] = H;
            let plus = parameters.stepped(&step).unscaled();
            let minus = parameters.stepped(&-step).unscaled();
            let numeric = (plus - minus) / (2.0 * H);
            assert!((derivative - numeric).norm() < 1e-8 * (1.0 + numeric.norm()), "parameter {k}");
            assert!(numeric.norm() > 1e-6, "parameter {k} moves nothing");
        }
    }
}

#[test]
fn refinement_leads_back_to_the_true_matrix() {
    let scene = Scene::new(4, 300, 8);
    let [a, b] = &scene.recordings(1);
    let f = &fundamental(&scene.cameras[0], &scene.cameras[1]);
    let views = Views::new(a, b, &pairs(300));
    let parameters = SevenParameters::new(f, views.sizes()).unwrap();
    let mut random = Random(36);
    let mut worst: f64 = 0.0;
    for _ in 0..8 {
        let step = Step::from_fn(|_, _| random.between(-0.012, 0.012));
        let start = parameters.stepped(&step).fundamental().unwrap();
        worst = worst.max(error(&start, &scene.cameras));
        let refined = refine(&views, &start, &[12.0, 6.0, 3.0, 1.5], 3).unwrap();
        let off = error(&refined, &scene.cameras);
        assert!(off < 0.1, "{off} px from {} px", error(&start, &scene.cameras));
    }
    assert!(worst > 2.0, "the starts must be off: {worst} px");
    // Nothing to refine on.
    let nothing = Views::new(a, b, &pairs(1));
    assert!(refine(&nothing, f, &[2.0], 1).is_none());
}

/// The recording of one camera whose masks are so many pixels too wide.
fn too_wide(scene: &Scene, camera: usize, by: usize) -> Recording {
    let size = scene.cameras[camera].size;
    let (width, height) = (size.width(), size.height());
    let mut recorder = Recorder::new(size, RecorderOptions::new().lines(1)).unwrap();
    for frame in 0..scene.frames {
        let exact = scene.mask(camera, frame);
        let mut mask = vec![0; size.pixels()];
        for (i, _) in exact.iter().enumerate().filter(|(_, moves)| **moves != 0) {
            let (x, y) = (i % width, i / width);
            for v in y.saturating_sub(by)..(y + by + 1).min(height) {
                let row = (y.abs_diff(v).pow(2), v * width);
                let across = (0..=by).rev().find(|across| across * across + row.0 <= by * by).unwrap();
                mask[row.1 + x.saturating_sub(across)..row.1 + (x + across + 1).min(width)].fill(1);
            }
        }
        recorder.push(&mask, frame as f64 / 25.0).unwrap();
    }
    recorder.finish().unwrap()
}

#[test]
fn outlines_that_are_too_wide_are_found_beside_the_geometry() {
    const RADIUS: f64 = 4.0;
    let scene = Scene::new(4, 300, 8);
    let truth = fundamental(&scene.cameras[0], &scene.cameras[1]);
    for wide in [[1, 0], [0, 1], [2, 0], [1, 1], [0, 0]] {
        let [a, b] = [0, 1].map(|camera| too_wide(&scene, camera, wide[camera]));
        let views = Views::new(&a, &b, &pairs(300));
        let refined = refine(&views, &truth, &[RADIUS], 5).unwrap();
        let found = insets(&views, &refined).unwrap();
        let moved = views.moved_outward(found);
        let found = refine(&moved, &refined, &[RADIUS], 5).unwrap();
        let (before, after) = (error(&refined, &scene.cameras), error(&found, &scene.cameras));
        if wide[0] == wide[1] {
            assert!(before < 0.2 && after < before + 0.02, "{wide:?}: {before} {after}");
        } else {
            assert!(before > 0.5 && after < 0.5 * before, "{wide:?}: {before} {after}");
        }
        // Which end of what moves is up is what tells on which side of its tangents it is.
        let rolled = views.clone().with_upright(false);
        assert!(insets(&rolled, &refined).is_none());
    }
}

#[test]
fn samples_of_what_meets_lead_out_of_a_wrong_optimum() {
    let scene = Scene::new(14, 120, 5);
    let [a, b] = scene.recordings(1);
    let views = Views::new(&a, &b, &pairs(120));
    let truth = fundamental(&scene.cameras[0], &scene.cameras[1]);
    let parameters = SevenParameters::new(&truth, views.sizes()).unwrap();
    let mut random = Random(47);
    let (mut stuck, mut led) = (0, 0);
    for seed in 0..40 {
        let step = Step::from_fn(|_, _| random.between(-0.08, 0.08));
        let moved = parameters.stepped(&step).fundamental().unwrap();
        // In a crowd refinement leaves it some pixels off.
        let Some(refined) = refine(&views, &moved, &[8.0, 4.0], 2) else { continue };
        let off = error(&refined, &scene.cameras);
        let found = resampled(&views, &views, &refined, 5.0, seed);
        assert!(found.len() <= 5);
        if (5.0..12.0).contains(&off) {
            stuck += 1;
            led += usize::from(found.iter().any(|f| error(f, &scene.cameras) < 0.4 * off));
        }
    }
    assert!(stuck > 10 && led * 10 > stuck * 8, "{led} of {stuck}");
}
