//! Which of the offsets that barcodes propose is the one: that at which a geometry stands out.
//!
//! The best barcodes of two cameras are alike by chance at many offsets where much moves, or little for long. Tangents are not: at the true
//! offset some geometry explains several times as much of them as any does at another. So where none stands out at the offset for which barcodes
//! speak most, a few hypotheses are looked at at each of the others ([`brief_search`]).

use crate::clock::{Aligned, Clocks};
use crate::error::Result;
use crate::frontier::busy_frames;
use crate::matching::find_candidates;
use crate::options::CalibrateOptions;
use crate::recording::FramePair;
use crate::search::{TrainingSet, brief_options, brief_search};
use crate::verify::thresholds::{STANDS_OUT, STANDS_OUT_OF_ALL, SURE, reaches, within};
use crate::watch::{Stage, Unwatched, Watch, report};

/// Fewest frames in which both cameras see something.
const LEAST_BUSY: usize = 40;
/// What was proposed is so many steps of so many seconds from the offset at the most: less than an object needs to cross a line.
const STEP_SECONDS: f64 = 0.08;
const MOST_STEPS: usize = 4;
/// So many offsets are compared at least before one stands out.
const COMPARED: usize = 5;

/// An offset at which a geometry stands out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutstandingOffset {
    /// Frames of B.
    pub offset: f64,
    /// Score of a tangent of the best geometry there.
    pub score: f64,
    /// What the best geometry explains at the next best of the offsets that were looked at, as a share of what this one does; 0 where it needs no comparison.
    pub runner_up: f64,
}

/// The offset at which the best geometry explains clearly more than at any other, of those proposed; `None` where none does.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn outstanding_offset(
    clocks: &Clocks,
    options: &CalibrateOptions,
    watch: &mut dyn Watch,
) -> Result<Option<OutstandingOffset>> {
    let proposed = clocks.proposed();
    let mut seen: Vec<(f64, f64)> = Vec::with_capacity(proposed.len());
    for (k, &offset) in proposed.iter().enumerate() {
        report(watch, Stage::TimeOffset, k as f64 / proposed.len() as f64)?;
        seen.push((of_tangent(&clocks.proposal(offset), options)?, offset));
        let enough =
            reaches(seen[k].0, SURE) || k + 1 >= COMPARED && outstanding(&seen, STANDS_OUT).is_some();
        if enough {
            break;
        }
    }
    let Some(found) = outstanding(&seen, STANDS_OUT_OF_ALL) else { return Ok(None) };
    // Barcodes were compared frame by frame about the first alone.
    if found.offset == proposed[0] {
        Ok(Some(found))
    } else {
        climbed(clocks, options, found, watch).map(Some)
    }
}

/// Step by step to where the best geometry explains most.
fn climbed(
    clocks: &Clocks,
    options: &CalibrateOptions,
    mut found: OutstandingOffset,
    watch: &mut dyn Watch,
) -> Result<OutstandingOffset> {
    let step = (STEP_SECONDS / clocks.frame_interval()).floor().max(1.0);
    for side in [-step, step] {
        for _ in 0..MOST_STEPS {
            report(watch, Stage::TimeOffset, 1.0)?;
            let offset = found.offset + side;
            let score = of_tangent(&clocks.proposal(offset), options)?;
            if score.is_nan() || score <= found.score {
                break;
            }
            (found.offset, found.score) = (offset, score);
        }
    }
    Ok(found)
}

/// The best of several, if it is sure by itself, or has so much that the next has no more than a share of it.
fn outstanding(seen: &[(f64, f64)], [least, share]: [f64; 2]) -> Option<OutstandingOffset> {
    let mut seen = seen.to_vec();
    seen.sort_by(|p, q| q.0.total_cmp(&p.0));
    let &(score, offset) = seen.first()?;
    let next = seen.get(1).map_or(0.0, |&(score, _)| score.max(0.0));
    let runner_up = next / score;
    let stands_out = seen.len() > 1 && reaches(score, least) && within(runner_up, share);
    (stands_out || reaches(score, SURE)).then_some(OutstandingOffset { offset, score, runner_up })
}

/// Score of a tangent of the best geometry of a brief search.
fn of_tangent(aligned: &Aligned, options: &CalibrateOptions) -> Result<f64> {
    let (a, b) = (aligned.a(), aligned.b());
    let common = aligned.frame_pairs();
    let busy = busy_frames(a, b, &common, None);
    if busy.len() < LEAST_BUSY {
        return Ok(0.0);
    }
    let candidates = find_candidates(a, b, &common, &common, &options.candidate_options())?;
    let views = |frames: &[FramePair]| aligned.views(frames).with_cameras(options.cameras_used());
    let (all, some) = (views(&busy), |limit| views(&busy_frames(a, b, &busy, Some(limit))));
    let training = TrainingSet::new(&all, some, brief_options(options.seed));
    brief_search(&training, &candidates, &mut Unwatched)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(scores: &[f64], limits: [f64; 2]) -> Option<(f64, f64)> {
        let seen: Vec<(f64, f64)> = scores.iter().enumerate().map(|(k, &s)| (s, k as f64)).collect();
        outstanding(&seen, limits).map(|o| (o.offset, (100.0 * o.runner_up).round()))
    }

    #[test]
    fn what_stands_out_has_clearly_more_than_the_next() {
        assert_eq!(found(&[0.1, 0.3, 0.05], STANDS_OUT), Some((1.0, 33.0)));
        assert_eq!(found(&[0.14, 0.3, 0.05], STANDS_OUT), None);
        assert_eq!(found(&[0.14, 0.3, 0.05], STANDS_OUT_OF_ALL), Some((1.0, 47.0)));
        assert_eq!(found(&[0.21, 0.3], STANDS_OUT_OF_ALL), None);
        assert_eq!(found(&[0.07, 0.01], STANDS_OUT_OF_ALL), None);
        assert_eq!(found(&[-0.2, 0.2], STANDS_OUT_OF_ALL), Some((1.0, 0.0)));
        // One alone is compared with nothing.
        assert_eq!([found(&[0.4], STANDS_OUT_OF_ALL), found(&[0.9], STANDS_OUT)], [None, Some((0.0, 0.0))]);
        assert_eq!([found(&[], STANDS_OUT), found(&[f64::NAN, 0.1], STANDS_OUT_OF_ALL)], [None; 2]);
        assert_eq!(found(&[-0.1, -0.2], STANDS_OUT_OF_ALL), None);
    }
}
