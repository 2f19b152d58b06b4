//! Tangents of silhouettes under a matrix: they know the true one, and chance counts for nothing.

mod common;

use std::sync::OnceLock;

use common::cameras::fundamental;
use common::flying::Scene;
use common::pairs;
use epibar::internals::{
    Class, FramePair, FrontierScore, Views, busy_frames, compare, frontier_score, shifted_score,
};
use epibar::{Fundamental, Recording};

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

#[test]
fn tangents_know_the_true_matrix() {
    let (scene, [a, b], f) = flying();
    let views = Views::new(a, b, &pairs(300));
    let truth = compare(&views, f, 2.0);
    let score = truth.score;
    assert!(score.matches() * 2 > score.tangents(), "{score:?}");
    assert_eq!(score.matches(), truth.matches.len());
    assert!(score.tops.excess > 300.0 && score.bottoms.excess > 300.0, "{score:?}");
    let near = truth.matches.iter().filter(|p| p.distance < 0.7).count();
    assert!(10 * near > 7 * truth.matches.len(), "{near} of {}", truth.matches.len());
    for p in &truth.matches {
        let distance = epibar::sampson_distance(f, p.a, p.b).abs();
        assert!((distance - p.distance).abs() < 1e-9 && p.distance < 2.0 && p.surprise > 0.0);
        assert!(p.frame.index() < scene.frames);
    }
    assert!([Class::Top, Class::Bottom].iter().all(|c| truth.matches.iter().any(|p| p.class == *c)));

    // Frames out of step: chance, which counts for nothing in either class, and against the whole.
    let total = |f: &Fundamental, shift| shifted_score(&views, f, 2.0, shift).total();
    let of_classes = |score: &FrontierScore| score.tops.excess + score.bottoms.excess;
    let shifted: Vec<FrontierScore> =
        (20..280).step_by(20).map(|shift| shifted_score(&views, f, 2.0, shift)).collect();
    let mean =
        |of: &dyn Fn(&FrontierScore) -> f64| shifted.iter().map(of).sum::<f64>() / shifted.len() as f64;
    let (classes, whole) = (mean(&of_classes), mean(&FrontierScore::total));
    assert!(classes.abs() < 0.08 * of_classes(&score), "{classes} of {}", of_classes(&score));
    assert!(whole < 0.0, "{whole} of {}", score.total());
    assert!(shifted.iter().all(|s| s.total() < 0.15 * score.total()), "{shifted:?} of {}", score.total());
    assert!(3 * score.objects.whole > score.objects.silhouettes, "{:?}", score.objects);
    assert!(shifted.iter().all(|s| 5 * s.objects.whole < score.objects.whole), "{shifted:?}");
    assert!(total(&f.transposed(), 0) < 0.15 * score.total());
    // The cameras the other way round score as high, for the transpose only.
    let exchanged = Views::new(b, a, &pairs(300));
    let of = |f: &Fundamental| frontier_score(&exchanged, f, 2.0);
    assert!((of(&f.transposed()).matches() as f64 / score.matches() as f64 - 1.0).abs() < 0.05);
    assert!(of(&f.transposed()).total() > 0.8 * score.total());
    assert!(of(f).total() < 0.15 * score.total());
    // Of a matrix nothing depends on the sign.
    let [size_a, size_b] = views.sizes();
    let negative = Fundamental::from_matrix(&-f.matrix(), size_a, size_b).unwrap();
    assert_eq!(compare(&views, &negative, 2.0).matches.len(), truth.matches.len());
    assert_eq!(FrontierScore::default().tangents(), 0);
}

#[test]
fn views_are_the_frames_asked_for() {
    let (_, [a, b], f) = flying();
    // B a frame early: the pairs put it right.
    let late: Vec<FramePair> = (0..299).map(|i| FramePair::new(i + 1, i)).collect();
    let total = |pairs: &[FramePair]| frontier_score(&Views::new(a, b, pairs), f, 2.0).total();
    assert!(total(&pairs(300)) > 1.5 * total(&late));
    let busy = busy_frames(a, b, &pairs(300), Some(60));
    assert!(busy.len() == 60 && busy.is_sorted() && busy.iter().all(|p| p.a == p.b));
    let few = Views::new(a, b, &busy);
    assert_eq!((few.frames(), few.a.frames(), few.b.frames()), (60, 60, 60));
    for (frame, in_a) in busy.iter().map(|p| p.a).enumerate() {
        let hulls: Vec<_> = a.silhouettes().hulls(in_a.index()).map(|h| a.silhouettes().hull(h)).collect();
        let ours: Vec<_> = few.a.hulls_of(frame).collect();
        assert!(ours.len() <= hulls.len() && !ours.is_empty());
        assert!(ours.iter().all(|h| hulls.iter().any(|k| h.len() == k.len())));
    }
}
