//! What is known about a pair of cameras.

use nalgebra::Matrix3;

use crate::clock::Timing;
use crate::geometry::{Fundamental, symmetric_epipolar_distance};
use crate::hypotheses::Source;
use crate::image::Line;
use crate::options::Method;
use crate::recording::RecordedFrame;
use crate::verify::trials::account_for_trials;
use crate::verify::{ErrorMap, Evidence, Rival, Verdict};

/// A line of A and a line of B with similar motion barcodes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct CandidatePair {
    /// Line in A.
    pub a: Line,
    /// Line in B.
    pub b: Line,
    /// Normalised correlation of the two barcodes.
    pub correlation: f64,
    /// Whether the pair fits `F`: the image area between the line in B and the one that `F` gives is below 3 × image
    /// width (paper §3.2).
    pub inlier: bool,
}

/// A point where an epipolar plane touches what moves, as both cameras see it, on their silhouettes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct FrontierPoint {
    /// Frame of A.
    pub frame: RecordedFrame,
    /// In A, pixels.
    pub a: [f64; 2],
    /// In B, pixels.
    pub b: [f64; 2],
    /// Symmetric epipolar distance under `F`, pixels; what outlines are off by is in it.
    pub residual: f64,
}

impl FrontierPoint {
    pub(crate) fn new(frame: RecordedFrame, a: [f64; 2], b: [f64; 2], f: &Fundamental) -> Self {
        Self { frame, a, b, residual: symmetric_epipolar_distance(f, a, b) }
    }
}

/// Score of `F` with B's frames moved against A's.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ShiftScore {
    /// Frames of shift, cyclic; 0 is as it was.
    pub shift: usize,
    /// Evidence of the silhouettes: a likelihood ratio against chance, its logarithm.
    pub score: f64,
}

/// What was counted on the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Counts {
    /// Frames common to both cameras.
    pub frames: usize,
    /// Informative lines of A.
    pub informative_a: usize,
    /// Informative lines of B.
    pub informative_b: usize,
    /// Pairs removed because both lines overlap straight paths with heavy traffic.
    pub on_motion_lines: usize,
    /// Pairs that are among the best of each other, the candidates among them.
    pub mutual_pairs: usize,
    /// Candidates.
    pub candidates: usize,
    /// Candidates that fit `F`.
    pub line_inliers: usize,
    /// Frontier points.
    pub frontier_points: usize,
}

/// What [`calibrate`](fn@crate::calibrate) found, good or bad.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Calibration {
    /// The fundamental matrix, `x_bᵀ F x_a = 0`; `None` where nothing could be estimated. It may be there though it is
    /// not accepted: look at the verdict first.
    pub fundamental: Option<Fundamental>,
    /// Whether it can be relied on, and why.
    pub verdict: Verdict,
    /// Expected symmetric epipolar distance over the volume where things moved, pixels; `None` where unknown.
    pub expected_error: Option<f64>,
    /// Expected error over image A and over image B; `None` where it is not known.
    pub error_maps: Option<[ErrorMap; 2]>,
    /// Which frame of A is which moment of B, and how well that is known.
    pub timing: Timing,
    /// Pairs of lines with similar barcodes, best correlation first.
    pub candidates: Vec<CandidatePair>,
    /// Matched points of silhouettes, by frames.
    pub frontier_points: Vec<FrontierPoint>,
    /// Homography of the floor from A to B, `x_b ~ H x_a`, pixels, where many candidates fit one.
    pub floor: Option<Matrix3<f64>>,
    /// Other geometries, highest score first.
    pub rivals: Vec<Rival>,
    /// Numbers behind the verdict.
    pub evidence: Evidence,
    /// Score on frames kept aside as B is shifted in time: first as it is, then at other shifts.
    pub shift_curve: Vec<ShiftScore>,
    /// What was counted on the way.
    pub counts: Counts,
    /// The matrix that was tested: the answer of the fitted frames alone, in which those kept aside had no part.
    pub tested: Option<Fundamental>,
    /// Which kind of hypothesis the winner grew from; `None` where there is none.
    pub source: Option<Source>,
    /// How it was found.
    pub method: Method,
    /// The seed it was found with.
    pub seed: u64,
    /// The answer with both insets solved for once more, on its way out: what was tested has those that the fitted frames tell.
    pub(crate) outlined: Option<Fundamental>,
}

impl Calibration {
    /// A refusal before anything could be estimated.
    pub(crate) fn refused(verdict: Verdict, timing: Timing, method: Method, seed: u64) -> Self {
        Self {
            fundamental: None,
            verdict,
            expected_error: None,
            error_maps: None,
            timing,
            candidates: Vec::new(),
            frontier_points: Vec::new(),
            floor: None,
            rivals: Vec::new(),
            evidence: Evidence::default(),
            shift_curve: Vec::new(),
            counts: Counts::default(),
            tested: None,
            source: None,
            method,
            seed,
            outlined: None,
        }
    }

    /// With the geometry that goes with both insets solved for once more. The points stay on the silhouettes, by which pairs of one camera share them.
    pub(crate) fn with_outlines(mut self) -> Self {
        if let Some(f) = self.outlined.take() {
            for point in &mut self.frontier_points {
                *point = FrontierPoint::new(point.frame, point.a, point.b, &f);
            }
            self.fundamental = Some(f);
        }
        self
    }

    /// Whether `F` can be relied on.
    pub fn accepted(&self) -> bool {
        self.verdict.accepted()
    }

    /// By clocks that are known better now; where they are the best of so many `trials`, the evidence has to make up for it.
    pub(crate) fn with_timing(mut self, timing: Timing, trials: usize) -> Self {
        self.timing = timing;
        if trials > 1 {
            account_for_trials(trials, &mut self.evidence, &mut self.verdict);
        }
        self
    }
}
