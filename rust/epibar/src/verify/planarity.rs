//! Does one plane explain everything?
//!
//! Where all that moves keeps to one straight path, or where both cameras stand at one place, a homography sends
//! every matched point of A to its match in B, and `F = [e']× H` for any `e'` (Hartley and Zisserman §11.9): the
//! score is high and says nothing of `F` off that plane. Objects have a width, so a path is a slab, not a plane: what
//! is measured is the distance from the best plane in widths of a silhouette, the mean of both images. Feet alone always lie on a plane, the
//! floor, so it is four fifths of the points that must fit, not half.

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
    let mut drawn: Vec<(f64, Matrix3<f64>)> = (0..SAMPLES)
        .into_par_iter()
        .filter_map(|k| {
            let mut random = Stream::Planes.generator(seed, k as u64);
            let count = matched.points.len();
            let drawn: [PointMatch; 4] =
                std::array::from_fn(|_| matched.points[random.random_range(0..count)]);
            let h = homography::from_points(drawn.iter())?;
            Some((matched.within(&h).0, h))
        })
        .collect();
    drawn.sort_by(|p, q| p.0.total_cmp(&q.0));
    drawn.truncate(FITTED);
    drawn.into_par_iter().map(|(_, h)| matched.fitted(&h)).reduce(|| f64::INFINITY, f64::min)
}

impl Matched {
    /// The residual of a homography fitted again and again to the matches that fit.
    fn fitted(&self, h: &Matrix3<f64>) -> f64 {
        let (mut residual, mut distances) = self.within(h);
        for _ in 0..ROUNDS {
            let near = self.points.iter().zip(&distances).filter(|(_, d)| **d <= residual).map(|(m, _)| m);
            let Some(better) = homography::from_points(near) else { break };
            let (value, of_better) = self.within(&better);
            if value >= residual {
                break;
            }
            (residual, distances) = (value, of_better);
        }
        residual
    }

    /// The transfer distance below which [`SHARE`] of the matches lie, and all distances: widths, the mean of both images.
    fn within(&self, h: &Matrix3<f64>) -> (f64, Vec<f64>) {
        let Some(inverse) = h.try_inverse() else {
            return (f64::INFINITY, vec![f64::INFINITY; self.points.len()]);
        };
        let distance = |&(a, b): &PointMatch| {
            let (there, back) = (transfer_distance(h, &(a, b)), transfer_distance(&inverse, &(b, a)));
            0.5 * (self.widths[0] * back + self.widths[1] * there)
        };
        let distances: Vec<f64> = self.points.iter().map(distance).collect();
        let mut sorted = distances.clone();
        let at = ((SHARE * sorted.len() as f64) as usize).min(sorted.len() - 1);
        let (_, value, _) = sorted.select_nth_unstable_by(at, f64::total_cmp);
        (*value, distances)
    }
}

/// Median over the silhouettes of the shorter side of the bounding box, pixels; 0 without any.
pub(super) fn median_width(view: &View) -> f64 {
    let frames = (0..view.frames()).step_by(view.frames().div_ceil(200).max(1));
    median(frames.flat_map(|frame| view.hulls_of(frame)).map(shorter_side)).unwrap_or(0.0)
}
