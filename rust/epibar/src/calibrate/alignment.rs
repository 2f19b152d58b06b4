//! Which frame of A is which frame of B.

use rayon::prelude::*;

use crate::estimate::ransac::Watch;
use crate::matching::mutual_matches;
use crate::recording::{Barcodes, Informative, Recording};
use crate::{Error, Result};

/// The offset between the cameras' frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimeOffset {
    /// Frame `i` of A is frame `i + offset` of B.
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

/// Pairs (frame of A, frame of B) that show the same moment.
///
/// Both recordings count time from their own first frame; `offset`, in frames of B, is where A's first frame
/// falls in B. Different frame rates meet through the frame times: each frame of A takes the nearest frame of B, if
/// that lies within 0.6 of the shorter frame interval.
pub fn common_frames(a: &Recording, b: &Recording, offset: f64) -> Vec<(u32, u32)> {
    if a.times.is_empty() || b.times.is_empty() {
        return Vec::new();
    }
    let interval = |r: &Recording| {
        let rate = r.frame_rate();
        if rate.is_finite() { 1.0 / rate } else { 1.0 }
    };
    let (step_a, step_b) = (interval(a), interval(b));
    let tolerance = 0.6 * step_a.min(step_b);
    let same_rate = (step_a / step_b - 1.0).abs() < 1e-4 && is_regular(a, step_a) && is_regular(b, step_b);
    let mut next = 0;
    let mut pairs = Vec::new();
    for (i, time) in a.times.iter().enumerate() {
        // Equal rates go by index, so that rounded time stamps cannot slip a frame.
        if same_rate {
            let j = (i as f64 + offset).round();
            if j >= 0.0 && j < b.frames() as f64 {
                pairs.push((i as u32, j as u32));
            }
            continue;
        }
        let target = time - a.times[0] + offset * step_b + b.times[0];
        while next + 1 < b.frames() && (b.times[next + 1] - target).abs() <= (b.times[next] - target).abs() {
            next += 1;
        }
        if (b.times[next] - target).abs() <= tolerance {
            pairs.push((i as u32, next as u32));
        }
    }
    pairs
}

/// Whether no frame is missing: every step is within half of the usual one.
fn is_regular(recording: &Recording, step: f64) -> bool {
    recording.times.windows(2).all(|t| ((t[1] - t[0]) / step - 1.0).abs() < 0.5)
}

/// Lines of each camera that take part in the search for the offset.
const LINES: usize = 700;
/// How many of the best mutual pairs speak for a shift.
const BEST: usize = 25;

/// The offset, in frames of B, whose best barcode correlations stand highest (DESIGN §7).
///
/// # Errors
/// [`Error::Interrupted`].
pub fn search_offset(a: &Recording, b: &Recording, seconds: f64, watch: &mut dyn Watch) -> Result<f64> {
    let rate = b.frame_rate();
    let rate = if rate.is_finite() { rate } else { 1.0 };
    let reach = (seconds * rate).ceil() as i64;
    let few = |r: &Recording| -> Barcodes {
        let rows = r.barcodes.informative(&Informative::default());
        let step = rows.len().div_ceil(LINES).max(1);
        r.barcodes.select_rows(&rows.into_iter().step_by(step).collect::<Vec<_>>())
    };
    let (lines_a, lines_b) = (few(a), few(b));
    let least = (a.frames().min(b.frames()) / 3).max(16);
    let mut best: Option<(f64, i64)> = None;
    let shifts: Vec<i64> = (-reach..=reach).collect();
    for (done, batch) in shifts.chunks(32).enumerate() {
        if !watch.keep_going("time offset", done as f64 * 32.0 / shifts.len() as f64) {
            return Err(Error::Interrupted);
        }
        let scored: Vec<Option<(f64, i64)>> = batch
            .par_iter()
            .map(|&shift| {
                let pairs = common_frames(a, b, shift as f64);
                if pairs.len() < least {
                    return Ok(None);
                }
                let bits_a = lines_a.select_frames(&pairs.iter().map(|p| p.0).collect::<Vec<_>>());
                let bits_b = lines_b.select_frames(&pairs.iter().map(|p| p.1).collect::<Vec<_>>());
                let matches = mutual_matches(&bits_a, &bits_b, 1, BEST)?;
                let sum: f64 = matches.iter().map(|m| f64::from(m.correlation)).sum();
                // Fisher's z, weighed by the frames behind it: a short overlap correlates by chance.
                let mean = (sum / BEST as f64).min(0.999);
                Ok(Some((mean.atanh() * (pairs.len() as f64).sqrt(), shift)))
            })
            .collect::<Result<_>>()?;
        for (score, shift) in scored.into_iter().flatten() {
            if best.is_none_or(|(most, _)| score > most) {
                best = Some((score, shift));
            }
        }
    }
    Ok(best.map_or(0.0, |(_, shift)| shift as f64))
}
