//! Does one plane explain everything?
//!
//! Where all that moves keeps to one straight path, or where both cameras stand at one place, a homography sends
//! every matched point of A to its match in B, and `F = [e']× H` for any `e'` (Hartley and Zisserman §11.9): the
//! score is high and says nothing of `F` off that plane. Objects have a width, so a path is a slab, not a plane: what
//! is measured is the distance from the best plane in widths of a silhouette, the mean of both images. Feet alone always lie on a plane, the
//! floor, so it is four fifths of the points that must fit, not half.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rayon::prelude::*;

use super::thresholds::MIN_POINTS;
use crate::frontier::{TangentMatch, View, Views};
use crate::geometry::fundamental::normaliser;
use crate::geometry::homography::{self, PointMatch, transfer_distance};
use crate::geometry::hull::shorter_side;
use crate::geometry::median::median;
use crate::random::Stream;

/// Share of the points that must fit.
const SHARE: f64 = 0.8;
/// Most points looked at.
const POINTS: usize = 1500;
/// Samples of four points: where half of the points lie on a plane one sample in sixteen is of it.
const SAMPLES: usize = 1200;
/// The best of them, which are fitted to more points.
const FITTED: usize = 24;
/// Samples that tell how good the others must be for that.
const FIRST: usize = 5 * FITTED;
/// Rounds of fitting to the points that fit.
const ROUNDS: usize = 6;

/// Matched points in normalised coordinates, and how many widths of a silhouette the unit is in A and in B.
struct Matched {
    points: Vec<PointMatch>,
    widths: [f64; 2],
}

/// How far four fifths of the matched points lie from the best homography between the views, in widths of the median
/// silhouettes; NaN with too few points to tell.
pub fn plane_residual(views: &Views, points: &[TangentMatch], seed: u64) -> f64 {
    let sizes = views.sizes();
    let (ta, tb) = (normaliser(sizes[0]), normaliser(sizes[1]));
    let step = points.len().div_ceil(POINTS).max(1);
    let normalised =
        |p: &TangentMatch| (ta * Vector3::new(p.a[0], p.a[1], 1.0), tb * Vector3::new(p.b[0], p.b[1], 1.0));
    let in_widths = |view: &View| 0.5 * view.size.diagonal() / median_width(view);
    let matched = Matched {
        points: points.iter().step_by(step).map(normalised).collect(),
        widths: [in_widths(&views.a), in_widths(&views.b)],
    };
    if matched.points.len() < MIN_POINTS || !matched.widths.iter().all(|w| w.is_finite()) {
        return f64::NAN;
    }
    let best = best_of(matched.drawn(0..FIRST, f64::INFINITY, seed));
    let enough = best.get(FITTED - 1).map_or(f64::INFINITY, |worst| worst.0);
    let others = matched.drawn(FIRST..SAMPLES, enough, seed);
    let best = best_of(best.into_iter().chain(others).collect());
    best.into_par_iter().map(|(_, h)| matched.fitted(&h)).reduce(|| f64::INFINITY, f64::min)
}

impl Matched {
    /// Homographies of samples of four points, each with its residual, without those whose residual is above `limit`.
    fn drawn(&self, samples: Range<usize>, limit: f64, seed: u64) -> Vec<(f64, Matrix3<f64>)> {
        let of_sample = |k: usize| {
            let mut random = Stream::Planes.generator(seed, k as u64);
            let count = self.points.len();
            let drawn: [PointMatch; 4] = std::array::from_fn(|_| self.points[random.random_range(0..count)]);
            let h = homography::from_points(drawn.iter())?;
            Some((self.within(&h, limit)?.0, h))
        };
        samples.into_par_iter().filter_map(of_sample).collect()
    }

    /// The residual of a homography fitted again and again to the matches that fit.
    fn fitted(&self, h: &Matrix3<f64>) -> f64 {
        let Some((mut residual, mut distances)) = self.within(h, f64::INFINITY) else { return f64::INFINITY };
        for _ in 0..ROUNDS {
            let near = self.points.iter().zip(&distances).filter(|(_, d)| **d <= residual).map(|(m, _)| m);
            let Some(better) = homography::from_points(near) else { break };
            match self.within(&better, residual) {
                Some((value, of_better)) if value < residual => (residual, distances) = (value, of_better),
                _ => break,
            }
        }
        residual
    }

    /// The transfer distance below which [`SHARE`] of the matches lie, and all distances: widths, the mean of both images. `None` where it is above `limit`,
    /// which shows before all are measured, or where `h` has no inverse.
    fn within(&self, h: &Matrix3<f64>, limit: f64) -> Option<(f64, Vec<f64>)> {
        let inverse = h.try_inverse()?;
        let distance = |&(a, b): &PointMatch| {
            let (there, back) = (transfer_distance(h, &(a, b)), transfer_distance(&inverse, &(b, a)));
            0.5 * (self.widths[0] * back + self.widths[1] * there)
        };
        let count = self.points.len();
        let at = ((SHARE * count as f64) as usize).min(count - 1);
        let mut distances = Vec::with_capacity(count);
        let mut above = 0;
        for matched in &self.points {
            let distance = distance(matched);
            distances.push(distance);
            above += usize::from(distance > limit);
            if above >= count - at {
                return None;
            }
        }
        let mut sorted = distances.clone();
        let (_, value, _) = sorted.select_nth_unstable_by(at, f64::total_cmp);
        Some((*value, distances))
    }
}

/// The homographies with the least residuals.
fn best_of(mut drawn: Vec<(f64, Matrix3<f64>)>) -> Vec<(f64, Matrix3<f64>)> {
    drawn.sort_by(|p, q| p.0.total_cmp(&q.0));
    drawn.truncate(FITTED);
    drawn
}

/// Median over the silhouettes of the shorter side of the bounding box, pixels; 0 without any.
pub(super) fn median_width(view: &View) -> f64 {
    let frames = (0..view.frames()).step_by(view.frames().div_ceil(200).max(1));
    median(frames.flat_map(|frame| view.hulls_of(frame)).map(shorter_side)).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_samples_are_those_of_all_measured_whole() {
        // Most lie on one plane, and some anywhere.
        let mut random = Stream::Planes.generator(9, 0);
        let h = Matrix3::new(0.9, 0.2, 0.1, -0.1, 1.1, -0.2, 0.1, -0.05, 1.0);
        let mut at = |scatter: f64| {
            let a = Vector3::new(random.random_range(-0.8..0.8), random.random_range(-0.6..0.6), 1.0);
            let b = h * a;
            let off = [0, 1].map(|_| scatter * random.random_range(-1.0..1.0));
            (a, Vector3::new(b.x / b.z + off[0], b.y / b.z + off[1], 1.0))
        };
        let points: Vec<PointMatch> = (0..300).map(|k| at(if k % 3 == 0 { 0.5 } else { 0.01 })).collect();
        let matched = Matched { points, widths: [20.0, 30.0] };
        let whole = best_of(matched.drawn(0..SAMPLES, f64::INFINITY, 4));
        let first = best_of(matched.drawn(0..FIRST, f64::INFINITY, 4));
        let others = matched.drawn(FIRST..SAMPLES, first[FITTED - 1].0, 4);
        assert!(others.len() < SAMPLES / 3, "{}", others.len());
        assert_eq!(best_of(first.into_iter().chain(others).collect()), whole);
    }
}
