//! A glance: a few hypotheses, refined once. Too little to find a geometry by, and enough to see that there is one.

use super::contest::score_of_tangent;
use super::either_order::from_a;
use super::pass::refined_once;
use super::training_set::{SearchOptions, TrainingSet};
use crate::error::Result;
use crate::hypotheses::Draws;
use crate::matching::Candidates;
use crate::random::seed_of_pass;
use crate::watch::Watch;

/// What is drawn and refined: a twentieth of what a search draws. Six development pairs whose offset barcodes did not tell had at the true one three times the score
/// of a tangent or more that they had at any of four others, and with an eighth 1.8 times or more.
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
    Ok(found.first().map_or(0.0, |best| score_of_tangent(training, best)))
}
