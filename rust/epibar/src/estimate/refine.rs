//! Refinement of `F` on frontier points (DESIGN §6).
//!
//! Tangent points are correspondences: minimise the robust Sampson error over seven parameters, find the
//! tangents anew, tighten the radius, repeat. While the epipole moves a tangent point slides along its silhouette,
//! but only along the tangent itself, so to first order the residual does not notice (envelope theorem) and the
//! Jacobian of fixed points is the right one.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::frontier::{FrontierOptions, FrontierPoint, compare};
use super::optimise::{Information, Problem, SevenParameters, Step, cauchy, minimise};
use super::views::Views;
use crate::geometry::Fundamental;

/// Sampson errors of matched tangent points.
pub struct SampsonProblem<'a> {
    /// The points.
    pub points: &'a [FrontierPoint],
    /// Scale of the Cauchy loss, pixels.
    pub scale: f64,
}

/// Sampson distance of a pair under a matrix, with what its derivative needs.
struct Residual {
    value: f64,
    algebraic: f64,
    norm2: f64,
    xa: Vector3<f64>,
    xb: Vector3<f64>,
    in_b: Vector3<f64>,
    in_a: Vector3<f64>,
}

impl Residual {
    fn new(f: &Matrix3<f64>, p: &FrontierPoint) -> Self {
        let (xa, xb) = (Vector3::new(p.a[0], p.a[1], 1.0), Vector3::new(p.b[0], p.b[1], 1.0));
        let (in_b, in_a) = (f * xa, f.tr_mul(&xb));
        let algebraic = xb.dot(&in_b);
        let norm2 = (in_b.x.powi(2) + in_b.y.powi(2) + in_a.x.powi(2) + in_a.y.powi(2)).max(1e-300);
        Self { value: algebraic / norm2.sqrt(), algebraic, norm2, xa, xb, in_b, in_a }
    }

    /// Derivative of the distance to the entries of the matrix, column by column.
    fn entries(&self) -> [f64; 9] {
        let scale = 1.0 / self.norm2.sqrt();
        let share = self.algebraic / self.norm2;
        let (xa, xb) = (&self.xa, &self.xb);
        // ∂algebraic = xb xaᵀ; ½ ∂norm² = in_b xaᵀ (first two rows) + xb in_aᵀ (first two columns).
        let b = [scale * (xb.x - share * self.in_b.x), scale * (xb.y - share * self.in_b.y), scale * xb.z];
        let a = [scale * share * self.in_a.x, scale * share * self.in_a.y, 0.0];
        std::array::from_fn(|k| {
            let (row, column) = (k % 3, k / 3);
            b[row] * xa[column] - xb[row] * a[column]
        })
    }
}

/// One row of the Jacobian with its residual, pixels.
pub fn residual_row(at: &SevenParameters, p: &FrontierPoint) -> (f64, Step) {
    let residual = Residual::new(&at.unscaled(), p);
    let entries = residual.entries();
    let derivatives = at.derivatives();
    let along = |k: usize| derivatives[k].as_slice().iter().zip(&entries).map(|(d, e)| d * e).sum();
    (residual.value, Step::from_fn(|k, _| along(k)))
}

impl Problem for SampsonProblem<'_> {
    fn linearise(&self, at: &SevenParameters) -> (f64, Information, Step) {
        let matrix = at.unscaled();
        // Summed over the nine entries of the matrix, where a row is cheap, and carried to the seven parameters once.
        let mut cost = 0.0;
        let mut normal = SMatrix::<f64, 9, 9>::zeros();
        let mut gradient = SVector::<f64, 9>::zeros();
        for p in self.points {
            let residual = Residual::new(&matrix, p);
            let (loss, weight) = cauchy(residual.value, self.scale);
            let weight = weight * p.surprise;
            cost += loss * p.surprise;
            let row = residual.entries();
            for j in 0..9 {
                let weighed = weight * row[j];
                gradient[j] += weighed * residual.value;
                // The lower triangle alone.
                for i in j..9 {
                    normal[(i, j)] += weighed * row[i];
                }
            }
        }
        normal.fill_upper_triangle_with_lower_triangle();
        let derivatives = at.derivatives();
        let chain = SMatrix::<f64, 9, 7>::from_fn(|i, k| derivatives[k].as_slice()[i]);
        (cost, chain.tr_mul(&(normal * chain)), chain.tr_mul(&gradient))
    }
}

/// Refines `f` while the radius shrinks; each radius, in pixels, is used `repeats` times. `None` where too few
/// tangents meet.
pub fn refine(
    views: &Views,
    f: &Fundamental,
    radii: &[f64],
    repeats: usize,
    upright: bool,
) -> Option<Fundamental> {
    let mut current = *f;
    for &radius in radii {
        for _ in 0..repeats {
            let options = FrontierOptions { radius, upright, shift: 0 };
            let points = compare(views, &current, &options).points;
            if points.len() < 12 {
                return None;
            }
            let start = SevenParameters::new(&current, views.sizes())?;
            let problem = SampsonProblem { points: &points, scale: 0.35 * radius };
            current = minimise(&problem, start, 12).0.fundamental()?;
        }
    }
    Some(current)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::frontier::Class;
    use crate::line::ImageSize;

    #[test]
    fn jacobian_equals_differences() {
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(800, 450).unwrap()];
        let matrix = Matrix3::new(1e-6, -3e-6, 2e-3, 5e-6, 2e-6, -9e-3, -4e-3, 6e-3, 1.0);
        let f = Fundamental::from_matrix(&matrix, sizes[0], sizes[1]).unwrap();
        let at = SevenParameters::new(&f, sizes).unwrap();
        for (a, b) in [([100.0, 50.0], [700.0, 300.0]), ([400.0, 333.0], [20.0, 410.0])] {
            let p = FrontierPoint { frame: 0, a, b, distance: 0.0, surprise: 1.0, class: Class::Top };
            let (_, row) = residual_row(&at, &p);
            for k in 0..7 {
                let mut step = Step::zeros();
                step[k] = 1e-6;
                let plus = Residual::new(&at.stepped(&step).unscaled(), &p).value;
                let minus = Residual::new(&at.stepped(&-step).unscaled(), &p).value;
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
