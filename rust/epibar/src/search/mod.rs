//! The search of the frontier method: many hypotheses, few different starts, refinement, restarts.
//!
//! Of the hypotheses of every source a few dozen *different* ones are refined with a shrinking radius, and compared on
//! more frames ([`starts`]); while they contest one another ([`contest`]) the best are perturbed and refined again
//! ([`perturb`]), and followed along the valleys that they lie in ([`pass`]). What remains is a list of different geometries with
//! their scores: a winner and its rivals, which [`mod@settle`] refines on all frames.

mod contest;
mod ground;
mod pass;
mod perturb;
mod settle;
mod solution;
mod starts;

pub use ground::{Ground, SearchOptions};
pub use settle::settle;
pub use solution::{Found, Searched, Solution};

use crate::error::Result;
use crate::frontier::Scorer;
use crate::hypotheses::sources::Frames;
use crate::hypotheses::{Hypotheses, hypotheses};
use crate::matching::Candidates;
use crate::random::GOLDEN;
use crate::watch::Watch;

/// Searches with all sources, on the fitted frames alone.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn search(ground: &Ground, candidates: &Candidates, watch: &mut dyn Watch) -> Result<Searched> {
    let scoring = Scorer::new(&ground.scoring, ground.coarse_radius());
    let frames = Frames { train: ground.train, comparing: &ground.comparing, scoring: &scoring };
    let mut found = Searched::default();
    for pass in 0..ground.options.passes {
        if pass > 0
            && !contest::is_one_sided(ground, &found.solutions)
            && !contest::is_undecided(ground, &found.solutions)
        {
            break;
        }
        // Apart from one another, so that no pass repeats the draws of another.
        let seed = ground.options.seed.wrapping_add((pass as u64).wrapping_mul(GOLDEN));
        let Hypotheses { scored, floors } =
            hypotheses(&frames, candidates, &ground.options.draws, seed, watch)?;
        found.floor = found.floor.or_else(|| floors.into_iter().next());
        found.solutions = pass::pass(ground, found.solutions, &scored, seed, watch)?;
    }
    Ok(found)
}
