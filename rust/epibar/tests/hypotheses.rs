//! Hypotheses from line pairs, from the floor, from silhouettes followed through time, and from two maps of a floor.

mod common;

use common::cameras::{Camera, error, fundamental, points, random_pair};
use common::flying::hull;
use common::masks::Random;
use common::pairs;
use epibar::internals::{
    Candidate, LineModel, LinePair, Scorer, SingleView, TopView, TrackModel, Views, border_segments,
    different, find_floors, ransac, refine, tracks,
};
use epibar::{ImageSize, Line, Recorder, RecorderOptions, Recording, Segment, Stage, Unwatched};
use nalgebra::{Matrix3, Vector3};

/// A candidate from two lines; `None` where one misses its image.
fn candidate(a: &Line, b: &Line, cameras: &[Camera; 2], correlation: f64) -> Option<Candidate> {
    let (segment_a, segment_b) = (a.clip(cameras[0].size)?, b.clip(cameras[1].size)?);
    let lines = LinePair { a: *a, b: *b };
    Some(Candidate { lines, segment_a, segment_b, correlation })
}

/// The line with both ends of its segment moved by up to `noise` pixels.
fn perturbed(line: &Line, camera: &Camera, noise: f64, random: &mut Random) -> Option<Line> {
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
        let both = perturbed(&a, &cameras[0], noise, random).zip(perturbed(&b, &cameras[1], noise, random));
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
        let best = ransac(&model, 1500, 3, 1, Stage::Lines, &mut Unwatched).unwrap();
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
            let both = perturbed(&a, &cameras[0], 0.3, &mut random).zip(perturbed(
                &b,
                &cameras[1],
                0.3,
                &mut random,
            ));
            candidates.extend(both.and_then(|(a, b)| candidate(&a, &b, &cameras, 0.9)));
        }
        candidates.extend(outliers(&cameras, 100, &mut random));
        let floors = find_floors(&candidates, sizes, 1, 3, &mut Unwatched).unwrap();
        let floor = &floors[0];
        assert!(
            floor.inliers > 120 && floor.outside_pencil > 80,
            "{} {}",
            floor.inliers,
            floor.outside_pencil
        );
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
        assert!(floor.outside_pencil < 25, "{} of {}", floor.outside_pencil, floor.inliers);
    }
    assert!(find_floors(&candidates[..19], sizes, 1, 3, &mut Unwatched).unwrap().is_empty());
}

fn record(size: ImageSize, masks: impl Iterator<Item = Vec<u8>>) -> Recording {
    let mut recorder = Recorder::new(size, RecorderOptions::new().lines(50)).unwrap();
    for (frame, mask) in masks.enumerate() {
        recorder.push(&mask, frame as f64 / 25.0).unwrap();
    }
    recorder.finish().unwrap()
}

fn all_frames(a: &Recording, b: &Recording) -> Views {
    Views::new(a, b, &pairs(a.frames() as u32))
}

/// A rectangle of `width` × 30 pixels at (x, 20).
fn paint(mask: &mut [u8], size: ImageSize, x: usize, width: usize) {
    for y in 20..50 {
        mask[y * size.width() + x..y * size.width() + x + width].fill(1);
    }
}

#[test]
fn a_track_ends_where_silhouettes_merge_and_where_time_jumps() {
    let size = ImageSize::new(160, 80).unwrap();
    // Two rectangles walk towards each other, one pixel a frame, touch at frame 30, and part again.
    let recording = record(
        size,
        (0..90).map(|t: usize| {
            let mut mask = vec![0; size.pixels()];
            paint(&mut mask, size, 20 + t.min(60), 20);
            paint(&mut mask, size, 100 - t.min(60), 20);
            mask
        }),
    );
    let view = all_frames(&recording, &recording).a;
    let found = tracks(&view, |_| true, 5);
    let early: Vec<_> = found.iter().filter(|t| t.start == 0).collect();
    assert_eq!(early.len(), 2);
    for track in &early {
        assert!((28..=31).contains(&track.end()), "{}", track.end());
        let [top, bottom] = track.extremes[10].unwrap();
        assert_eq!((top[1], bottom[1]), (20.0, 49.0));
    }
    // A gap in time ends them all.
    let cut = tracks(&view, |t| t != 14, 5);
    assert!(cut.iter().all(|t| t.end() <= 15 || t.start >= 15));
    assert!(tracks(&view, |_| true, 1000).is_empty());
}

/// Upright boxes, as tall and as wide as people, that walk about before two cameras at the height of a person.
fn walkers() -> ([Camera; 2], Views) {
    let cameras = [
        Camera::new([7.0, -3.0, 1.8], [0.0, 0.0, 1.0], (320, 240), 300.0, 0.0),
        Camera::new([2.0, -7.5, 1.6], [0.0, 0.0, 1.0], (320, 240), 320.0, 0.0),
    ];
    let masks = |camera: &Camera| {
        (0..240)
            .map(|t| {
                let mut mask = vec![0; camera.size.pixels()];
                for k in 0..4 {
                    let (k, t) = (f64::from(k), f64::from(t) / 25.0);
                    let (x, y) = ((0.55 * t + 1.7 * k).sin() * 2.2, (0.4 * t + 2.9 * k).cos() * 2.2);
                    let height = 1.6 + 0.1 * k;
                    let corners: Vec<[f64; 2]> = (0..8)
                        .map(|i| {
                            let side = |bit: usize| if i >> bit & 1 == 0 { -0.2 } else { 0.2 };
                            let z = if i >> 2 & 1 == 0 { 0.0 } else { height };
                            camera.project(&Vector3::new(x + side(0), y + side(1), z)).unwrap()
                        })
                        .collect();
                    common::flying::fill(&mut mask, camera.size.width(), &hull(corners));
                }
                mask
            })
            .collect::<Vec<_>>()
    };
    let [a, b] = cameras.each_ref().map(|c| record(c.size, masks(c).into_iter()));
    let views = all_frames(&a, &b);
    (cameras, views)
}

#[test]
fn tracks_of_walkers_lead_near_the_truth_without_a_single_line() {
    let (cameras, views) = walkers();
    let scorer = Scorer::new(&views, 3.0);
    let model = TrackModel::new(&views, &scorer);
    assert!(model.pairs() >= 8, "{}", model.pairs());
    let best = ransac(&model, 4000, 20, 1, Stage::Tracks, &mut Unwatched).unwrap();
    // Near enough for refinement to find the rest of the way.
    let nearest = best
        .iter()
        .filter_map(|s| refine(&views, &s.model, &[8.0, 4.0, 2.0], 2))
        .map(|f| error(&f, &cameras))
        .fold(f64::INFINITY, f64::min);
    assert!(nearest < 1.5, "{nearest} px");
}

#[test]
fn one_camera_tells_how_high_it_hangs_and_how_it_is_held() {
    let (cameras, views) = walkers();
    for (camera, view) in cameras.iter().zip([&views.a, &views.b]) {
        let held = SingleView::of(view, Some(&camera.matrix()));
        assert_eq!(held.len(), 1);
        // Heights of people of 1.6 to 1.9 m.
        let height = camera.centre().z / 1.75;
        assert!((held[0].height() / height - 1.0).abs() < 0.15, "{} {height}", held[0].height());
        let up = camera.rotation() * Vector3::z();
        let off = held[0].axes().column(2).angle(&up).to_degrees();
        assert!(off < 2.0, "{off} degrees");
        // A place of the floor is seen where it is.
        let foot = camera.project(&Vector3::new(0.3, -0.2, 0.0)).unwrap();
        let top = camera.project(&Vector3::new(0.3, -0.2, 1.75)).unwrap();
        let place = held[0].place(&[top, foot]).expect("a whole figure");
        let seen = held[0].pixel(place).expect("in front of the camera");
        assert!((seen[0] - foot[0]).hypot(seen[1] - foot[1]) < 1e-6);
        // What is half as tall is no figure.
        let waist = camera.project(&Vector3::new(0.3, -0.2, 0.8)).unwrap();
        assert_eq!(held[0].place(&[waist, foot]), None);
        // Without a matrix several focal lengths stay, and one is near.
        let unknown = SingleView::of(view, None);
        assert!(unknown.len() > 1);
        assert!(unknown.iter().any(|view| (view.height() / height - 1.0).abs() < 0.25));
    }
}

#[test]
fn two_maps_of_a_floor_lead_near_the_truth_without_lines_or_tracks() {
    let (cameras, views) = walkers();
    // Moments far apart and out of order, so that nothing can be followed.
    let views = views.chosen(&(0..120).map(|k| k * 47 % 240).collect::<Vec<_>>());
    let scorer = Scorer::new(&views, 3.0);
    assert_eq!(TrackModel::new(&views, &scorer).pairs(), 0);
    let top_view = TopView::new(&views).expect("figures on a floor");
    let best = ransac(&top_view, 4000, 200, 1, Stage::TopView, &mut Unwatched).unwrap();
    let best = different(best, 20);
    assert!(best.len() <= 20);
    let nearest = best
        .iter()
        .filter_map(|s| refine(&views, &top_view.fundamental(&s.model)?, &[8.0, 4.0, 2.0], 2))
        .map(|f| error(&f, &cameras))
        .fold(f64::INFINITY, f64::min);
    assert!(nearest < 1.5, "{nearest} px");
    // Where it is not known which end is up nothing stands anywhere.
    assert!(TopView::new(&views.clone().with_upright(false)).is_none());
}
