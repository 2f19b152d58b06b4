//! How far is a geometry from any two cameras, beyond what it may be off by chance?
//!
//! What is known of it badly may be far from any two cameras, and the truth is not. So of the deviation counts what its own covariance does not explain.

use super::error_map::Uncertainty;
use super::thresholds::{CAMERAS_CHANCE, CAMERAS_ERROR, CAMERAS_ERROR_GIVEN};
use crate::frontier::Views;
use crate::geometry::possible_cameras::least_deviation;
use crate::geometry::{CameraMatrices, Fundamental};

/// [`least_deviation`] of `f`, less what is chance; all of it where its uncertainty is not known.
pub(super) fn from_cameras(views: &Views, f: &Fundamental, uncertainty: Option<&Uncertainty>) -> f64 {
    let known = views.cameras.as_ref();
    let found = least_deviation(f, views.sizes(), known);
    let beyond = uncertainty.map_or(f64::NAN, |of| found - CAMERAS_CHANCE * deviates(of, known));
    if beyond.is_nan() { found } else { beyond.max(0.0) }
}

/// Pixels that a geometry may be off which is so far from any two cameras.
pub(super) fn error_of(views: &Views, from_cameras: f64) -> f64 {
    let by_unit = if views.cameras.is_some() { CAMERAS_ERROR_GIVEN } else { CAMERAS_ERROR };
    by_unit * views.pixel_scale() * from_cameras
}

/// Standard deviation of [`least_deviation`]; NaN where it is not known.
fn deviates(of: &Uncertainty, known: Option<&CameraMatrices>) -> f64 {
    let axes = of.covariance.symmetric_eigen();
    let at = |k: usize, side: f64| {
        let step = axes.eigenvectors.column(k) * (side * axes.eigenvalues[k].max(0.0).sqrt());
        let f = of.at.stepped(&step).fundamental();
        f.map_or(f64::NAN, |f| least_deviation(&f, of.at.sizes(), known))
    };
    (0..7).map(|k| (0.5 * (at(k, 1.0) - at(k, -1.0))).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::throughout::tests::seen;
    use super::*;
    use crate::geometry::SevenParameters;
    use crate::geometry::seven_parameters::Information;
    use crate::image::ImageSize;

    #[test]
    fn what_is_chance_does_not_count() {
        let (views, _) = seen(40, 0, 0.0, 0);
        // Of no two cameras.
        let f = nalgebra::Matrix3::new(1e-6, 4e-6, -3e-3, -9e-6, 2e-6, 8e-3, 1e-3, -5e-3, 0.3);
        let size = ImageSize::new(640, 480).unwrap();
        let f = Fundamental::from_matrix(&f, size, size).unwrap();
        let at = SevenParameters::new(&f, views.sizes()).unwrap();
        let known_to = |deviation: f64| {
            let covariance = Information::identity() * deviation * deviation;
            let of = Uncertainty { at: at.clone(), covariance, alike: covariance, systematic: 0.0 };
            from_cameras(&views, &f, Some(&of))
        };
        let all = from_cameras(&views, &f, None);
        assert!(all > 0.01, "{all}");
        assert!((known_to(0.0) - all).abs() < 1e-9, "{} of {all}", known_to(0.0));
        let [well, badly] = [known_to(1e-3), known_to(0.2)];
        assert!(well < all && well > 0.7 * all && badly < 0.5 * well, "{all} {well} {badly}");
        assert_eq!(known_to(f64::NAN), all);
    }
}
