//! Two recordings on one time line.

use super::between;
use super::clock::{Clock, nearest};
use crate::frontier::{Up, Views};
use crate::recording::tracker::Links;
use crate::recording::{FramePair, RecordedFrame, Recording};

/// Two recordings on one time line.
#[derive(Debug, Clone)]
pub struct Aligned<'a> {
    a: &'a Recording,
    b: &'a Recording,
    clock: Clock,
    positions: Vec<f64>,
    links: &'a Links,
    up: [Up; 2],
}

impl<'a> Aligned<'a> {
    /// By a clock; `links` are those of the silhouettes of B, `up` is up in either image.
    pub fn new(a: &'a Recording, b: &'a Recording, links: &'a Links, clock: Clock, up: [Up; 2]) -> Self {
        Self { a, b, clock, positions: clock.positions(a, b), links, up }
    }

    /// With only every so many-th of the common frames, at most `limit` of them.
    #[must_use]
    pub fn thinned(mut self, limit: usize) -> Self {
        let common = self.positions.iter().filter(|p| !p.is_nan()).count();
        let step = common.div_ceil(limit.max(1)).max(1);
        let known = self.positions.iter_mut().filter(|p| !p.is_nan());
        known.enumerate().filter(|(k, _)| k % step != 0).for_each(|(_, p)| *p = f64::NAN);
        self
    }

    /// Recording A.
    pub fn a(&self) -> &'a Recording {
        self.a
    }

    /// Recording B.
    pub fn b(&self) -> &'a Recording {
        self.b
    }

    /// The clock.
    pub fn clock(&self) -> Clock {
        self.clock
    }

    /// Frames of A with the nearest frame of B.
    pub fn frame_pairs(&self) -> Vec<FramePair> {
        nearest(&self.positions, self.a, self.b)
    }

    /// Where a frame of A falls among the frames of B; NaN where B saw nothing of that moment.
    pub fn position(&self, frame: RecordedFrame) -> f64 {
        self.positions[frame.index()]
    }

    /// Silhouettes of both at some of those pairs, B's drawn at the very moment of A's frame.
    pub fn views(&self, frame_pairs: &[FramePair]) -> Views {
        if frame_pairs.iter().all(|p| self.position(p.a).fract() == 0.0) {
            return Views::new(self.a, self.b, frame_pairs).with_up(self.up);
        }
        let hulls = |frame: RecordedFrame| {
            let found = between::hulls(&self.b.silhouettes, self.links, self.position(frame));
            found.into_iter().map(|hull| hull.vertices).collect()
        };
        Views::with_hulls_of_b(self.a, self.b, frame_pairs, hulls).with_up(self.up)
    }
}
