//! Known camera matrices as a prior on `F`: with them it is an essential matrix, `E = K_bᵀ F K_a`.
//!
//! Its two singular values are equal, which leaves five parameters of seven (Hartley and Zisserman, *Multiple View
//! Geometry*, 9.6). The two that go are those that motion on a floor knows least: heads near the horizon leave them in a
//! valley where the score hardly changes. Camera matrices are measured too, so this is a prior of known width and no
//! law: outlines that are exact overrule a focal length that is not.

use nalgebra::{Matrix3, SMatrix};

use super::least_squares::Problem;
use crate::geometry::CameraMatrices;
use crate::geometry::seven_parameters::{Information, SevenParameters, Step, as_columns};

/// Standard deviation of `(s₁ − s₂) / (s₁ + s₂)` of an essential matrix: about the relative error of a focal length.
pub const DEVIATION: f64 = 0.01;

/// The constraint as a prior on `F`.
#[derive(Debug, Clone, Copy)]
pub struct EssentialPrior<'a>(pub &'a CameraMatrices);

impl EssentialPrior<'_> {
    /// Residuals of the constraint, in standard deviations, and their derivatives: the nine entries of
    /// `E Eᵀ E − ½ tr(E Eᵀ) E` for an `E` of unit norm. Where the singular values are nearly equal the norm of them is
    /// `(s₁ − s₂) / (s₁ + s₂)`.
    fn residuals(self, at: &SevenParameters) -> (Matrix3<f64>, [Matrix3<f64>; 7]) {
        let essential = |f: &Matrix3<f64>| self.0.b.tr_mul(&(f * self.0.a));
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

    /// Information of the prior on the parameters, `JᵀJ` in units of its standard deviation, and the less the further the
    /// geometry is from an essential matrix, for then the outlines contradict the camera matrices.
    pub fn information(self, at: &SevenParameters) -> Information {
        let (cost, information, _) = self.linearise(at);
        information / (1.0 + 2.0 * cost)
    }
}

impl Problem for EssentialPrior<'_> {
    fn linearise(&self, at: &SevenParameters) -> (f64, Information, Step) {
        let (residuals, derivatives) = self.residuals(at);
        let jacobian = as_columns(&derivatives);
        let residuals = SMatrix::<f64, 9, 1>::from_column_slice(residuals.as_slice());
        (0.5 * residuals.norm_squared(), jacobian.tr_mul(&jacobian), jacobian.tr_mul(&residuals))
    }
}

/// Points, and the prior with a weight where the camera matrices are known.
pub struct WithPrior<'a, P> {
    /// The points.
    pub points: &'a P,
    /// The prior and its weight.
    pub prior: Option<(EssentialPrior<'a>, f64)>,
}

impl<P: Problem> Problem for WithPrior<'_, P> {
    fn linearise(&self, at: &SevenParameters) -> (f64, Information, Step) {
        let points = self.points.linearise(at);
        let Some((prior, weight)) = &self.prior else { return points };
        let prior = prior.linearise(at);
        (points.0 + weight * prior.0, points.1 + prior.1 * *weight, points.2 + prior.2 * *weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Fundamental;
    use crate::image::ImageSize;
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
        assert!(EssentialPrior(&cameras()).linearise(&at).0 < 1e-9);
        let mut wrong = cameras();
        wrong.a[(0, 0)] *= 1.05;
        wrong.a[(1, 1)] *= 1.05;
        let cost = EssentialPrior(&wrong).linearise(&at).0;
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
    fn cameras_that_are_contradicted_weigh_less() {
        let at = parameters(&cameras());
        let known = EssentialPrior(&cameras()).information(&at).norm();
        let mut wrong = cameras();
        wrong.a[(0, 0)] *= 1.3;
        wrong.a[(1, 1)] *= 1.3;
        assert!(EssentialPrior(&wrong).information(&at).norm() < 0.05 * known);
        let CameraMatrices { a, mut b } = cameras();
        assert!(CameraMatrices::new(a, b).is_ok());
        b[(2, 2)] = 2.0;
        assert!(CameraMatrices::new(a, b).is_err());
    }

    #[test]
    fn jacobian_equals_differences() {
        let mut wrong = cameras();
        wrong.a[(0, 0)] *= 1.3;
        let at = parameters(&cameras());
        let (_, derivatives) = EssentialPrior(&wrong).residuals(&at);
        for k in 0..7 {
            let mut step = Step::zeros();
            step[k] = 1e-6;
            let difference = (EssentialPrior(&wrong).residuals(&at.stepped(&step)).0
                - EssentialPrior(&wrong).residuals(&at.stepped(&-step)).0)
                / 2e-6;
            assert!((derivatives[k] - difference).norm() < 1e-4 * (1.0 + difference.norm()), "{k}");
        }
    }
}
