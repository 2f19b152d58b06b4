//! The search of the frontier method: many hypotheses, few different starts, refinement, restarts.
//!
//! What remains is a list of different geometries with their scores: a winner and its rivals.
//!
//! * `training_set`: the frames that are looked at, and how far geometries are apart there.
//! * `early`: ends where one geometry stands out among few hypotheses.
//! * `either_order`: draws hypotheses by one order of the cameras or by the other.
//! * `pass`: from hypotheses to solutions, which are followed along the valleys that they lie in.
//! * `starts`: of the hypotheses of every source a few dozen *different* ones, refined with a shrinking radius.
//! * `contest`: whether one geometry stands out among those found, or others contest it.
//! * `resample`: the best fitted anew to samples of what meets, while they contest one another or still gain.
//! * `solution`: what is found.
//! * `settle`: the winner and its rivals refined on all frames, with silhouettes moved onto their outlines.
//! * `by_lines`: the search of the paper instead.
//! * `brief`: looks whether there is anything to search for.

pub mod by_lines;

mod brief;
mod contest;
mod early;
mod either_order;
mod pass;
mod resample;
mod settle;
mod solution;
mod starts;
mod training_set;

pub use brief::{brief_options, brief_search};
pub use resample::resampled;
pub use settle::{insets, settle};
pub use solution::{Found, Searched, Solution};
pub use training_set::{Effort, SearchOptions, TrainingSet};

use crate::error::Result;
use crate::hypotheses::Hypotheses;
use crate::matching::Candidates;
use crate::random::seed_of_pass;
use crate::watch::Watch;
use either_order::{from_a, from_b};

/// Searches with all sources, on the fitted frames alone: with few hypotheses, where one geometry does not stand out among these with many, and again by the
/// other order of the cameras where the truth may have been missed. What is `known` is where an earlier search ended, by a clock nearly as good, and is among what
/// is found.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn search(
    training: &TrainingSet,
    candidates: &Candidates,
    known: &[Solution],
    watch: &mut dyn Watch,
) -> Result<Searched> {
    let known = pass::again(training, known);
    if let Some(found) = early::outstanding(training, candidates, &known, watch)? {
        return Ok(found);
    }
    let mut found = Searched { solutions: known, floor: None };
    for pass in 0..training.options.passes {
        if pass > 0 && !contest::is_open(training, &found.solutions, pass) {
            break;
        }
        let seed = seed_of_pass(training.options.seed, pass as u64);
        let draw = if pass % 2 == 0 { from_a } else { from_b };
        let Hypotheses { scored, floors } =
            draw(training, candidates, &training.options.effort.draws, seed, watch)?;
        found.floor = found.floor.or_else(|| floors.into_iter().next());
        found.solutions = pass::pass(training, found.solutions, &scored, seed, watch)?;
    }
    Ok(found)
}
