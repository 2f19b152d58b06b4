//! The search of the frontier method: many hypotheses, few different starts, refinement, restarts.
//!
//! Of the hypotheses of every source a few dozen *different* ones are refined with a shrinking radius, and compared on
//! more frames ([`starts`]); while they contest one another ([`contest`]) or the best still gains, the best are fitted anew to samples of what meets
//! ([`resample`]) and refined again, and followed along the valleys that they lie in ([`pass`]). What remains is a list of different geometries with
//! their scores: a winner and its rivals, which [`mod@settle`] refines on all frames, with silhouettes moved onto their outlines. Where one stands out among few hypotheses that is
//! all ([`early`]). [`by_lines`] is the search of the paper instead, and [`brief`] looks whether there is anything to search for.

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
/// other order of the cameras where the truth may have been missed.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn search(training: &TrainingSet, candidates: &Candidates, watch: &mut dyn Watch) -> Result<Searched> {
    if let Some(found) = early::outstanding(training, candidates, watch)? {
        return Ok(found);
    }
    let mut found = Searched::default();
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
