//! Do the camera matrices that were given agree with what moves?
//!
//! They are a prior, which exact outlines overrule. Where they hold a geometry that explains far less than the one that is refined without them, the two contradict each
//! other: the matrices are not those of these cameras, or one camera's silhouettes lack the same part of everybody, which no camera matrices fit.

use super::gains::Gain;
use super::thresholds::{CONTRADICTED_GAIN, CONTRADICTED_SHARE, within};
use crate::frontier::Views;
use crate::geometry::Fundamental;
use crate::refine::polish;

/// Frames that are looked at, at most.
const FRAMES: usize = 400;

/// Whether the matrices contradict what moves by what is explained without them; what is no number does.
pub(super) fn contradict(without: &Gain) -> bool {
    !within(without.share, CONTRADICTED_SHARE) && !within(without.deviate, CONTRADICTED_GAIN)
}

/// What `f`, which was found with the camera matrices of `views`, explains once it is refined without them, beside what it does; `None` where none were given.
pub(super) fn without_given_cameras(views: &Views, f: &Fundamental) -> Option<Gain> {
    views.cameras?;
    let step = views.frames().div_ceil(FRAMES).max(1);
    let part = views.chosen(&(0..views.frames()).step_by(step).collect::<Vec<_>>());
    let freed = polish(&part.clone().with_cameras(None), f);
    Some(Gain::of(&part, &freed, f))
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::super::throughout::tests::seen;
    use super::*;
    use crate::geometry::CameraMatrices;

    #[test]
    fn matrices_that_hold_a_geometry_where_less_is_explained_contradict_what_moves() {
        let (views, f) = seen(240, 0, 0.0, 0);
        assert_eq!(without_given_cameras(&views, &f), None);
        let known = Matrix3::new(400.0, 0.0, 319.5, 0.0, 400.0, 239.5, 0.0, 0.0, 1.0);
        let views = views.with_cameras(Some(CameraMatrices::new(known, known).unwrap()));
        let agree = without_given_cameras(&views, &f).unwrap();
        assert!(!contradict(&agree), "{agree:?}");
        // Held three pixels away.
        let mut held = *f.matrix();
        held[(2, 2)] -= 3.0 * held[(2, 1)];
        let sizes = views.sizes();
        let held = Fundamental::from_matrix(&held, sizes[0], sizes[1]).unwrap();
        let without = without_given_cameras(&views, &held).unwrap();
        assert!(contradict(&without), "{without:?}");
    }

    #[test]
    fn what_is_no_number_contradicts() {
        let contradicts = |share, deviate| contradict(&Gain { share, deviate });
        assert!(!contradicts(1.01, 9.0) && !contradicts(2.0, 1.0));
        assert!(contradicts(2.0, 6.0) && contradicts(f64::NAN, 6.0) && contradicts(f64::NAN, f64::NAN));
    }
}
