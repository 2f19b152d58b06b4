//! How far from one plane is what cameras see of which nothing tells the focal lengths?
//!
//! A plane before cameras of unknown focal lengths is related by homographies, which leave the lengths open before three and next to open
//! before more (Triggs 1998). What the outlines are wrong by then moves them by far more than a covariance says, which is of small errors.

use crate::image::ImageSize;
use crate::network::evidence::planes::Seen;
use crate::network::given::input::IntrinsicKind;
use crate::network::model::joint::PairMeetings;
use crate::network::solve::networks::Solved;
use crate::network::thresholds as limits;

/// Of each camera how far from one plane what is seen is, in the median of confirmed pairs, pixels of a 640×480 image: infinite where the plane tells
/// the focal length, since it is given, or those of others are, or where no pair sees enough to tell.
pub fn relief(solved: &Solved, confirmed: &[(usize, usize)]) -> Vec<f64> {
    let placed = &solved.network.placed;
    let is_known = |&c: &usize| placed[c] && IntrinsicKind::Focal.is_given(&solved.beliefs[c]);
    let known = (0..placed.len()).filter(is_known).count();
    let relief = if known < limits::FOCALS_TELL { of_all(solved, confirmed) } else { f64::INFINITY };
    (0..placed.len()).map(|c| if is_known(&c) { f64::INFINITY } else { relief }).collect()
}

fn of_all(solved: &Solved, confirmed: &[(usize, usize)]) -> f64 {
    let pairs = solved.settled.of_confirmed(&solved.network.placed, confirmed);
    let of_pair = |p: &PairMeetings| {
        let seen = Seen::of(&solved.settled, p)?;
        let [a, b] = [p.a, p.b].map(|c| &solved.settled.cameras[c]);
        Some(seen.relief(p, [a, b]) / ImageSize::pixel_scale([a.size, b.size]))
    };
    let mut all: Vec<f64> = pairs.filter_map(of_pair).collect();
    all.sort_unstable_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::evidence::alternatives::tests::solved;
    use crate::network::evidence::planes::tests::of_plane;
    use crate::network::model::beliefs::Belief;

    const ALL: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];

    /// Nothing is known of the focal lengths of all cameras but these.
    fn without_focals(mut solved: Solved, known: &[usize]) -> Solved {
        for (c, beliefs) in solved.beliefs.iter_mut().enumerate().filter(|(c, _)| !known.contains(c)) {
            beliefs.intrinsic[0] = Belief::about(solved.network.cameras[c].log_focal, f64::INFINITY);
        }
        solved
    }

    #[test]
    fn a_plane_leaves_focal_lengths_open_that_nothing_tells() {
        let plane = Solved { settled: of_plane(false), ..solved(|_, _| ()) };
        let found = relief(&without_focals(plane.clone(), &[]), &ALL);
        assert!(found.iter().all(|r| *r < 1e-3), "{found:?}");
        let found = relief(&without_focals(plane.clone(), &[2]), &ALL);
        assert!(found[2] == f64::INFINITY && found[0] < 1e-3, "{found:?}");
        assert_eq!(relief(&without_focals(plane.clone(), &[1, 2]), &ALL), [f64::INFINITY; 4]);
        // To a tenth is not known.
        let mut rough = without_focals(plane.clone(), &[]);
        for beliefs in &mut rough.beliefs {
            beliefs.intrinsic[0].deviation = 0.09;
        }
        assert!(relief(&rough, &ALL).iter().all(|r| *r < 1e-3));
        // Nothing speaks for any.
        assert_eq!(relief(&without_focals(plane, &[]), &[]), [f64::INFINITY; 4]);
    }

    #[test]
    fn what_has_depth_is_far_from_any_plane() {
        let found = relief(&without_focals(solved(|_, _| ()), &[]), &ALL);
        assert!(found.iter().all(|r| *r > 5.0 * limits::RELIEF), "{found:?}");
    }
}
