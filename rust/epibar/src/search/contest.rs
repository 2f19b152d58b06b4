//! Whether one geometry stands out among those found: the truth announces itself by that.

use super::solution::Solution;
use super::training_set::TrainingSet;
use crate::frontier::frontier_score;
use crate::frontier::symmetric::class_scores;
use crate::frontier::volume::disagreement;

/// Pixels, of a 640×480 image, that make another geometry of one.
const APART: f64 = 5.0;
/// Share of the best one's score from which on another geometry contests it.
pub(super) const CONTESTING: f64 = 0.7;
/// Share of the best one's score below which it is clear.
pub(super) const CLEAR: f64 = 0.5;

/// The score of the best other geometry as a share of the best one's.
pub(super) fn contest(training: &TrainingSet, solutions: &[Solution]) -> f64 {
    let Some(best) = solutions.first().filter(|best| best.score > 0.0) else { return 1.0 };
    let spots = training.spots(&best.fundamental);
    let rival = solutions.iter().find(|s| disagreement(&spots, &s.fundamental) > APART * training.scale);
    rival.map_or(0.0, |rival| rival.score / best.score)
}

/// Whether the truth may not have been found by so many passes.
pub(super) fn is_open(training: &TrainingSet, solutions: &[Solution], passes: usize) -> bool {
    /// Score of a tangent below which even the best has so little evidence that the truth may have been missed, however far behind all others are. One in
    /// six development pairs with an answer had less. Of seven of these three were off by 6 to 90 px by one order of the cameras, one of which
    /// was accepted, and by less than 1.4 px by the other.
    const LITTLE: f64 = 0.16;
    let Some(best) = solutions.first() else { return true };
    let of_tangent = score_of_tangent(training, best);
    is_one_sided(training, best)
        || is_undecided(training, solutions, of_tangent)
        || (passes == 1 && of_tangent < LITTLE)
}

/// Whether one geometry, found by few hypotheses, stands out so much that many find no other.
pub(super) fn stands_out(training: &TrainingSet, solutions: &[Solution]) -> bool {
    /// Score of a tangent. Of 74 development pairs of all families the wrong ones of which no other had [`CLEAR`] of the score had 0.12 at the most, right ones
    /// 0.15 to 2.3.
    const MUCH: f64 = 0.2;
    let Some(best) = solutions.first() else { return false };
    score_of_tangent(training, best) >= MUCH
        && contest(training, solutions) <= CLEAR
        && !is_one_sided(training, best)
}

/// What a solution scores for each tangent of the frames that compare.
pub(super) fn score_of_tangent(training: &TrainingSet, solution: &Solution) -> f64 {
    let (views, radius) = (&training.comparing, training.coarse_radius());
    let tangents = frontier_score(views, &solution.fundamental, radius).tangents();
    solution.score / tangents.max(1) as f64
}

/// Whether the best solution explains one class of tangents and hardly the other: the floor, with an epipole that
/// is wrong. Then the truth may not have been found yet.
fn is_one_sided(training: &TrainingSet, best: &Solution) -> bool {
    const WEAK: f64 = 0.1;
    let [tops, bottoms] = class_scores(&training.comparing, &best.fundamental);
    tops.min(bottoms) < WEAK * tops.max(bottoms)
}

/// Whether the best solution has, of each tangent, what only the truth or its neighbours were seen to have, and yet another has nearly as
/// much: then neither may be the truth.
fn is_undecided(training: &TrainingSet, solutions: &[Solution], of_tangent: f64) -> bool {
    /// Score of a tangent: of unrelated cameras 0.08 to 0.2, of true geometries 0.3 and more; where it is much
    /// more, the truth is among those that contest one another.
    const PROMISING: std::ops::Range<f64> = 0.25..0.6;
    const NEARLY: f64 = 0.85;
    PROMISING.contains(&of_tangent) && contest(training, solutions) > NEARLY
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::*;
    use crate::frontier::Views;
    use crate::frontier::symmetric::tests::walkers;
    use crate::geometry::Fundamental;
    use crate::hypotheses::Source;
    use crate::image::ImageSize;
    use crate::search::SearchOptions;

    #[test]
    fn what_explains_much_and_far_more_than_any_other_stands_out() {
        let size = ImageSize::new(640, 480).unwrap();
        let camera = Matrix3::new(500.0, 0.0, 320.0, 0.0, 500.0, 240.0, 0.0, 0.0, 1.0);
        let inverse = camera.try_inverse().unwrap();
        let (views, rotation, translation) = walkers(&camera, size);
        let frames: Vec<usize> = (0..views.frames()).collect();
        let some = |limit: usize| -> Views { views.chosen(&frames[..limit.min(frames.len())]) };
        let training = TrainingSet::new(&views, some, SearchOptions::default());
        let solution = |e: &Vector3<f64>, map: &Matrix3<f64>| {
            let matrix = inverse.transpose() * e.cross_matrix() * map * inverse;
            let f = Fundamental::from_matrix(&matrix, size, size).unwrap();
            Solution::new(&training.comparing, f, Source::Floor).unwrap()
        };
        let truth = solution(&translation, rotation.matrix());
        let elsewhere = Vector3::new(-1.0, 4.0, 3.0);
        let other =
            |share| Solution { score: share * truth.score, ..solution(&elsewhere, rotation.matrix()) };
        let stands = |solutions: &[Solution]| stands_out(&training, solutions);
        assert!(stands(&[truth]) && stands(&[truth, other(0.4)]));
        assert!(!stands(&[truth, other(0.6)]) && !stands(&[other(0.1)]) && !stands(&[]));
        assert!(!stands(&[Solution { score: f64::NAN, ..truth }]));
        // The floor, 3 m below, with a wrong epipole.
        let floor = rotation.matrix() + translation * Vector3::new(0.0, 1.0, 0.0).transpose() / 3.0;
        let one_sided = solution(&Vector3::new(6.0, 0.3, 2.0), &floor);
        assert!(!stands(&[Solution { score: truth.score, ..one_sided }]));
    }
}
