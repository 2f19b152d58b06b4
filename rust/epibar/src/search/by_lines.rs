//! The method of the paper: pairs of lines propose, line inliers sift, and the barcodes of whole pencils choose.

use rayon::prelude::*;

use super::{Found, Solution};
use crate::error::Result;
use crate::frontier::Views;
use crate::frontier::volume::{Correspondence, disagreement, moving_correspondences};
use crate::geometry::Fundamental;
use crate::hypotheses::{Estimator, LineModel, Source, ransac};
use crate::matching::{Candidates, Pencils};
use crate::recording::{FramePair, Recording};
use crate::watch::{Stage, Watch, report};

/// The hypotheses with most inliers, whose pencils are looked at.
const SIFTED: usize = 2000;
/// So many of them are compared before the watch is asked again, and the others need not be as alike as the best so far.
const AT_ONCE: usize = 100;
/// Places of each camera, and frames, at which those are compared.
const FEW: (usize, usize) = (40, 300);
/// The best of them, each of which is fitted to its inliers; the others than the winner may be rivals.
const FITTED: usize = 60;
/// Places and frames by which the winner is chosen of them.
const MANY: (usize, usize) = (150, 1500);
/// Which power of the number of inliers counts: many of them say the same. Chosen on `pets_cameras`, where 0.25 and 0.5 find nine of 28 pairs,
/// 0 eight, and inliers alone seven.
const OF_INLIERS: f64 = 0.25;
/// Most solutions.
const KEPT: usize = 12;
/// Solutions that differ by less are one, pixels of a 640×480 image.
const APART: f64 = 1.0;
/// Spots that tell two of them apart.
const SPOTS: usize = 120;

/// What candidates were found on: recordings and their common frames.
pub struct Filmed<'f> {
    /// A and B.
    pub recordings: [&'f Recording; 2],
    /// Frames that are compared.
    pub frames: &'f [FramePair],
    /// Line pairs that may be epipolar, by those frames.
    pub candidates: &'f Candidates,
}

/// Finds `F` from all common frames, and what is tested from the fitted frames alone.
///
/// Lines choose the winner. What else they led to is told from it by tangents, like the rivals of the other method.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn search(
    all: &Filmed,
    fitted: &Filmed,
    views: &Views,
    draws: usize,
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<Found> {
    let mut half = |stage: Stage, share: f64| watch.keep_going(stage, 0.5 * share);
    let fitted = best(fitted, views, draws, seed, &mut half)?.first().map(|s| s.fundamental);
    let mut half = |stage: Stage, share: f64| watch.keep_going(stage, 0.5 + 0.5 * share);
    let solutions = different(views, best(all, views, draws, seed, &mut half)?, seed);
    Ok(Found { solutions, fitted, floor: None })
}

/// The most alike pencils first.
fn best(
    filmed: &Filmed,
    views: &Views,
    draws: usize,
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<Vec<Solution>> {
    let model = LineModel::new(filmed.candidates.best(), views.sizes());
    let mut sifting = |stage: Stage, share: f64| watch.keep_going(stage, 0.6 * share);
    let sifted = ransac(&model, draws, SIFTED, seed, Stage::Lines, &mut sifting)?;
    let pencils = |(places, frames): (usize, usize)| {
        let step = filmed.frames.len().div_ceil(frames).max(1);
        let frames: Vec<FramePair> = filmed.frames.iter().copied().step_by(step).collect();
        Pencils::new(filmed.recordings, &frames, places, seed)
    };
    let (few, many) = (pencils(FEW), pencils(MANY));
    let score = |pencils: &Pencils, f: &Fundamental, least: f64| {
        let weight = model.score(f).max(1.0).powf(OF_INLIERS);
        Some(weight * pencils.alike(f, least / weight)?)
    };
    let mut alike: Vec<(f64, Fundamental)> = Vec::with_capacity(FITTED + AT_ONCE);
    for (k, chunk) in sifted.chunks(AT_ONCE).enumerate() {
        report(watch, Stage::Lines, 0.6 + 0.2 * (k * AT_ONCE) as f64 / sifted.len() as f64)?;
        let least = alike.get(FITTED - 1).map_or(f64::NEG_INFINITY, |worst| worst.0);
        alike.par_extend(chunk.par_iter().filter_map(|s| Some((score(&few, &s.model, least)?, s.model))));
        alike.sort_by(|p, q| q.0.total_cmp(&p.0));
        alike.truncate(FITTED);
    }
    report(watch, Stage::Lines, 0.8)?;
    let fitted = |(_, drawn): (f64, Fundamental)| {
        let of = |fundamental: Fundamental| Solution {
            fundamental,
            score: score(&many, &fundamental, f64::NEG_INFINITY).unwrap_or(0.0),
            chance: 0.0,
            source: Source::BestLines,
        };
        let (drawn, fitted) = (of(drawn), of(model.optimise(&drawn)));
        if fitted.score >= drawn.score { fitted } else { drawn }
    };
    let mut solutions: Vec<Solution> = alike.into_par_iter().map(fitted).collect();
    solutions.sort_by(|p, q| q.score.total_cmp(&p.score));
    Ok(solutions)
}

/// Solutions that differ from all before them over the volume where things moved.
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
