//! Different starts among the hypotheses, and what they are refined to.

use rayon::prelude::*;

use super::solution::Solution;
use super::training_set::TrainingSet;
use crate::frontier::symmetric::SymmetricScore;
use crate::frontier::symmetric_score;
use crate::frontier::volume::{Correspondence, disagreement};
use crate::geometry::Fundamental;
use crate::hypotheses::{Hypothesis, Source};
use crate::refine::refine;

/// Starts that differ from one another.
pub(super) struct Starts<'a> {
    training: &'a TrainingSet<'a>,
    /// Least distance of two, pixels.
    apart: f64,
    kept: Vec<(Fundamental, Vec<Correspondence>, Source)>,
}

impl<'a> Starts<'a> {
    /// The best hypotheses that differ from one another by at least `apart` pixels: first some of each source, then
    /// the best of all.
    pub(super) fn new(
        training: &'a TrainingSet<'a>,
        scored: &[Hypothesis],
        own: usize,
        limit: usize,
        apart: f64,
    ) -> Self {
        let mut starts = Self { training, apart, kept: Vec::new() };
        for source in Source::ALL {
            starts.add(scored.iter().filter(|s| s.source == source), own);
        }
        let rest = limit.saturating_sub(starts.len());
        starts.add(scored.iter(), rest);
        starts
    }

    /// Adds at most `limit` hypotheses that differ from all that are kept.
    pub(super) fn add<'s>(&mut self, scored: impl Iterator<Item = &'s Hypothesis>, limit: usize) {
        let enough = self.kept.len() + limit;
        for hypothesis in scored {
            if self.kept.len() >= enough {
                break;
            }
            let f = hypothesis.fundamental;
            if self.kept.iter().all(|(_, spots, _)| disagreement(spots, &f) > self.apart) {
                self.kept.push((f, self.training.spots(&f), hypothesis.source));
            }
        }
    }

    pub(super) fn len(&self) -> usize {
        self.kept.len()
    }

    /// The starts from the `first` on.
    pub(super) fn from(&self, first: usize) -> Vec<(Fundamental, Source)> {
        self.kept[first..].iter().map(|(f, _, source)| (*f, *source)).collect()
    }
}

/// Adds the best of what starts are refined to: each by every schedule of radii, of which that with the highest score is
/// kept. In a crowd nearly every tangent meets a wrong one within a wide radius, and a good start is lost there; a bad
/// start needs it.
///
/// On the comparing frames: on the fewer that score, starts in a crowd of sixteen end elsewhere.
pub(super) fn with_refined(
    training: &TrainingSet,
    mut solutions: Vec<Solution>,
    starts: &[(Fundamental, Source)],
    schedules: &[&[f64]],
    limit: usize,
) -> Vec<Solution> {
    let views = &training.comparing;
    let mut refined: Vec<(SymmetricScore, Fundamental, Source)> = starts
        .par_iter()
        .filter_map(|(f, source)| {
            let tried = schedules.iter().filter_map(|radii| {
                let radii: Vec<f64> = radii.iter().map(|r| r * training.scale).collect();
                let refined = refine(views, f, &radii, 2)?;
                let score = symmetric_score(views, &refined);
                score.total.is_finite().then_some((score, refined, *source))
            });
            tried.max_by(|p, q| p.0.total.total_cmp(&q.0.total))
        })
        .collect();
    refined.sort_by(|p, q| q.0.total.total_cmp(&p.0.total));
    // Chance only takes away, so whoever has less than the last that is kept need not be asked for it.
    for some in refined.chunks(limit) {
        if solutions.len() == limit && some[0].0.total <= solutions[limit - 1].score {
            break;
        }
        solutions.par_extend(
            some.par_iter().filter_map(|(score, f, source)| Solution::scored(views, *score, *f, *source)),
        );
        solutions = training.distinct(solutions, training.scale, limit);
    }
    solutions
}
