//! The whole job: two recordings in, one calibration out.
//!
//! Common time line → candidates → `F` by the chosen method → verdict.

mod alignment;
mod error_map;
mod judge;
mod split;
mod timing;
mod verdict;

use nalgebra::Matrix3;

pub use alignment::{
    Aligned, Clock, Links, Measured, RunnerUp, Searched, TimeOffset, common_frames, frame_interval, measure,
    search_offset,
};
pub use error_map::{ErrorMap, Uncertainty};
pub use timing::Timing;
pub use verdict::{Kind, Verdict};

use crate::estimate::essential::CameraMatrices;
use crate::estimate::frontier::{FrontierOptions, FrontierPoint, compare};
use crate::estimate::line_model::LineModel;
use crate::estimate::ransac::{Watch, ransac};
use crate::estimate::search::{Found, SearchOptions, Solution, Source, search};
use crate::estimate::standing::{Standing, standing};
use crate::estimate::views::{Views, busy_frames};
use crate::geometry::Fundamental;
use crate::matching::candidates::find_candidates_among;
use crate::matching::{Candidate, CandidateOptions, Candidates};
use crate::recording::Recording;
use crate::verify::{Evidence, ShiftScore};
use crate::{Error, Result};
use split::Split;

/// How `F` is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Frontier points: every source of hypotheses, the tangent score, sub-pixel refinement (DESIGN §6).
    #[default]
    Frontier,
    /// Line pairs alone, as in the paper.
    Lines,
}

/// Options of [`calibrate`].
#[derive(Debug, Clone)]
pub struct CalibrateOptions {
    /// Which method.
    pub method: Method,
    /// Seed of everything random.
    pub seed: u64,
    /// Which frames belong together.
    pub time_offset: TimeOffset,
    /// Both cameras are the right way up (DESIGN §6, the mirror).
    pub upright: bool,
    /// The camera matrices of A and B, where both are known: `F` is expected to be an essential matrix under them
    /// by `Method::Frontier`.
    pub cameras: Option<CameraMatrices>,
    /// How candidates are chosen.
    pub candidates: CandidateOptions,
    /// RANSAC draws of `Method::Lines`, and of each line source of `Method::Frontier` (paper §4.3: 10,000).
    pub draws: usize,
    /// A result with a larger expected error, pixels, is refused.
    pub max_expected_error: f64,
}

impl Default for CalibrateOptions {
    fn default() -> Self {
        Self {
            method: Method::default(),
            seed: 0,
            time_offset: TimeOffset::Known(0.0),
            upright: true,
            cameras: None,
            candidates: CandidateOptions::default(),
            draws: 10_000,
            max_expected_error: 3.0,
        }
    }
}

/// Another geometry that the search found.
#[derive(Debug, Clone)]
pub struct Rival {
    /// The matrix.
    pub fundamental: Fundamental,
    /// Its evidence as a share of the winner's.
    pub share: f64,
    /// Standard score of the difference in evidence, over blocks of frames.
    pub z: f64,
    /// Mean symmetric epipolar distance from the winner over the volume where things moved, pixels.
    pub distance: f64,
    /// What its hypotheses came from.
    pub source: &'static str,
}

/// What [`calibrate`] found, good or bad.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// The fundamental matrix, `x_bᵀ F x_a = 0`; `None` where nothing could be estimated.
    pub fundamental: Option<Fundamental>,
    /// Whether it can be relied on, and why.
    pub verdict: Verdict,
    /// Expected symmetric epipolar distance over the volume where things moved, pixels; NaN where unknown.
    pub expected_error: f64,
    /// Expected error over image A and over image B; `None` where it is not known.
    pub error_maps: Option<[ErrorMap; 2]>,
    /// Which frame of A is which moment of B, and how well that is known.
    pub timing: Timing,
    /// Candidates with the counts of their filters.
    pub candidates: Candidates,
    /// Which of the best candidates fit the result (area below 3 × image width).
    pub inliers: Vec<bool>,
    /// Matched tangent points; `frame` is a frame of A.
    pub frontier_points: Vec<FrontierPoint>,
    /// Homography of the floor from A to B, where many candidates fit one.
    pub floor: Option<Matrix3<f64>>,
    /// Other geometries with evidence, most first.
    pub rivals: Vec<Rival>,
    /// Numbers behind the verdict.
    pub evidence: Evidence,
    /// The matrix that was tested: the answer of the fitted frames alone, in which those kept aside had no part.
    pub tested: Option<Fundamental>,
    /// Evidence on frames kept aside as B is shifted in time.
    pub shift_curve: Vec<ShiftScore>,
    /// Common frames used.
    pub frames: usize,
    /// Which kind of hypothesis the winner grew from.
    pub source: &'static str,
}

impl Calibration {
    /// A refusal before anything could be estimated.
    fn refused(verdict: Verdict, timing: Timing, frames: usize, candidates: Candidates) -> Self {
        Self {
            fundamental: None,
            verdict,
            expected_error: f64::NAN,
            error_maps: None,
            timing,
            inliers: vec![false; candidates.best().len()],
            candidates,
            frontier_points: Vec::new(),
            floor: None,
            rivals: Vec::new(),
            evidence: Evidence::default(),
            tested: None,
            shift_curve: Vec::new(),
            frames,
            source: "none",
        }
    }
}

/// Fewest common frames that can be calibrated at all.
const MIN_FRAMES: usize = 16;
/// Informative lines of each camera that the frontier method works with at least.
const FRONTIER_LINES: usize = 12_000;
/// Fewest candidates that make a pencil.
const MIN_CANDIDATES: usize = 3;

/// Finds the fundamental matrix between two cameras.
///
/// Refusing is a result, not an error: see [`Calibration::verdict`].
///
/// # Errors
/// [`Error::Interrupted`] where `watch` says so, [`Error::Argument`] for options out of range.
pub fn calibrate(
    a: &Recording,
    b: &Recording,
    options: &CalibrateOptions,
    watch: &mut dyn Watch,
) -> Result<Calibration> {
    check(options)?;
    timing::calibrate(a, b, options, watch)
}

/// [`calibrate`] by a known clock.
fn calibrate_at(
    a: &Recording,
    b: &Recording,
    aligned: &Aligned,
    options: &CalibrateOptions,
    watch: &mut dyn Watch,
) -> Result<Calibration> {
    let pairs = aligned.frame_pairs();
    let timing = Timing::of(aligned.clock(), a, b);
    let refuse = |verdict, candidates| Ok(Calibration::refused(verdict, timing, pairs.len(), candidates));
    if pairs.len() < MIN_FRAMES {
        return refuse(Verdict::too_few_frames(pairs.len(), MIN_FRAMES), Candidates::default());
    }
    if !watch.keep_going("candidates", 0.0) {
        return Err(Error::Interrupted);
    }
    let busy = busy_frames(a, b, &pairs, usize::MAX);
    let split = Split::new(&pairs, &busy, split::stay(a, b, &pairs));
    let mut candidate_options = options.candidates.clone();
    let over = match options.method {
        Method::Frontier => {
            candidate_options.densify = candidate_options.densify.max(FRONTIER_LINES);
            &split.fitted
        }
        Method::Lines => &pairs,
    };
    let candidates = find_candidates_among(a, b, &pairs, over, &candidate_options)?;
    if let Some(verdict) = Verdict::too_little_motion(&candidates) {
        return refuse(verdict, candidates);
    }
    if candidates.pairs.len() < MIN_CANDIDATES {
        return refuse(Verdict::no_candidates(), candidates);
    }
    if busy.len() < MIN_FRAMES {
        return refuse(Verdict::too_few_silhouettes(busy.len(), MIN_FRAMES), candidates);
    }

    let standing = [a, b].map(|r| if options.upright { Standing::UPRIGHT } else { standing(r) });
    let options = &CalibrateOptions { upright: standing.iter().all(|s| s.sure), ..options.clone() };
    let up = standing.map(|s| s.up);
    // The paper's method knows nothing of them.
    let cameras = options.cameras.filter(|_| options.method == Method::Frontier);
    let views_of = |pairs: &[(u32, u32)]| aligned.views(pairs).with_up(up).with_cameras(cameras);
    let views = views_of(&pairs);
    let fitted_views = views_of(&split.fitted_busy);
    let found = match options.method {
        Method::Frontier => {
            let subset = |limit| views_of(&busy_frames(a, b, &split.fitted_busy, limit));
            let search_options =
                SearchOptions { upright: options.upright, draws: options.draws, ..SearchOptions::default() };
            search(&views, &fitted_views, subset, &candidates, &search_options, options.seed, watch)?
        }
        Method::Lines => {
            let fitted = find_candidates_among(a, b, &pairs, &split.fitted, &candidate_options)?;
            let fitted = by_lines(&fitted, &views, options, watch)?.first().map(|s| s.fundamental);
            Found { solutions: by_lines(&candidates, &views, options, watch)?, fitted, floor: None }
        }
    };
    let Some(winner) = found.solutions.first() else {
        return refuse(Verdict::no_hypothesis(), candidates);
    };
    let fundamental = winner.fundamental;
    let busy_views = views_of(&busy);
    let judged = judge::judge(&judge::Case {
        views: &views,
        busy_views: &busy_views,
        fitted_views: &fitted_views,
        split: &split,
        fundamental: &fundamental,
        found: &found,
        options,
        frame_rate: a.frame_rate(),
    });
    let model = LineModel::new(candidates.best(), views.sizes());
    let inliers = model.inliers(&fundamental);
    let mut frontier_points = judged.points;
    for p in &mut frontier_points {
        p.frame = pairs[p.frame as usize].0;
    }
    Ok(Calibration {
        fundamental: Some(fundamental),
        verdict: judged.verdict,
        expected_error: judged.expected_error,
        error_maps: judged.uncertainty.map(|u| u.maps()),
        timing,
        inliers,
        frontier_points,
        floor: found
            .floor
            .as_ref()
            .filter(|f| judge::is_floor(f, candidates.best().len()))
            .map(|f| f.homography),
        rivals: judged.rivals,
        evidence: judged.evidence,
        shift_curve: judged.curve.scores,
        tested: found.fitted,
        frames: pairs.len(),
        source: winner.source.name(),
        candidates,
    })
}

fn check(options: &CalibrateOptions) -> Result<()> {
    let positive = options.max_expected_error > 0.0;
    if !positive {
        return Err(Error::Argument {
            name: "max_expected_error",
            value: options.max_expected_error.to_string(),
            expected: "a positive number of pixels",
        });
    }
    if options.draws == 0 {
        return Err(Error::Argument { name: "draws", value: "0".into(), expected: "at least 1" });
    }
    if options.cameras.is_some_and(|cameras| !cameras.usable()) {
        return Err(Error::Argument {
            name: "cameras",
            value: format!("{:?}", options.cameras),
            expected: "two finite camera matrices [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]",
        });
    }
    options.time_offset.check()
}

/// The paper's method: line inliers decide, local optimisation on the inliers.
fn by_lines(
    candidates: &Candidates,
    views: &Views,
    options: &CalibrateOptions,
    watch: &mut dyn Watch,
) -> Result<Vec<Solution>> {
    let pairs: &[Candidate] = candidates.best();
    let model = LineModel::new(pairs, views.sizes());
    let best = ransac(&model, options.draws, 1, options.seed, "lines", watch)?;
    Ok(best
        .into_iter()
        .map(|scored| {
            let fundamental = model.optimise(&scored.model);
            Solution { fundamental, evidence: scored.score, chance: 0.0, source: Source::BestLines }
        })
        .collect())
}

/// Matched tangents of all frames under `f` at a radius in pixels.
fn matched(views: &Views, f: &Fundamental, radius: f64, upright: bool) -> Vec<FrontierPoint> {
    compare(views, f, &FrontierOptions { radius, upright, shift: 0 }).points
}
