//! Which way silhouettes stand, where a camera may be rolled.
//!
//! People stand, so the long axes of their silhouettes tell the roll of the camera, up to a half turn. The axis of
//! a silhouette comes from the second moments of its hull; axes are averaged by doubled angles, each by how long
//! its silhouette is.
//!
//! Perspective decides the half turn. A camera at height `H` over a level floor sees somebody of height `h` at
//! distance `d`, with the horizon at nought, from `-f H / d` up to `-f (H - h) / d`: the middle lies `H / h - ½` of the
//! silhouette's own height below the horizon. So the taller a silhouette, the lower it stands in the image, if the
//! camera is above the waist of those who walk.

use std::f64::consts::PI;

use crate::geometry::hull::{doubled_axis, extent};
use crate::recording::{Recording, visible};

/// Silhouettes are turned to all sides where less than this share of their doubled axes remains in the mean.
const ALIKE: f64 = 0.1;
/// Above this share they stand side by side. People: 0.75 and more; a hand 0.4 to 0.5.
const SIDE_BY_SIDE: f64 = 0.6;
/// Least correlation of height and depth in the image that decides which end is up, in the mean over [`BLOCKS`] parts of
/// the recording, and how many of its standard errors it must be.
const CORRELATION: f64 = 0.4;
const CORRELATION_Z: f64 = 3.0;
const BLOCKS: usize = 8;
/// Fewest silhouettes in a part.
const FEWEST: usize = 20;

/// Up in the image of a camera that is the right way up.
const IMAGE_UP: [f64; 2] = [0.0, -1.0];

/// Up in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Up {
    /// Unit length; of both senses the one that is nearer to the image's where nothing distinguishes them,
    /// and the image's where silhouettes have no common axis.
    pub direction: [f64; 2],
    /// Whether it is known which of both ends is up.
    pub known: bool,
}

impl Up {
    /// Up of a camera known to be the right way up.
    pub const IMAGE: Self = Self { direction: IMAGE_UP, known: true };
}

/// Up in the images of two cameras: known where they are the right way up, else found.
pub fn up_in(recordings: [&Recording; 2], upright: bool) -> [Up; 2] {
    if upright { [Up::IMAGE; 2] } else { recordings.map(up_of) }
}

/// Up in the image of a recording, from how its silhouettes stand.
pub fn up_of(recording: &Recording) -> Up {
    let silhouettes = &recording.silhouettes;
    let cut = |p: &[f64; 2]| visible::on_border(recording.size, recording.visible.as_deref(), *p);
    let whole: Vec<Vec<[f64; 2]>> = (0..silhouettes.len())
        .map(|hull| silhouettes.hull(hull).iter().map(|p| p.map(f64::from)).collect())
        .filter(|hull: &Vec<[f64; 2]>| !hull.iter().any(cut))
        .collect();
    of_hulls(&whole)
}

fn of_hulls(hulls: &[Vec<[f64; 2]>]) -> Up {
    let (mut sum, mut count) = ([0.0; 2], 0.0);
    for axis in hulls.iter().filter_map(|hull| doubled_axis(hull)) {
        sum = [sum[0] + axis[0], sum[1] + axis[1]];
        count += 1.0;
    }
    let length = sum[0].hypot(sum[1]) / count;
    if length.is_nan() || length < ALIKE {
        return Up { direction: IMAGE_UP, known: false };
    }
    let angle = 0.5 * sum[1].atan2(sum[0]);
    // Between −½π and ½π: the sense in which y is negative is up.
    let (sin, cos) = if angle > 0.0 { angle - PI } else { angle }.sin_cos();
    let up = [cos, sin];
    match sense(hulls, up).filter(|_| length >= SIDE_BY_SIDE) {
        Some(sense) => Up { direction: up.map(|u| sense * u), known: true },
        None => Up { direction: up, known: false },
    }
}

/// 1 where the taller silhouettes lie against `up`, −1 where they lie along it; `None` where neither is clear.
fn sense(hulls: &[Vec<[f64; 2]>], up: [f64; 2]) -> Option<f64> {
    let extents: Vec<[f64; 2]> = hulls
        .iter()
        .map(|hull| {
            let [low, high] = extent(hull, up);
            [high - low, -0.5 * (low + high)]
        })
        .collect();
    let size = extents.len() / BLOCKS;
    if size < FEWEST {
        return None;
    }
    let correlations: Vec<f64> = extents.chunks_exact(size).take(BLOCKS).map(correlation).collect();
    let n = BLOCKS as f64;
    let mean = correlations.iter().sum::<f64>() / n;
    let variance = correlations.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let clear = mean.abs() >= CORRELATION && mean.abs() >= CORRELATION_Z * (variance / n).sqrt();
    clear.then_some(mean.signum())
}

/// Pearson's, 0 where something is constant.
fn correlation(pairs: &[[f64; 2]]) -> f64 {
    let mean = [0, 1].map(|k| pairs.iter().map(|p| p[k]).sum::<f64>() / pairs.len() as f64);
    let product = |i: usize, j: usize| pairs.iter().map(|p| (p[i] - mean[i]) * (p[j] - mean[j])).sum::<f64>();
    let deviations = (product(0, 0) * product(1, 1)).sqrt();
    if deviations > 0.0 { product(0, 1) / deviations } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rectangles before a camera at `height` metres that is rolled by `roll`: how large is everything, and where.
    fn seen(height: f64, roll: f64) -> Up {
        let (sin, cos) = roll.sin_cos();
        let hulls: Vec<Vec<[f64; 2]>> = (0..400)
            .map(|k| {
                let distance = 6.0 + 3.0 * (0.37 * f64::from(k)).sin();
                let (foot, head) = (-300.0 * height / distance, -300.0 * (height - 1.7) / distance);
                let (middle, half) = (90.0 * (0.11 * f64::from(k)).cos(), 0.25 * 300.0 / distance);
                // Up is `-y` before the roll.
                let corner = |u: f64, v: f64| [320.0 + u * cos + v * sin, 240.0 + u * sin - v * cos];
                [(-half, foot), (half, foot), (half, head), (-half, head)]
                    .map(|(u, v)| corner(middle + u, v))
                    .to_vec()
            })
            .collect();
        of_hulls(&hulls)
    }

    #[test]
    fn up_is_found_at_every_roll() {
        for k in 0..24 {
            let roll = 0.1 + f64::from(k) * PI / 12.0;
            for height in [1.3, 1.7, 5.0] {
                let Up { direction: up, known } = seen(height, roll);
                assert!(known);
                assert!((up[0] - roll.sin()).abs() < 1e-6 && (up[1] + roll.cos()).abs() < 1e-6, "{up:?}");
            }
            // At half the height of those who walk nothing distinguishes feet from heads.
            assert!(!seen(0.85, roll).known);
        }
        assert_eq!(of_hulls(&[]), Up { direction: IMAGE_UP, known: false });
    }
}
