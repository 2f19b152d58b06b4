//! Where hypotheses come from: every source is an [`Estimator`] for the one loop in [`super::ransac`], and all are
//! scored by tangents on the same few frames.

use rayon::prelude::*;

use super::floor::{Floor, FloorEpipoles, find_floors};
use super::frontier::Scorer;
use super::line_model::LineModel;
use super::ransac::{Estimator, Scored, Watch, ransac};
use super::search::SearchOptions;
use super::track_model::TrackModel;
use super::views::Views;
use crate::Result;
use crate::geometry::Fundamental;
use crate::matching::{Candidate, Candidates};

/// Where a hypothesis came from; what is grown from a solution has the source of that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Pairs among the best candidates, as in the paper.
    BestLines,
    /// Pairs among all mutual candidates.
    AllLines,
    /// Pairs among the best candidates, the lines deciding, as in the paper.
    LineInliers,
    /// The floor's homography and heads.
    Floor,
    /// Silhouettes followed through time.
    Tracks,
}

impl Source {
    /// Every source.
    pub(super) const ALL: [Self; 5] =
        [Self::BestLines, Self::AllLines, Self::LineInliers, Self::Floor, Self::Tracks];

    /// A word for reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::BestLines => "best_lines",
            Self::AllLines => "all_lines",
            Self::LineInliers => "line_inliers",
            Self::Floor => "floor",
            Self::Tracks => "tracks",
        }
    }
}

/// Line pairs as hypotheses, tangents as the score.
struct TangentScored<'a> {
    lines: LineModel<'a>,
    scorer: &'a Scorer<'a>,
}

impl Estimator for TangentScored<'_> {
    type Model = Fundamental;

    fn generate(&self, index: usize, random: &mut rand_pcg::Pcg64Mcg) -> Option<Fundamental> {
        self.lines.generate(index, random)
    }

    fn score(&self, model: &Fundamental) -> f64 {
        self.scorer.score(model)
    }

    fn glance(&self, model: &Fundamental) -> f64 {
        self.scorer.glance(model)
    }
}

/// Hypotheses of all sources, best first, and the floors met on the way.
pub(super) struct Hypotheses {
    pub(super) scored: Vec<(Scored<Fundamental>, Source)>,
    pub(super) floors: Vec<Floor>,
}

/// The frames that hypotheses are made of and scored on.
pub(super) struct Frames<'a> {
    /// All fitted frames, consecutive for the most part.
    pub(super) train: &'a Views,
    /// Those that associate silhouettes.
    pub(super) comparing: &'a Views,
    /// Those that score.
    pub(super) scoring: &'a Scorer<'a>,
}

/// Line models that are fitted to their inliers before they are scored with tangents.
const LINE_FITS: usize = 60;

/// Times as many draws from tracks where the camera matrices are known: half are fitted to them, and most of those refused
/// before they are scored.
const WITH_CAMERAS: usize = 3;

/// Draws from every source.
///
/// # Errors
/// [`crate::Error::Interrupted`].
pub(super) fn hypotheses(
    frames: &Frames,
    candidates: &Candidates,
    options: &SearchOptions,
    scale: f64,
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<Hypotheses> {
    let sizes = frames.train.sizes();
    let mut scored: Vec<(Scored<Fundamental>, Source)> = Vec::new();
    let line_sources: [(&[Candidate], Source); 2] =
        [(candidates.best(), Source::BestLines), (&candidates.pairs, Source::AllLines)];
    for (pairs, source) in line_sources {
        let estimator = TangentScored { lines: LineModel::new(pairs, sizes), scorer: frames.scoring };
        let seed = seed.wrapping_add((source as u64 + 1) << 56);
        let best = ransac(&estimator, options.draws, 300, seed, source.name(), watch)?;
        scored.extend(best.into_iter().map(|s| (s, source)));
    }
    let lines = LineModel::new(candidates.best(), sizes);
    let best = ransac(&lines, options.draws, LINE_FITS, seed, Source::LineInliers.name(), watch)?;
    let fitted: Vec<_> = best
        .into_par_iter()
        .map(|start| {
            let model = lines.optimise(&start.model);
            let score = frames.scoring.score(&model);
            (Scored { model, score, index: start.index }, Source::LineInliers)
        })
        .collect();
    scored.extend(fitted);
    let floors = find_floors(candidates.best(), sizes, seed, 3, watch)?;
    for floor in &floors {
        let estimator = FloorEpipoles::new(floor, frames.comparing, frames.scoring, options.upright);
        let best = ransac(&estimator, options.floor_draws, 100, seed, "floor epipoles", watch)?;
        scored.extend(best.into_iter().map(|s| (s, Source::Floor)));
    }
    let tracks = TrackModel::new(frames.train, frames.scoring, scale, options.upright);
    if tracks.pairs() > 0 {
        let times = if frames.train.cameras.is_some() { WITH_CAMERAS } else { 1 };
        let draws = options.track_draws * times;
        let best = ransac(&tracks, draws, 300, seed, Source::Tracks.name(), watch)?;
        scored.extend(best.into_iter().map(|s| (s, Source::Tracks)));
    }
    scored.retain(|s| s.0.score.is_finite());
    scored.sort_by(|p, q| q.0.score.total_cmp(&p.0.score));
    Ok(Hypotheses { scored, floors })
}
