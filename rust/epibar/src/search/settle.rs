//! The last refinement, on all frames.

use rayon::prelude::*;

use super::solution::{Found, Searched, Solution, share_of};
use super::training_set::TrainingSet;
use crate::error::Result;
use crate::frontier::Views;
use crate::geometry::Fundamental;
use crate::refine::{self, polish, touch_up};
use crate::watch::{Stage, Watch, report};

/// A solution with less than this share of the best one's score is no rival to settle.
const WORTH_SETTLING: f64 = 0.5;
/// A solution with this share of the best one's score contests it.
const NEARLY_BEST: f64 = 0.85;
/// Solutions that differ by less are one, pixels of a 640×480 image.
const APART: f64 = 0.5;
/// Solutions that are kept.
const KEPT: usize = 12;

/// By how many pixels hulls lie inside of the outlines in A and in B, as the best of the few that remain on the fitted frames tells; `None` where
/// there is none, or nobody knows which end is up.
pub fn insets(training: &TrainingSet, searched: &Searched) -> Option<[f64; 2]> {
    if !training.all.upright {
        return None;
    }
    let fitted = refined_on(training, training.all, &searched.solutions, polish);
    let Solution { fundamental, .. } = fitted.first()?;
    refine::insets(training.all, fundamental)
}

/// The few that remain, first on the fitted frames alone, for the test, and from there on all frames, for the answer.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn settle(
    training: &TrainingSet,
    all: &Views,
    searched: Searched,
    watch: &mut dyn Watch,
) -> Result<Found> {
    report(watch, Stage::Settle, 0.0)?;
    let fitted = refined_on(training, training.all, &searched.solutions, polish);
    report(watch, Stage::Settle, 0.5)?;
    let (fitted, solutions) = rayon::join(
        || fitted.first().map(|s| polish(training.all, &s.fundamental)),
        || followed(training, all, refined_on(training, all, &fitted, touch_up)),
    );
    Ok(Found { solutions, fitted, floor: searched.floor })
}

/// What contests the best, and the best itself, polished: a point on the way to the answer is no rival of it.
fn followed(training: &TrainingSet, all: &Views, solutions: Vec<Solution>) -> Vec<Solution> {
    let contesting = solutions.first().map_or(0.0, |best| share_of(best.score, NEARLY_BEST));
    let ends = solutions
        .into_par_iter()
        .filter_map(|s| {
            let end = || Solution::new(all, polish(all, &s.fundamental), s.source);
            if s.score >= contesting { end() } else { Some(s) }
        })
        .collect();
    training.distinct(ends, APART * training.scale, KEPT)
}

/// The best, each refined on `views` by `refine`.
fn refined_on(
    training: &TrainingSet,
    views: &Views,
    solutions: &[Solution],
    refine: impl Fn(&Views, &Fundamental) -> Fundamental + Sync,
) -> Vec<Solution> {
    let enough = solutions.first().map_or(0.0, |best| share_of(best.score, WORTH_SETTLING));
    let finalists: Vec<Solution> = solutions
        .par_iter()
        .filter(|s| s.score >= enough)
        .filter_map(|s| Solution::new(views, refine(views, &s.fundamental), s.source))
        .collect();
    training.distinct(finalists, APART * training.scale, KEPT)
}
