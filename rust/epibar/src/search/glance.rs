//! A glance: a few hypotheses, refined once. Too little to find a geometry by, and enough to see that there is one.

use super::either_order::from_a;
use super::pass::refined_once;
use super::training_set::{SearchOptions, TrainingSet};
use crate::error::Result;
use crate::frontier::frontier_score;
use crate::hypotheses::Draws;
use crate::matching::Candidates;
use crate::random::seed_of_pass;
use crate::watch::Watch;

/// What is drawn and refined: a twentieth of what a search draws. Of twelve development pairs whose offset barcodes did not tell, all had at the true one twice the score
/// of a tangent or more that they had at any other, with an eighth as with a twentieth.
pub fn of_a_glance(seed: u64) -> SearchOptions {
    let draws = Draws { lines: 500, floor: 75, tracks: 1000, top_view: 2000 };
    SearchOptions { seed, draws, starts: 12, own_starts: 2, ..SearchOptions::default() }
}

/// Score of a tangent of the best geometry that is seen at a glance; 0 where there is none.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn glance(training: &TrainingSet, candidates: &Candidates, watch: &mut dyn Watch) -> Result<f64> {
    let hypotheses = from_a(training, candidates, seed_of_pass(training.options.seed, 0), watch)?;
    let found = refined_once(training, &hypotheses.scored);
    Ok(found.first().map_or(0.0, |best| {
        let tangents =
            frontier_score(&training.comparing, &best.fundamental, training.coarse_radius()).tangents();
        best.score / tangents.max(1) as f64
    }))
}
