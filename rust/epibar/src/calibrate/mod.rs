//! The whole job: two recordings in, one calibration out.
//!
//! The clocks are aligned; on one time line candidates are found, an `F` is searched with them, refined, and verified, once
//! more with other frames kept aside where they say too little. What it says of the clocks may call for another time line, and then all is
//! done once more.

mod clock_by_motion;
mod found_before;
mod offset_choice;
mod result;
mod time_line;

pub use offset_choice::{OutstandingOffset, outstanding_offset};

use crate::calibration::Calibration;
use crate::clock::{Aligned, Clocks, TimeOffset, Timing};
use crate::error::Result;
use crate::matching::Candidates;
use crate::options::{CalibrateOptions, Method};
use crate::recording::Recording;
use crate::verify::second_look::Earlier;
use crate::verify::split::Fold;
use crate::verify::thresholds::MIN_Z_FOR_CLOCK;
use crate::verify::trials::falls_for;
use crate::verify::{Case, untestable, verify};
use crate::watch::{Stage, Unwatched, Watch, report};
use clock_by_motion::{found_clock_by_motion, given_clock_by_motion};
use found_before::FoundBefore;
use time_line::TimeLine;

/// Finds the fundamental matrix between two cameras.
///
/// Refusing is a result, not an error: see [`Calibration::verdict`]. The result depends on the recordings and the
/// options, not on the number of threads.
///
/// # Errors
/// [`Error::Argument`](crate::Error::Argument) for options out of range.
pub fn calibrate(a: &Recording, b: &Recording, options: &CalibrateOptions) -> Result<Calibration> {
    calibrate_watched(a, b, options, &mut Unwatched)
}

/// [`calibrate`] with progress, and a way to stop: `watch` is asked between batches of work.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted) where `watch` says so, [`Error::Argument`](crate::Error::Argument)
/// for options out of range.
pub fn calibrate_watched(
    a: &Recording,
    b: &Recording,
    options: &CalibrateOptions,
    watch: &mut dyn Watch,
) -> Result<Calibration> {
    options.check()?;
    let found = at_better_clock(a, b, options.time_offset, options, watch)?;
    let next = options.time_offset.where_refused();
    let Some(next) = next.filter(|_| !found.accepted()) else { return Ok(found.with_outlines()) };
    let other = at_better_clock(a, b, next, options, watch)?;
    let other_is_better = other.accepted() || other.evidence.z > found.evidence.z;
    Ok(if other_is_better { other } else { found }.with_outlines())
}

/// From what is known of the offset, and once more from another one near it where that is clearly better.
fn at_better_clock(
    a: &Recording,
    b: &Recording,
    offset: TimeOffset,
    options: &CalibrateOptions,
    watch: &mut dyn Watch,
) -> Result<Calibration> {
    let (found, better) = calibrate_from(a, b, offset, options, watch)?;
    let Some(better) = better else { return Ok(found) };
    let (other, _) = calibrate_from(a, b, TimeOffset::About(better), options, watch)?;
    // It is still the best of as many as were tried before.
    let Timing { runner_up, trials, .. } = found.timing;
    let timing = Timing { runner_up, trials, ..other.timing };
    let other = other.with_timing(timing, trials);
    Ok(if other.evidence.z > found.evidence.z { other } else { found })
}

/// From what is known of the offset, which is learned with the geometry; and another offset that is clearly better, if there is one.
fn calibrate_from(
    a: &Recording,
    b: &Recording,
    offset: TimeOffset,
    options: &CalibrateOptions,
    watch: &mut dyn Watch,
) -> Result<(Calibration, Option<f64>)> {
    let mut clocks = Clocks::new(a, b, offset, options.upright, watch)?;
    if options.method == Method::Frontier
        && let Some(outstanding) = outstanding_offset(&clocks, options, &mut after_barcodes(watch))?
    {
        clocks.take(outstanding.offset);
    }
    let mut known = FoundBefore::default();
    loop {
        let found;
        (found, known) = calibrate_at(&clocks.aligned(), &known, options, watch)?;
        let credible = found.fundamental.filter(|_| found.evidence.z >= MIN_Z_FOR_CLOCK);
        if let Some(timing) = clocks.learn(credible) {
            // Only where their number decides is it asked more closely.
            let decides = found.accepted() && falls_for(timing.trials, &found.evidence);
            let trials = if decides { clocks.trials_by_parts(watch)? } else { timing.trials };
            let found = found.with_timing(timing, trials);
            return Ok(if offset.is_given() {
                (given_clock_by_motion(found, &clocks, options), None)
            } else {
                found_clock_by_motion(found, &clocks, options)
            });
        }
    }
}

/// The last tenth of the work on the offset.
fn after_barcodes(watch: &mut dyn Watch) -> impl Watch {
    |stage, done| watch.keep_going(stage, 0.9 + 0.1 * done)
}

/// By a known clock: once, and once more with other frames kept aside where these say too little. `known` is what was found by a clock nearly as good; what is
/// found by this one comes beside the calibration.
fn calibrate_at(
    aligned: &Aligned,
    known: &FoundBefore,
    options: &CalibrateOptions,
    watch: &mut dyn Watch,
) -> Result<(Calibration, FoundBefore)> {
    let time_line = TimeLine::new(aligned, options);
    if let Some(verdict) = untestable::too_few_frames(time_line.common.len()) {
        return Ok((time_line.refused(verdict, &Candidates::default()), FoundBefore::default()));
    }
    let first = looked_at(&time_line, Fold::First, known, None, watch)?;
    let Some(earlier) = first.again.filter(|_| options.method == Method::Frontier) else {
        return Ok((first.calibration, first.found));
    };
    let second = looked_at(&time_line, Fold::Second, known, Some(&earlier), watch)?.calibration;
    let second_is_better = second.evidence.z > first.calibration.evidence.z;
    Ok((if second_is_better { second } else { first.calibration }, first.found))
}

/// What a look at some of the frames brought.
struct LookedAt {
    calibration: Calibration,
    /// What is worth a second look at other frames, if anything is.
    again: Option<Earlier>,
    /// What was found.
    found: FoundBefore,
}

impl LookedAt {
    fn refused(calibration: Calibration) -> Self {
        Self { calibration, again: None, found: FoundBefore::default() }
    }
}

/// Found by some frames and tested on others; `earlier` is what a look at other frames said.
fn looked_at(
    time_line: &TimeLine,
    fold: Fold,
    known: &FoundBefore,
    earlier: Option<&Earlier>,
    watch: &mut dyn Watch,
) -> Result<LookedAt> {
    report(watch, Stage::Candidates, 0.0)?;
    let split = time_line.split(fold);
    let candidates = time_line.candidates(&split)?;
    if let Some(verdict) = untestable::too_little_motion(&candidates, time_line.busy.len()) {
        return Ok(LookedAt::refused(time_line.refused(verdict, &candidates)));
    }
    let seen = time_line.split_views(split);
    let known = known.without_tested(&seen.split, &time_line.busy);
    let searched = time_line.searched(&seen, &candidates, known, watch)?;
    // As the fitted frames have them, in which those kept aside had no part.
    let solutions = searched.solutions().to_vec();
    let (moved, found) = time_line.refined(&seen, searched, watch)?;
    let seen = moved.unwrap_or(seen);
    let Some(winner) = found.solutions.first() else {
        return Ok(LookedAt::refused(time_line.refused(untestable::no_hypothesis(), &candidates)));
    };
    let case = Case { earlier, ..time_line.case(&seen, &found) };
    let verified = verify(&case, &winner.fundamental, watch)?;
    let again = Earlier::new(&verified, found.fitted);
    let calibration = time_line.calibration(&seen, &candidates, &found, winner, verified);
    let found = FoundBefore { solutions, fitted: seen.split.fitted };
    Ok(LookedAt { calibration, again, found })
}
