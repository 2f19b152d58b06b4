//! Which frame of A is which moment of B.
//!
//! A [`Clock`] is a line: where A's first frame falls in B, and how fast B's time runs against A's. From it each frame
//! of A gets a *position* in B, a frame number that need not be whole: [`links`] follows the silhouettes of B from
//! frame to frame, [`between`] draws them as they were at such a position, [`search`] finds the offset before any `F`
//! is known, and [`measure`] sharpens it, and the rate, once there is one.

mod between;
mod links;
mod measure;
mod search;

pub use measure::{MEASURABLE_PPM, Measured, measure};
pub use search::{RunnerUp, Searched, search_offset};

use crate::estimate::views::Views;
use crate::recording::Recording;
use crate::{Error, Result};
pub use links::Links;

/// The offset between the cameras' frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimeOffset {
    /// Frame 0 of A falls this many frames after frame 0 of B.
    Known(f64),
    /// Found from the barcodes, within this many seconds either way.
    Search {
        /// Largest offset considered, seconds.
        seconds: f64,
    },
}

impl TimeOffset {
    pub(super) fn check(self) -> Result<()> {
        let (value, ok, expected) = match self {
            Self::Known(offset) => (offset, offset.is_finite(), "a finite number of frames"),
            Self::Search { seconds } => {
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

/// How the time of A maps to the time of B.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// Where A's first frame falls in B, frames of B after B's first.
    pub offset: f64,
    /// Seconds by B's clock for each second by A's: 1 + 10⁻⁶ · drift in ppm.
    pub rate: f64,
}

impl Clock {
    /// An offset in frames of B, and clocks that run alike.
    pub fn at(offset: f64) -> Self {
        Self { offset, rate: 1.0 }
    }

    /// Of which `frames_per_frame` is [`Clock::frames_per_frame`].
    pub fn of_frames(offset: f64, frames_per_frame: f64, a: &Recording, b: &Recording) -> Self {
        Self { offset, rate: frames_per_frame / interval_ratio(a, b) }
    }

    /// Frames of B for each frame of A, dropped frames apart.
    pub fn frames_per_frame(&self, a: &Recording, b: &Recording) -> f64 {
        self.rate * interval_ratio(a, b)
    }

    /// Pairs (frame of A, nearest frame of B) that show the same moment.
    pub fn common_frames(&self, a: &Recording, b: &Recording) -> Vec<(u32, u32)> {
        nearest(&self.positions(a, b), a, b)
    }

    /// For each frame of A its position in B, in frames; NaN where B saw nothing of that moment.
    ///
    /// Equal frame rates go by index, so that rounded time stamps cannot slip a frame; others, and recordings with
    /// frames missing, go by the frame times.
    pub fn positions(&self, a: &Recording, b: &Recording) -> Vec<f64> {
        if b.times.is_empty() {
            return vec![f64::NAN; a.frames()];
        }
        let (step_a, step_b) = (frame_interval(a), frame_interval(b));
        let last = (b.frames() - 1) as f64;
        if is_one(step_a / step_b) && is_regular(a, step_a) && is_regular(b, step_b) {
            let position = |i: usize| whole_if_near(i as f64 * self.rate + self.offset);
            let inside = |p: f64| if (-0.5..last + 0.5).contains(&p) { p.clamp(0.0, last) } else { f64::NAN };
            return (0..a.frames()).map(|i| inside(position(i))).collect();
        }
        let mut next = 0;
        a.times
            .iter()
            .map(|time| {
                let target = (time - a.times[0]) * self.rate + self.offset * step_b + b.times[0];
                while next + 1 < b.frames() && b.times[next + 1] <= target {
                    next += 1;
                }
                whole_if_near(position_at(&b.times, next, target, step_a, step_b))
            })
            .collect()
    }
}

/// Position of a time among B's frames, of which `j` is the last that is not later (or the first).
fn position_at(times: &[f64], j: usize, target: f64, step_a: f64, step_b: f64) -> f64 {
    let near = |frame: usize, tolerance: f64| {
        if (times[frame] - target).abs() <= tolerance { frame as f64 } else { f64::NAN }
    };
    if target < times[j] || j + 1 == times.len() {
        return near(j, 0.5 * step_b);
    }
    let gap = times[j + 1] - times[j];
    let fraction = (target - times[j]) / gap;
    // Where frames are missing nothing is known of what moved.
    if gap > LONG_STEP * step_b {
        return near(if fraction < 0.5 { j } else { j + 1 }, NEAR * step_a.min(step_b));
    }
    j as f64 + fraction
}

/// Frames further apart than so many frame intervals have others missing between them.
const LONG_STEP: f64 = 1.6;
/// Two frames are of one moment within this share of the shorter frame interval.
const NEAR: f64 = 0.6;

/// Frames of B in one of A, exactly one where the rates are as good as equal.
fn interval_ratio(a: &Recording, b: &Recording) -> f64 {
    let ratio = frame_interval(a) / frame_interval(b);
    if is_one(ratio) { 1.0 } else { ratio }
}

fn is_one(ratio: f64) -> bool {
    (ratio - 1.0).abs() < 1e-4
}

/// A position that differs from a whole frame by rounding alone is that frame.
fn whole_if_near(position: f64) -> f64 {
    if (position - position.round()).abs() < 1e-6 { position.round() } else { position }
}

/// Seconds from one frame to the next, over the whole recording: neither a dropped frame nor time stamps in whole
/// milliseconds move it. One second for fewer than two frames.
pub fn frame_interval(recording: &Recording) -> f64 {
    let times = &recording.times;
    let step = 1.0 / recording.frame_rate();
    if !step.is_finite() {
        return 1.0;
    }
    let steps: f64 = times.windows(2).map(|t| ((t[1] - t[0]) / step).round().max(1.0)).sum();
    (times[times.len() - 1] - times[0]) / steps
}

/// Whether no frame is missing: every step is within half of the usual one.
fn is_regular(recording: &Recording, step: f64) -> bool {
    recording.times.windows(2).all(|t| ((t[1] - t[0]) / step - 1.0).abs() < 0.5)
}

/// Pairs (frame of A, nearest frame of B) that show the same moment, clocks running alike.
///
/// Both recordings count time from their own first frame; `offset`, in frames of B, is where A's first frame
/// falls in B.
pub fn common_frames(a: &Recording, b: &Recording, offset: f64) -> Vec<(u32, u32)> {
    Clock::at(offset).common_frames(a, b)
}

/// Each frame of A with the frame of B nearest to its position, if it is near.
fn nearest(positions: &[f64], a: &Recording, b: &Recording) -> Vec<(u32, u32)> {
    let within = NEAR * (frame_interval(a) / frame_interval(b)).min(1.0);
    let near = positions.iter().enumerate().filter(|(_, p)| (*p - p.round()).abs() <= within);
    near.map(|(i, p)| (i as u32, p.round() as u32)).collect()
}

/// Two recordings on one time line.
#[derive(Debug, Clone)]
pub struct Aligned<'a> {
    a: &'a Recording,
    b: &'a Recording,
    clock: Clock,
    positions: Vec<f64>,
    links: &'a Links,
}

impl<'a> Aligned<'a> {
    /// By a clock; `links` are those of B.
    pub fn new(a: &'a Recording, b: &'a Recording, links: &'a Links, clock: Clock) -> Self {
        Self { a, b, clock, positions: clock.positions(a, b), links }
    }

    /// The same with only every so many-th frame, at most `limit` of them.
    #[must_use]
    pub fn thinned(mut self, limit: usize) -> Self {
        let common = self.positions.iter().filter(|p| !p.is_nan()).count();
        let step = common.div_ceil(limit.max(1)).max(1);
        let known = self.positions.iter_mut().filter(|p| !p.is_nan());
        known.enumerate().filter(|(k, _)| k % step != 0).for_each(|(_, p)| *p = f64::NAN);
        self
    }

    /// The clock.
    pub fn clock(&self) -> Clock {
        self.clock
    }

    /// Frames of A with the nearest frame of B.
    pub fn frame_pairs(&self) -> Vec<(u32, u32)> {
        nearest(&self.positions, self.a, self.b)
    }

    /// Where a frame of A falls among the frames of B; NaN where B saw nothing of that moment.
    pub fn position(&self, frame: u32) -> f64 {
        self.positions[frame as usize]
    }

    /// Silhouettes of both at some of those pairs, B's drawn at the very moment of A's frame.
    pub fn views(&self, frame_pairs: &[(u32, u32)]) -> Views {
        if frame_pairs.iter().all(|p| self.positions[p.0 as usize].fract() == 0.0) {
            return Views::new(self.a, self.b, frame_pairs);
        }
        let hulls = |frame: u32| {
            let found = between::hulls(&self.b.silhouettes, self.links, self.positions[frame as usize]);
            found.into_iter().map(|hull| hull.vertices).collect()
        };
        Views::with_hulls_of_b(self.a, self.b, frame_pairs, hulls)
    }
}
