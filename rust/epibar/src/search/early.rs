//! An early end: a geometry that stands out among few hypotheses is the one that many find.
//!
//! Where much moves before both cameras and little of it is hidden, one hypothesis of hundreds is near enough to the truth to be refined to it, and then
//! explains several times as much as any other. The many are for scenes in which the truth is hard to find, or hard to tell from others.

use super::contest::{CONTESTING, contest, stands_out, still_stands_out};
use super::either_order::from_a;
use super::pass::{USUAL, grown, refined_once};
use super::solution::{Searched, Solution};
use super::training_set::{Effort, TrainingSet};
use crate::error::Result;
use crate::hypotheses::Hypotheses;
use crate::matching::Candidates;
use crate::random::seed_of_pass;
use crate::watch::{Stage, Watch};

/// One of so many hypotheses of a search is drawn.
const ONE_OF: usize = 8;
/// Different ones of them that are refined, and how many each source has for its own.
const STARTS: usize = 20;
const OWN_STARTS: usize = 3;

/// What few hypotheses grow to, and with them what is `known` from a search with many by a clock nearly as good; `None` where no geometry stands out among them.
///
/// Few hypotheses find one geometry of several neighbours, and many compare them: so neighbours contest it only where many have not been drawn.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub(super) fn outstanding(
    training: &TrainingSet,
    candidates: &Candidates,
    known: &[Solution],
    watch: &mut dyn Watch,
) -> Result<Option<Searched>> {
    // Its own stages come again where it ends nothing.
    let mut watch = |_: Stage, _: f64| watch.keep_going(Stage::Few, 0.0);
    let seed = seed_of_pass(training.options.seed, 0);
    let draws = training.options.effort.draws.one_of(ONE_OF);
    let few = Effort { draws, starts: STARTS, own_starts: OWN_STARTS };
    let Hypotheses { scored, floors } = from_a(training, candidates, &few.draws, seed, &mut watch)?;
    let refined = refined_once(training, &few, &scored, known.to_vec());
    if known.is_empty() && contest(training, &refined) > CONTESTING {
        return Ok(None);
    }
    let solutions = grown(training, refined, &USUAL, seed, &mut watch)?;
    let floor = floors.into_iter().next();
    let ends = if known.is_empty() { stands_out } else { still_stands_out };
    Ok(ends(training, &solutions).then_some(Searched { solutions, floor }))
}
