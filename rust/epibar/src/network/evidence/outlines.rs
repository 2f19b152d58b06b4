//! By how much the outlines of each camera are wrong.
//!
//! Masks of one camera may be clean and those of another ragged, or so small that a filter takes the heads off. Tangents
//! that meet scatter by what the outlines of both cameras are wrong by, each as far as its pixels count.

use crate::geometry::median::deviation;
use crate::network::model::residual::CameraPair;
use crate::network::observations::observed::Observed;
use crate::network::solve::settle::Settled;
use crate::network::thresholds as limits;

/// Robust standard deviation of residuals, pixels, of each camera: of those in which its own pixels have the larger share. NaN
/// of a camera of which there are hardly any.
fn scatter_of_cameras(settled: &Settled) -> Vec<f64> {
    let mut residuals = vec![Vec::new(); settled.cameras.len()];
    for p in &settled.pairs {
        let pair = CameraPair::new(&settled.cameras[p.a], &settled.cameras[p.b]);
        for m in &p.meetings {
            if let Some((residual, share)) = pair.shared(m) {
                residuals[if share > 0.5 { p.a } else { p.b }].push(residual);
            }
        }
    }
    let of_one = |r: Vec<f64>| match r.len() {
        0..limits::LEAST_MEETINGS => f64::NAN,
        _ => deviation(r.into_iter()).unwrap_or(f64::NAN),
    };
    residuals.into_iter().map(of_one).collect()
}

/// By how many pixels the outlines of each camera may all be wrong alike: by what all of the network say, and by more where
/// its own say so.
pub fn outline_errors(settled: &Settled, shapes: Shapes) -> Vec<f64> {
    let own = scatter_of_cameras(settled).into_iter();
    own.map(|own| outline_error(own.max(settled.scale), shapes)).collect()
}

/// What is seen of the silhouettes of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shapes {
    /// Cut out: there are gaps between them and their hulls.
    Masks,
    /// Without a gap, so that they may stand for something else, as boxes and ellipses do.
    Convex,
    /// Without a gap, and wrong in the same way all over the image, or principal points are wrong.
    Strained,
}

impl Shapes {
    /// Of most cameras, as far as the shapes themselves tell.
    pub fn of(observed: &[Observed]) -> Self {
        let convex = observed.iter().filter(|o| o.fill > limits::CONVEX).count();
        if 2 * convex > observed.len() { Self::Convex } else { Self::Masks }
    }
}

/// What scatters more than pixels do by themselves is wrong outlines, and part of it is common to all.
fn outline_error(scatter: f64, shapes: Shapes) -> f64 {
    let beyond = (scatter.powi(2) - limits::PIXELS.powi(2)).max(0.0).sqrt();
    let of_masks =
        limits::OUTLINE_ERROR.max(limits::OUTLINE_SHARE[0] * scatter).max(limits::OUTLINE_SHARE[1] * beyond);
    match shapes {
        Shapes::Masks => of_masks,
        Shapes::Convex => of_masks.max(limits::OUTLINE_COARSE * beyond),
        Shapes::Strained => limits::OUTLINE_STRAINED * scatter,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::solve::settle::tests::seen;

    #[test]
    fn ragged_outlines_are_of_their_camera() {
        let found = scatter_of_cameras(&seen([0.3, 0.3, 1.2, 0.3]));
        assert!((0.8..1.4).contains(&found[2]), "{found:?}");
        assert!([0, 1, 3].iter().all(|c| found[*c] < 0.5), "{found:?}");
        let errors = outline_errors(&seen([0.3, 0.3, 1.2, 0.3]), Shapes::Masks);
        assert!(errors[2] > 0.6, "{errors:?}");
        // No camera is better than what all together say.
        assert!([0, 1, 3].iter().all(|c| (errors[*c] - 0.25).abs() < 1e-9), "{errors:?}");
    }

    #[test]
    fn coarse_shapes_that_scatter_are_wrong_alike_by_more() {
        let of = |scatter, shapes| outline_error(scatter, shapes);
        assert_eq!(of(0.5, Shapes::Convex), of(0.5, Shapes::Masks));
        assert!(of(4.0, Shapes::Convex) > 2.0 * of(4.0, Shapes::Masks));
        assert!(of(4.0, Shapes::Convex) < of(4.0, Shapes::Strained));
    }

    #[test]
    fn a_camera_that_hardly_meets_anything_is_like_the_others() {
        let mut few = seen([0.3; 4]);
        few.pairs.retain(|p| p.b != 3);
        assert!(scatter_of_cameras(&few)[3].is_nan());
        assert!((outline_errors(&few, Shapes::Masks)[3] - 0.25).abs() < 1e-9);
        assert!((outline_errors(&few, Shapes::Strained)[3] - 2.0).abs() < 1e-9);
    }
}
