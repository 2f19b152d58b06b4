//! What the tangents of one view look like from the other, as flat arrays.

use super::angles::{AngleHistogram, PencilAngles};
use super::elementary::angle;
use super::tangents::{LANES, NONE, Tangents};
use crate::geometry::Fundamental;

/// Tangents of A as B sees them.
#[derive(Debug, Default)]
pub(super) struct Sent {
    /// `F x`.
    pub(super) line: [Vec<f64>; 3],
    /// Squared length of its normal.
    pub(super) norm2: Vec<f64>,
    /// Its angle in the pencil of B.
    pub(super) angle: Vec<f64>,
    /// Pixels per radian where it passes the image centre.
    pub(super) elsewhere: Vec<f64>,
    /// The tangent of B that it meets, or [`NONE`].
    pub(super) met: Vec<u32>,
    /// Squared Sampson distance to it.
    pub(super) squared: Vec<f64>,
    /// Pixels per radian where it meets it.
    pub(super) lever: Vec<f64>,
    /// What each adds to the score, and `−ln` of its chance.
    pub(super) excess: Vec<f64>,
    pub(super) surprise: Vec<f64>,
    /// The chance itself.
    pub(super) chance: Vec<f64>,
}

/// Tangents of B as those of A see them.
#[derive(Debug, Default)]
pub(super) struct Targets {
    /// Pixels that the line moves at its point per radian.
    pub(super) lever: Vec<f64>,
    /// Squared length of the normal of its point's epipolar line in A.
    pub(super) back_norm2: Vec<f64>,
    pub(super) angle: Vec<f64>,
    pub(super) histogram: AngleHistogram,
}

/// Pixels of Sampson distance per radian where a line with a normal of squared length `norm2` touches B at a point
/// whose epipolar line in A has one of `back_norm2`.
///
/// A Sampson distance shares the gap between both views: near an epipole of A a pixel there is worth many in B,
/// and a wide range of angles is within the radius.
#[inline(always)]
pub(super) fn pixels_per_radian(norm2: f64, back_norm2: f64, lever: f64) -> f64 {
    (lever / (1.0 + back_norm2 / norm2.max(1e-300)).sqrt()).max(1e-9)
}

impl Targets {
    #[inline(always)]
    pub(super) fn fill(&mut self, tangents: &Tangents, f: &Fundamental, pencil: &PencilAngles) {
        let n = tangents.len();
        for part in [&mut self.lever, &mut self.back_norm2, &mut self.angle] {
            part.resize(n + LANES, 0.0);
        }
        let (x, y) = (&tangents.x[..n], &tangents.y[..n]);
        let line = [0, 1, 2].map(|k| &tangents.line[k][..n]);
        let (lever, back_norm2, angles) =
            (&mut self.lever[..n], &mut self.back_norm2[..n], &mut self.angle[..n]);
        let (m, to, from) = (f.matrix(), &pencil.coordinates, &pencil.line);
        for i in 0..n {
            let (lx, ly, lz) = (line[0][i], line[1][i], line[2][i]);
            let cx = to.m11 * lx + to.m12 * ly + to.m13 * lz;
            let cy = to.m21 * lx + to.m22 * ly + to.m23 * lz;
            angles[i] = angle(cy, cx);
            let tx = from.m12 * cx - from.m11 * cy;
            let ty = from.m22 * cx - from.m21 * cy;
            let tz = from.m32 * cx - from.m31 * cy;
            let moved = tx * x[i] + ty * y[i] + tz;
            lever[i] = moved.abs() / (lx * lx + ly * ly).sqrt().max(1e-300);
            let back_x = m.m11 * x[i] + m.m21 * y[i] + m.m31;
            let back_y = m.m12 * x[i] + m.m22 * y[i] + m.m32;
            back_norm2[i] = back_x * back_x + back_y * back_y;
        }
        self.histogram.fill(angles);
    }
}

impl Sent {
    #[inline(always)]
    pub(super) fn fill(&mut self, tangents: &Tangents, f: &Fundamental, pencil: &PencilAngles) {
        let n = tangents.len();
        let [line_x, line_y, line_z] = &mut self.line;
        for part in [
            &mut *line_x,
            &mut *line_y,
            &mut *line_z,
            &mut self.norm2,
            &mut self.angle,
            &mut self.elsewhere,
            &mut self.squared,
            &mut self.lever,
            &mut self.excess,
            &mut self.surprise,
            &mut self.chance,
        ] {
            part.resize(n, 0.0);
        }
        self.met.resize(n, NONE);
        let (line_x, line_y, line_z) = (&mut line_x[..n], &mut line_y[..n], &mut line_z[..n]);
        let (x, y) = (&tangents.x[..n], &tangents.y[..n]);
        let (norm2, angles, elsewhere) =
            (&mut self.norm2[..n], &mut self.angle[..n], &mut self.elsewhere[..n]);
        let (m, to, from) = (f.matrix(), &pencil.coordinates, &pencil.line);
        let (x_max, y_max) = (pencil.size.x_max(), pencil.size.y_max());
        for i in 0..n {
            let lx = m.m11 * x[i] + m.m12 * y[i] + m.m13;
            let ly = m.m21 * x[i] + m.m22 * y[i] + m.m23;
            let lz = m.m31 * x[i] + m.m32 * y[i] + m.m33;
            (line_x[i], line_y[i], line_z[i]) = (lx, ly, lz);
            let length2 = lx * lx + ly * ly;
            norm2[i] = length2;
            let cx = to.m11 * lx + to.m12 * ly + to.m13 * lz;
            let cy = to.m21 * lx + to.m22 * ly + to.m23 * lz;
            angles[i] = angle(cy, cx);
            // The point of the line nearest the image centre, clamped into the image.
            let safe = length2.max(1e-300);
            let distance = (0.5 * (lx * x_max + ly * y_max) + lz) / safe;
            let px = (0.5 * x_max - distance * lx).max(0.0).min(x_max);
            let py = (0.5 * y_max - distance * ly).max(0.0).min(y_max);
            let tx = from.m12 * cx - from.m11 * cy;
            let ty = from.m22 * cx - from.m21 * cy;
            let tz = from.m32 * cx - from.m31 * cy;
            let lever = (tx * px + ty * py + tz).abs() / safe.sqrt();
            let back_x = m.m11 * px + m.m21 * py + m.m31;
            let back_y = m.m12 * px + m.m22 * py + m.m32;
            elsewhere[i] = pixels_per_radian(length2, back_x * back_x + back_y * back_y, lever);
        }
    }
}
