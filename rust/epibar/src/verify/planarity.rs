//! Does one plane explain everything?
//!
//! Where all that moves keeps to one straight path, or where both cameras stand at one place, a homography sends
//! every matched point of A to its match in B, and `F = [e']× H` for any `e'` (Hartley and Zisserman §11.9): the
//! score is high and says nothing of `F` off that plane. Objects have a width, so a path is a slab, not a plane: what
//! is measured is the distance from the best plane in widths of a silhouette. Feet alone always lie on a plane, the
//! floor, so it is four fifths of the points that must fit, not half.

use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rayon::prelude::*;

use crate::frontier::{TangentMatch, Views};
use crate::geometry::fundamental::normaliser;
use crate::geometry::homography;
use crate::geometry::hull::shorter_side;
use crate::random::generator;

/// Share of the points that must fit.
const SHARE: f64 = 0.8;
/// Most points looked at.
const POINTS: usize = 1500;
/// Samples of four points.
const SAMPLES: usize = 400;
/// The best of them, which are fitted to more points.
const FITTED: usize = 24;
/// Rounds of fitting to the points that fit.
const ROUNDS: usize = 6;

type Match = (Vector3<f64>, Vector3<f64>);

/// How far four fifths of the matched points lie from the best homography between the views, in widths of B's median
/// silhouette; infinite with too few points to tell.
pub fn plane_residual(views: &Views, points: &[TangentMatch], seed: u64) -> f64 {
    const SALT: u64 = 0x70_6C_61_6E_65;
    let sizes = views.sizes();
    let (ta, tb) = (normaliser(sizes[0]), normaliser(sizes[1]));
    let step = points.len().div_ceil(POINTS).max(1);
    let matches: Vec<Match> = points
        .iter()
        .step_by(step)
        .map(|p| (ta * Vector3::new(p.a[0], p.a[1], 1.0), tb * Vector3::new(p.b[0], p.b[1], 1.0)))
        .collect();
    let width = median_width(views);
    if matches.len() < 20 || width <= 0.0 {
        return f64::INFINITY;
    }
    let mut drawn: Vec<(f64, Matrix3<f64>)> = (0..SAMPLES)
        .into_par_iter()
        .filter_map(|k| {
            let mut random = generator(seed.wrapping_add(SALT), k as u64);
            let drawn: [Match; 4] = std::array::from_fn(|_| matches[random.random_range(0..matches.len())]);
            let h = homography::from_points(drawn.iter())?;
            Some((within(&h, &matches).0, h))
        })
        .collect();
    drawn.sort_by(|p, q| p.0.total_cmp(&q.0));
    drawn.truncate(FITTED);
    let best = drawn.into_par_iter().map(|(_, h)| fitted(&h, &matches)).reduce(|| f64::INFINITY, f64::min);
    best * 0.5 * sizes[1].diagonal() / width
}

/// The residual of a homography fitted again and again to the matches that fit.
fn fitted(h: &Matrix3<f64>, matches: &[Match]) -> f64 {
    let (mut residual, mut distances) = within(h, matches);
    for _ in 0..ROUNDS {
        let near = matches.iter().zip(&distances).filter(|(_, d)| **d <= residual).map(|(m, _)| m);
        let Some(better) = homography::from_points(near) else { break };
        let (value, of_better) = within(&better, matches);
        if value >= residual {
            break;
        }
        (residual, distances) = (value, of_better);
    }
    residual
}

/// The transfer distance in B below which [`SHARE`] of the matches lie, and all distances; normalised coordinates.
fn within(h: &Matrix3<f64>, matches: &[Match]) -> (f64, Vec<f64>) {
    let distances: Vec<f64> = matches
        .iter()
        .map(|(a, b)| {
            let p = h * a;
            let d = (p.x / p.z - b.x).hypot(p.y / p.z - b.y);
            if d.is_nan() { f64::INFINITY } else { d }
        })
        .collect();
    let mut sorted = distances.clone();
    let at = ((SHARE * sorted.len() as f64) as usize).min(sorted.len() - 1);
    let (_, value, _) = sorted.select_nth_unstable_by(at, f64::total_cmp);
    (*value, distances)
}

/// Median over B's silhouettes of the shorter side of the bounding box, pixels.
fn median_width(views: &Views) -> f64 {
    let mut widths: Vec<f64> = Vec::new();
    for frame in (0..views.frames()).step_by(views.frames().div_ceil(200).max(1)) {
        for hull in views.b.hulls_of(frame) {
            widths.push(shorter_side(hull));
        }
    }
    widths.sort_by(f64::total_cmp);
    widths.get(widths.len() / 2).copied().unwrap_or(0.0)
}
