//! Solutions moved at random, to leave a local optimum.

use rand::RngExt;
use rayon::prelude::*;

use super::solution::Solution;
use super::training_set::TrainingSet;
use crate::frontier::frontier_score;
use crate::geometry::Fundamental;
use crate::geometry::seven_parameters::{SevenParameters, Step};
use crate::hypotheses::Source;
use crate::random::generator;

/// Copies of a solution, and the best of them by tangents.
const COPIES: usize = 160;
const BEST: usize = 5;

/// Copies of a solution moved at random, several sizes of move, the best few by tangents.
pub(super) fn perturbed(
    training: &TrainingSet,
    solution: &Solution,
    seed: u64,
) -> Vec<(Fundamental, Source)> {
    let Some(parameters) = SevenParameters::new(&solution.fundamental, training.all.sizes()) else {
        return Vec::new();
    };
    let radius = training.coarse_radius();
    let mut copies: Vec<(f64, usize, Fundamental)> = (0..COPIES)
        .into_par_iter()
        .filter_map(|k| {
            let mut random = generator(seed, k as u64);
            let size = 0.2 * 0.5f64.powi((k % 6) as i32);
            let step = Step::from_fn(|_, _| size * (2.0 * random.random::<f64>() - 1.0));
            let f = parameters.stepped(&step).fundamental()?;
            Some((frontier_score(&training.scoring, &f, radius).total(), k, f))
        })
        .collect();
    copies.sort_by(|p, q| q.0.total_cmp(&p.0).then(p.1.cmp(&q.1)));
    copies.into_iter().take(BEST).map(|(_, _, f)| (f, solution.source)).collect()
}
