//! Sampson errors of tangents that meet, as a least-squares problem over the seven parameters.
//!
//! While the epipole moves a tangent point slides along its silhouette, but only along the tangent itself, so to first
//! order the residual does not notice (envelope theorem) and the Jacobian of fixed points is the right one.

use nalgebra::{Matrix3, SMatrix, SVector};
use pulp::{Arch, Simd, WithSimd};

use super::least_squares::Problem;
use crate::frontier::TangentMatch;
use crate::frontier::score::logarithm;
use crate::geometry::seven_parameters::{Information, SevenParameters, Step};

/// Points that are summed up at a time.
const CHUNK: usize = 64;
/// Sums that run beside one another.
const LANES: usize = 8;

/// Sampson errors of matched tangent points.
pub struct SampsonProblem {
    /// Coordinates in A and in B and the weight of each point, padded with points of no weight.
    columns: [Vec<f64>; 5],
    /// Scale of the Cauchy loss, pixels.
    scale: f64,
    arch: Arch,
}

impl SampsonProblem {
    /// `scale`: of the Cauchy loss, pixels.
    pub fn new(points: &[TangentMatch], scale: f64) -> Self {
        Self::of_rows(points.iter().map(|p| [p.a[0], p.a[1], p.b[0], p.b[1], p.surprise]), scale)
    }

    /// Of matches `(a, b)` that weigh alike; `scale`: of the Cauchy loss, pixels.
    pub fn of_matches(matches: &[([f64; 2], [f64; 2])], scale: f64) -> Self {
        Self::of_rows(matches.iter().map(|(a, b)| [a[0], a[1], b[0], b[1], 1.0]), scale)
    }

    fn of_rows(rows: impl ExactSizeIterator<Item = [f64; 5]>, scale: f64) -> Self {
        let padded = rows.len().next_multiple_of(CHUNK);
        let mut columns: [Vec<f64>; 5] = std::array::from_fn(|_| Vec::with_capacity(padded));
        for row in rows {
            for (column, value) in columns.iter_mut().zip(row) {
                column.push(value);
            }
        }
        for column in &mut columns {
            column.resize(padded, 0.0);
        }
        Self { columns, scale, arch: Arch::new() }
    }
}

/// Sampson distance of a pair `[x_a, y_a, x_b, y_b]` under a matrix, and its derivative to the entries of the matrix,
/// column by column.
#[inline(always)]
fn sampson(m: &Matrix3<f64>, [xa, ya, xb, yb]: [f64; 4]) -> (f64, [f64; 9]) {
    let in_b =
        [m.m11 * xa + m.m12 * ya + m.m13, m.m21 * xa + m.m22 * ya + m.m23, m.m31 * xa + m.m32 * ya + m.m33];
    let in_a = [m.m11 * xb + m.m21 * yb + m.m31, m.m12 * xb + m.m22 * yb + m.m32];
    let algebraic = xb * in_b[0] + yb * in_b[1] + in_b[2];
    let norm2 = in_b[0] * in_b[0] + in_b[1] * in_b[1] + in_a[0] * in_a[0] + in_a[1] * in_a[1];
    let norm2 = norm2.max(1e-300);
    let (scale, share) = (1.0 / norm2.sqrt(), algebraic / norm2);
    // ∂algebraic = xb xaᵀ; ½ ∂norm² = in_b xaᵀ (first two rows) + xb in_aᵀ (first two columns).
    let b = [scale * (xb - share * in_b[0]), scale * (yb - share * in_b[1]), scale];
    let a = [scale * share * in_a[0], scale * share * in_a[1]];
    let entries = [
        b[0] * xa - xb * a[0],
        b[1] * xa - yb * a[0],
        b[2] * xa - a[0],
        b[0] * ya - xb * a[1],
        b[1] * ya - yb * a[1],
        b[2] * ya - a[1],
        b[0],
        b[1],
        b[2],
    ];
    (algebraic * scale, entries)
}

/// The residual of each point, pixels, and its row of the Jacobian.
pub fn residual_rows<'p>(
    at: &SevenParameters,
    points: &'p [TangentMatch],
) -> impl Iterator<Item = (f64, Step)> + use<'p> {
    let (matrix, derivatives) = (at.unscaled(), at.derivatives());
    points.iter().map(move |p| {
        let (residual, entries) = sampson(&matrix, [p.a[0], p.a[1], p.b[0], p.b[1]]);
        let along = |k: usize| derivatives[k].as_slice().iter().zip(&entries).map(|(d, e)| d * e).sum();
        (residual, Step::from_fn(|k, _| along(k)))
    })
}

/// Cost, `JᵀWJ` (lower triangle) and `JᵀWr` over the nine entries of the matrix.
struct Sums {
    cost: [f64; LANES],
    normal: [[[f64; LANES]; 9]; 9],
    gradient: [[f64; LANES]; 9],
}

/// Pass over all points.
struct Linearisation<'p> {
    problem: &'p SampsonProblem,
    matrix: &'p Matrix3<f64>,
}

/// Adds the products of two rows, lane by lane whatever the width of the CPU's vectors.
#[inline(always)]
fn add_products<S: Simd>(simd: S, sum: &mut [f64; LANES], p: &[f64; CHUNK], q: &[f64; CHUNK]) {
    let sum = S::as_mut_simd_f64s(sum).0;
    let width = sum.len();
    let (p, q) = (S::as_simd_f64s(p).0, S::as_simd_f64s(q).0);
    for (k, sum) in sum.iter_mut().enumerate() {
        let mut total = *sum;
        for at in (k..p.len()).step_by(width) {
            total = simd.add_f64s(total, simd.mul_f64s(p[at], q[at]));
        }
        *sum = total;
    }
}

impl WithSimd for Linearisation<'_> {
    type Output = Sums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Sums {
        let (m, scale2) = (self.matrix, self.problem.scale * self.problem.scale);
        let columns = self.problem.columns.each_ref().map(|c| c.as_chunks::<CHUNK>().0);
        let mut sums =
            Sums { cost: [0.0; LANES], normal: [[[0.0; LANES]; 9]; 9], gradient: [[0.0; LANES]; 9] };
        let mut entries = [[0.0; CHUNK]; 9];
        let (mut value, mut loss) = ([0.0; CHUNK], [0.0; CHUNK]);
        for chunk in 0..columns[0].len() {
            let [xa, ya, xb, yb, surprise] = columns.map(|c| &c[chunk]);
            let mut weight = [0.0; CHUNK];
            for i in 0..CHUNK {
                let (residual, of_point) = sampson(m, [xa[i], ya[i], xb[i], yb[i]]);
                let q = 1.0 + residual * residual / scale2;
                value[i] = residual;
                loss[i] = 0.5 * scale2 * logarithm(q);
                weight[i] = surprise[i] / q;
                for (entries, entry) in entries.iter_mut().zip(of_point) {
                    entries[i] = entry;
                }
            }
            add_products(simd, &mut sums.cost, &loss, surprise);
            for j in 0..9 {
                let mut weighed = [0.0; CHUNK];
                for i in 0..CHUNK {
                    weighed[i] = weight[i] * entries[j][i];
                }
                add_products(simd, &mut sums.gradient[j], &weighed, &value);
                for (row, entries) in sums.normal.iter_mut().zip(&entries).skip(j) {
                    add_products(simd, &mut row[j], &weighed, entries);
                }
            }
        }
        sums
    }
}

impl Problem for SampsonProblem {
    fn linearise(&self, at: &SevenParameters) -> (f64, Information, Step) {
        // Summed over the nine entries of the matrix, where a row is cheap, and carried to the seven parameters once.
        let matrix = at.unscaled();
        let sums = self.arch.dispatch(Linearisation { problem: self, matrix: &matrix });
        let total = |lanes: &[f64; LANES]| lanes.iter().sum::<f64>();
        let normal = SMatrix::<f64, 9, 9>::from_fn(|i, j| total(&sums.normal[i.max(j)][i.min(j)]));
        let gradient = SVector::<f64, 9>::from_fn(|i, _| total(&sums.gradient[i]));
        let (information, gradient) = at.carried(&normal, &gradient);
        (total(&sums.cost), information, gradient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frontier::{Class, CommonFrame};
    use crate::geometry::Fundamental;
    use crate::image::ImageSize;

    #[test]
    fn jacobian_equals_differences() {
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(800, 450).unwrap()];
        let matrix = Matrix3::new(1e-6, -3e-6, 2e-3, 5e-6, 2e-6, -9e-3, -4e-3, 6e-3, 1.0);
        let f = Fundamental::from_matrix(&matrix, sizes[0], sizes[1]).unwrap();
        let at = SevenParameters::new(&f, sizes).unwrap();
        for (a, b) in [([100.0, 50.0], [700.0, 300.0]), ([400.0, 333.0], [20.0, 410.0])] {
            let p =
                TangentMatch { frame: CommonFrame(0), a, b, distance: 0.0, surprise: 1.0, class: Class::Top };
            let row_at = |at: &SevenParameters| residual_rows(at, std::slice::from_ref(&p)).next().unwrap();
            let (_, row) = row_at(&at);
            for k in 0..7 {
                let mut step = Step::zeros();
                step[k] = 1e-6;
                let plus = row_at(&at.stepped(&step)).0;
                let minus = row_at(&at.stepped(&-step)).0;
                let difference = (plus - minus) / 2e-6;
                assert!(
                    (row[k] - difference).abs() < 1e-5 * (1.0 + difference.abs()),
                    "{k}: {} {difference}",
                    row[k]
                );
            }
        }
    }
}
