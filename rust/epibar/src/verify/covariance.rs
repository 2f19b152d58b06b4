//! How far off an `F` may be: the covariance of its seven parameters, and what it means in pixels.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::thresholds::{MIN_BLOCKS, MIN_POINTS};
use crate::frontier::volume::Correspondence;
use crate::frontier::{Class, TangentMatch};
use crate::geometry::seven_parameters::{Information, SevenParameters, Step};
use crate::image::ImageSize;
use crate::refine::least_squares::cauchy;
use crate::refine::residual_rows;

/// Covariance of the seven parameters from tangents that meet, robust to those of one moment sharing their error.
///
/// `(JᵀWJ)⁻¹ (Σ_blocks g gᵀ) (JᵀWJ)⁻¹` with `g = JᵀWr` the gradient of a block of consecutive frames (the sandwich
/// estimator with clusters): a walker whose outline is off in one frame is off in the next as well. The weights are those of
/// the fit: surprise, and the Cauchy loss of a `scale` in pixels. `None` where the points do not determine the parameters.
pub fn covariance(
    at: &SevenParameters,
    points: &[TangentMatch],
    scale: f64,
    block: usize,
) -> Option<Information> {
    let mut normal = Information::zeros();
    let mut blocks: BTreeMap<u32, Step> = BTreeMap::new();
    for WeightedPoint { p, weight, residual, row } in weighed(at, points, scale) {
        normal.ger(weight, &row, &row, 1.0);
        let block = p.frame.0 / block.max(1) as u32;
        blocks.entry(block).or_insert_with(Step::zeros).axpy(weight * residual, &row, 1.0);
    }
    let count = blocks.len() as f64;
    if points.len() < MIN_POINTS || blocks.len() < MIN_BLOCKS {
        return None;
    }
    // Small-sample correction of clustered sandwiches: seven of the blocks' freedom went into the fit.
    let correction = count / (count - 7.0).max(1.0);
    Some(sandwich(&normal, blocks.values(), 1.0)? * correction)
}

/// `N⁻¹ (Σ w g gᵀ) N⁻¹` of normal equations and gradients of one weight; `None` where it is not finite.
fn sandwich<'g>(
    normal: &Information,
    gradients: impl Iterator<Item = &'g Step>,
    weight: f64,
) -> Option<Information> {
    let inverse = normal.try_inverse()?;
    let mut meat = Information::zeros();
    for gradient in gradients {
        meat.ger(weight, gradient, gradient, 1.0);
    }
    let result = inverse * meat * inverse;
    result.iter().all(|v| v.is_finite()).then_some(result)
}

/// Covariance of the seven parameters from what outlines may be off alike, which neither scatters nor averages out: all tops by a `deviation` in
/// pixels, all bottoms, and either as it changes across the images.
///
/// What tangents are off alike, as `φ` over the points, moves the fit by `(JᵀWJ)⁻¹ JᵀWφ`, and `F` follows it, so that residuals do not show it. Of each class
/// `φ` is 1, and each coordinate of a match in units of its deviation over an image; the covariance is the sum of what they move the fit by. Where
/// all moves near a plane little holds the fit off it, and such an error is many times as large there. `None` where the points do not
/// determine the parameters.
pub fn covariance_alike(
    at: &SevenParameters,
    points: &[TangentMatch],
    scale: f64,
    deviation: f64,
) -> Option<Information> {
    let mut normal = Information::zeros();
    let mut moved = [[Step::zeros(); 5]; 2];
    for WeightedPoint { p, weight, row, .. } in weighed(at, points, scale) {
        normal.ger(weight, &row, &row, 1.0);
        let [size_a, size_b] = at.sizes();
        let ([xa, ya], [xb, yb]) = (in_deviations(p.a, size_a), in_deviations(p.b, size_b));
        let class = match p.class {
            Class::Top => 0,
            Class::Bottom => 1,
        };
        for (gradient, phi) in moved[class].iter_mut().zip([1.0, xa, ya, xb, yb]) {
            gradient.axpy(weight * phi, &row, 1.0);
        }
    }
    sandwich(&normal, moved.iter().flatten(), deviation * deviation)
}

/// A place in an image from its middle, in units of the deviation of what lies evenly over the image.
fn in_deviations(place: [f64; 2], size: ImageSize) -> [f64; 2] {
    let sides = [size.width as f64, size.height as f64];
    [0, 1].map(|k| (2.0 * place[k] / sides[k] - 1.0) * 3f64.sqrt())
}

/// A point as it counts in the fit.
struct WeightedPoint<'p> {
    p: &'p TangentMatch,
    /// Surprise, and the loss of its residual.
    weight: f64,
    /// Pixels.
    residual: f64,
    /// Of the Jacobian.
    row: Step,
}

fn weighed<'p>(
    at: &SevenParameters,
    points: &'p [TangentMatch],
    scale: f64,
) -> impl Iterator<Item = WeightedPoint<'p>> + use<'p> {
    points.iter().zip(residual_rows(at, points)).map(move |(p, (residual, row))| {
        let weight = p.surprise * cauchy(residual, scale).1;
        WeightedPoint { p, weight, residual, row }
    })
}

/// A covariance once a prior of known information is taken into account.
///
/// `(C⁻¹ + P)⁻¹ = C (I + P C)⁻¹`, which asks for no inverse of `C`; `None` where it is not finite.
pub fn with_prior(covariance: &Information, prior: &Information) -> Option<Information> {
    let inverse = (Information::identity() + prior * covariance).try_inverse()?;
    let result = covariance * inverse;
    result.iter().all(|v| v.is_finite()).then_some(0.5 * (result + result.transpose()))
}

/// Expected symmetric epipolar distance over correspondences, pixels: mean over points of the mean of a folded normal.
pub fn expected_error(
    at: &SevenParameters,
    covariance: &Information,
    correspondences: &[Correspondence],
) -> f64 {
    let matrix = at.unscaled();
    let derivatives = at.derivatives();
    let mut sum = 0.0;
    for (a, b) in correspondences {
        let (xa, xb) = (Vector3::new(a[0], a[1], 1.0), Vector3::new(b[0], b[1], 1.0));
        let (in_b, in_a) = (matrix * xa, matrix.tr_mul(&xb));
        let scale = 0.5 * (1.0 / in_b.x.hypot(in_b.y).max(1e-300) + 1.0 / in_a.x.hypot(in_a.y).max(1e-300));
        let row = Step::from_fn(|k, _| xb.dot(&(derivatives[k] * xa)) * scale);
        sum += expected_distance(covariance, &row);
    }
    sum / (correspondences.len().max(1)) as f64
}

/// What to expect of a distance whose derivatives by the parameters are known: the mean of a folded normal.
pub fn expected_distance(covariance: &Information, row: &Step) -> f64 {
    (row.dot(&(covariance * row)).max(0.0) * 2.0 / std::f64::consts::PI).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frontier::CommonFrame;
    use crate::frontier::volume::disagreement;
    use crate::geometry::Fundamental;
    use crate::random::generator;
    use crate::refine::least_squares::minimise;
    use crate::refine::sampson::SampsonProblem;
    use nalgebra::Matrix3;
    use rand::RngExt;

    #[test]
    fn a_prior_adds_its_information() {
        let positive = |salt: usize| {
            let root = Information::from_fn(|i, k| {
                ((3 * i + 5 * k + salt) % 7) as f64 - 3.0 + if i == k { 9.0 } else { 0.0 }
            });
            root * root.transpose()
        };
        let (covariance, prior) = (positive(0) * 1e-4, positive(4));
        let both = with_prior(&covariance, &prior).unwrap();
        let expected = (covariance.try_inverse().unwrap() + prior).try_inverse().unwrap();
        assert!((both - expected).norm() < 1e-6 * expected.norm());
        assert!(both.trace() < covariance.trace());
    }

    #[test]
    fn it_is_that_of_the_fit() {
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(800, 450).unwrap()];
        let matrix = Matrix3::new(1e-6, -3e-6, 2e-3, 5e-6, 2e-6, -9e-3, -4e-3, 6e-3, 1.0);
        let f = Fundamental::from_matrix(&matrix, sizes[0], sizes[1]).unwrap();
        let truth = SevenParameters::new(&f, sizes).unwrap();
        let (count, scale, mut random) = (600, 1.0, generator(8, 0));
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let points: Vec<Correspondence> = (0..count)
            .map(|_| {
                let a = [between(0.0, 639.0), between(0.0, 479.0)];
                let line = f.line_in_b(&Vector3::new(a[0], a[1], 1.0));
                let foot = -line.z / (line.x * line.x + line.y * line.y);
                let along = between(-300.0, 700.0) / line.x.hypot(line.y);
                (a, [line.x * foot - line.y * along, line.y * foot + line.x * along])
            })
            .collect();
        let (mut stated, mut found) = (0.0, 0.0);
        for _ in 0..40 {
            // Noise of half a pixel, and one match in twelve is several pixels off, as where two people are one silhouette;
            // eight matches of one moment share half of it.
            let mut shared = [0.0; 2];
            let matches: Vec<TangentMatch> = (0..count)
                .map(|k| {
                    let wild = if k % 12 == 5 { 8.0 } else { 0.0 };
                    if k % 8 == 0 {
                        shared = [between(-0.6, 0.6), between(-0.6, 0.6)];
                    }
                    let (a, b) = points[k];
                    let b = [0, 1].map(|i| b[i] + shared[i] + between(-0.6, 0.6) + wild * between(-1.0, 1.0));
                    let (frame, surprise) = (CommonFrame(k as u32 / 8), between(0.5, 4.0));
                    TangentMatch { frame, a, b, distance: 0.0, surprise, class: Class::Top }
                })
                .collect();
            let (end, _) = minimise(&SampsonProblem::new(&matches, scale), truth.clone(), 20);
            let covariance = covariance(&end, &matches, scale, 1).unwrap();
            stated += expected_error(&end, &covariance, &points);
            found += disagreement(&points, &end.fundamental().unwrap());
        }
        assert!((0.75..1.25).contains(&(found / stated)), "{found} {stated}");
    }

    /// Points of two classes under a true geometry: at any depth, or `flat`, near a plane, as people's heads and feet on one path.
    fn two_classes(f: &Fundamental, flat: bool) -> Vec<TangentMatch> {
        let mut random = generator(11, 0);
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let epipole = f.epipole_b().normalize();
        let found = (0..2000).filter_map(|k| {
            let a = [between(20.0, 620.0), between(20.0, 460.0)];
            let of_class = if k % 2 == 0 { 0.96 } else { 1.04 };
            let depth = if flat { of_class + between(-0.01, 0.01) } else { between(0.2, 1.8) };
            // [e]× F - e vᵀ is the homography of a plane, whatever v is (Hartley and Zisserman, 13.1).
            let x = Vector3::new(a[0], a[1], 1.0);
            let f = f.matrix() / f.matrix().norm();
            let b = epipole.cross(&(f * x)) - epipole * (Vector3::new(1e-3, 2e-3, 1.0).dot(&x) * 2.0 * depth);
            let b = [b.x / b.z, b.y / b.z];
            let class = if k % 2 == 0 { Class::Top } else { Class::Bottom };
            let seen = (0.0..800.0).contains(&b[0]) && (0.0..450.0).contains(&b[1]);
            let frame = CommonFrame(k);
            seen.then_some(TangentMatch { frame, a, b, distance: 0.0, surprise: 1.0, class })
        });
        let found: Vec<_> = found.take(600).collect();
        assert_eq!(found.len(), 600);
        found
    }

    #[test]
    fn what_is_off_alike_counts_most_off_the_plane() {
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(800, 450).unwrap()];
        let matrix = Matrix3::new(1e-6, -3e-6, 2e-3, 5e-6, 2e-6, -9e-3, -4e-3, 6e-3, 1.0);
        let f = Fundamental::from_matrix(&matrix, sizes[0], sizes[1]).unwrap();
        let at = SevenParameters::new(&f, sizes).unwrap();
        let everywhere: Vec<Correspondence> = two_classes(&f, false).iter().map(|p| (p.a, p.b)).collect();
        let known = |flat, deviation| {
            let points = two_classes(&f, flat);
            let alike = covariance_alike(&at, &points, 1.0, deviation).unwrap();
            let here: Vec<Correspondence> = points.iter().map(|p| (p.a, p.b)).collect();
            (expected_error(&at, &alike, &here), expected_error(&at, &alike, &everywhere))
        };
        let (here, beyond) = known(false, 0.5);
        assert!((0.2..1.5).contains(&here) && beyond < 1.5 * here, "{here} {beyond}");
        let (here, beyond) = known(true, 0.5);
        assert!((0.2..1.5).contains(&here) && beyond > 4.0 * here, "{here} {beyond}");
        let (twice, _) = known(true, 1.0);
        assert!((twice / here - 2.0).abs() < 1e-6, "{twice} {here}");
        assert_eq!(known(false, 0.0), (0.0, 0.0));
    }

    #[test]
    fn what_is_off_alike_is_what_the_fit_follows() {
        // All tops moved down in B by 0.7 px, by which a Sampson distance is half a pixel: the fit goes where the covariance says that it may.
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(800, 450).unwrap()];
        let matrix = Matrix3::new(1e-6, -3e-6, 2e-3, 5e-6, 2e-6, -9e-3, -4e-3, 6e-3, 1.0);
        let f = Fundamental::from_matrix(&matrix, sizes[0], sizes[1]).unwrap();
        let at = SevenParameters::new(&f, sizes).unwrap();
        let mut points = two_classes(&f, false);
        let volume: Vec<Correspondence> = points.iter().map(|p| (p.a, p.b)).collect();
        let alike = covariance_alike(&at, &points, 1.0, 0.5).unwrap();
        for p in points.iter_mut().filter(|p| p.class == Class::Top) {
            p.b[1] += 0.7;
        }
        let (end, _) = minimise(&SampsonProblem::new(&points, 1.0), at.clone(), 20);
        let off = disagreement(&volume, &end.fundamental().unwrap());
        let stated = expected_error(&at, &alike, &volume);
        assert!((0.1..1.0).contains(&(off / stated)), "{off} {stated}");
    }
}
