//! Options of a calibration.

use crate::clock::TimeOffset;
use crate::error::{Error, Result};
use crate::geometry::CameraMatrices;
use crate::matching::CandidateOptions;
use crate::verify::thresholds::MIN_CANDIDATES;

/// A result that states a larger error, pixels, is refused unless something else is said.
pub const MAX_EXPECTED_ERROR: f64 = 3.0;
/// How far either way offsets of clocks are looked for, seconds, unless something else is said.
pub const SEARCH_SECONDS: f64 = 21.0;

/// How `F` is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Method {
    /// Frontier points: every source of hypotheses, scored by epipolar tangents, refined to a fraction of a pixel.
    #[default]
    Frontier,
    /// Line pairs alone, as in the paper.
    Lines,
}

impl Method {
    /// The word in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Frontier => "frontier",
            Self::Lines => "lines",
        }
    }
}

/// Options of [`calibrate`](fn@crate::calibrate).
///
/// ```
/// use epibar::{CalibrateOptions, Method, TimeOffset};
///
/// let options = CalibrateOptions::new().method(Method::Lines).time_offset(TimeOffset::Known(2.5)).seed(7);
/// assert_eq!(options.seed, 7);
/// ```
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct CalibrateOptions {
    /// Which method.
    pub method: Method,
    /// Seed of the random draws of the search, and of the points at which errors are measured. The test whether the geometry may turn
    /// about a plane draws alike for any seed.
    pub seed: u64,
    /// Which frames belong together.
    pub time_offset: TimeOffset,
    /// Both cameras are the right way up, rolled by less than a quarter turn. Upright walkers look nearly the same upside
    /// down, and a mirrored geometry may score as high as the true one. Where `false`, up comes from how silhouettes stand.
    pub upright: bool,
    /// The camera matrices of A and B, where both are known: `F` is expected to be an essential matrix under them
    /// by [`Method::Frontier`].
    pub cameras: Option<CameraMatrices>,
    /// How many of the best pairs of lines are candidates (paper §2: 1,000), at least 3.
    pub candidates: usize,
    /// RANSAC draws of [`Method::Lines`], and of each line source of [`Method::Frontier`] (paper §4.3: 10,000).
    pub draws: usize,
    /// A result with a larger expected error, pixels, is refused.
    pub max_expected_error: f64,
    pub(crate) matching: CandidateOptions,
}

impl Default for CalibrateOptions {
    fn default() -> Self {
        Self {
            method: Method::default(),
            seed: 0,
            time_offset: TimeOffset::Known(0.0),
            upright: true,
            cameras: None,
            candidates: 1000,
            draws: 10_000,
            max_expected_error: MAX_EXPECTED_ERROR,
            matching: CandidateOptions::default(),
        }
    }
}

impl CalibrateOptions {
    /// The defaults.
    pub fn new() -> Self {
        Self::default()
    }

    /// With a [method](Self::method).
    #[must_use]
    pub fn method(self, method: Method) -> Self {
        Self { method, ..self }
    }

    /// With a [seed](Self::seed).
    #[must_use]
    pub fn seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// With a [time offset](Self::time_offset).
    #[must_use]
    pub fn time_offset(self, time_offset: TimeOffset) -> Self {
        Self { time_offset, ..self }
    }

    /// With cameras that are [upright](Self::upright), or are not known to be.
    #[must_use]
    pub fn upright(self, upright: bool) -> Self {
        Self { upright, ..self }
    }

    /// With known [camera matrices](Self::cameras).
    #[must_use]
    pub fn cameras(self, cameras: CameraMatrices) -> Self {
        Self { cameras: Some(cameras), ..self }
    }

    /// With a number of [candidates](Self::candidates).
    #[must_use]
    pub fn candidates(self, candidates: usize) -> Self {
        Self { candidates, ..self }
    }

    /// With a number of [draws](Self::draws).
    #[must_use]
    pub fn draws(self, draws: usize) -> Self {
        Self { draws, ..self }
    }

    /// With a largest [expected error](Self::max_expected_error), pixels.
    #[must_use]
    pub fn max_expected_error(self, max_expected_error: f64) -> Self {
        Self { max_expected_error, ..self }
    }

    /// With all that can be chosen about candidates; for tests and measurements.
    #[cfg(feature = "internals")]
    #[doc(hidden)]
    #[must_use]
    pub fn matching(self, matching: CandidateOptions) -> Self {
        Self { matching, ..self }
    }

    /// Camera matrices, for the method that makes use of them: the paper's knows nothing of such.
    pub(crate) fn cameras_used(&self) -> Option<CameraMatrices> {
        self.cameras.filter(|_| self.method == Method::Frontier)
    }

    /// How candidates are chosen.
    pub(crate) fn candidate_options(&self) -> CandidateOptions {
        let mut options = self.matching.clone();
        options.limit = self.candidates;
        options.seed = self.seed;
        options.reserve = options.reserve.max(self.candidates);
        if self.method == Method::Frontier {
            options.densify = options.densify.max(FRONTIER_LINES);
        }
        options
    }

    /// Whether every number is in its range.
    pub(crate) fn check(&self) -> Result<()> {
        let at_least = |name, value: usize, least, expected| {
            if value >= least {
                Ok(())
            } else {
                Err(Error::Argument { name, value: value.to_string(), expected })
            }
        };
        if self.max_expected_error.is_nan() || self.max_expected_error <= 0.0 {
            return Err(Error::Argument {
                name: "max_expected_error",
                value: self.max_expected_error.to_string(),
                expected: "a positive number of pixels",
            });
        }
        at_least("draws", self.draws, 1, "at least 1")?;
        at_least("candidates", self.candidates, MIN_CANDIDATES, "at least 3, which make a pencil")?;
        self.time_offset.check()
    }
}

/// Informative lines of each camera that the frontier method works with at least.
const FRONTIER_LINES: usize = 12_000;
