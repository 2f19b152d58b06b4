//! Hypotheses of all sources, scored by tangents on the same few frames.

use rayon::prelude::*;

use super::floor::{FloorHomography, find_floors};
use super::floor_epipoles::FloorEpipoles;
use super::line_model::LineModel;
use super::ransac::{Estimator, Scored, ransac};
use super::top_view::{TopView, different};
use super::track_model::TrackModel;
use crate::error::Result;
use crate::frontier::{Scorer, Views};
use crate::geometry::Fundamental;
use crate::matching::{Candidate, Candidates};
use crate::random::{Generator, seed_of_source};
use crate::watch::{Stage, Watch};

/// Where a hypothesis came from; what is grown from a solution has the source of that.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
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
    /// Where figures stand on the floor, by either camera alone.
    TopView,
}

impl Source {
    /// Every source.
    pub(crate) const ALL: [Self; 6] =
        [Self::BestLines, Self::AllLines, Self::LineInliers, Self::Floor, Self::Tracks, Self::TopView];

    /// A word for reports and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::BestLines => "best_lines",
            Self::AllLines => "all_lines",
            Self::LineInliers => "line_inliers",
            Self::Floor => "floor",
            Self::Tracks => "tracks",
            Self::TopView => "top_view",
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

    fn generate(&self, index: usize, random: &mut Generator) -> Option<Fundamental> {
        self.lines.generate(index, random)
    }

    fn score(&self, model: &Fundamental) -> f64 {
        self.scorer.score(model)
    }

    fn preview(&self, model: &Fundamental) -> f64 {
        self.scorer.preview(model)
    }
}

/// A scored hypothesis.
#[derive(Debug, Clone, Copy)]
pub struct Hypothesis {
    /// The matrix.
    pub fundamental: Fundamental,
    /// Its score by tangents.
    pub score: f64,
    /// Where it came from.
    pub source: Source,
}

/// Hypotheses of all sources, best first, and the floors found on the way.
#[derive(Debug)]
pub struct Hypotheses {
    /// Best first.
    pub scored: Vec<Hypothesis>,
    /// Best first.
    pub floors: Vec<FloorHomography>,
}

/// How many hypotheses are drawn.
#[derive(Debug, Clone, Copy)]
pub struct Draws {
    /// Of each line source.
    pub lines: usize,
    /// Of those that have the most inliers, which are fitted to them before they are scored with tangents.
    pub line_fits: usize,
    /// Of each floor homography.
    pub floor: usize,
    /// From tracks, where no camera matrices are known.
    pub tracks: usize,
    /// Of overlays of two maps of the floor.
    pub top_view: usize,
}

impl Draws {
    /// Of every kind one of so many.
    #[must_use]
    pub fn one_of(self, many: usize) -> Self {
        Self {
            lines: self.lines / many,
            line_fits: self.line_fits / many,
            floor: self.floor / many,
            tracks: self.tracks / many,
            top_view: self.top_view / many,
        }
    }
}

/// The frames that hypotheses are made of and scored on.
pub struct Frames<'a> {
    /// All fitted frames, consecutive for the most part.
    pub train: &'a Views,
    /// Frames that associate silhouettes.
    pub comparing: &'a Views,
    /// Frames that score.
    pub scoring: &'a Scorer<'a>,
}

/// The best hypotheses of a line source and of tracks that go on, and those of each floor.
const KEPT: usize = 300;
const KEPT_OF_FLOOR: usize = 100;
/// The best overlays that go on, and different ones of them that become an `F`.
const OVERLAYS: usize = 1000;
const KEPT_OF_TOP_VIEW: usize = 60;
/// Most floors.
const FLOORS: usize = 3;

/// Times as many draws from tracks where the camera matrices are known: half are fitted to them, and most of those refused
/// before they are scored.
const WITH_CAMERAS: usize = 3;

/// Draws from every source.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn hypotheses(
    frames: &Frames,
    candidates: &Candidates,
    draws: &Draws,
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<Hypotheses> {
    let sizes = frames.train.sizes();
    let mut scored: Vec<Hypothesis> = Vec::new();
    let mut add = |found: Vec<Scored<Fundamental>>, source| {
        let hypothesis = |s: Scored<_>| Hypothesis { fundamental: s.model, score: s.score, source };
        scored.extend(found.into_iter().map(hypothesis));
    };
    let line_sources: [(&[Candidate], Source, Stage); 2] = [
        (candidates.best(), Source::BestLines, Stage::BestLines),
        (&candidates.pairs, Source::AllLines, Stage::AllLines),
    ];
    for (pairs, source, stage) in line_sources {
        let estimator = TangentScored { lines: LineModel::new(pairs, sizes), scorer: frames.scoring };
        let seed = seed_of_source(seed, source as u64);
        add(ransac(&estimator, draws.lines, KEPT, seed, stage, watch)?, source);
    }
    let lines = LineModel::new(candidates.best(), sizes);
    let best = ransac(&lines, draws.lines, draws.line_fits.max(1), seed, Stage::LineInliers, watch)?;
    let fitted = best.into_par_iter().map(|start| {
        let model = lines.optimise(&start.model);
        let score = frames.scoring.score(&model);
        Scored { model, score, index: start.index }
    });
    add(fitted.collect(), Source::LineInliers);
    let floors = find_floors(candidates.best(), sizes, seed, FLOORS, watch)?;
    for floor in &floors {
        let estimator = FloorEpipoles::new(floor, frames.comparing, frames.scoring);
        add(
            ransac(&estimator, draws.floor, KEPT_OF_FLOOR, seed, Stage::FloorEpipoles, watch)?,
            Source::Floor,
        );
    }
    let tracks = TrackModel::new(frames.train, frames.scoring);
    if tracks.pairs() > 0 {
        let times = if frames.train.cameras.is_some() { WITH_CAMERAS } else { 1 };
        add(ransac(&tracks, draws.tracks * times, KEPT, seed, Stage::Tracks, watch)?, Source::Tracks);
    }
    if let Some(top_view) = TopView::new(frames.train) {
        let best = ransac(&top_view, draws.top_view, OVERLAYS, seed, Stage::TopView, watch)?;
        let fitted = different(best, KEPT_OF_TOP_VIEW).into_par_iter().filter_map(|start| {
            let model = top_view.fundamental(&start.model)?;
            let score = frames.scoring.score(&model);
            Some(Scored { model, score, index: start.index })
        });
        add(fitted.collect(), Source::TopView);
    }
    scored.retain(|s| s.score.is_finite());
    scored.sort_by(|p, q| q.score.total_cmp(&p.score));
    Ok(Hypotheses { scored, floors })
}
