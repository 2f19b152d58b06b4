//! The method of the paper: line inliers decide, and local optimisation on the inliers.

use rayon::prelude::*;

use crate::error::Result;
use crate::frontier::Views;
use crate::frontier::volume::{Correspondence, disagreement, moving_correspondences};
use crate::geometry::Fundamental;
use crate::hypotheses::{LineModel, Source, ransac};
use crate::matching::Candidates;
use crate::search::{Found, Solution};
use crate::watch::{Stage, Watch};

/// The best hypotheses, each of which is fitted to its inliers; the others than the winner may be rivals.
const FITTED: usize = 60;
/// Most solutions.
const KEPT: usize = 12;
/// Solutions that differ by less are one, pixels of a 640×480 image.
const APART: f64 = 1.0;
/// Spots that tell two of them apart.
const SPOTS: usize = 120;

/// Finds `F` from the candidates of all common frames, and what is tested from those of the fitted frames alone.
///
/// Lines choose the winner. What else they led to is told from it by tangents, like the rivals of the other method.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn search(
    all: &Candidates,
    fitted: &Candidates,
    views: &Views,
    draws: usize,
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<Found> {
    let mut best = |candidates: &Candidates, keep: usize| -> Result<Vec<Solution>> {
        let model = LineModel::new(candidates.best(), views.sizes());
        let best = ransac(&model, draws, keep, seed, Stage::Lines, watch)?;
        let solution =
            |(fundamental, score)| Solution { fundamental, score, chance: 0.0, source: Source::BestLines };
        Ok(best.into_par_iter().map(|s| solution((model.optimise(&s.model), s.score))).collect())
    };
    let fitted = best(fitted, 1)?.first().map(|s| s.fundamental);
    Ok(Found { solutions: different(views, best(all, FITTED)?, seed), fitted, floor: None })
}

/// Those that differ from all before them over the volume where things moved.
fn different(views: &Views, solutions: Vec<Solution>, seed: u64) -> Vec<Solution> {
    let apart = APART * views.pixel_scale();
    let spots = |f: &Fundamental| moving_correspondences(views, f, SPOTS, seed);
    let mut kept: Vec<(Solution, Vec<Correspondence>)> = Vec::new();
    for solution in solutions {
        if kept.len() < KEPT
            && kept.iter().all(|(_, known)| disagreement(known, &solution.fundamental) > apart)
        {
            kept.push((solution, spots(&solution.fundamental)));
        }
    }
    kept.into_iter().map(|(solution, _)| solution).collect()
}
