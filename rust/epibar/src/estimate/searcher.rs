//! Stages of the search: different starts, refinement, restarts, walks, and the last polish.

use rand::RngExt;
use rayon::prelude::*;

use super::evidence::{Weighed, chance_level, class_evidence, evidence, pixel_scale, weigh};
use super::explore::explore;
use super::frontier::{Comparer, FrontierOptions, frontier_score};
use super::optimise::{SevenParameters, Step};
use super::ransac::{Scored, Watch, generator};
use super::refine::refine;
use super::search::{SearchOptions, Solution};
use super::sources::Source;
use super::views::Views;
use super::volume::{Correspondence, disagreement, moving_correspondences};
use crate::geometry::Fundamental;
use crate::{Error, Result};

/// How widely is searched around what hypotheses gave.
struct Breadth {
    /// Solutions that are kept while others are sought.
    kept: usize,
    /// How many of the best solutions are shaken in a round.
    shaken: usize,
    /// How many of the best solutions are walked from.
    explored: usize,
    /// A solution is not walked from with less than this share of the best one's evidence.
    worth_exploring: f64,
}

/// Where one geometry stands out among those first met.
const USUAL: Breadth = Breadth { kept: 16, shaken: 6, explored: 3, worth_exploring: 0.7 };
/// Where none does: the truth may be none of them.
const WIDE: Breadth = Breadth { kept: 40, shaken: 16, explored: 12, worth_exploring: 0.5 };
/// Times as many starts as the options say are refined there.
const WIDE_STARTS: usize = 3;
/// Share of the best one's evidence from which on another geometry contests it.
const CONTESTING: f64 = 0.7;
/// Share of the best one's evidence below which it is clear.
const CLEAR: f64 = 0.5;
/// A solution with less than this share of the best one's evidence is no rival to settle.
const WORTH_SETTLING: f64 = 0.5;
/// Pixels, of a 640×480 image, that make another geometry of one.
const APART: f64 = 5.0;
/// Spots that tell two geometries apart.
const SPOTS: usize = 120;

/// A start, what tells it apart from others, and where it came from.
type Kept = (Fundamental, Vec<Correspondence>, Source);

/// The frames that the stages look at.
pub(super) struct Searcher<'a> {
    all: &'a Views,
    pub(super) scoring: Views,
    pub(super) comparing: Views,
    pub(super) scale: f64,
    options: &'a SearchOptions,
}

impl<'a> Searcher<'a> {
    pub(super) fn new(
        all: &'a Views,
        train: &Views,
        subset: impl Fn(usize) -> Views,
        options: &'a SearchOptions,
    ) -> Self {
        let per_frame = 0.5 * (train.a.hulls() + train.b.hulls()) as f64 / train.frames().max(1) as f64;
        let frames = |hulls: usize| (hulls as f64 / per_frame.max(0.1)) as usize;
        Self {
            all,
            scoring: subset(frames(options.scoring_hulls).clamp(60, 300)),
            comparing: subset(frames(options.comparing_hulls).clamp(150, 600)),
            scale: pixel_scale(all),
            options,
        }
    }

    pub(super) fn coarse(&self) -> FrontierOptions {
        FrontierOptions { radius: 5.0 * self.scale, upright: self.options.upright, shift: 0 }
    }

    fn points(&self, f: &Fundamental) -> Vec<Correspondence> {
        moving_correspondences(&self.scoring, f, SPOTS)
    }

    /// The best hypotheses that differ from one another by at least `apart` pixels: first some of each source, then
    /// the best of all.
    fn different(
        &self,
        scored: &[(Scored<Fundamental>, Source)],
        own: usize,
        limit: usize,
        apart: f64,
    ) -> Vec<Kept> {
        let mut kept: Vec<Kept> = Vec::new();
        for source in Source::ALL {
            let of_source = scored.iter().filter(|s| s.1 == source);
            self.take(of_source, own, apart, &mut kept);
        }
        let rest = limit.saturating_sub(kept.len());
        self.take(scored.iter(), rest, apart, &mut kept);
        kept
    }

    /// Adds at most `limit` hypotheses that differ from all that are kept.
    fn take<'s>(
        &self,
        scored: impl Iterator<Item = &'s (Scored<Fundamental>, Source)>,
        limit: usize,
        apart: f64,
        kept: &mut Vec<Kept>,
    ) {
        let enough = kept.len() + limit;
        for (hypothesis, source) in scored {
            if kept.len() >= enough {
                break;
            }
            let f = hypothesis.model;
            if kept.iter().all(|(_, points, _)| disagreement(points, &f) > apart) {
                kept.push((f, self.points(&f), *source));
            }
        }
    }

    /// Adds the best of what starts are refined to: each from a wide radius and from a narrow one, of which that with more
    /// evidence is kept: in a crowd nearly every tangent meets a wrong one within a wide radius, and a good start
    /// is lost there; a bad start needs it.
    ///
    /// On the comparing frames: on the fewer that score, starts in a crowd of sixteen end elsewhere.
    fn with_refined(
        &self,
        mut solutions: Vec<Solution>,
        starts: &[(Fundamental, Source)],
        schedules: &[&[f64]],
        limit: usize,
    ) -> Vec<Solution> {
        let (views, upright) = (&self.comparing, self.options.upright);
        let mut refined: Vec<(Weighed, Fundamental, Source)> = starts
            .par_iter()
            .filter_map(|(f, source)| {
                let tried = schedules.iter().filter_map(|radii| {
                    let radii: Vec<f64> = radii.iter().map(|r| r * self.scale).collect();
                    let refined = refine(views, f, &radii, 2, upright)?;
                    let weighed = evidence(views, &refined, upright);
                    weighed.total.is_finite().then_some((weighed, refined, *source))
                });
                tried.max_by(|p, q| p.0.total.total_cmp(&q.0.total))
            })
            .collect();
        refined.sort_by(|p, q| q.0.total.total_cmp(&p.0.total));
        // Chance only takes away, so whoever has less than the last that is kept need not be asked for it.
        for some in refined.chunks(limit) {
            if solutions.len() == limit && some[0].0.total <= solutions[limit - 1].evidence {
                break;
            }
            solutions.par_extend(some.par_iter().filter_map(|(weighed, f, source)| {
                let mut comparer = Comparer::new(&views.a, &views.b, f, upright);
                solution(&mut comparer, views, *weighed, *f, *source)
            }));
            solutions = self.distinct(solutions, self.scale, limit);
        }
        solutions
    }

    /// Sorted by evidence, near copies of a better one dropped.
    fn distinct(&self, mut solutions: Vec<Solution>, apart: f64, limit: usize) -> Vec<Solution> {
        solutions.retain(|s| s.evidence.is_finite());
        solutions.sort_by(|p, q| q.evidence.total_cmp(&p.evidence));
        let mut kept: Vec<(Solution, Vec<Correspondence>)> = Vec::new();
        for solution in solutions {
            if kept.len() >= limit {
                break;
            }
            if kept.iter().all(|(_, points)| disagreement(points, &solution.fundamental) > apart) {
                let points = self.points(&solution.fundamental);
                kept.push((solution, points));
            }
        }
        kept.into_iter().map(|(s, _)| s).collect()
    }

    /// The evidence of the best other geometry as a share of the best one's: the truth announces itself by a small one.
    fn contest(&self, solutions: &[Solution]) -> f64 {
        let Some(best) = solutions.first().filter(|best| best.evidence > 0.0) else { return 1.0 };
        let points = self.points(&best.fundamental);
        let rival = solutions.iter().find(|s| disagreement(&points, &s.fundamental) > APART * self.scale);
        rival.map_or(0.0, |rival| rival.evidence / best.evidence)
    }

    /// Whether the best solution explains one class of tangents and hardly the other: the floor, with an epipole that
    /// is wrong. Then the truth may not have been met yet.
    pub(super) fn is_one_sided(&self, solutions: &[Solution]) -> bool {
        const WEAK: f64 = 0.1;
        let Some(best) = solutions.first() else { return true };
        let [tops, bottoms] = class_evidence(&self.comparing, &best.fundamental, self.options.upright);
        tops.min(bottoms) < WEAK * tops.max(bottoms)
    }

    /// Whether the best solution has what only the truth or its neighbours were seen to have, and yet another has nearly as
    /// much: then neither may be the truth.
    pub(super) fn is_undecided(&self, solutions: &[Solution]) -> bool {
        /// Evidence of a tangent: of unrelated cameras 0.08 to 0.2, of true geometries 0.3 and more; where it is much
        /// more, the truth is among those that contest one another.
        const PROMISING: std::ops::Range<f64> = 0.25..0.6;
        const NEARLY: f64 = 0.85;
        let Some(best) = solutions.first() else { return false };
        let tangents = frontier_score(&self.comparing, &best.fundamental, &self.coarse()).tangents();
        PROMISING.contains(&(best.evidence / tangents.max(1) as f64)) && self.contest(solutions) > NEARLY
    }

    /// From hypotheses to solutions, those known before among them.
    pub(super) fn pass(
        &self,
        known: Vec<Solution>,
        scored: &[(Scored<Fundamental>, Source)],
        seed: u64,
        watch: &mut dyn Watch,
    ) -> Result<Vec<Solution>> {
        const SCHEDULES: [&[f64]; 2] = [&[16.0, 8.0, 4.0], &[6.0, 3.0]];
        let (options, apart) = (self.options, 4.0 * self.scale);
        let starts_of = |kept: &[Kept]| -> Vec<(Fundamental, Source)> {
            kept.iter().map(|(f, _, source)| (*f, *source)).collect()
        };
        let mut going = stages(watch);
        going("refine", 0.0)?;
        let mut breadth = &USUAL;
        let mut starts = self.different(scored, options.own_starts, options.starts, apart);
        let mut solutions = self.with_refined(known, &starts_of(&starts), &SCHEDULES, breadth.kept);
        if self.contest(&solutions) > CONTESTING {
            breadth = &WIDE;
            going("refine", 0.3)?;
            let refined = starts.len();
            self.take(
                scored.iter(),
                (WIDE_STARTS * options.starts).saturating_sub(refined),
                apart,
                &mut starts,
            );
            solutions =
                self.with_refined(solutions, &starts_of(&starts[refined..]), &SCHEDULES, breadth.kept);
        }
        for round in 0..options.restarts {
            if self.contest(&solutions) < CLEAR {
                break;
            }
            going("restart", round as f64 / options.restarts as f64)?;
            let mut shaken = Vec::new();
            for (k, solution) in solutions.iter().take(breadth.shaken).enumerate() {
                shaken.extend(self.shaken(solution, seed.wrapping_add((round * 100 + k) as u64)));
            }
            solutions = self.with_refined(solutions, &shaken, &[&[8.0, 4.0], &[3.0]], breadth.kept);
        }
        self.walked(&solutions, breadth, &mut going)
    }

    /// Walks on from those that could win, on the frames that compare.
    fn walked(
        &self,
        solutions: &[Solution],
        breadth: &Breadth,
        going: &mut impl FnMut(&'static str, f64) -> Result<()>,
    ) -> Result<Vec<Solution>> {
        let mut walked = solutions.to_vec();
        for (k, start) in solutions.iter().take(breadth.explored).enumerate() {
            going("explore", k as f64 / breadth.explored as f64)?;
            if start.evidence < breadth.worth_exploring * solutions[0].evidence {
                break;
            }
            walked.extend(explore(&self.comparing, start, self.scale, self.options.upright));
        }
        Ok(self.distinct(walked, self.scale, 12))
    }

    /// The best, each ended on `views` by `end`.
    pub(super) fn settled(
        &self,
        views: &Views,
        solutions: &[Solution],
        end: impl Fn(&Views, &Fundamental, bool) -> Fundamental + Sync,
    ) -> Vec<Solution> {
        let upright = self.options.upright;
        let best = solutions.first().map_or(0.0, |s| s.evidence);
        let finalists: Vec<Solution> = solutions
            .par_iter()
            .filter(|s| s.evidence >= WORTH_SETTLING * best)
            .filter_map(|s| weighed_solution(views, end(views, &s.fundamental, upright), s.source, upright))
            .collect();
        self.distinct(finalists, 0.5 * self.scale, 12)
    }

    /// Copies of a solution moved at random, several sizes of move, the best few by tangents.
    fn shaken(&self, solution: &Solution, seed: u64) -> Vec<(Fundamental, Source)> {
        const COPIES: usize = 160;
        const BEST: usize = 5;
        let Some(parameters) = SevenParameters::new(&solution.fundamental, self.all.sizes()) else {
            return Vec::new();
        };
        let options = self.coarse();
        let mut copies: Vec<(f64, usize, Fundamental)> = (0..COPIES)
            .into_par_iter()
            .filter_map(|k| {
                let mut random = generator(seed, k as u64);
                let size = 0.2 * 0.5f64.powi((k % 6) as i32);
                let step = Step::from_fn(|_, _| size * (2.0 * random.random::<f64>() - 1.0));
                let f = parameters.stepped(&step).fundamental()?;
                Some((frontier_score(&self.scoring, &f, &options).total(), k, f))
            })
            .collect();
        copies.sort_by(|p, q| q.0.total_cmp(&p.0).then(p.1.cmp(&q.1)));
        copies.into_iter().take(BEST).map(|(_, _, f)| (f, solution.source)).collect()
    }
}

/// The evidence for `f` less that of chance; `None` where it is not finite.
fn weighed_solution(views: &Views, f: Fundamental, source: Source, upright: bool) -> Option<Solution> {
    let (weighed, mut comparer) = weigh(views, &f, upright);
    solution(&mut comparer, views, weighed, f, source)
}

/// The same where it has been weighed; the comparison is from A to B.
fn solution(
    comparer: &mut Comparer,
    views: &Views,
    weighed: Weighed,
    f: Fundamental,
    source: Source,
) -> Option<Solution> {
    let chance = chance_level(comparer, views.frames(), weighed.radius);
    let evidence = weighed.total - chance;
    evidence.is_finite().then_some(Solution { fundamental: f, evidence, chance, source })
}

/// Tells of a stage, and whether to go on.
pub(super) fn stages(watch: &mut dyn Watch) -> impl FnMut(&'static str, f64) -> Result<()> {
    |stage, done| if watch.keep_going(stage, done) { Ok(()) } else { Err(Error::Interrupted) }
}
