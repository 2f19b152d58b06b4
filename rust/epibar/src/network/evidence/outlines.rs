//! By how much the outlines of each camera are wrong.
//!
//! Masks of one camera may be clean and those of another ragged, or so small that a filter takes the heads off. Tangents
//! that meet scatter by what the outlines of both cameras are wrong by, each as far as its pixels count.

use crate::geometry::median::deviation;
use crate::network::model::beliefs::{Belief, Beliefs};
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

/// Beliefs by which insets differ from side to side, and with the size of silhouettes, as far as the outlines of each camera are wrong; those that are
/// given where shapes are no masks: what stands for a figure is wrong by what it stands for, which is more of large ones.
#[must_use]
pub fn with_uneven_insets(mut beliefs: Vec<Beliefs>, settled: &Settled, shapes: Shapes) -> Vec<Beliefs> {
    if shapes == Shapes::Masks {
        for (beliefs, wrong) in beliefs.iter_mut().zip(outline_errors(settled, shapes)) {
            beliefs.insets.small = Belief::about(0.0, limits::UNEVEN_BY_SIZE * wrong);
            beliefs.insets.sides = Belief::about(0.0, limits::UNEVEN_BY_SIDE * wrong);
        }
    }
    beliefs
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
    use crate::network::model::beliefs::InsetBeliefs;
    use crate::network::model::camera::{Camera, FOCAL};
    use crate::network::model::joint::JointProblem;
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

    #[test]
    fn what_small_silhouettes_lose_is_no_other_focal_length() {
        let mut one = seen([0.05; 4]);
        // Figures in the upper half of the first camera's image are half as tall, and their tops are cut off by most of a pixel.
        for p in one.pairs.iter_mut().filter(|p| p.a == 0) {
            for m in p.meetings.iter_mut().filter(|m| m.a[1] < 240.0) {
                m.smallness[0] = 1.0;
                m.a[1] += 0.8;
            }
        }
        let known = |c: &Camera| Beliefs {
            intrinsic: std::array::from_fn(|k| match k {
                FOCAL => Belief::about(c.log_focal, 0.3),
                _ => Belief::fixed(c.intrinsic()[k]),
            }),
            clock: [Belief::fixed(0.0); 2],
            insets: InsetBeliefs::all_around(Belief::fixed(0.0)),
            centred: false,
            posed: false,
        };
        let even: Vec<Beliefs> = one.cameras.iter().map(known).collect();
        let solved = |beliefs: &[Beliefs]| {
            let moving = vec![true; 4];
            let problem = JointProblem { pairs: &one.pairs, beliefs, scale: 0.5, prior_weight: 0.01, moving };
            problem.solve(&one.cameras, 30).0[0]
        };
        assert_eq!(with_uneven_insets(even.clone(), &one, Shapes::Convex), even);
        let off = |found: &Camera| (found.log_focal - one.cameras[0].log_focal).abs();
        let (without, with) = (solved(&even), solved(&with_uneven_insets(even.clone(), &one, Shapes::Masks)));
        assert_eq!((without.insets.small, without.insets.sides), (0.0, [0.0; 4]));
        assert!((with.insets.small - 0.8).abs() < 0.1, "{:?}", with.insets);
        assert!(off(&with) < 0.3 * off(&without), "{} {}", off(&with), off(&without));
    }
}
