//! What is given and what is found out of the clocks.

use super::clock::Clock;
use super::offset_and_drift::{MEASURABLE_PPM, Measured};
use crate::error::{Error, Result};
use crate::recording::Recording;

/// The offset between the cameras' frames.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum TimeOffset {
    /// Frame 0 of A falls this many frames of B after frame 0 of B.
    Known(f64),
    /// Frame 0 of A falls about this many frames of B after frame 0 of B, to a frame or two: it is sharpened with the geometry.
    About(f64),
    /// Found from the barcodes, within this many seconds either way.
    Search {
        /// Largest offset considered, seconds.
        seconds: f64,
    },
    /// It is not known whether the cameras were started together. No offset is tried first: what is accepted so has passed the test of shifted
    /// clocks, and no other clock near it explains as much. Only where it is refused one is searched for; where neither is accepted, it is the one for
    /// which more speaks.
    Auto {
        /// Largest offset considered, seconds.
        seconds: f64,
    },
}

impl TimeOffset {
    /// What is tried next where what is found so is refused.
    pub(crate) fn where_refused(self) -> Option<Self> {
        match self {
            Self::Auto { seconds } => Some(Self::Search { seconds }),
            Self::Known(_) | Self::About(_) | Self::Search { .. } => None,
        }
    }

    /// Whether it is told, and not found.
    pub(crate) fn is_given(self) -> bool {
        matches!(self, Self::Known(_))
    }

    pub(crate) fn check(self) -> Result<()> {
        let (value, ok, expected) = match self {
            Self::Known(offset) | Self::About(offset) => {
                (offset, offset.is_finite(), "a finite number of frames")
            }
            Self::Search { seconds } | Self::Auto { seconds } => {
                (seconds, seconds.is_finite() && seconds > 0.0, "a positive number of seconds to search")
            }
        };
        if ok {
            Ok(())
        } else {
            Err(Error::Argument { name: "time_offset", value: value.to_string(), expected })
        }
    }
}

/// Which frame of A is which moment of B.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Timing {
    /// Frame 0 of A falls so many frames of B after B's first frame. At equal frame rates, and clocks that run alike,
    /// frame `i` of A is frame `i + offset` of B.
    pub offset: f64,
    /// Frames of B for each frame of A: frame `i` of A is frame `offset + i · frames_per_frame` of B, where no frame
    /// of either is missing.
    pub frames_per_frame: f64,
    /// Standard error of the offset, frames of B; NaN where it was given, or could not be measured.
    pub offset_error: f64,
    /// By how much B's clock runs faster than A's, ppm; NaN where the recordings do not show it.
    pub drift: f64,
    /// Standard error of the drift, ppm.
    pub drift_error: f64,
    /// The drift is large enough to be taken into account, and is.
    pub drift_used: bool,
    /// The second best offset by the barcodes, where the offset was searched.
    pub runner_up: Option<RunnerUp>,
    /// Offsets tried; 1 where it was given.
    pub trials: usize,
}

impl Timing {
    pub(crate) fn of(clock: Clock, a: &Recording, b: &Recording) -> Self {
        Self {
            offset: clock.offset,
            frames_per_frame: clock.frames_per_frame(a, b),
            offset_error: f64::NAN,
            drift: f64::NAN,
            drift_error: f64::NAN,
            drift_used: clock.rate != 1.0,
            runner_up: None,
            trials: 1,
        }
    }

    pub(super) fn set_drift(&mut self, measured: &Measured) {
        let error = 1e6 * measured.rate_error;
        if error <= MEASURABLE_PPM {
            (self.drift, self.drift_error) = (1e6 * (measured.rate - 1.0), error);
        }
    }
}

/// The second best offset.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct RunnerUp {
    /// Frames of B.
    pub offset: f64,
    /// Its score as a share of the best.
    pub share: f64,
}
