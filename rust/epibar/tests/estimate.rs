//! From candidates to a fundamental matrix: parameters, line pairs, the floor, tangents, refinement.

mod common;

use std::sync::OnceLock;

use common::cameras::{Camera, error, fundamental, points, random_pair};
use common::flying::Scene;
use common::masks::Random;
use epibar::estimate::floor::find_floors;
use epibar::estimate::frontier::{Class, FrontierOptions, FrontierScore, compare, frontier_score};
use epibar::estimate::line_model::LineModel;
use epibar::estimate::optimise::{SevenParameters, Step};
use epibar::estimate::ransac::{Unwatched, ransac};
use epibar::estimate::refine::refine;
use epibar::estimate::views::{Views, busy_frames};
use epibar::geometry::LinePair;
use epibar::matching::Candidate;
use epibar::{Fundamental, Line, Recording, Segment, border_segments};
use nalgebra::{Matrix3, Vector3};

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

/// A candidate from two lines; `None` where one misses its image.
fn candidate(a: &Line, b: &Line, cameras: &[Camera; 2], correlation: f64) -> Option<Candidate> {
    let (segment_a, segment_b) = (a.clip(cameras[0].size)?, b.clip(cameras[1].size)?);
    let lines = LinePair { a: *a, b: *b };
    Some(Candidate { lines, segment_a, segment_b, correlation })
}

/// The line with both ends of its segment moved by up to `noise` pixels.
fn shaken(line: &Line, camera: &Camera, noise: f64, random: &mut Random) -> Option<Line> {
    let s = line.clip(camera.size)?;
    let [x0, y0, x1, y1] = [s.x0, s.y0, s.x1, s.y1].map(|v| v + random.between(-noise, noise));
    Segment { x0, y0, x1, y1 }.line()
}

fn line_through(p: &Vector3<f64>, q: &Vector3<f64>) -> Line {
    Line::from_homogeneous(&p.cross(q)).unwrap()
}

/// Pairs of lines that have nothing to do with one another.
fn outliers(cameras: &[Camera; 2], count: usize, random: &mut Random) -> Vec<Candidate> {
    let (seed, half) = (random.below(1 << 30) as u64, 0.5);
    let a = border_segments(cameras[0].size, count, seed);
    let b = border_segments(cameras[1].size, count, seed + 1);
    let pairs = a.iter().zip(&b);
    pairs.filter_map(|(a, b)| candidate(&a.line()?, &b.line()?, cameras, half)).collect()
}

/// Epipolar line pairs through random points, off by up to `noise` pixels.
fn epipolar(cameras: &[Camera; 2], count: usize, noise: f64, random: &mut Random) -> Vec<Candidate> {
    let f = fundamental(&cameras[0], &cameras[1]);
    let mut found = Vec::new();
    while found.len() < count {
        let (a, b) = points(cameras, 1, random)[0];
        let lines = [(a, f.epipole_a()), (b, f.epipole_b())];
        let [a, b] = lines.map(|(p, e)| line_through(e, &Vector3::new(p[0], p[1], 1.0)));
        let both = shaken(&a, &cameras[0], noise, random).zip(shaken(&b, &cameras[1], noise, random));
        found.extend(both.and_then(|(a, b)| candidate(&a, &b, cameras, random.between(0.4, 0.9))));
    }
    found
}

#[test]
fn line_pairs_half_of_them_wrong_give_the_matrix() {
    let mut random = Random(33);
    for _ in 0..12 {
        let cameras = random_pair(&mut random);
        let mut candidates = epipolar(&cameras, 150, 0.3, &mut random);
        candidates.extend(outliers(&cameras, 150, &mut random));
        let model = LineModel::new(&candidates, [cameras[0].size, cameras[1].size]);
        let best = ransac(&model, 1500, 3, 1, "lines", &mut Unwatched).unwrap();
        assert!(best.len() == 3 && best.is_sorted_by(|p, q| p.score >= q.score));
        let f = model.optimise(&best[0].model);
        let off = error(&f, &cameras);
        assert!(off < 1.0, "{off} px");
        let inliers = model.inliers(&f);
        let count = |range: std::ops::Range<usize>| inliers[range].iter().filter(|&&i| i).count();
        assert!(count(0..150) > 135, "{} of 150 true pairs", count(0..150));
        assert!(count(150..candidates.len()) < 30, "{} wrong pairs", count(150..candidates.len()));
        let wrong = model.inliers(&f.transposed());
        assert!(wrong.iter().filter(|&&i| i).count() < 100);
    }
}

/// The homography of the plane z = 0, from four points of it.
fn floor_homography(cameras: &[Camera; 2]) -> Matrix3<f64> {
    let of = |camera: &Camera| {
        let column = |x, y| camera.homogeneous(&Vector3::new(x, y, 0.0));
        let origin = column(0.0, 0.0);
        Matrix3::from_columns(&[column(1.0, 0.0) - origin, column(0.0, 1.0) - origin, origin])
    };
    of(&cameras[1]) * of(&cameras[0]).try_inverse().unwrap()
}

#[test]
fn lines_on_the_floor_give_its_homography() {
    let mut random = Random(34);
    for _ in 0..6 {
        let cameras = random_pair(&mut random);
        let sizes = [cameras[0].size, cameras[1].size];
        let h = floor_homography(&cameras);
        let mut candidates = Vec::new();
        while candidates.len() < 150 {
            let mut spot = || Vector3::new(random.between(-2.5, 2.5), random.between(-2.5, 2.5), 0.0);
            let (p, q) = (spot(), spot());
            let seen = |camera: &Camera| camera.project(&p).is_some() && camera.project(&q).is_some();
            if (p - q).norm() < 0.5 || !cameras.iter().all(seen) {
                continue;
            }
            let [a, b] = [0, 1].map(|i| {
                let camera = &cameras[i];
                line_through(&camera.homogeneous(&p), &camera.homogeneous(&q))
            });
            let both =
                shaken(&a, &cameras[0], 0.3, &mut random).zip(shaken(&b, &cameras[1], 0.3, &mut random));
            candidates.extend(both.and_then(|(a, b)| candidate(&a, &b, &cameras, 0.9)));
        }
        candidates.extend(outliers(&cameras, 100, &mut random));
        let floors = find_floors(&candidates, sizes, 1, 3, &mut Unwatched).unwrap();
        let floor = &floors[0];
        assert!(floor.inliers > 120 && floor.spread > 80, "{} {}", floor.inliers, floor.spread);
        let mut offs = Vec::new();
        for x in -2..=2 {
            for y in -2..=2 {
                let point = Vector3::new(f64::from(x), f64::from(y), 0.0);
                let Some(a) = cameras[0].see(&point) else { continue };
                let [expected, found] = [&h, &floor.homography].map(|h| {
                    let b = h * Vector3::new(a[0], a[1], 1.0);
                    [b.x / b.z, b.y / b.z]
                });
                let b = cameras[1].project(&point).unwrap();
                assert!((expected[0] - b[0]).hypot(expected[1] - b[1]) < 1e-6);
                offs.push((found[0] - b[0]).hypot(found[1] - b[1]));
            }
        }
        assert!(offs.iter().sum::<f64>() < 1.0 * offs.len() as f64, "{offs:?} px");
    }
}

#[test]
fn epipolar_lines_are_no_floor() {
    let mut random = Random(35);
    let cameras = random_pair(&mut random);
    let sizes = [cameras[0].size, cameras[1].size];
    let mut candidates = epipolar(&cameras, 150, 0.3, &mut random);
    candidates.extend(outliers(&cameras, 50, &mut random));
    for floor in find_floors(&candidates, sizes, 1, 3, &mut Unwatched).unwrap() {
        // A pencil fits many homographies; that its lines meet in one point gives it away.
        assert!(floor.spread < 25, "{} of {}", floor.spread, floor.inliers);
    }
    assert!(find_floors(&candidates[..19], sizes, 1, 3, &mut Unwatched).unwrap().is_empty());
}

/// The scene, its recordings and the true matrix.
fn flying() -> &'static (Scene, [Recording; 2], Fundamental) {
    static SHARED: OnceLock<(Scene, [Recording; 2], Fundamental)> = OnceLock::new();
    SHARED.get_or_init(|| {
        let scene = Scene::new(4, 300, 8);
        let recordings = scene.recordings(1);
        let f = fundamental(&scene.cameras[0], &scene.cameras[1]);
        (scene, recordings, f)
    })
}

fn all_frames() -> Vec<(u32, u32)> {
    (0..300).map(|i| (i, i)).collect()
}

fn at_radius(radius: f64, shift: usize) -> FrontierOptions {
    FrontierOptions { radius, upright: true, shift }
}

#[test]
fn tangents_tell_the_true_matrix() {
    let (scene, [a, b], f) = flying();
    let views = Views::new(a, b, &all_frames());
    let truth = compare(&views, f, &at_radius(2.0, 0));
    let score = truth.score;
    assert!(score.matches() * 2 > score.tangents(), "{score:?}");
    assert_eq!(score.matches(), truth.points.len());
    assert!(score.tops.excess > 300.0 && score.bottoms.excess > 300.0, "{score:?}");
    let near = truth.points.iter().filter(|p| p.distance < 0.7).count();
    assert!(10 * near > 7 * truth.points.len(), "{near} of {}", truth.points.len());
    for p in &truth.points {
        let distance = epibar::geometry::sampson_distance(f, p.a, p.b).abs();
        assert!((distance - p.distance).abs() < 1e-9 && p.distance < 2.0 && p.surprise > 0.0);
        assert!((p.frame as usize) < scene.frames);
    }
    assert!([Class::Top, Class::Bottom].iter().all(|c| truth.points.iter().any(|p| p.class == *c)));

    // The same frames out of step: chance, which counts for nothing.
    let total = |f: &Fundamental, shift| frontier_score(&views, f, &at_radius(2.0, shift)).total();
    let shifted: Vec<f64> = (20..280).step_by(20).map(|shift| total(f, shift)).collect();
    let mean = shifted.iter().sum::<f64>() / shifted.len() as f64;
    assert!(mean.abs() < 0.08 * score.total(), "{mean} of {}", score.total());
    assert!(shifted.iter().all(|s| *s < 0.15 * score.total()), "{shifted:?} of {}", score.total());
    assert!(total(&f.transposed(), 0) < 0.15 * score.total());
    // The cameras the other way round see the same evidence, for the transpose only.
    let exchanged = Views::new(b, a, &all_frames());
    let of = |f: &Fundamental| frontier_score(&exchanged, f, &at_radius(2.0, 0));
    assert!((of(&f.transposed()).matches() as f64 / score.matches() as f64 - 1.0).abs() < 0.05);
    assert!(of(&f.transposed()).total() > 0.8 * score.total());
    assert!(of(f).total() < 0.15 * score.total());
    // Of a matrix nothing depends on the sign.
    let negative = Fundamental::from_parts(-f.matrix(), -f.epipole_a(), *f.epipole_b()).unwrap();
    assert_eq!(compare(&views, &negative, &at_radius(2.0, 0)).points.len(), truth.points.len());
    assert_eq!(FrontierScore::default().tangents(), 0);
}

#[test]
fn views_are_the_frames_asked_for() {
    let (_, [a, b], f) = flying();
    // B a frame early: the pairs put it right.
    let late: Vec<(u32, u32)> = (0..299).map(|i| (i + 1, i)).collect();
    let total =
        |pairs: &[(u32, u32)]| frontier_score(&Views::new(a, b, pairs), f, &at_radius(2.0, 0)).total();
    assert!(total(&all_frames()) > 1.5 * total(&late));
    let busy = busy_frames(a, b, &all_frames(), 60);
    assert!(busy.len() == 60 && busy.is_sorted() && busy.iter().all(|(i, j)| i == j));
    let few = Views::new(a, b, &busy);
    assert_eq!((few.frames(), few.a.frames(), few.b.frames()), (60, 60, 60));
    for (frame, &(in_a, _)) in busy.iter().enumerate() {
        let hulls: Vec<_> = a.silhouettes.hulls(in_a as usize).map(|h| a.silhouettes.hull(h)).collect();
        let ours: Vec<_> = few.a.hulls_of(frame).collect();
        assert!(ours.len() <= hulls.len() && !ours.is_empty());
        assert!(ours.iter().all(|h| hulls.iter().any(|k| h.len() == k.len())));
    }
}

#[test]
fn refinement_leads_back_to_the_true_matrix() {
    let (scene, [a, b], f) = flying();
    let views = Views::new(a, b, &all_frames());
    let parameters = SevenParameters::new(f, views.sizes()).unwrap();
    let mut random = Random(36);
    let mut worst: f64 = 0.0;
    for _ in 0..8 {
        let step = Step::from_fn(|_, _| random.between(-0.012, 0.012));
        let start = parameters.stepped(&step).fundamental().unwrap();
        worst = worst.max(error(&start, &scene.cameras));
        let refined = refine(&views, &start, &[12.0, 6.0, 3.0, 1.5], 3, true).unwrap();
        let off = error(&refined, &scene.cameras);
        assert!(off < 0.1, "{off} px from {} px", error(&start, &scene.cameras));
    }
    assert!(worst > 2.0, "the starts must be off: {worst} px");
    // Nothing to refine on.
    let nothing = Views::new(a, b, &all_frames()[..1]);
    assert!(refine(&nothing, f, &[2.0], 1, true).is_none());
}
