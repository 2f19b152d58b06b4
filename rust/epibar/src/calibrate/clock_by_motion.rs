//! Whether what moves tells the clock that an accepted geometry was found with.

use crate::calibration::Calibration;
use crate::clock::Clocks;
use crate::options::CalibrateOptions;
use crate::verify::other_clocks::{OtherClock, other_clocks};
use crate::verify::thresholds::{CLOCK_BETTER, reaches};

/// An accepted geometry, unless what moves does not tell the clock that it was found with; and an offset that is clearly better.
pub(super) fn found_clock_by_motion(
    found: Calibration,
    clocks: &Clocks,
    options: &CalibrateOptions,
) -> (Calibration, Option<f64>) {
    let others = clocks_beside(&found, clocks, options);
    let best = others.iter().max_by(|p, q| p.share.total_cmp(&q.share));
    let better =
        best.filter(|o| reaches(o.share, CLOCK_BETTER)).map(|o| clocks.later(o.later).clock().offset);
    let open = others.iter().filter(|o| o.is_open(options.max_expected_error));
    match open.max_by(|p, q| p.distance.total_cmp(&q.distance)) {
        Some(other) => (Calibration { verdict: other.verdict(clocks.frame_interval()), ..found }, better),
        None => (found, better),
    }
}

/// An accepted geometry, unless another clock than the one that was given explains clearly more; where one explains as much it is said.
pub(super) fn given_clock_by_motion(
    found: Calibration,
    clocks: &Clocks,
    options: &CalibrateOptions,
) -> Calibration {
    let (limit, frame_interval) = (options.max_expected_error, clocks.frame_interval());
    let others = clocks_beside(&found, clocks, options);
    let better = others.iter().filter(|o| o.is_better(limit)).max_by(|p, q| p.gain.total_cmp(&q.gain));
    if let Some(other) = better {
        return Calibration { verdict: other.verdict_of_given(frame_interval), ..found };
    }
    let open = others.iter().filter(|o| o.is_open(limit));
    match open.max_by(|p, q| p.distance.total_cmp(&q.distance)) {
        Some(other) => {
            let verdict = found.verdict.with_remark(&other.remark_on_given(frame_interval));
            Calibration { verdict, ..found }
        }
        None => found,
    }
}

/// Other clocks under which a geometry of its own explains most of what an accepted one does.
fn clocks_beside(found: &Calibration, clocks: &Clocks, options: &CalibrateOptions) -> Vec<OtherClock> {
    let Some(f) = found.fundamental.filter(|_| found.accepted()) else { return Vec::new() };
    other_clocks(|frames| clocks.later(frames), &f, options.cameras_used(), options.seed)
}
