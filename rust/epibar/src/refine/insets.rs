//! By how much hulls lie inside of the outlines, in either image, solved for beside `F`.
//!
//! A mask that is a pixel too wide, or eaten by as much, puts its tangents outside of what moves or inside, all alike. Bottoms then lie
//! too low and tops too high, or the other way round, and `F` gives way to that: residuals are small, and the epipolar lines are off
//! by what the outlines are. Figures stand near and far, so no `F` follows it everywhere, and how far the outlines of either image are to be
//! moved along their normals is told by the same tangents.

use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};

use super::essential::EssentialPrior;
use super::least_squares::{Problem, Unknowns, cauchy, minimise};
use super::polish::{loss_scale, prior_weight};
use super::sampson::residual_rows;
use crate::frontier::{Class, TangentMatch, Views, meeting_radius, tangent_matches};
use crate::geometry::{Fundamental, SevenParameters};

/// Standard deviation of what outlines are off by, pixels of a 640×480 image.
const DEVIATION: f64 = 1.0;
/// Steps at most.
const ITERATIONS: usize = 30;

/// The seven parameters and both insets.
type StepWithInsets = SVector<f64, 9>;
type Normal = SMatrix<f64, 9, 9>;

/// Where the search is.
struct At {
    geometry: SevenParameters,
    insets: [f64; 2],
}

impl Unknowns<9> for At {
    fn stepped(&self, step: &StepWithInsets) -> Self {
        Self {
            geometry: self.geometry.stepped(&step.fixed_rows::<7>(0).into_owned()),
            insets: [self.insets[0] + step[7], self.insets[1] + step[8]],
        }
    }
}

/// What is minimised.
struct WithInsets<'m> {
    views: &'m Views,
    matches: &'m [TangentMatch],
    /// Of the Cauchy loss, pixels.
    scale: f64,
    prior_weight: f64,
}

/// Unit normals of the epipolar lines through a match, away from what moves, in A and in B.
fn outward(views: &Views, matrix: &Matrix3<f64>, m: &TangentMatch) -> [Vector2<f64>; 2] {
    let away = |line: Vector3<f64>, [x, y]: [f64; 2]| {
        let normal = line.xy() / line.xy().norm().max(f64::MIN_POSITIVE);
        let to_top = normal.dot(&Vector2::new(x, y)) > 0.0;
        if to_top == (m.class == Class::Top) { normal } else { -normal }
    };
    let (in_a, in_b) = lines(matrix, m);
    [away(in_a, views.a.up), away(in_b, views.b.up)]
}

/// Derivatives of the residual of a match by both insets, along normals that are known.
fn by_insets(matrix: &Matrix3<f64>, m: &TangentMatch, [out_a, out_b]: &[Vector2<f64>; 2]) -> [f64; 2] {
    let (in_a, in_b) = lines(matrix, m);
    let norm = (in_a.xy().norm_squared() + in_b.xy().norm_squared()).sqrt().max(f64::MIN_POSITIVE);
    [in_a.xy().dot(out_a) / norm, in_b.xy().dot(out_b) / norm]
}

/// Epipolar lines of a match in A and in B.
fn lines(matrix: &Matrix3<f64>, m: &TangentMatch) -> (Vector3<f64>, Vector3<f64>) {
    let point = |[x, y]: [f64; 2]| Vector3::new(x, y, 1.0);
    (matrix.tr_mul(&point(m.b)), matrix * point(m.a))
}

impl Problem<At, 9> for WithInsets<'_> {
    // Where the epipole is nearly open the last digits of the cost move it.
    const LEAST_GAIN: f64 = 1e-8;

    fn linearise(&self, at: &At) -> (f64, Normal, StepWithInsets) {
        let matrix = at.geometry.unscaled();
        let normals: Vec<_> = self.matches.iter().map(|m| outward(self.views, &matrix, m)).collect();
        let along = |p: [f64; 2], normal: &Vector2<f64>, by: f64| (Vector2::from(p) + normal * by).into();
        let moved = self.views.insets.unwrap_or_default();
        let [by_a, by_b] = [0, 1].map(|k| at.insets[k] - moved[k]);
        let moved: Vec<_> = (self.matches.iter().zip(&normals))
            .map(|(m, [a, b])| TangentMatch { a: along(m.a, a, by_a), b: along(m.b, b, by_b), ..*m })
            .collect();
        let (mut cost, mut normal, mut gradient) = (0.0, Normal::zeros(), StepWithInsets::zeros());
        let rows = residual_rows(&at.geometry, &moved).zip(moved.iter().zip(&normals));
        for ((residual, of_geometry), (m, normals)) in rows {
            let mut row = StepWithInsets::zeros();
            row.fixed_rows_mut::<7>(0).copy_from(&of_geometry);
            [row[7], row[8]] = by_insets(&matrix, m, normals);
            let (loss, weight) = cauchy(residual, self.scale);
            cost += m.surprise * loss;
            let weighed = row * (m.surprise * weight);
            normal += weighed * row.transpose();
            gradient += weighed * residual;
        }
        let weight = self.prior_weight / (DEVIATION * self.views.pixel_scale()).powi(2);
        for (k, off) in at.insets.into_iter().enumerate() {
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
        (cost, normal, gradient)
    }
}

/// By how many pixels hulls lie inside of the outlines in A and in B as they were seen, beyond them where below nought, as tangents tell that meet under
/// `f`. `None` where it is not known which end of what moves is up, so that nobody knows on which side of its tangents it is.
pub fn insets(views: &Views, f: &Fundamental) -> Option<[f64; 2]> {
    let radius = meeting_radius(views, f);
    let matches = tangent_matches(views, f, radius);
    Some(solve(views, f, &matches, loss_scale(radius))?.insets)
}

/// `f`, refined with both insets on tangents that meet under it; `scale` is that of the Cauchy loss, pixels. `None` as of [`insets`].
pub fn with_insets(
    views: &Views,
    f: &Fundamental,
    matches: &[TangentMatch],
    scale: f64,
) -> Option<Fundamental> {
    solve(views, f, matches, scale)?.geometry.fundamental()
}

fn solve(views: &Views, f: &Fundamental, matches: &[TangentMatch], scale: f64) -> Option<At> {
    if !views.upright || matches.is_empty() || scale.is_nan() {
        return None;
    }
    let problem = WithInsets { views, matches, scale, prior_weight: prior_weight(matches) };
    let geometry = SevenParameters::new(f, views.sizes())?;
    Some(minimise(&problem, At { geometry, insets: views.insets.unwrap_or_default() }, ITERATIONS).0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frontier::{CommonFrame, View};
    use crate::image::ImageSize;

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
            let problem = WithInsets { views: &views, matches: &matches, scale: 1.5, prior_weight: 3.0 };
            let geometry = SevenParameters::new(&f, sizes).unwrap();
            let at = At { geometry, insets: [0.3, -0.6] };
            let (_, _, gradient) = problem.linearise(&at);
            let cost = |step: &StepWithInsets| problem.linearise(&at.stepped(step)).0;
            for k in 0..9 {
                let step = StepWithInsets::ith(k, H);
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
