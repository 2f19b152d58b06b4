//! A view that ends before the image does: no tangents at its edge.

use epibar::internals::{FramePair, TangentMatch, Views, compare};
use epibar::{Error, Fundamental, ImageSize, Recorder, RecorderOptions, Recording};
use nalgebra::Matrix3;

/// Both cameras have seen nothing where x + y lies below this, x counted from the left of what A shows.
const CORNER: i64 = 70;
/// What A shows is so far to the right in B, pixels.
const RIGHT: i64 = 25;

fn size(right: i64) -> ImageSize {
    ImageSize::new(160 + right as usize, 120).unwrap()
}

/// A disc that comes out from behind the corner, at the same height in both images.
fn record(right: i64, with_visible: bool) -> Recording {
    let size = size(right);
    let at = |pixel: usize| ((pixel % size.width()) as i64 - right, (pixel / size.width()) as i64);
    let mut recorder = Recorder::new(size, RecorderOptions::new().lines(50)).unwrap();
    if with_visible {
        // A square of 5 x 5 pixels leaves out those with a hidden pixel four steps towards the corner.
        let visible: Vec<u8> =
            (0..size.pixels()).map(at).map(|(x, y)| u8::from(x + y - 4 >= CORNER)).collect();
        recorder = recorder.with_visible(&visible).unwrap();
    }
    for frame in 0..90 {
        let (u, v) = (30.0 + 0.9 * f64::from(frame), 55.0 - 25.0 * (0.07 * f64::from(frame)).sin());
        let mask: Vec<u8> = (0..size.pixels())
            .map(at)
            .map(|(x, y)| u8::from((x as f64 - u).hypot(y as f64 - v) < 14.0 && x + y >= CORNER))
            .collect();
        recorder.push(&mask, 0.04 * f64::from(frame)).unwrap();
    }
    recorder.finish().unwrap()
}

/// Frontier points of A and B under the matrix of equal heights.
fn frontier_points(a: &Recording, b: &Recording) -> Vec<TangentMatch> {
    let matrix = Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0);
    let f = Fundamental::from_matrix(&matrix, a.size(), b.size()).unwrap();
    let pairs: Vec<FramePair> = (0..90).map(|i| FramePair::new(i, i)).collect();
    compare(&Views::new(a, b, &pairs), &f, 2.0).matches
}

/// Pixels between a point of A and the edge of what is seen.
fn from_edge(p: [f64; 2]) -> f64 {
    (p[0] + p[1] - CORNER as f64) / 2f64.sqrt()
}

#[test]
fn no_tangent_where_a_corner_hides_the_object() {
    let all = frontier_points(&record(0, false), &record(RIGHT, false));
    let at_edge = all.iter().filter(|p| from_edge(p.a) < 2.0).count();
    assert!(at_edge > 20 && all.len() > at_edge + 60, "{at_edge} of {}", all.len());

    let (a, b) = (record(0, true), record(RIGHT, true));
    let kept = frontier_points(&a, &b);
    for p in &kept {
        let in_a = [p.b[0] - RIGHT as f64, p.b[1]];
        assert!(from_edge(p.a) >= 2.0 && from_edge(in_a) >= 2.0, "{p:?}");
    }
    assert!(kept.len() + at_edge + 10 >= all.len(), "{} of {} are left", kept.len(), all.len());

    // A silhouette is cut where one of its vertices is at the edge.
    let cut = |r: &Recording| (0..r.silhouettes().len()).filter(|&h| r.silhouettes().is_cut(h)).count();
    assert_eq!(cut(&a), cut(&b));
    assert!((20..80).contains(&cut(&a)), "{} of 90 are cut", cut(&a));
    assert!(cut(&record(0, false)) < cut(&a));
}

#[test]
fn an_area_of_another_size_is_refused() {
    let recorder = || Recorder::new(size(0), RecorderOptions::new().lines(5)).unwrap();
    let error = recorder().with_visible(&[1; 100]).unwrap_err();
    assert!(matches!(error, Error::Length { left: 100, right: 19_200, .. }));
    assert!(error.to_string().starts_with("visible "), "{error}");

    let mut late = recorder();
    late.push(&vec![0; 19_200], 0.0).unwrap();
    assert!(matches!(late.with_visible(&vec![1; 19_200]), Err(Error::Argument { name: "visible", .. })));
}

#[test]
fn what_is_all_visible_is_not_kept() {
    let kept = |visible: &[u8]| {
        let recorder = Recorder::new(size(0), RecorderOptions::new().lines(5)).unwrap();
        let mut recorder = recorder.with_visible(visible).unwrap();
        recorder.push(&vec![0; 19_200], 0.0).unwrap();
        recorder.finish().unwrap().visible().map(<[u8]>::to_vec)
    };
    assert_eq!(kept(&vec![255; 19_200]), None);
    let mut visible = vec![255; 19_200];
    visible[7] = 0;
    let found = kept(&visible).unwrap();
    assert_eq!((found[6], found[7], found.iter().map(|&v| usize::from(v)).sum()), (1, 0, 19_199));
}
