//! Do both halves of the recording ask for the same geometry?
//!
//! A camera that was turned a little at half time, or that sinks, leaves two geometries near each other, and what is found on all
//! frames is neither: a compromise that explains both halves, and either less well than what is refined on it alone.

use super::gains::{BLOCKS, Gain};
use super::thresholds::{HALF_DIFFERS, HALF_SHARE, reaches, within};
use crate::frontier::Views;
use crate::frontier::volume::{Correspondence, disagreement, moving_correspondences};
use crate::geometry::Fundamental;
use crate::refine::polish;

/// Frames of a half, at most.
const FRAMES: usize = 200;
/// Fewest frames of a half.
const LEAST: usize = 2 * BLOCKS;

/// How far the geometries of both halves are apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Halves {
    /// From each other over the volume where things moved, pixels; 0 where neither half asks for another geometry than all of it.
    pub apart: f64,
    /// From that of the whole, the farther of the two.
    pub away: f64,
}

/// What either half asks for beside `f`, which all frames gave; `volume` is where things moved by it.
pub(super) fn halves(views: &Views, f: &Fundamental, volume: &[Correspondence], seed: u64) -> Halves {
    let same = Halves { apart: 0.0, away: 0.0 };
    let half = views.frames() / 2;
    if half < LEAST {
        return same;
    }
    let (first, second) =
        rayon::join(|| of_half(views, 0..half, f), || of_half(views, half..views.frames(), f));
    if !first.asks_for_another && !second.asks_for_another {
        return same;
    }
    let of_first = moving_correspondences(views, &first.polished, volume.len(), seed);
    Halves {
        apart: disagreement(&of_first, &second.polished),
        away: disagreement(volume, &first.polished).max(disagreement(volume, &second.polished)),
    }
}

struct Half {
    polished: Fundamental,
    asks_for_another: bool,
}

fn of_half(views: &Views, frames: std::ops::Range<usize>, f: &Fundamental) -> Half {
    let step = frames.len().div_ceil(FRAMES);
    let part = views.chosen(&frames.step_by(step).collect::<Vec<_>>());
    let polished = polish(&part, f);
    let whole = Gain::of(&part, f, &polished);
    // What is no number asks for another.
    let asks_for_another = !reaches(whole.share, HALF_SHARE) && !within(-whole.deviate, HALF_DIFFERS);
    Half { polished, asks_for_another }
}

#[cfg(test)]
mod tests {
    use super::super::throughout::tests::seen;
    use super::*;

    fn apart(from: usize, lower: f64) -> Halves {
        let (views, f) = seen(240, from, lower, 0);
        let f = polish(&views, &f);
        halves(&views, &f, &moving_correspondences(&views, &f, 120, 1), 1)
    }

    #[test]
    fn a_compromise_between_two_halves_is_noticed() {
        assert_eq!(apart(0, 0.0), Halves { apart: 0.0, away: 0.0 });
        for lower in [3.0, 6.0] {
            let found = apart(120, lower);
            assert!((found.apart - lower).abs() < 0.3 * lower, "{lower}: {found:?}");
            assert!(found.away > 0.3 * lower, "{lower}: {found:?}");
        }
    }

    #[test]
    fn of_few_frames_nothing_is_asked() {
        let (views, f) = seen(2 * LEAST - 1, LEAST, 6.0, 0);
        let volume = moving_correspondences(&views, &f, 120, 1);
        assert_eq!(halves(&views, &f, &volume, 1), Halves { apart: 0.0, away: 0.0 });
    }
}
