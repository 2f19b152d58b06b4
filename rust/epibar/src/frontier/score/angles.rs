//! Angles in the pencil of epipolar lines of B, and how often tangents lie at each.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix2x3, Matrix3x2, Vector3};

use crate::geometry::fundamental::{denormaliser, normaliser};
use crate::image::{Homogeneous, ImageSize};

/// Oriented angle of lines in the pencil of B.
#[derive(Debug, Clone, Copy)]
pub(super) struct PencilAngles {
    /// Coordinates of a line in the pencil.
    pub(super) coordinates: Matrix2x3<f64>,
    /// The line that one turned by a right angle from the coordinates `(−c_y, c_x)` is.
    pub(super) line: Matrix3x2<f64>,
    pub(super) size: ImageSize,
}

impl PencilAngles {
    pub(super) fn new(epipole: &Homogeneous, size: ImageSize) -> Self {
        let e = (normaliser(size) * epipole).normalize();
        // The first line is the one through the image centre, so that a far epipole's few visible lines lie
        // near angle 0 or π and do not wrap. (In normalised coordinates the centre is the origin.)
        let centre = e.cross(&Vector3::z()).try_normalize(1e-12);
        let first = centre.unwrap_or_else(|| e.cross(&Vector3::x()).normalize());
        let second = e.cross(&first);
        let basis = Matrix3x2::from_columns(&[first, second]);
        Self {
            coordinates: basis.transpose() * denormaliser(size).transpose(),
            line: normaliser(size).transpose() * basis,
            size,
        }
    }
}

/// How often tangents lie at each angle, over all frames.
#[derive(Debug, Default)]
pub(super) struct AngleHistogram {
    low: f64,
    scale: f64,
    wraps: bool,
    /// Running sums, one more than bins; none before the first filling.
    sums: Vec<f64>,
}

const BINS: usize = 768;

impl AngleHistogram {
    #[inline(always)]
    pub(super) fn fill(&mut self, angles: &[f64]) {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for &angle in angles {
            low = if angle < low { angle } else { low };
            high = if angle > high { angle } else { high };
        }
        self.wraps = high - low > PI;
        if self.wraps || angles.is_empty() {
            (low, high) = (-PI, PI);
        }
        self.low = low;
        self.scale = BINS as f64 / (high - low).max(1e-12);
        self.sums.clear();
        self.sums.resize(BINS + 1, 0.0);
        for &angle in angles {
            let bin = (((angle - low) * self.scale) as usize).min(BINS - 1);
            self.sums[bin + 1] += 1.0;
        }
        let mut sum = 0.0;
        for count in &mut self.sums {
            sum += *count;
            *count = sum;
        }
    }

    #[inline(always)]
    fn below(sums: &[f64; BINS + 1], position: f64) -> f64 {
        let position = position.clamp(0.0, BINS as f64);
        let bin = (position as usize).min(BINS - 1);
        let (p, q) = (sums[bin], sums[bin + 1]);
        p + (q - p) * (position - bin as f64)
    }

    /// Tangents within `half` of `angle`.
    #[inline(always)]
    pub(super) fn count(&self, angle: f64, half: f64) -> f64 {
        let Some(sums) = self.sums.first_chunk() else { return 0.0 };
        if half >= PI {
            return sums[BINS];
        }
        let below = |position| Self::below(sums, position);
        let from = (angle - half - self.low) * self.scale;
        let to = (angle + half - self.low) * self.scale;
        let mut count = below(to) - below(from);
        if self.wraps {
            let turn = TAU * self.scale;
            count += below(to - turn) - below(from - turn);
            count += below(to + turn) - below(from + turn);
        }
        count.max(0.0)
    }
}
