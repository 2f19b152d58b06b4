//! The method of the paper: line inliers decide, and local optimisation on the inliers.

use crate::error::Result;
use crate::geometry::Fundamental;
use crate::hypotheses::{LineModel, Source, ransac};
use crate::image::ImageSize;
use crate::matching::Candidates;
use crate::search::{Found, Solution};
use crate::watch::{Stage, Watch};

/// Finds `F` from the candidates of all common frames, and what is tested from those of the fitted frames alone.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn search(
    all: &Candidates,
    fitted: &Candidates,
    sizes: [ImageSize; 2],
    draws: usize,
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<Found> {
    let mut best = |candidates: &Candidates| -> Result<Option<(Fundamental, f64)>> {
        let model = LineModel::new(candidates.best(), sizes);
        let best = ransac(&model, draws, 1, seed, Stage::Lines, watch)?;
        Ok(best.first().map(|scored| (model.optimise(&scored.model), scored.score)))
    };
    let fitted = best(fitted)?.map(|(f, _)| f);
    let solution =
        |(fundamental, score)| Solution { fundamental, score, chance: 0.0, source: Source::BestLines };
    Ok(Found { solutions: best(all)?.map(solution).into_iter().collect(), fitted, floor: None })
}
