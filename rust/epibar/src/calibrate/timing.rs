//! The clocks and the geometry, in turn: one cannot be had without the other.

use super::alignment::{
    Aligned, Clock, Links, MEASURABLE_PPM, Measured, RunnerUp, TimeOffset, measure, search_offset,
};
use super::judge::{MIN_Z, not_rounded_up, suggestion};
use super::verdict::{Kind, Verdict};
use super::{CalibrateOptions, Calibration, MIN_FRAMES, calibrate_at};
use crate::Result;
use crate::estimate::evidence::evidence;
use crate::estimate::ransac::Watch;
use crate::estimate::views::busy_frames;
use crate::geometry::Fundamental;
use crate::recording::Recording;

/// Which frame of A is which moment of B.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    /// Its standard error, ppm.
    pub drift_error: f64,
    /// The drift is large enough to be taken into account, and is.
    pub drift_used: bool,
    /// The second best offset by the barcodes, where the offset was searched.
    pub runner_up: Option<RunnerUp>,
    /// Offsets tried; 1 where it was given.
    pub trials: usize,
}

impl Timing {
    pub(super) fn of(clock: Clock, a: &Recording, b: &Recording) -> Self {
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

    fn with_drift(&mut self, measured: &Measured) {
        let error = 1e6 * measured.rate_error;
        if error <= MEASURABLE_PPM {
            (self.drift, self.drift_error) = (1e6 * (measured.rate - 1.0), error);
        }
    }
}

/// Offsets that differ by less than this, frames, give the same geometry.
const SAME_OFFSET: f64 = 0.05;
/// Below this standard score of a geometry its silhouettes say nothing of the clock.
const MIN_Z_FOR_CLOCK: f64 = 4.0;
/// An offset with a larger standard error, frames, is not known any better than before.
const MAX_OFFSET_ERROR: f64 = 0.25;
/// Frames for a first geometry.
const SOME_FRAMES: usize = 300;

pub(super) fn calibrate(
    a: &Recording,
    b: &Recording,
    options: &CalibrateOptions,
    watch: &mut dyn Watch,
) -> Result<Calibration> {
    let links = Links::new(b);
    match options.time_offset {
        TimeOffset::Known(offset) => at_known_offset(a, b, &links, offset, options, watch),
        TimeOffset::Search { seconds } => {
            let searched = search_offset(a, b, seconds, watch)?;
            let start = Clock::at(searched.map_or(0.0, |s| s.offset));
            let mut found = sharpened(a, b, &links, start, options, watch)?;
            if let Some(searched) = searched {
                found.timing.runner_up = searched.runner_up;
                found.timing.trials = searched.trials;
                account_for_trials(&mut found);
            }
            Ok(found)
        }
    }
}

/// The offset is kept; a difference of the clocks that shows is taken into account.
fn at_known_offset(
    a: &Recording,
    b: &Recording,
    links: &Links,
    offset: f64,
    options: &CalibrateOptions,
    watch: &mut dyn Watch,
) -> Result<Calibration> {
    let clock = Clock::at(offset);
    let found = calibrate_at(a, b, &Aligned::new(a, b, links, clock), options, watch)?;
    let Some(measured) = measured(a, b, links, clock, &found, options) else { return Ok(found) };
    let rate = measured.clock.rate;
    let mut found = if rate == 1.0 {
        found
    } else {
        calibrate_at(a, b, &Aligned::new(a, b, links, Clock { rate, ..clock }), options, watch)?
    };
    found.timing.with_drift(&measured);
    Ok(found)
}

/// What the recordings say of the clock, where there is evidence that they show the same moments at all.
fn measured(
    a: &Recording,
    b: &Recording,
    links: &Links,
    clock: Clock,
    found: &Calibration,
    options: &CalibrateOptions,
) -> Option<Measured> {
    let f = found.fundamental.filter(|_| found.evidence.z >= MIN_Z_FOR_CLOCK)?;
    measure(a, b, links, clock, &f, options.upright).filter(|m| m.offset_error < MAX_OFFSET_ERROR)
}

/// From a clock that is right to a frame or two.
///
/// A geometry from some of the frames is enough to sharpen the clock with; the answer takes all of them.
fn sharpened(
    a: &Recording,
    b: &Recording,
    links: &Links,
    start: Clock,
    options: &CalibrateOptions,
    watch: &mut dyn Watch,
) -> Result<Calibration> {
    let better = |clock: Clock, found: &Calibration, sharp: bool| {
        let near = match found.fundamental {
            Some(f) if !sharp => nearest_frame(a, b, links, clock, &f, options.upright),
            _ => clock,
        };
        measured(a, b, links, near, found, options)
    };
    let some = Aligned::new(a, b, links, start).thinned(SOME_FRAMES);
    let first = calibrate_at(a, b, &some, options, watch)?;
    let (mut clock, mut sharp) = match better(start, &first, false) {
        Some(measured) => (measured.clock, true),
        None => (start, false),
    };
    let mut last = false;
    loop {
        let mut found = calibrate_at(a, b, &Aligned::new(a, b, links, clock), options, watch)?;
        let Some(measured) = better(clock, &found, sharp) else { return Ok(found) };
        let end = |clock: Clock| clock.offset + a.frames() as f64 * clock.frames_per_frame(a, b);
        let now = measured.clock;
        let moved = (now.offset - clock.offset).abs().max((end(now) - end(clock)).abs());
        if moved < SAME_OFFSET || last {
            found.timing.offset = now.offset;
            found.timing.frames_per_frame = now.frames_per_frame(a, b);
            found.timing.offset_error = measured.offset_error;
            found.timing.with_drift(&measured);
            return Ok(found);
        }
        (clock, sharp, last) = (now, true, true);
    }
}

/// The clock moved by whole frames to where `f` has most evidence: barcodes find the offset to a frame or two.
fn nearest_frame(
    a: &Recording,
    b: &Recording,
    links: &Links,
    clock: Clock,
    f: &Fundamental,
    upright: bool,
) -> Clock {
    const REACH: i32 = 4;
    const FRAMES: usize = 400;
    let moved = |k: i32| Clock { offset: clock.offset + f64::from(k), ..clock };
    let weigh = |k: i32| {
        let aligned = Aligned::new(a, b, links, moved(k));
        let pairs = aligned.frame_pairs();
        if pairs.len() < MIN_FRAMES {
            return f64::NEG_INFINITY;
        }
        evidence(&aligned.views(&busy_frames(a, b, &pairs, FRAMES)), f, upright).total
    };
    let by_evidence = (-REACH..=REACH).map(|k| (weigh(k), k));
    by_evidence
        .max_by(|p, q| p.0.total_cmp(&q.0).then(q.1.abs().cmp(&p.1.abs())))
        .map_or(clock, |(_, k)| moved(k))
}

/// An offset chosen among many fits by chance as well as the best of so many: the standard score is what is left
/// of it when the chance is multiplied by their number, `exp(−z²/2) · trials`.
fn account_for_trials(found: &mut Calibration) {
    let evidence = &mut found.evidence;
    let trials = found.timing.trials as f64;
    evidence.z = (evidence.z.max(0.0).powi(2) - 2.0 * trials.ln()).max(0.0).sqrt();
    if found.verdict.accepted() && evidence.z < MIN_Z {
        found.verdict = Verdict {
            kind: Kind::NoCommonScene,
            reason: format!(
                "{} that the two cameras see the same moving things: the best of {trials} time offsets stands \
                 {:.1} standard deviations above chance when their number is allowed for, and {MIN_Z:.0} are needed; more \
                 motion, or a search among fewer, may do.",
                suggestion(evidence.z),
                not_rounded_up(evidence.z)
            ),
        };
    }
}
