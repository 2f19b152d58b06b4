//! The frames that a search looks at, and how far geometries are apart there.

use super::solution::Solution;
use crate::frontier::Views;
use crate::frontier::volume::{Correspondence, disagreement, moving_correspondences};
use crate::geometry::Fundamental;
use crate::hypotheses::Draws;

/// How many hypotheses there are, and how many of them go on.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// How many are drawn.
    pub draws: Draws,
    /// Different ones that are refined.
    pub starts: usize,
    /// Of those, starts that each source has for its own.
    pub own_starts: usize,
}

/// Options of the search.
#[derive(Debug, Clone)]
pub struct SearchOptions {
    /// Seed of every random draw.
    pub seed: u64,
    /// What is drawn and refined where no geometry stands out among fewer hypotheses.
    pub effort: Effort,
    /// Silhouettes of a camera that score hypotheses: few frames of a crowd, many of a lone walker.
    pub scoring_hulls: usize,
    /// Silhouettes of a camera that compare refined solutions.
    pub comparing_hulls: usize,
    /// Rounds of resampling the best; others follow while the best gains.
    pub restarts: usize,
    /// Most times that all is done with new hypotheses, while the best explains one class of tangents alone, or has
    /// a high score and another nearly as high a one.
    pub passes: usize,
}

impl Default for Effort {
    fn default() -> Self {
        Self {
            draws: Draws { lines: 10_000, line_fits: 60, floor: 1500, tracks: 20_000, top_view: 40_000 },
            starts: 60,
            own_starts: 12,
        }
    }
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self {
            seed: 0,
            effort: Effort::default(),
            scoring_hulls: 700,
            comparing_hulls: 1600,
            restarts: 2,
            passes: 3,
        }
    }
}

/// Spots that tell two geometries apart.
const SPOTS: usize = 120;

/// The fitted frames, and thinner sets of them.
pub struct TrainingSet<'a> {
    /// All fitted frames.
    pub(super) all: &'a Views,
    /// Frames that score hypotheses.
    pub(super) scoring: Views,
    /// Frames that compare refined solutions.
    pub(super) comparing: Views,
    /// Pixels for one of a 640×480 image.
    pub(super) scale: f64,
    pub(super) options: SearchOptions,
}

impl<'a> TrainingSet<'a> {
    /// `subset` gives at most so many of the fitted frames.
    pub fn new(all: &'a Views, subset: impl Fn(usize) -> Views, options: SearchOptions) -> Self {
        let per_frame = 0.5 * (all.a.hulls() + all.b.hulls()) as f64 / all.frames().max(1) as f64;
        let frames = |hulls: usize| (hulls as f64 / per_frame.max(0.1)) as usize;
        Self {
            all,
            scoring: subset(frames(options.scoring_hulls).clamp(60, 300)),
            comparing: subset(frames(options.comparing_hulls).clamp(150, 600)),
            scale: all.pixel_scale(),
            options,
        }
    }

    /// This set with silhouettes moved outward by so many pixels; `all` are the fitted frames of which that is done.
    pub fn moved_outward<'m>(&self, all: &'m Views, insets: [f64; 2]) -> TrainingSet<'m> {
        TrainingSet {
            all,
            scoring: self.scoring.moved_outward(insets),
            comparing: self.comparing.moved_outward(insets),
            scale: self.scale,
            options: self.options.clone(),
        }
    }

    /// Radius at which hypotheses are scored, pixels.
    pub(super) fn coarse_radius(&self) -> f64 {
        5.0 * self.scale
    }

    /// Spots of the moving volume under `f`.
    pub(super) fn spots(&self, f: &Fundamental) -> Vec<Correspondence> {
        moving_correspondences(&self.scoring, f, SPOTS, self.options.seed)
    }

    /// Sorted by score, near copies of a better one dropped.
    pub(super) fn distinct(&self, mut solutions: Vec<Solution>, apart: f64, limit: usize) -> Vec<Solution> {
        solutions.retain(|s| s.score.is_finite());
        solutions.sort_by(|p, q| q.score.total_cmp(&p.score));
        let mut kept: Vec<(Solution, Vec<Correspondence>)> = Vec::new();
        for solution in solutions {
            if kept.len() >= limit {
                break;
            }
            if kept.iter().all(|(_, spots)| disagreement(spots, &solution.fundamental) > apart) {
                kept.push((solution, self.spots(&solution.fundamental)));
            }
        }
        kept.into_iter().map(|(s, _)| s).collect()
    }
}
