//! Silhouettes followed through time, hypotheses from them, and whether one plane explains everything.

mod common;

use common::cameras::{Camera, error, fundamental};
use common::flying::{Scene, hull};
use common::masks::Random;
use epibar::estimate::frontier::{Class, FrontierOptions, FrontierPoint, Scorer};
use epibar::estimate::ransac::{Unwatched, ransac};
use epibar::estimate::refine::refine;
use epibar::estimate::track_model::TrackModel;
use epibar::estimate::tracks::tracks;
use epibar::estimate::views::Views;
use epibar::planarity::plane_residual;
use epibar::{ImageSize, Recorder, RecorderOptions, Recording};
use nalgebra::Vector3;

fn record(size: ImageSize, masks: impl Iterator<Item = Vec<u8>>) -> Recording {
    let mut recorder = Recorder::new(size, RecorderOptions { lines: 50, ..Default::default() }).unwrap();
    for (frame, mask) in masks.enumerate() {
        recorder.push(&mask, frame as f64 / 25.0).unwrap();
    }
    recorder.finish().unwrap()
}

fn all_frames(a: &Recording, b: &Recording) -> Views {
    let pairs: Vec<(u32, u32)> = (0..a.frames() as u32).map(|k| (k, k)).collect();
    Views::new(a, b, &pairs)
}

/// A rectangle of `width` × 30 pixels at (x, 20).
fn paint(mask: &mut [u8], size: ImageSize, x: usize, width: usize) {
    for y in 20..50 {
        mask[y * size.width + x..y * size.width + x + width].fill(1);
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
                    common::flying::fill(&mut mask, camera.size.width, &hull(corners));
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
    let options = FrontierOptions { radius: 3.0, upright: true, shift: 0 };
    let scorer = Scorer::new(&views, options);
    let model = TrackModel::new(&views, &scorer, 0.5, true);
    assert!(model.pairs() >= 8, "{}", model.pairs());
    let best = ransac(&model, 4000, 20, 1, "test", &mut Unwatched).unwrap();
    // Near enough for refinement to find the rest of the way.
    let nearest = best
        .iter()
        .filter_map(|s| refine(&views, &s.model, &[8.0, 4.0, 2.0], 2, true))
        .map(|f| error(&f, &cameras))
        .fold(f64::INFINITY, f64::min);
    assert!(nearest < 1.5, "{nearest} px");
}

#[test]
fn a_plane_is_told_from_a_volume() {
    let scene = Scene::new(4, 60, 3);
    let [a, b] = scene.recordings(50);
    let views = all_frames(&a, &b);
    let f = fundamental(&scene.cameras[0], &scene.cameras[1]);
    assert!(error(&f, &scene.cameras) < 1e-6);
    let mut random = Random(5);
    let mut matched = |depth: f64| -> Vec<FrontierPoint> {
        (0..400)
            .filter_map(|frame| {
                let point = Vector3::new(
                    random.between(-1.5, 1.5),
                    random.between(-depth, depth),
                    random.between(0.2, 2.2),
                );
                let (a, b) = (scene.cameras[0].see(&point)?, scene.cameras[1].see(&point)?);
                Some(FrontierPoint { frame, a, b, distance: 0.0, surprise: 1.0, class: Class::Top })
            })
            .collect()
    };
    let (path, volume) = (plane_residual(&views, &matched(0.03)), plane_residual(&views, &matched(1.5)));
    assert!(path < 0.2, "{path}");
    assert!(volume > 3.0 * path, "{path} {volume}");
    assert!(plane_residual(&views, &matched(1.5)[..10]).is_infinite());
}
