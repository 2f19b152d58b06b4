//! The search of the frontier method: many hypotheses, few different starts, refinement, restarts.
//!
//! Of the hypotheses of [`super::sources`] a few dozen *different* ones are refined with a shrinking radius, and
//! compared on more frames; the best are shaken and refined again. What remains is a list of different geometries with
//! their evidence: a winner and its rivals.

use super::floor::Floor;
use super::frontier::Scorer;
use super::ransac::Watch;
use super::refine::{polish, touch_up};
use super::searcher::{Searcher, stages};
use super::sources::{Frames, hypotheses};
use super::views::Views;
use crate::Result;
use crate::geometry::Fundamental;
use crate::matching::Candidates;

/// Options of the search.
#[derive(Debug, Clone)]
pub struct SearchOptions {
    /// Hypotheses of each line source.
    pub draws: usize,
    /// Hypotheses per floor homography.
    pub floor_draws: usize,
    /// Hypotheses from tracks, where no camera matrices are known.
    pub track_draws: usize,
    /// Silhouettes of a camera that score hypotheses: few frames of a crowd, many of a lone walker.
    pub scoring_hulls: usize,
    /// Silhouettes of a camera that compare refined solutions.
    pub comparing_hulls: usize,
    /// Different starts that are refined.
    pub starts: usize,
    /// Of those, starts that each source has for its own.
    pub own_starts: usize,
    /// Rounds of shaking the best.
    pub restarts: usize,
    /// Most times that all is done with new hypotheses, while the best explains one class of tangents alone, or has
    /// much evidence and another nearly as much.
    pub passes: usize,
    /// Both cameras are the right way up.
    pub upright: bool,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self {
            draws: 10_000,
            floor_draws: 1500,
            track_draws: 20_000,
            scoring_hulls: 700,
            comparing_hulls: 1600,
            starts: 60,
            own_starts: 12,
            restarts: 2,
            passes: 3,
            upright: true,
        }
    }
}

/// A refined geometry with its evidence.
#[derive(Debug, Clone)]
pub struct Solution {
    /// The matrix, fitted to all frames.
    pub fundamental: Fundamental,
    /// Excess over chance of its tangents, at the radius that gives most, less `chance`.
    pub evidence: f64,
    /// The same excess with the clocks shifted: what the model of chance missed.
    pub chance: f64,
    /// The hypotheses it grew from.
    pub source: Source,
}

/// What the search found.
#[derive(Debug, Clone, Default)]
pub struct Found {
    /// Different geometries, most evidence first.
    pub solutions: Vec<Solution>,
    /// The winner of the fitted frames alone, in which those kept aside had no part.
    pub fitted: Option<Fundamental>,
    /// The plane that many candidates fit, if there is one.
    pub floor: Option<Floor>,
}

pub use super::sources::Source;

/// Apart from one another, so that no pass repeats the draws of another: 2⁶⁴ over the golden ratio.
const PASS_SEED: u64 = 0x9E37_79B9_7F4A_7C15;

/// Searches with all sources.
///
/// # Errors
/// [`crate::Error::Interrupted`].
pub fn search(
    all: &Views,
    train: &Views,
    subset: impl Fn(usize) -> Views,
    candidates: &Candidates,
    options: &SearchOptions,
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<Found> {
    let searcher = Searcher::new(all, train, subset, options);
    let scoring = Scorer::new(&searcher.scoring, searcher.coarse());
    let frames = Frames { train, comparing: &searcher.comparing, scoring: &scoring };
    let (mut solutions, mut floor) = (Vec::new(), None);
    for pass in 0..options.passes {
        if pass > 0 && !searcher.is_one_sided(&solutions) && !searcher.is_undecided(&solutions) {
            break;
        }
        let seed = seed.wrapping_add((pass as u64).wrapping_mul(PASS_SEED));
        let found = hypotheses(&frames, candidates, options, searcher.scale, seed, watch)?;
        floor = floor.or_else(|| found.floors.into_iter().next());
        solutions = searcher.pass(solutions, &found.scored, seed, watch)?;
    }
    let mut going = stages(watch);
    going("settle", 0.0)?;
    // The few that remain, first on the fitted frames alone, for the test, and from there on all frames, for the answer.
    let fitted = searcher.settled(train, &solutions, polish);
    going("settle", 0.5)?;
    let mut solutions = searcher.settled(all, &fitted, touch_up);
    let polished =
        |views, solution: Option<&Solution>| solution.map(|s| polish(views, &s.fundamental, options.upright));
    let (fitted, winner) =
        rayon::join(|| polished(train, fitted.first()), || polished(all, solutions.first()));
    if let (Some(solution), Some(polished)) = (solutions.first_mut(), winner) {
        solution.fundamental = polished;
    }
    Ok(Found { solutions, fitted, floor })
}
