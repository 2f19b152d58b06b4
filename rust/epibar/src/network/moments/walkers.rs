//! What stands on the floor: silhouettes whose tops and bottoms meet in two cameras, as segments in space.
//!
//! Where both ends of a silhouette meet both ends of one silhouette of another camera, and are its top and its bottom in
//! both images, two frontier points of one object are known: points on its surface, true correspondences, and so points
//! in space. Walkers have their bottoms on one plane, are upright, and about equally tall wherever they are. Epipolar
//! constraints know nothing of this: they tell the vertical, the floor and the
//! scale.

use nalgebra::{Matrix3, Vector3};

use super::tangents::{MatchedEnds, Tangents, other_end};
use crate::geometry::median::{deviation, median};
use crate::network::model::camera::Camera;
use crate::network::thresholds as limits;

/// A silhouette of two cameras with its top and its bottom, raw pixels in A and in B.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figure {
    /// Top in A, in B.
    pub top: [[f64; 2]; 2],
    /// Bottom in A, in B.
    pub bottom: [[f64; 2]; 2],
}

/// Figures of a pair of cameras.
#[derive(Debug, Clone)]
pub struct PairFigures {
    /// Index of camera A.
    pub a: usize,
    /// Index of camera B.
    pub b: usize,
    /// The figures.
    pub figures: Vec<Figure>,
}

/// Below this share of up in a tangent's normal, top and bottom mean nothing.
const STEEP: f64 = 0.6;
/// Rays of a point that differ by less, radians, do not tell how far away it is.
const NARROW: f64 = 0.05;

/// The silhouettes of which both ends meet those of one silhouette of the other camera, top to top.
pub fn figures(tangents: &Tangents, met: &[MatchedEnds]) -> Vec<Figure> {
    let mut found = Vec::new();
    for (k, low) in met.iter().enumerate() {
        let Some(high) = other_end(met, k) else { continue };
        let below = |m: &MatchedEnds| tangents.below(m);
        let top_first =
            |[a, b]: [f64; 2], [c, d]: [f64; 2]| a > STEEP && b > STEEP && c < -STEEP && d < -STEEP;
        let (of_low, of_high) = (below(low), below(high));
        let (top, bottom) = if top_first(of_low, of_high) {
            (low, high)
        } else if top_first(of_high, of_low) {
            (high, low)
        } else {
            continue;
        };
        let [top, bottom] = [top, bottom].map(|m| tangents.pixels(m));
        found.push(Figure { top, bottom });
    }
    found
}

/// The point nearest to the rays of a pixel of A and a pixel of B; `None` behind a camera, or where the rays are
/// nearly parallel.
pub fn triangulated(a: &Camera, b: &Camera, pixels: [[f64; 2]; 2]) -> Option<Vector3<f64>> {
    let (p, q) = (a.ray(pixels[0])?.normalize(), b.ray(pixels[1])?.normalize());
    let cosine = p.dot(&q);
    let sine2 = 1.0 - cosine * cosine;
    if sine2 < NARROW * NARROW {
        return None;
    }
    let between = b.position - a.position;
    let (along_p, along_q) = (between.dot(&p), between.dot(&q));
    let s = (along_p - cosine * along_q) / sine2;
    let t = (cosine * along_p - along_q) / sine2;
    (s > 0.0 && t > 0.0).then(|| 0.5 * (a.position + p * s + b.position + q * t))
}

/// Top and bottom of a figure in space.
pub fn segment(a: &Camera, b: &Camera, figure: &Figure) -> Option<[Vector3<f64>; 2]> {
    Some([triangulated(a, b, figure.top)?, triangulated(a, b, figure.bottom)?])
}

/// The plane on which walkers stand, and how tall they are, in the unit of the network.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Floor {
    /// Up, unit length.
    pub up: Vector3<f64>,
    /// `up · X` of its points.
    pub level: f64,
    /// Height of those who walk on it, their median.
    pub height: f64,
    /// Robust standard deviation of bottoms from the floor, over the height.
    pub unevenness: f64,
    /// Robust standard deviation of heights over their median.
    pub diversity: f64,
    /// Angle between up and the mean of the segments, radians.
    pub lean: f64,
    /// Standard deviation of the bottoms along the direction in which they are spread least.
    pub reach: f64,
    /// Figures that it rests on.
    pub figures: usize,
}

/// Samples of three bottoms.
const SAMPLES: usize = 300;
/// Three bottoms nearer to one line tell no plane: twice the area of their triangle, in squares of the median height.
const LEAST_TRIANGLE: f64 = 0.05;
/// Rounds of least squares.
const REFITS: usize = 5;

impl Floor {
    /// The floor of segments, each a top and a bottom; `None` where they are too few, or have none in common.
    pub fn of(segments: &[[Vector3<f64>; 2]]) -> Option<Self> {
        if segments.len() < limits::FLOOR_FIGURES {
            return None;
        }
        let height = median(segments.iter().map(|[t, b]| (t - b).norm()))?;
        let mean_up: Vector3<f64> = segments.iter().map(|[t, b]| (t - b).normalize()).sum();
        let mean_up = mean_up.normalize();
        let mut best: Option<(usize, Vector3<f64>, f64)> = None;
        for k in 0..SAMPLES {
            // Three bottoms far apart in the list, each sample other ones.
            let n = segments.len();
            let pick = |j: usize| segments[(k * 7919 + j * n / 3 + (k * k + 31 * j) % 97) % n][1];
            let (p, q, r) = (pick(0), pick(1), pick(2));
            let normal = (q - p).cross(&(r - p));
            if normal.norm() < LEAST_TRIANGLE * height * height {
                continue;
            }
            let normal = normal.normalize();
            let normal = if normal.dot(&mean_up) < 0.0 { -normal } else { normal };
            let level = normal.dot(&p);
            let on = segments
                .iter()
                .filter(|[_, b]| (normal.dot(b) - level).abs() < limits::ON_FLOOR * height)
                .count();
            if best.is_none_or(|b| on > b.0) {
                best = Some((on, normal, level));
            }
        }
        let (_, mut up, mut level) = best?;
        for _ in 0..REFITS {
            (up, level) = refitted(segments, up, level, limits::ON_FLOOR * height)?;
        }
        let up = if up.dot(&mean_up) < 0.0 { -up } else { up };
        let level = median(segments.iter().map(|[_, b]| up.dot(b)))?;
        let standing: Vec<_> = segments
            .iter()
            .filter(|[_, b]| (up.dot(b) - level).abs() < 2.0 * limits::ON_FLOOR * height)
            .copied()
            .collect();
        if standing.len() < limits::FLOOR_FIGURES {
            return None;
        }
        let tall = median(standing.iter().map(|[t, _]| up.dot(t) - level))?;
        let mean: Vector3<f64> = standing.iter().map(|[t, b]| (t - b) / tall).sum();
        let middle = standing.iter().map(|s| s[1]).sum::<Vector3<f64>>() / standing.len() as f64;
        let scatter: Matrix3<f64> =
            standing.iter().map(|s| (s[1] - middle) * (s[1] - middle).transpose()).sum();
        let mut spreads: Vec<f64> = scatter.symmetric_eigen().eigenvalues.iter().copied().collect();
        spreads.sort_by(f64::total_cmp);
        Some(Self {
            up,
            level,
            height: tall,
            unevenness: deviation(standing.iter().map(|[_, b]| (up.dot(b) - level) / tall))?,
            diversity: deviation(standing.iter().map(|[t, _]| (up.dot(t) - level) / tall - 1.0))?,
            lean: mean.normalize().dot(&up).clamp(-1.0, 1.0).acos(),
            reach: (spreads[1].max(0.0) / standing.len() as f64).sqrt(),
            figures: standing.len(),
        })
    }
}

/// The plane by least squares of the bottoms within reach of one.
fn refitted(
    segments: &[[Vector3<f64>; 2]],
    up: Vector3<f64>,
    level: f64,
    reach: f64,
) -> Option<(Vector3<f64>, f64)> {
    let near: Vec<Vector3<f64>> =
        segments.iter().map(|s| s[1]).filter(|b| (up.dot(b) - level).abs() < reach).collect();
    if near.len() < limits::FLOOR_FIGURES / 2 {
        return None;
    }
    let mean = near.iter().sum::<Vector3<f64>>() / near.len() as f64;
    let scatter: Matrix3<f64> = near.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
    let eigen = scatter.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let normal = eigen.eigenvectors.column(least).into_owned();
    let normal = if normal.dot(&up) < 0.0 { -normal } else { normal };
    Some((normal, normal.dot(&mean)))
}
