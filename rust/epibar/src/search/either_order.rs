//! Hypotheses by one order of the cameras or by the other.
//!
//! Hypotheses are scored by what tangents of A meet in B, since that costs half of asking both. Where one camera sees more than the other, or
//! worse, the truth may be among the best by one order and not by the other.

use super::training_set::TrainingSet;
use crate::error::Result;
use crate::frontier::{Scorer, Views};
use crate::hypotheses::sources::Frames;
use crate::hypotheses::{Draws, Hypotheses, hypotheses};
use crate::matching::Candidates;
use crate::watch::Watch;

/// Draws from every source, tangents of A first.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub(super) fn from_a(
    training: &TrainingSet,
    candidates: &Candidates,
    draws: &Draws,
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<Hypotheses> {
    let views = [training.all, &training.comparing, &training.scoring];
    drawn(training, views, candidates, draws, seed, watch)
}

/// Draws from every source, tangents of B first; the matrices are those from A to B. Floors are left to [`from_a`].
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub(super) fn from_b(
    training: &TrainingSet,
    candidates: &Candidates,
    draws: &Draws,
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<Hypotheses> {
    let views = [training.all, &training.comparing, &training.scoring].map(Views::swapped);
    let mut found = drawn(training, views.each_ref(), &candidates.swapped(), draws, seed, watch)?;
    for hypothesis in &mut found.scored {
        hypothesis.fundamental = hypothesis.fundamental.transposed();
    }
    found.floors.clear();
    Ok(found)
}

/// Draws from every source on all fitted frames, those that compare and those that score.
fn drawn(
    training: &TrainingSet,
    [train, comparing, scoring]: [&Views; 3],
    candidates: &Candidates,
    draws: &Draws,
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<Hypotheses> {
    let scoring = Scorer::new(scoring, training.coarse_radius());
    let frames = Frames { train, comparing, scoring: &scoring };
    hypotheses(&frames, candidates, draws, seed, watch)
}
