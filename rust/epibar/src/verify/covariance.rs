//! How far off an `F` may be: the covariance of its seven parameters, and what it means in pixels.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::frontier::TangentMatch;
use crate::frontier::volume::Correspondence;
use crate::geometry::seven_parameters::{Information, SevenParameters, Step};
use crate::refine::residual_rows;

/// Covariance of the seven parameters from tangents that meet, robust to those of one moment sharing their error.
///
/// `(JᵀJ)⁻¹ (Σ_blocks g gᵀ) (JᵀJ)⁻¹` with `g` the gradient of a block of consecutive frames (the sandwich
/// estimator with clusters): a walker whose outline is off in one frame is off in the next as well. `None` where
/// the points do not determine the parameters.
pub fn covariance(at: &SevenParameters, points: &[TangentMatch], block: usize) -> Option<Information> {
    let mut normal = Information::zeros();
    let mut blocks: BTreeMap<u32, Step> = BTreeMap::new();
    for (p, (residual, row)) in points.iter().zip(residual_rows(at, points)) {
        normal.ger(1.0, &row, &row, 1.0);
        blocks.entry(p.frame.0 / block.max(1) as u32).or_insert_with(Step::zeros).axpy(residual, &row, 1.0);
    }
    let count = blocks.len() as f64;
    if points.len() < 20 || count < 8.0 {
        return None;
    }
    let inverse = normal.try_inverse()?;
    let mut meat = Information::zeros();
    for gradient in blocks.values() {
        meat.ger(1.0, gradient, gradient, 1.0);
    }
    // Small-sample correction of clustered sandwiches: seven of the blocks' freedom went into the fit.
    let correction = count / (count - 7.0).max(1.0);
    let result = inverse * meat * inverse * correction;
    result.iter().all(|v| v.is_finite()).then_some(result)
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
        sum += (row.dot(&(covariance * row)).max(0.0) * 2.0 / std::f64::consts::PI).sqrt();
    }
    sum / (correspondences.len().max(1)) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
