//! Refinement of `F` on frontier points (DESIGN §6).
//!
//! Tangent points are correspondences: minimise the robust Sampson error over seven parameters, find the
//! tangents anew, tighten the radius, repeat. While the epipole moves a tangent point slides along its silhouette,
//! but only along the tangent itself, so to first order the residual does not notice (envelope theorem) and the
//! Jacobian of fixed points is the right one.

use nalgebra::{Matrix3, Vector3};

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

    /// Derivative of the distance along a change `g` of the matrix.
    fn along(&self, g: &Matrix3<f64>) -> f64 {
        let (gb, ga) = (g * self.xa, g.tr_mul(&self.xb));
        let half = self.in_b.x * gb.x + self.in_b.y * gb.y + self.in_a.x * ga.x + self.in_a.y * ga.y;
        (self.xb.dot(&gb) - self.algebraic * half / self.norm2) / self.norm2.sqrt()
    }
}

/// One row of the Jacobian with its residual, pixels.
pub fn residual_row(at: &SevenParameters, p: &FrontierPoint) -> (f64, Step) {
    let residual = Residual::new(&at.unscaled(), p);
    let derivatives = at.derivatives();
    (residual.value, Step::from_fn(|k, _| residual.along(&derivatives[k])))
}

impl Problem for SampsonProblem<'_> {
    fn linearise(&self, at: &SevenParameters) -> (f64, Information, Step) {
        let (matrix, derivatives) = (at.unscaled(), at.derivatives());
        let (mut cost, mut normal, mut gradient) = (0.0, Information::zeros(), Step::zeros());
        for p in self.points {
            let residual = Residual::new(&matrix, p);
            let (loss, weight) = cauchy(residual.value, self.scale);
            let weight = weight * p.surprise;
            let row = Step::from_fn(|k, _| residual.along(&derivatives[k]));
            cost += loss * p.surprise;
            normal.ger(weight, &row, &row, 1.0);
            gradient.axpy(weight * residual.value, &row, 1.0);
        }
        (cost, normal, gradient)
    }

    fn cost(&self, at: &SevenParameters) -> f64 {
        let matrix = at.unscaled();
        self.points.iter().map(|p| cauchy(Residual::new(&matrix, p).value, self.scale).0 * p.surprise).sum()
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
