//! Footage from some moment on, and fewer of its frames.

use crate::network::observations::observed::Observed;
use crate::network::observations::survey::Survey;

/// Frames of each camera that are looked at.
pub const FRAMES: usize = 400;
/// Frames on which the best of several starts is chosen.
const SOME: usize = 120;
/// Frames on which turns are tried.
const FEW: usize = 60;
/// Where the end of a stretch begins, by which a camera is asked for that moved in the midst of it, as a share of it.
const END: f64 = 2.0 / 3.0;

/// New footage from some moment on.
pub struct Stretch<'a> {
    observed: &'a [Observed],
    /// Share of each camera's footage at which it begins.
    begins: f64,
    pub all: Survey<'a>,
    pub some: Survey<'a>,
    pub few: Survey<'a>,
}

impl<'a> Stretch<'a> {
    /// Footage from a share of it on.
    pub fn from(observed: &'a [Observed], begins: f64) -> Self {
        let start: Vec<f64> =
            observed.iter().map(|o| begins * o.times.last().copied().unwrap_or(0.0)).collect();
        let [all, some, few] =
            [FRAMES, SOME, FEW].map(|limit| Survey::among(observed, limit, |c, seconds| seconds >= start[c]));
        Self { observed, begins, all, some, few }
    }

    /// Its end.
    pub fn end(&self) -> Self {
        Self::from(self.observed, self.share(END))
    }

    /// A share of it as a share of all footage.
    pub fn share(&self, of_this: f64) -> f64 {
        self.begins + (1.0 - self.begins) * of_this
    }
}
