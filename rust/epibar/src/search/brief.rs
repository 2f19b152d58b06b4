//! A brief search: a few hypotheses, refined once. Too little to find a geometry by, and enough to see that there is one.

use super::contest::score_of_tangent;
use super::either_order::from_a;
use super::pass::refined_once;
use super::training_set::{Effort, SearchOptions, TrainingSet};
use crate::error::Result;
use crate::matching::Candidates;
use crate::random::seed_of_pass;
use crate::watch::Watch;

/// What is drawn and refined: a twentieth of what a search draws. Six development pairs whose offset barcodes did not tell had at the true one three times the score
/// of a tangent or more that they had at any of four others, and with an eighth 1.8 times or more.
pub fn brief_options(seed: u64) -> SearchOptions {
    let draws = Effort::default().draws.one_of(20);
    let effort = Effort { draws, starts: 12, own_starts: 2 };
    SearchOptions { seed, effort, ..SearchOptions::default() }
}

/// Score of a tangent of the best geometry that is found; 0 where there is none.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn brief_search(training: &TrainingSet, candidates: &Candidates, watch: &mut dyn Watch) -> Result<f64> {
    let SearchOptions { seed, effort, .. } = &training.options;
    let hypotheses = from_a(training, candidates, &effort.draws, seed_of_pass(*seed, 0), watch)?;
    let found = refined_once(training, effort, &hypotheses.scored, Vec::new());
    Ok(found.first().map_or(0.0, |best| score_of_tangent(training, best)))
}
