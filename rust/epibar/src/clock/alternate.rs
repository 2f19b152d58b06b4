//! The clocks and the geometry, in turn: one cannot be had without the other.

use std::iter::once;

use super::aligned::Aligned;
use super::clock::Clock;
use super::offset::{FoundOffset, find_offset, find_offset_among};
use super::offset_and_drift::{Measured, sharpen};
use super::timing::{RunnerUp, TimeOffset, Timing};
use crate::error::Result;
use crate::frontier::up::{Up, up_in};
use crate::frontier::{busy_frames, symmetric_score};
use crate::geometry::Fundamental;
use crate::recording::tracker::Links;
use crate::recording::{RecordedFrame, Recording};
use crate::watch::{Unwatched, Watch};

/// Offsets that differ by less than this, frames, give the same geometry.
const SAME_OFFSET: f64 = 0.05;
/// An offset with a larger standard error, frames, is not known any better than before.
const MAX_OFFSET_ERROR: f64 = 0.25;
/// Frames for a first geometry.
const SOME_FRAMES: usize = 300;
/// Parts of a recording, each of which is left out in turn, with so much of it on either side.
const PARTS: usize = 5;
const SEAM: f64 = 0.2;
/// What is found without them is the same within so many seconds: barcodes find an offset to a frame or two.
const PARTS_AGREE: f64 = 0.1;
/// Fewest common frames at which an offset is looked at.
const LEAST_COMMON: usize = 16;

/// Two recordings and what is known of their clocks, while geometries for them are found.
///
/// Ask for the recordings on one time line ([`Clocks::aligned`]), find a geometry, and tell it ([`Clocks::learn`]), until
/// that answers.
pub struct Clocks<'a> {
    a: &'a Recording,
    b: &'a Recording,
    links: Links,
    up: [Up; 2],
    given: TimeOffset,
    clock: Clock,
    found: Option<FoundOffset>,
    next: Next,
}

/// What the next geometry is for.
#[derive(Debug, Clone, Copy)]
enum Next {
    /// The offset is given: the geometry shows whether the rates differ.
    Drift,
    /// The offset is given, and the rate is in the clock that was measured.
    WithDrift(Measured),
    /// The offset was searched, to a frame or two: a geometry from some of the frames is enough to sharpen it with.
    First,
    /// The answer takes all frames. `sharp`: the clock has been sharpened; `last`: what is found now is final.
    Again { sharp: bool, last: bool },
}

impl<'a> Clocks<'a> {
    /// From an offset that is given, or is searched by barcodes. `upright`: both cameras are the right way up.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn new(
        a: &'a Recording,
        b: &'a Recording,
        offset: TimeOffset,
        upright: bool,
        watch: &mut dyn Watch,
    ) -> Result<Self> {
        let (clock, found, next) = match offset {
            TimeOffset::Known(offset) => (Clock::at(offset), None, Next::Drift),
            TimeOffset::Auto { .. } => (Clock::at(0.0), None, Next::Drift),
            TimeOffset::About(offset) => (Clock::at(offset), None, Next::First),
            TimeOffset::Search { seconds } => {
                let found = find_offset(a, b, seconds, watch)?;
                (Clock::at(found.as_ref().map_or(0.0, |s| s.offset)), found, Next::First)
            }
        };
        Ok(Self { a, b, links: Links::new(b), up: up_in([a, b], upright), given: offset, clock, found, next })
    }

    /// From offsets that barcodes propose. `upright`: both cameras are the right way up.
    ///
    /// # Errors
    /// None that input can cause.
    pub fn from_found(a: &'a Recording, b: &'a Recording, found: FoundOffset, upright: bool) -> Result<Self> {
        let about = Self::new(a, b, TimeOffset::About(found.offset), upright, &mut Unwatched)?;
        Ok(Self { found: Some(found), ..about })
    }

    /// Both recordings on the time line for which a geometry is wanted.
    pub fn aligned(&self) -> Aligned<'_> {
        let aligned = self.aligned_at(self.clock);
        if matches!(self.next, Next::First) { aligned.thinned(SOME_FRAMES) } else { aligned }
    }

    /// Offsets that may be it, frames of B, those first for which barcodes speak most; none where it was not searched for.
    pub fn proposed(&self) -> Vec<f64> {
        self.found.iter().flat_map(|f| once(f.offset).chain(f.others.iter().copied())).collect()
    }

    /// Both recordings by one of those, and some of the frames.
    pub fn proposal(&self, offset: f64) -> Aligned<'_> {
        self.aligned_at(Clock::at(offset)).thinned(SOME_FRAMES)
    }

    /// Takes another of those that may be it than the one for which barcodes speak most.
    pub fn take(&mut self, offset: f64) {
        if let Some(found) = self.found.as_mut().filter(|found| found.offset != offset) {
            // Barcodes speak for that one no less.
            found.runner_up = Some(RunnerUp { offset: found.offset, share: 1.0 });
            found.offset = offset;
            self.clock = Clock::at(offset);
        }
    }

    /// Seconds between frames of B.
    pub fn frame_interval(&self) -> f64 {
        self.b.frame_interval()
    }

    /// Both recordings with what is in A so many frames of B later.
    pub fn later(&self, frames: f64) -> Aligned<'_> {
        self.aligned_at(self.clock.later(frames))
    }

    /// Takes the geometry that was found, if there is evidence for it that the recordings show the same moments at all.
    /// `None`: the clock is better known now, and a geometry is wanted for it.
    pub fn learn(&mut self, f: Option<Fundamental>) -> Option<Timing> {
        let clock = self.clock;
        let mut timing = Timing::of(clock, self.a, self.b);
        match self.next {
            Next::Drift => {
                if let Some(measured) = f.and_then(|f| self.measured(clock, &f)) {
                    let rate = measured.clock.rate;
                    if rate != 1.0 {
                        self.clock = Clock { rate, ..clock };
                        self.next = Next::WithDrift(measured);
                        return None;
                    }
                    timing.set_drift(&measured);
                }
            }
            Next::WithDrift(measured) => timing.set_drift(&measured),
            Next::First => {
                let measured = f.and_then(|f| self.sharpened(&f, false));
                // By a clock that is no better known the same frames give the same geometry.
                if measured.is_some() || !self.are_all() {
                    self.next = Next::Again { sharp: measured.is_some(), last: false };
                    self.clock = measured.map_or(clock, |m| m.clock);
                    return None;
                }
            }
            Next::Again { sharp, last } => {
                if let Some(measured) = f.and_then(|f| self.sharpened(&f, sharp)) {
                    let settled = last || self.moved(measured.clock) < SAME_OFFSET;
                    if !settled {
                        self.clock = measured.clock;
                        self.next = Next::Again { sharp: true, last: true };
                        return None;
                    }
                    timing.offset = measured.clock.offset;
                    timing.frames_per_frame = measured.clock.frames_per_frame(self.a, self.b);
                    timing.offset_error = measured.offset_error;
                    timing.set_drift(&measured);
                }
            }
        }
        if let Some(found) = &self.found {
            timing.runner_up = found.runner_up;
            timing.trials = found.trials;
        }
        Some(timing)
    }

    /// Among how many offsets the one that was searched is the best for frames that did not choose it: those that count
    /// as the same, where barcodes find it without any one part of what both cameras filmed; otherwise all that were tried.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn trials_by_parts(&self, watch: &mut dyn Watch) -> Result<usize> {
        let (TimeOffset::Search { seconds }, Some(found)) = (self.given, &self.found) else { return Ok(1) };
        let common = self.aligned_at(Clock::at(found.offset)).frame_pairs();
        let (length, agree) =
            (common.len() as f64 / PARTS as f64, (PARTS_AGREE / self.b.frame_interval()).ceil());
        let of_a = |place: f64| common[(place as usize).min(common.len() - 1)].a;
        for part in 0..PARTS {
            let (first, last) =
                (of_a((part as f64 - SEAM) * length), of_a((part as f64 + 1.0 + SEAM) * length));
            let other = |frame: RecordedFrame| frame < first || frame > last;
            let without = find_offset_among(self.a, self.b, other, seconds, watch)?;
            if without.is_none_or(|w| (w.offset - found.offset).abs() > agree) {
                return Ok(found.trials);
            }
        }
        Ok(2 * agree as usize + 1)
    }

    fn aligned_at(&self, clock: Clock) -> Aligned<'_> {
        Aligned::new(self.a, self.b, &self.links, clock, self.up)
    }

    /// Whether the first geometry is from all frames that there are.
    fn are_all(&self) -> bool {
        let all = self.aligned_at(self.clock);
        all.clone().thinned(SOME_FRAMES).frame_pairs() == all.frame_pairs()
    }

    /// What the recordings say of a clock that is about right, with a geometry that is.
    fn measured(&self, clock: Clock, f: &Fundamental) -> Option<Measured> {
        sharpen(self.a, self.b, &self.links, clock, f, self.up).filter(|m| m.offset_error < MAX_OFFSET_ERROR)
    }

    /// [`Clocks::measured`] from the clock, or from the best of those some whole frames away where it is not yet sharp.
    fn sharpened(&self, f: &Fundamental, sharp: bool) -> Option<Measured> {
        let near = if sharp { self.clock } else { self.nearest_frame(f) };
        self.measured(near, f)
    }

    /// By how many frames of B a clock differs, at the end of the recording where it differs more.
    fn moved(&self, now: Clock) -> f64 {
        let end =
            |clock: Clock| clock.offset + self.a.frames() as f64 * clock.frames_per_frame(self.a, self.b);
        (now.offset - self.clock.offset).abs().max((end(now) - end(self.clock)).abs())
    }

    /// The clock moved by whole frames to where `f` has the highest score: barcodes find the offset to a frame or two.
    fn nearest_frame(&self, f: &Fundamental) -> Clock {
        const REACH: i32 = 4;
        const FRAMES: usize = 400;
        let score = |k: i32| {
            let aligned = self.later(f64::from(k));
            let pairs = aligned.frame_pairs();
            if pairs.len() < LEAST_COMMON {
                return f64::NEG_INFINITY;
            }
            let busy = busy_frames(self.a, self.b, &pairs, Some(FRAMES));
            symmetric_score(&aligned.views(&busy), f).total
        };
        let by_score = (-REACH..=REACH).map(|k| (score(k), k));
        by_score
            .max_by(|p, q| p.0.total_cmp(&q.0).then(q.1.abs().cmp(&p.1.abs())))
            .map_or(self.clock, |(_, k)| self.clock.later(f64::from(k)))
    }
}
