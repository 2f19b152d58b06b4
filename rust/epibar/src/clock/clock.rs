//! A clock: a line from the time of A to the time of B.

use crate::recording::{FramePair, LONG_STEP, Recording};

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

    /// The clock with this offset whose [`Clock::frames_per_frame`] is `frames_per_frame`.
    pub fn of_frames(offset: f64, frames_per_frame: f64, a: &Recording, b: &Recording) -> Self {
        Self { offset, rate: frames_per_frame / interval_ratio(a, b) }
    }

    /// The clock by which what is in A is so many frames of B later.
    #[must_use]
    pub fn later(self, frames: f64) -> Self {
        Self { offset: self.offset + frames, ..self }
    }

    /// Frames of B for each frame of A, dropped frames apart.
    pub fn frames_per_frame(&self, a: &Recording, b: &Recording) -> f64 {
        self.rate * interval_ratio(a, b)
    }

    /// Frames of A, each with the nearest frame of B that shows its moment.
    pub fn common_frames(&self, a: &Recording, b: &Recording) -> Vec<FramePair> {
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
        let (step_a, step_b) = (a.frame_interval(), b.frame_interval());
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

/// Two frames are of one moment within this share of the shorter frame interval.
const NEAR: f64 = 0.6;

/// Frames of B in one of A, exactly one where the rates are as good as equal.
fn interval_ratio(a: &Recording, b: &Recording) -> f64 {
    let ratio = a.frame_interval() / b.frame_interval();
    if is_one(ratio) { 1.0 } else { ratio }
}

fn is_one(ratio: f64) -> bool {
    (ratio - 1.0).abs() < 1e-4
}

/// A position that differs from a whole frame by rounding alone is that frame.
fn whole_if_near(position: f64) -> f64 {
    if (position - position.round()).abs() < 1e-6 { position.round() } else { position }
}

/// Frames are where their number says within this share of the frame interval; with time stamps in whole milliseconds they
/// are at up to 200 frames a second.
const REGULAR: f64 = 0.2;

/// Whether the number of a frame tells its time: none is missing, and the rate does not vary.
///
/// Steps that are all much alike do not say so: phones film 24 frames a second in the dark and 30 in the light.
fn is_regular(recording: &Recording, step: f64) -> bool {
    let times = &recording.times;
    times.iter().enumerate().all(|(i, t)| ((t - times[0]) / step - i as f64).abs() < REGULAR)
}

/// Frames of A, each with the nearest frame of B that shows its moment, clocks running alike.
///
/// Both recordings count time from their own first frame; `offset`, in frames of B, is where A's first frame
/// falls in B.
pub fn common_frames(a: &Recording, b: &Recording, offset: f64) -> Vec<FramePair> {
    Clock::at(offset).common_frames(a, b)
}

/// Each frame of A with the frame of B nearest to its position, if it is near.
pub(super) fn nearest(positions: &[f64], a: &Recording, b: &Recording) -> Vec<FramePair> {
    let within = NEAR * (a.frame_interval() / b.frame_interval()).min(1.0);
    let near = positions.iter().enumerate().filter(|(_, p)| (*p - p.round()).abs() <= within);
    near.map(|(i, p)| FramePair::new(i as u32, p.round() as u32)).collect()
}
