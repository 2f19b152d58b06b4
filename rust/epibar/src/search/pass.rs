//! One pass of the search: from hypotheses to solutions.

use super::contest::{CLEAR, CONTESTING, contest};
use super::resample::resampled;
use super::solution::{Solution, share_of};
use super::starts::{Starts, with_refined};
use super::training_set::{Effort, TrainingSet};
use crate::error::Result;
use crate::geometry::Fundamental;
use crate::hypotheses::{Hypothesis, Source};
use crate::random::seed_of_resampled;
use crate::refine::valley::walk;
use crate::watch::{Stage, Watch, report};

/// How widely is looked around what hypotheses gave.
pub(super) struct Breadth {
    /// Solutions that are kept while others are sought.
    kept: usize,
    /// How many of the best solutions are resampled in a round.
    resampled: usize,
    /// How many of the best solutions are walked from.
    walked: usize,
    /// A solution is not walked from with less than this share of the best one's score.
    worth_walking: f64,
}

/// Where one geometry stands out among those found first.
pub(super) const USUAL: Breadth = Breadth { kept: 16, resampled: 6, walked: 3, worth_walking: 0.7 };
/// Where none does: the truth may be none of them.
const WIDE: Breadth = Breadth { kept: 40, resampled: 16, walked: 12, worth_walking: 0.5 };
/// Times as many starts as the options say are refined there.
const WIDE_STARTS: usize = 3;
/// Pixels, of a 640×480 image, by which starts differ.
const STARTS_APART: f64 = 4.0;
/// Radii of refinement, pixels of a 640×480 image: of starts, and of resampled solutions.
const SCHEDULES: [&[f64]; 2] = [&[16.0, 8.0, 4.0], &[6.0, 3.0]];
const RESAMPLED_SCHEDULES: [&[f64]; 2] = [&[8.0, 4.0], &[3.0]];
/// Most rounds of resampling, while the best gains this share of its score or more.
const ROUNDS: usize = 12;
const GAIN: f64 = 0.05;
/// Solutions that a pass ends with.
const KEPT: usize = 12;

/// From hypotheses to solutions, those known before among them.
pub(super) fn pass(
    training: &TrainingSet,
    known: Vec<Solution>,
    scored: &[Hypothesis],
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<Vec<Solution>> {
    report(watch, Stage::Refine, 0.0)?;
    let mut breadth = &USUAL;
    let effort = &training.options.effort;
    let mut starts = starts_of(training, effort, scored);
    let mut solutions = with_refined(training, known, &starts.from(0), &SCHEDULES, breadth.kept);
    if contest(training, &solutions) > CONTESTING {
        breadth = &WIDE;
        report(watch, Stage::Refine, 0.3)?;
        let refined = starts.len();
        starts.add(scored.iter(), (WIDE_STARTS * effort.starts).saturating_sub(refined));
        solutions = with_refined(training, solutions, &starts.from(refined), &SCHEDULES, breadth.kept);
    }
    grown(training, solutions, breadth, seed, watch)
}

/// What solutions grow to.
pub(super) fn grown(
    training: &TrainingSet,
    solutions: Vec<Solution>,
    breadth: &Breadth,
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<Vec<Solution>> {
    let solutions = gained(training, solutions, breadth, seed, watch)?;
    walked(training, &solutions, breadth, watch)
}

/// What hypotheses become when the best of them that differ are refined, those known before among them.
pub(super) fn refined_once(
    training: &TrainingSet,
    effort: &Effort,
    scored: &[Hypothesis],
    known: Vec<Solution>,
) -> Vec<Solution> {
    let starts = starts_of(training, effort, scored);
    with_refined(training, known, &starts.from(0), &SCHEDULES, USUAL.kept)
}

/// What solutions of an earlier search are on these frames.
pub(super) fn again(training: &TrainingSet, known: &[Solution]) -> Vec<Solution> {
    let starts: Vec<(Fundamental, Source)> = known.iter().map(|s| (s.fundamental, s.source)).collect();
    with_refined(training, Vec::new(), &starts, &SCHEDULES, USUAL.kept)
}

/// Different ones of the best hypotheses.
fn starts_of<'a>(training: &'a TrainingSet<'a>, effort: &Effort, scored: &[Hypothesis]) -> Starts<'a> {
    Starts::new(training, scored, effort.own_starts, effort.starts, STARTS_APART * training.scale)
}

/// The best of solutions and of what they become when they are resampled, round after round: some while others contest the best one, more
/// while it gains, which it does step by step where it comes from far.
fn gained(
    training: &TrainingSet,
    mut solutions: Vec<Solution>,
    breadth: &Breadth,
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<Vec<Solution>> {
    let best = |solutions: &[Solution]| solutions.first().map_or(0.0, |best| best.score);
    let radius = training.coarse_radius();
    let (mut gains, mut before) = (false, best(&solutions));
    for round in 0..ROUNDS {
        let contested = round < training.options.restarts && contest(training, &solutions) >= CLEAR;
        if !(contested || gains) {
            break;
        }
        report(watch, Stage::Restart, 1.0 - 0.5f64.powi(round as i32))?;
        let mut moved = Vec::new();
        for (k, Solution { fundamental, source, .. }) in solutions.iter().take(breadth.resampled).enumerate()
        {
            let seed = seed_of_resampled(seed, round as u64, k as u64);
            let found = resampled(&training.comparing, &training.scoring, fundamental, radius, seed);
            moved.extend(found.into_iter().map(|f| (f, *source)));
        }
        solutions = with_refined(training, solutions, &moved, &RESAMPLED_SCHEDULES, breadth.kept);
        let now = best(&solutions);
        gains = now - before > GAIN * before.abs();
        before = now;
    }
    Ok(solutions)
}

/// Walks on from those that could win, on the frames that compare. What was visited stays as rivals.
fn walked(
    training: &TrainingSet,
    solutions: &[Solution],
    breadth: &Breadth,
    watch: &mut dyn Watch,
) -> Result<Vec<Solution>> {
    let mut all = solutions.to_vec();
    for (k, start) in solutions.iter().take(breadth.walked).enumerate() {
        report(watch, Stage::Explore, k as f64 / breadth.walked as f64)?;
        if start.score < share_of(solutions[0].score, breadth.worth_walking) {
            break;
        }
        let visited = walk(&training.comparing, &start.fundamental, start.score, start.chance);
        all.extend(visited.into_iter().map(|(fundamental, score)| Solution { fundamental, score, ..*start }));
    }
    Ok(training.distinct(all, training.scale, KEPT))
}
