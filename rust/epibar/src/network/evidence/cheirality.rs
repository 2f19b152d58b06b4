//! Do rays that meet do so before their cameras?
//!
//! Tangents meet where planes through both cameras touch from the same side, and two rays of one such plane may still run apart, so that
//! they would meet behind a camera (cheirality: Hartley 1998). A wrong geometry that fits outlines has most of its points there.

use crate::network::model::joint::PairMeetings;
use crate::network::observations::evenly::evenly;
use crate::network::observations::figures::crossing;
use crate::network::solve::settle::Settled;
use crate::network::thresholds as limits;

/// Meetings that are looked at of each pair.
const MEETINGS: usize = 400;

/// The camera with most of those confirmed pairs of which most of what meets would be behind a camera, where those are half of its own; `None` where
/// there is none.
pub fn behind(settled: &Settled, placed: &[bool], confirmed: &[(usize, usize)]) -> Option<usize> {
    let stand = settled.of_confirmed(placed, confirmed);
    let pairs: Vec<(&PairMeetings, bool)> = stand.map(|p| (p, before(settled, p) < limits::BEFORE)).collect();
    let of = |camera: usize| pairs.iter().filter(move |(p, _)| p.a == camera || p.b == camera);
    let bad = |camera: usize| of(camera).filter(|(_, bad)| *bad).count();
    let cameras = (0..placed.len()).filter(|&c| bad(c) > 0 && 2 * bad(c) >= of(c).count());
    cameras.max_by_key(|&c| (bad(c), std::cmp::Reverse(c)))
}

/// The share of what meets in a pair that is before both cameras, of rays that are not nearly parallel; 1 where all are.
fn before(settled: &Settled, pair: &PairMeetings) -> f64 {
    let (a, b) = (&settled.cameras[pair.a], &settled.cameras[pair.b]);
    let some = evenly(pair.meetings.len(), MEETINGS).map(|k| &pair.meetings[k]);
    let along: Vec<[f64; 2]> = some.filter_map(|m| Some(crossing(a, b, [m.a, m.b])?.1)).collect();
    let before = along.iter().filter(|[s, t]| *s > 0.0 && *t > 0.0).count();
    if along.is_empty() { 1.0 } else { before as f64 / along.len() as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::solve::settle::tests::seen;

    const ALL: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];

    #[test]
    fn what_is_seen_is_before_the_cameras() {
        let settled = seen([0.3; 4]);
        assert!(settled.pairs.iter().all(|p| before(&settled, p) > 0.99));
        assert_eq!(behind(&settled, &[true; 4], &ALL), None);
    }

    #[test]
    fn a_camera_on_the_other_side_of_all_it_sees_is_named() {
        let mut settled = seen([0.3; 4]);
        // Its epipolar planes are the same if its place is mirrored at that of another camera, and its rays run apart from those of that one.
        let [other, own] = [0, 3].map(|c| settled.cameras[c].position);
        settled.cameras[3].position = 2.0 * other - own;
        let of_both = settled.pairs.iter().find(|p| (p.a, p.b) == (0, 3)).unwrap();
        assert!(before(&settled, of_both) < 0.01);
        assert_eq!(behind(&settled, &[true; 4], &ALL), Some(3));
        assert_eq!(behind(&settled, &[true, true, true, false], &ALL), None);
        assert_eq!(behind(&settled, &[true; 4], &ALL[..2]), None);
    }
}
