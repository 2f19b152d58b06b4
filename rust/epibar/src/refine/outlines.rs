//! `F` with what outlines are off by solved for beside it.
//!
//! A mask that is a pixel too wide, or eaten by as much, puts its tangents outside of what moves or inside, all alike. Bottoms then lie
//! too low and tops too high, or the other way round, and `F` gives way to that: residuals are small, and the epipolar lines are off
//! by what the outlines are. Figures stand near and far, so no `F` follows it everywhere, and how far the outlines of either image are to be
//! moved along their normals is told by the same tangents.

use nalgebra::{SMatrix, SVector, Vector3};

use super::essential::EssentialPrior;
use super::least_squares::{Problem, cauchy};
use super::polish::prior_weight;
use super::sampson::residual_rows;
use crate::frontier::{Class, TangentMatch, Views};
use crate::geometry::{Fundamental, SevenParameters};

/// Standard deviation of what outlines are off by, pixels of a 640×480 image.
const DEVIATION: f64 = 1.0;
/// Steps at most.
const ITERATIONS: usize = 30;
/// A step that lowers the cost by a smaller share is the last.
const LEAST_GAIN: f64 = 1e-8;

/// The seven parameters and both outlines.
type Step = SVector<f64, 9>;
type Normal = SMatrix<f64, 9, 9>;
/// Unit normals of the epipolar lines through a match, away from what moves, in A and in B.
type Outward = [[f64; 2]; 2];

/// Where the search is.
#[derive(Clone)]
struct At {
    geometry: SevenParameters,
    outlines: [f64; 2],
}

impl At {
    fn stepped(&self, step: &Step) -> Self {
        Self {
            geometry: self.geometry.stepped(&step.fixed_rows::<7>(0).into_owned()),
            outlines: [self.outlines[0] + step[7], self.outlines[1] + step[8]],
        }
    }
}

/// What is minimised.
struct Outlines<'m> {
    views: &'m Views,
    matches: &'m [TangentMatch],
    /// Of the Cauchy loss, pixels.
    scale: f64,
    prior_weight: f64,
}

impl Outlines<'_> {
    fn outward(&self, f: &Fundamental, m: &TangentMatch) -> Outward {
        let away = |[x, y]: [f64; 2], up: [f64; 2]| {
            let norm = x.hypot(y).max(f64::MIN_POSITIVE);
            let to_top = (x * up[0] + y * up[1]) > 0.0;
            let sign = if to_top == (m.class == Class::Top) { 1.0 } else { -1.0 };
            [sign * x / norm, sign * y / norm]
        };
        let point = |[x, y]: [f64; 2]| Vector3::new(x, y, 1.0);
        let (in_a, in_b) = (f.line_in_a(&point(m.b)), f.line_in_b(&point(m.a)));
        [away([in_a.x, in_a.y], self.views.a.up), away([in_b.x, in_b.y], self.views.b.up)]
    }

    /// The matches with outlines moved, and the normals along which they were.
    fn moved(&self, at: &At) -> Option<(Vec<TangentMatch>, Vec<Outward>)> {
        let f = at.geometry.fundamental()?;
        let normals: Vec<_> = self.matches.iter().map(|m| self.outward(&f, m)).collect();
        let [by_a, by_b] = at.outlines;
        let along = |p: [f64; 2], n: [f64; 2], by: f64| [p[0] + by * n[0], p[1] + by * n[1]];
        let points = self.matches.iter().zip(&normals);
        let moved =
            points.map(|(m, [a, b])| TangentMatch { a: along(m.a, *a, by_a), b: along(m.b, *b, by_b), ..*m });
        Some((moved.collect(), normals))
    }

    /// Robust cost, normal matrix and gradient.
    fn linearise(&self, at: &At) -> Option<(f64, Normal, Step)> {
        let (moved, normals) = self.moved(at)?;
        let matrix = at.geometry.unscaled();
        let (mut cost, mut normal, mut gradient) = (0.0, Normal::zeros(), Step::zeros());
        for ((residual, along), (m, [out_a, out_b])) in
            residual_rows(&at.geometry, &moved).zip(moved.iter().zip(&normals))
        {
            let in_b = matrix * Vector3::new(m.a[0], m.a[1], 1.0);
            let in_a = matrix.tr_mul(&Vector3::new(m.b[0], m.b[1], 1.0));
            let norm = (in_a.xy().norm_squared() + in_b.xy().norm_squared()).sqrt().max(f64::MIN_POSITIVE);
            let mut row = Step::zeros();
            row.fixed_rows_mut::<7>(0).copy_from(&along);
            row[7] = (in_a.x * out_a[0] + in_a.y * out_a[1]) / norm;
            row[8] = (in_b.x * out_b[0] + in_b.y * out_b[1]) / norm;
            let (loss, weight) = cauchy(residual, self.scale);
            cost += m.surprise * loss;
            let weighed = row * (m.surprise * weight);
            normal += weighed * row.transpose();
            gradient += weighed * residual;
        }
        let deviation = DEVIATION * self.views.pixel_scale();
        for (k, off) in at.outlines.into_iter().enumerate() {
            let weight = self.prior_weight / (deviation * deviation);
            cost += 0.5 * weight * off * off;
            normal[(7 + k, 7 + k)] += weight;
            gradient[7 + k] += weight * off;
        }
        if let Some(cameras) = &self.views.cameras {
            let (of_prior, information, step) = EssentialPrior(cameras).linearise(&at.geometry);
            cost += self.prior_weight * of_prior;
            let mut block = normal.fixed_view_mut::<7, 7>(0, 0);
            block += information * self.prior_weight;
            let mut block = gradient.fixed_rows_mut::<7>(0);
            block += step * self.prior_weight;
        }
        cost.is_finite().then_some((cost, normal, gradient))
    }

    /// Levenberg–Marquardt.
    fn minimise(&self, start: At) -> Option<At> {
        let mut at = start;
        let (mut cost, mut normal, mut gradient) = self.linearise(&at)?;
        let mut damping = 1e-4;
        for _ in 0..ITERATIONS {
            let damped = normal + Normal::from_diagonal(&normal.diagonal().map(|d| damping * (d + 1e-12)));
            let tried = damped.cholesky().map(|c| at.stepped(&c.solve(&-gradient)));
            let found = tried.and_then(|tried| self.linearise(&tried).map(|found| (tried, found)));
            match found.filter(|(_, found)| found.0 < cost) {
                Some((tried, found)) => {
                    let gain = (cost - found.0) / cost.max(f64::MIN_POSITIVE);
                    at = tried;
                    (cost, normal, gradient) = found;
                    damping = (damping * 0.3).max(1e-9);
                    if gain < LEAST_GAIN {
                        break;
                    }
                }
                None => damping *= 8.0,
            }
        }
        Some(at)
    }
}

/// `f`, refined on tangents that meet under it, with outlines of either image that may all be off by so much; `scale` is that of the Cauchy
/// loss, pixels. `None` where it is not known which end of what moves is up, so that nobody knows on which side of its tangents it is.
pub fn with_outlines(
    views: &Views,
    f: &Fundamental,
    matches: &[TangentMatch],
    scale: f64,
) -> Option<Fundamental> {
    if !views.upright || matches.is_empty() || scale.is_nan() {
        return None;
    }
    let problem = Outlines { views, matches, scale, prior_weight: prior_weight(matches) };
    let geometry = SevenParameters::new(f, views.sizes())?;
    let found = problem.minimise(At { geometry, outlines: [0.0; 2] })?;
    found.geometry.fundamental()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frontier::{CommonFrame, View};
    use crate::image::ImageSize;
    use nalgebra::Matrix3;

    #[test]
    fn gradient_equals_differences_of_the_cost() {
        const H: f64 = 1e-6;
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(800, 450).unwrap()];
        let [a, b] = sizes.map(|size| View::made_up(size, &[vec![]]));
        let f = Matrix3::new(1e-6, -4e-6, 2e-3, 1e-6, 5e-6, 6e-3, 1e-3, -7e-3, -0.9);
        let f = Fundamental::from_matrix(&f, sizes[0], sizes[1]).unwrap();
        let matches: Vec<TangentMatch> = (0..40)
            .map(|i| {
                let (x, y) = (f64::from(i * 97 % 600), f64::from(i * 61 % 440));
                let line = f.line_in_b(&Vector3::new(x, y, 1.0));
                let across = f64::from(i * 31 % 700);
                let off = f64::from(i % 7) - 3.0;
                TangentMatch {
                    frame: CommonFrame(0),
                    a: [x, y],
                    b: [across, -(line.x * across + line.z) / line.y + off],
                    distance: 1.0,
                    surprise: 0.5 + f64::from(i % 3),
                    class: if i % 2 == 0 { Class::Top } else { Class::Bottom },
                }
            })
            .collect();
        let k = |focal: f64| Matrix3::new(focal, 0.0, 320.0, 0.0, focal, 240.0, 0.0, 0.0, 1.0);
        let cameras = crate::geometry::CameraMatrices::new(k(600.0), k(700.0)).ok();
        for cameras in [None, cameras] {
            let views = Views::of(a.clone(), b.clone(), vec![]).with_cameras(cameras);
            let problem = Outlines { views: &views, matches: &matches, scale: 1.5, prior_weight: 3.0 };
            let geometry = SevenParameters::new(&f, sizes).unwrap();
            let at = At { geometry, outlines: [0.3, -0.6] };
            let (_, _, gradient) = problem.linearise(&at).unwrap();
            let cost = |step: &Step| problem.linearise(&at.stepped(step)).unwrap().0;
            for k in 0..9 {
                let step = Step::ith(k, H);
                let difference = (cost(&step) - cost(&-step)) / (2.0 * H);
                // Normals turn with the lines, and a point that slides along its tangent is not noticed: to first order.
                assert!(
                    (gradient[k] - difference).abs() < 0.02 * (1.0 + difference.abs()),
                    "{k}: {} {difference}",
                    gradient[k]
                );
            }
        }
    }
}
