//! Angles in the pencil of epipolar lines of B, and how often tangents lie at each.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3x2, Vector2, Vector3};

use crate::geometry::fundamental::{denormaliser, normaliser};
use crate::line::{Homogeneous, ImageSize};

/// Oriented angle of lines in the pencil of B.
pub(super) struct PencilAngle {
    pub(super) basis: Matrix3x2<f64>,
    to_normalised: nalgebra::Matrix3<f64>,
}

impl PencilAngle {
    pub(super) fn new(epipole: &Homogeneous, size: ImageSize) -> Self {
        let e = (normaliser(size) * epipole).normalize();
        // The first line is the one through the image centre, so that a far epipole's few visible lines lie
        // near angle 0 or π and do not wrap. (In normalised coordinates the centre is the origin.)
        let centre = e.cross(&Vector3::z()).try_normalize(1e-12);
        let first = centre.unwrap_or_else(|| e.cross(&Vector3::x()).normalize());
        let second = e.cross(&first);
        Self {
            basis: Matrix3x2::from_columns(&[first, second]),
            to_normalised: denormaliser(size).transpose(),
        }
    }

    pub(super) fn coordinates(&self, line: &Homogeneous) -> Vector2<f64> {
        self.basis.tr_mul(&(self.to_normalised * line))
    }
}

/// How often tangents of each side lie at each angle, over all frames.
pub(super) struct AngleHistogram {
    low: f64,
    scale: f64,
    wraps: bool,
    /// Running sums, one more than bins.
    sums: [Vec<f32>; 2],
}

const BINS: usize = 768;

impl AngleHistogram {
    pub(super) fn new(angles: &[(f64, bool)]) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for &(angle, _) in angles {
            low = low.min(angle);
            high = high.max(angle);
        }
        let wraps = high - low > PI;
        if wraps || angles.is_empty() {
            (low, high) = (-PI, PI);
        }
        let scale = BINS as f64 / (high - low).max(1e-12);
        let mut sums = [vec![0f32; BINS + 1], vec![0f32; BINS + 1]];
        for &(angle, positive) in angles {
            let bin = (((angle - low) * scale) as usize).min(BINS - 1);
            sums[usize::from(positive)][bin + 1] += 1.0;
        }
        for side in &mut sums {
            for i in 0..BINS {
                side[i + 1] += side[i];
            }
        }
        Self { low, scale, wraps, sums }
    }

    fn below(&self, position: f64, side: usize) -> f64 {
        let position = position.clamp(0.0, BINS as f64);
        let bin = (position as usize).min(BINS - 1);
        let (p, q) = (f64::from(self.sums[side][bin]), f64::from(self.sums[side][bin + 1]));
        p + (q - p) * (position - bin as f64)
    }

    /// Tangents within `half` of `angle`.
    pub(super) fn count(&self, angle: f64, half: f64, positive: bool) -> f64 {
        let side = usize::from(positive);
        if half >= PI {
            return self.below(BINS as f64, side);
        }
        let from = (angle - half - self.low) * self.scale;
        let to = (angle + half - self.low) * self.scale;
        let mut count = self.below(to, side) - self.below(from, side);
        if self.wraps {
            let turn = TAU * self.scale;
            count += self.below(to - turn, side) - self.below((from - turn).min(to - turn), side);
            count += self.below(to + turn, side) - self.below(from + turn, side);
        }
        count.max(0.0)
    }
}

/// The point of `line` nearest the image centre, clamped into the image, and its pixels per radian.
pub(super) fn centre_of_line(
    pencil: &PencilAngle,
    c: &Vector2<f64>,
    line: &Homogeneous,
    size: ImageSize,
) -> (Homogeneous, f64) {
    let turned = pencil.basis * Vector2::new(-c.y, c.x);
    let back = normaliser(size).transpose() * turned;
    let norm2 = (line.x * line.x + line.y * line.y).max(1e-300);
    let (cx, cy) = (0.5 * size.x_max(), 0.5 * size.y_max());
    let d = (line.x * cx + line.y * cy + line.z) / norm2;
    let (x, y) = ((cx - d * line.x).clamp(0.0, size.x_max()), (cy - d * line.y).clamp(0.0, size.y_max()));
    let point = Vector3::new(x, y, 1.0);
    (point, back.dot(&point).abs() / norm2.sqrt())
}
