//! Footage from some moment on, and fewer of its frames.

use crate::network::given::pair_choice::all_pairs;
use crate::network::model::camera::Camera;
use crate::network::observations::observed::Observed;
use crate::network::observations::survey::Survey;
use crate::network::observations::time_parts::TimeParts;
use crate::network::solve::relocate::Placed;

/// Frames of each camera that are looked at.
pub const FRAMES: usize = 400;
/// Frames on which the best of several starts is chosen.
const SOME: usize = 120;
/// Frames on which turns are tried.
const FEW: usize = 60;
/// Parts of the footage by which poses are compared.
pub const PARTS: usize = 48;
/// The part with which the end of a stretch begins, by which a camera is asked for that moved in the midst of it.
const END: usize = 2 * PARTS / 3;

/// New footage from some moment on.
pub struct Stretch<'a> {
    observed: &'a [Observed],
    /// By whose clocks.
    cameras: Vec<Camera>,
    /// The network's time at which it begins.
    begins: f64,
    /// What comes before it, as a share of all that is compared.
    before: f64,
    /// Its parts.
    pub parts: TimeParts,
    pub all: Survey<'a>,
    pub some: Survey<'a>,
    pub few: Survey<'a>,
}

impl<'a> Stretch<'a> {
    /// All footage, by the clocks of a network.
    pub fn whole(observed: &'a [Observed], network: &Placed) -> Self {
        Self::from(observed, network.cameras.clone(), f64::NEG_INFINITY, 0.0)
    }

    fn from(observed: &'a [Observed], cameras: Vec<Camera>, begins: f64, before: f64) -> Self {
        let [all, some, few] = [FRAMES, SOME, FEW]
            .map(|limit| Survey::among(observed, limit, |c, seconds| cameras[c].time_of(seconds) >= begins));
        let pairs: Vec<(usize, usize)> = all_pairs(cameras.len()).collect();
        let parts = all.time_parts(&cameras, &pairs, PARTS);
        Self { observed, cameras, begins, before, parts, all, some, few }
    }

    /// Its end: a third of what is compared.
    pub fn end(&self) -> Self {
        let (begins, before) = (self.parts.start(END), self.before_part(END));
        Self::from(self.observed, self.cameras.clone(), begins, before)
    }

    /// What comes before one of its parts, as a share of all that is compared.
    pub fn before_part(&self, part: usize) -> f64 {
        self.before + (1.0 - self.before) * part as f64 / PARTS as f64
    }

    /// Footage since some moment of it: the network's time, and what comes before as a share of all that is compared; all of it
    /// where there is none.
    pub fn since(&self, moment: Option<(f64, f64)>) -> Self {
        let (begins, before) = moment.unwrap_or((self.begins, self.before));
        Self::from(self.observed, self.cameras.clone(), begins, before)
    }
}
