//! What known camera matrices say of `F`: with them it is an essential matrix, `E = K_bᵀ F K_a`.
//!
//! Its two singular values are equal, which leaves five parameters of seven (Hartley and Zisserman, *Multiple View
//! Geometry*, 9.6). The two that go are those that motion on a floor knows least: heads near the horizon leave them in a
//! valley where the evidence hardly changes. Camera matrices are measured too, so this is a prior of known width and no
//! law: outlines that are exact overrule a focal length that is not.

use nalgebra::{Matrix3, SMatrix};

use super::optimise::{Information, Problem, SevenParameters, Step, as_columns};
use crate::geometry::Fundamental;

/// Standard deviation of `(s₁ − s₂) / (s₁ + s₂)` of an essential matrix: about the relative error of a focal length.
const DEVIATION: f64 = 0.01;

/// Camera matrices of A and B, undistorted pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraMatrices {
    /// Of A.
    pub a: Matrix3<f64>,
    /// Of B.
    pub b: Matrix3<f64>,
}

impl CameraMatrices {
    /// Residuals of the constraint, in standard deviations, and their derivatives: the nine entries of
    /// `E Eᵀ E − ½ tr(E Eᵀ) E` for an `E` of unit norm. Where the singular values are nearly equal the norm of them is
    /// `(s₁ − s₂) / (s₁ + s₂)`.
    fn residuals(&self, at: &SevenParameters) -> (Matrix3<f64>, [Matrix3<f64>; 7]) {
        let essential = |f: &Matrix3<f64>| self.b.tr_mul(&(f * self.a));
        let e = essential(&at.unscaled());
        let norm = e.norm();
        let e = e / norm;
        let square = e * e.transpose();
        let derivatives = at.derivatives().map(|f| {
            let d = essential(&f) / norm;
            let d = d - e * e.dot(&d);
            (d * e.tr_mul(&e) + e * d.tr_mul(&e) + square * d - d * 0.5) / DEVIATION
        });
        ((square * e - e * 0.5) / DEVIATION, derivatives)
    }

    /// `(s₁ − s₂) / (s₁ + s₂)` of the singular values of `E`: 0 for an essential matrix.
    pub fn deviation(&self, f: &Fundamental) -> f64 {
        let e = self.b.tr_mul(&(f.matrix() * self.a));
        // Of rank 2: s₁² + s₂² is the trace of E Eᵀ, s₁² s₂² the sum of its principal minors.
        let square = e * e.transpose();
        let (sum, product) = (square.trace(), 0.5 * (square.trace().powi(2) - square.norm_squared()));
        let twice = 2.0 * product.max(0.0).sqrt();
        ((sum - twice).max(0.0) / (sum + twice)).sqrt()
    }

    /// Whether both are finite, with positive focal lengths and a last row of 0, 0, 1.
    pub fn usable(&self) -> bool {
        let last = |k: &Matrix3<f64>| (k.row(2).transpose() - nalgebra::Vector3::z()).norm() < 1e-9;
        let one = |k: &Matrix3<f64>| k.iter().all(|v| v.is_finite()) && k.m11 > 0.0 && k.m22 > 0.0 && last(k);
        one(&self.a) && one(&self.b)
    }

    /// What the constraint tells of a geometry: `JᵀJ`, its standard deviation as the unit, and the less the further the
    /// geometry is from an essential matrix, for then the outlines contradict the camera matrices.
    pub fn information(&self, at: &SevenParameters) -> Information {
        let (cost, information, _) = self.linearise(at);
        information / (1.0 + 2.0 * cost)
    }
}

impl Problem for CameraMatrices {
    fn linearise(&self, at: &SevenParameters) -> (f64, Information, Step) {
        let (residuals, derivatives) = self.residuals(at);
        let jacobian = as_columns(&derivatives);
        let residuals = SMatrix::<f64, 9, 1>::from_column_slice(residuals.as_slice());
        (0.5 * residuals.norm_squared(), jacobian.tr_mul(&jacobian), jacobian.tr_mul(&residuals))
    }
}

/// Two problems at once, the second with a weight.
pub struct Weighted<'a, P> {
    /// The points.
    pub points: &'a P,
    /// What the cameras say, and how much it counts.
    pub prior: Option<(&'a CameraMatrices, f64)>,
}

impl<P: Problem> Problem for Weighted<'_, P> {
    fn linearise(&self, at: &SevenParameters) -> (f64, Information, Step) {
        let points = self.points.linearise(at);
        let Some((cameras, weight)) = self.prior else { return points };
        let prior = cameras.linearise(at);
        (points.0 + weight * prior.0, points.1 + prior.1 * weight, points.2 + prior.2 * weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line::ImageSize;
    use crate::verify::with_prior;
    use nalgebra::{Rotation3, Vector3};

    fn cameras() -> CameraMatrices {
        CameraMatrices {
            a: Matrix3::new(600.0, 0.0, 310.0, 0.0, 605.0, 250.0, 0.0, 0.0, 1.0),
            b: Matrix3::new(700.0, 0.0, 410.0, 0.0, 690.0, 220.0, 0.0, 0.0, 1.0),
        }
    }

    fn parameters(of: &CameraMatrices) -> SevenParameters {
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(800, 450).unwrap()];
        let rotation = Rotation3::from_euler_angles(0.2, 1.4, -0.3);
        let essential = Vector3::new(1.0, 0.2, 0.7).cross_matrix() * rotation.matrix();
        let inverse = |k: Matrix3<f64>| k.try_inverse().unwrap();
        let f = inverse(of.b).transpose() * essential * inverse(of.a);
        SevenParameters::new(&Fundamental::from_matrix(&f, sizes[0], sizes[1]).unwrap(), sizes).unwrap()
    }

    #[test]
    fn true_cameras_fit_and_a_wrong_focal_length_does_not() {
        let at = parameters(&cameras());
        assert!(cameras().linearise(&at).0 < 1e-9);
        let mut wrong = cameras();
        wrong.a[(0, 0)] *= 1.05;
        wrong.a[(1, 1)] *= 1.05;
        let cost = wrong.linearise(&at).0;
        let f = at.fundamental().unwrap();
        assert!(cameras().deviation(&f) < 1e-6);
        let e = wrong.b.tr_mul(&(at.unscaled() * wrong.a));
        let s = e.svd(false, false).singular_values;
        let deviation = (s[0] - s[1]) / (s[0] + s[1]);
        assert!((wrong.deviation(&f) / deviation - 1.0).abs() < 1e-6);
        let deviations = deviation / DEVIATION;
        assert!(((2.0 * cost).sqrt() / deviations - 1.0).abs() < 0.05, "{cost} {deviations}");
    }

    #[test]
    fn cameras_that_are_contradicted_tell_less() {
        let at = parameters(&cameras());
        let told = cameras().information(&at).norm();
        let mut wrong = cameras();
        wrong.a[(0, 0)] *= 1.3;
        wrong.a[(1, 1)] *= 1.3;
        assert!(wrong.information(&at).norm() < 0.05 * told);
        let mut spoilt = cameras();
        spoilt.b[(2, 2)] = 2.0;
        assert!(cameras().usable() && !spoilt.usable());
    }

    #[test]
    fn a_prior_adds_its_information() {
        let root =
            Information::from_fn(|i, k| ((3 * i + 5 * k) % 7) as f64 - 3.0 + if i == k { 9.0 } else { 0.0 });
        let covariance = root * root.transpose() * 1e-4;
        let prior = cameras().information(&parameters(&cameras()));
        let both = with_prior(&covariance, &prior).unwrap();
        let expected = (covariance.try_inverse().unwrap() + prior).try_inverse().unwrap();
        assert!((both - expected).norm() < 1e-6 * expected.norm());
        assert!(both.trace() < covariance.trace());
    }

    #[test]
    fn jacobian_equals_differences() {
        let mut wrong = cameras();
        wrong.a[(0, 0)] *= 1.3;
        let at = parameters(&cameras());
        let (_, derivatives) = wrong.residuals(&at);
        for k in 0..7 {
            let mut step = Step::zeros();
            step[k] = 1e-6;
            let difference =
                (wrong.residuals(&at.stepped(&step)).0 - wrong.residuals(&at.stepped(&-step)).0) / 2e-6;
            assert!((derivatives[k] - difference).norm() < 1e-4 * (1.0 + difference.norm()), "{k}");
        }
    }
}
