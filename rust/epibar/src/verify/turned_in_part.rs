//! The geometry of a part of the recording, if a camera was turned for that part.
//!
//! A small turn moves the image on: so either camera's image is moved to all sides, what meets best is refined on the part, and the
//! seven parameters take up what a shift is not.

use nalgebra::Matrix3;
use rayon::prelude::*;

use crate::frontier::{Views, total_score};
use crate::geometry::Fundamental;
use crate::refine::refine;

/// An image is moved by up to this share of its width: a turn of 17° at a focal length of one width.
const FARTHEST: f64 = 0.3;
/// Within what tangents meet at first, pixels of a 640×480 image.
const RADIUS: f64 = 8.0;
/// Steps between two shifts, in radii.
const SPACING: f64 = 1.5;
/// Silhouettes of a camera on which shifts are compared, and frames at least and at most.
const SILHOUETTES: usize = 800;
const FRAMES: (usize, usize) = (24, 120);
/// So many of the best on one in [`PREVIEW_STEP`] of these frames are compared on all of them.
const COMPARED: usize = 240;
const PREVIEW_STEP: usize = 4;
/// How many of the best are refined.
const REFINED: usize = 12;
/// Rounds at each radius.
const ROUNDS: usize = 3;

/// What explains these frames best of all that a shift of either image leads to from `f`; `None` where too little meets.
pub(super) fn moved_for(
    views: &Views,
    frames: &[usize],
    f: &Fundamental,
    radius: f64,
) -> Option<Fundamental> {
    let part = views.chosen(frames);
    let in_a_frame = part.a.hulls().max(part.b.hulls()) / frames.len().max(1);
    let most = (SILHOUETTES / in_a_frame.max(1)).clamp(FRAMES.0, FRAMES.1);
    let every = |step: usize, views: &Views| {
        views.chosen(&(0..views.frames()).step_by(step.max(1)).collect::<Vec<_>>())
    };
    let few = every(frames.len().div_ceil(most), &part);
    let coarse = (RADIUS * views.pixel_scale()).max(2.0 * radius);
    let previewed =
        best_on(&every(PREVIEW_STEP, &few), shifted(views, f, SPACING * coarse), coarse, COMPARED);
    let refined = best_on(&few, previewed, coarse, REFINED).into_par_iter().filter_map(|moved| {
        let refined = refine(&part, &moved, &[coarse, 2.0 * radius, radius], ROUNDS)?;
        let score = total_score(&part, &refined, radius);
        score.is_finite().then_some((score, refined))
    });
    let refined: Vec<_> = refined.collect();
    refined.into_iter().max_by(|p, q| p.0.total_cmp(&q.0)).map(|(_, moved)| moved)
}

/// So many of the geometries, those with the most evidence on some frames, the best first.
fn best_on(views: &Views, tried: Vec<Fundamental>, radius: f64, count: usize) -> Vec<Fundamental> {
    let scored = tried.into_par_iter().map(|f| (total_score(views, &f, radius), f));
    let mut scored: Vec<_> = scored.filter(|(score, _)| score.is_finite()).collect();
    scored.sort_by(|p, q| q.0.total_cmp(&p.0));
    scored.into_iter().take(count).map(|(_, f)| f).collect()
}

/// `f` after shifts of either image to all sides, `spacing` pixels apart.
fn shifted(views: &Views, f: &Fundamental, spacing: f64) -> Vec<Fundamental> {
    let [size_a, size_b] = views.sizes();
    let mut found = vec![];
    for (size, of_a) in [(size_a, true), (size_b, false)] {
        let steps = (FARTHEST * size.width as f64 / spacing).ceil() as i32;
        for (i, j) in (-steps..=steps).flat_map(|i| (-steps..=steps).map(move |j| (i, j))) {
            let mut back = Matrix3::identity();
            (back[(0, 2)], back[(1, 2)]) = (-spacing * f64::from(i), -spacing * f64::from(j));
            let matrix = if of_a { f.matrix() * back } else { back.transpose() * f.matrix() };
            found.extend(Fundamental::from_matrix(&matrix, size_a, size_b));
        }
    }
    found
}
