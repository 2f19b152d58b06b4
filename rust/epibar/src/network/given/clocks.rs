//! The clocks of all cameras, before any geometry is known.
//!
//! Clocks belong to cameras, not to pairs: an offset each, so that they agree round every cycle. For some pairs the offset is
//! found from barcodes, with now and then a wrong one among them; three cameras whose offsets add up to nought vouch for
//! each other.

use rayon::prelude::*;

pub use super::clock_pairs::PairOffset;
use super::clock_pairs::{asked, asked_beyond, unvouched};
use crate::calibrate::{OutstandingOffset, outstanding_offset};
use crate::clock::offset::FoundOffset;
use crate::clock::{Clocks, TimeOffset, find_offset, score_at_offset};
use crate::error::Result;
use crate::network::model::beliefs::Belief;
use crate::network::thresholds as limits;
use crate::options::CalibrateOptions;
use crate::recording::Recording;
use crate::watch::{Stage, Unwatched, Watch, report};

/// No clock is wrong by a tenth, ppm.
pub const MOST_DRIFT: f64 = 1e5;

/// A search starts from a found offset rounded to this, seconds, which it sharpens anyway: so it is the same one though one more camera
/// moved all offsets by a millisecond.
pub const GRID: f64 = 0.04;

/// Offsets of all cameras.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Offsets {
    /// For each camera: what is at `t` in the first camera is at `t + seconds` in this one; NaN where nothing tells.
    pub seconds: Vec<f64>,
    /// All cameras started together, as far as barcodes tell.
    pub together: bool,
    /// The offsets were given, and are not solved for.
    pub given: bool,
}

impl Offsets {
    /// Found offsets, seconds, to a frame or two.
    pub fn found(seconds: Vec<f64>) -> Self {
        Self { seconds, together: false, given: false }
    }

    /// Given offsets, seconds.
    pub fn given(seconds: Vec<f64>) -> Self {
        Self { seconds, together: false, given: true }
    }

    /// Where the first frame of a camera falls in another, frames of that one, to start a search from.
    pub(in crate::network) fn frames_between(&self, a: usize, b: usize, of_b: &Recording) -> TimeOffset {
        let seconds = self.seconds[b] - self.seconds[a];
        if self.given || self.together {
            TimeOffset::Known(seconds / of_b.frame_interval())
        } else {
            TimeOffset::About((seconds / GRID).round_ties_even() * GRID / of_b.frame_interval())
        }
    }

    /// Whether two cameras filmed at the same time for a while, as far as is known.
    pub(in crate::network) fn overlap(&self, a: usize, b: usize, of_a: &Recording, of_b: &Recording) -> bool {
        let between = self.seconds[b] - self.seconds[a];
        let length = |times: &[f64]| times[times.len() - 1] - times[0];
        (-length(of_a.times())..=length(of_b.times())).contains(&between)
    }

    /// What is believed of the offset and the drift of a camera's clock; the first one's is the network's, and has no error.
    pub(in crate::network) fn beliefs(&self, camera: usize) -> [Belief; 2] {
        let seconds = self.seconds[camera];
        let [offset, drift] = if self.given || camera == 0 {
            [0.0; 2]
        } else {
            [if self.together { limits::CLOCK_TOGETHER } else { limits::CLOCK_FOUND }, limits::DRIFT]
        };
        [Belief::about(if seconds.is_finite() { seconds } else { 0.0 }, offset), Belief::about(0.0, drift)]
    }
}

/// What an offset weighs whose runner-up has nothing of its score, and one whose runner-up has all.
const CLEAR: f64 = 1.05;
const UNCLEAR: f64 = 0.05;
/// What it weighs where it closes no triangle, against 1 more for each that it closes.
const ALONE: f64 = 0.2;
/// Rounds of taking means.
const ROUNDS: usize = 20;

/// What the barcodes of two recordings say of their clocks.
fn by_barcodes(f: &FoundOffset, [a, b]: [usize; 2], interval: f64) -> PairOffset {
    PairOffset {
        a,
        b,
        seconds: f.offset * interval,
        score: f.score,
        unshifted: f.unshifted,
        runner_up: f.runner_up.map_or(0.0, |r| r.share),
    }
}

/// The offset of a pair at which a geometry stands out among those that barcodes propose, if one does.
fn by_geometry(
    recordings: [&Recording; 2],
    found: &FoundOffset,
    said: PairOffset,
    watch: &mut dyn Watch,
) -> Result<PairOffset> {
    let clocks = Clocks::from_found(recordings[0], recordings[1], found.clone(), true)?;
    let outstanding = outstanding_offset(&clocks, &CalibrateOptions::new(), watch)?;
    Ok(outstanding.map_or(said, |OutstandingOffset { offset, runner_up, .. }| {
        let seconds = offset * recordings[1].frame_interval();
        // Where both say the same, the clearer of the two.
        let runner_up = if offset == found.offset { said.runner_up.min(runner_up) } else { runner_up };
        PairOffset { seconds, runner_up, ..said }
    }))
}

/// Offsets of pairs: those asked for by [`asked`], and more where these leave cameras that nothing vouches for; of few cameras those pairs for which nothing
/// vouches are asked for a geometry that stands out.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn pair_offsets(
    recordings: &[&Recording],
    seconds: f64,
    watch: &mut dyn Watch,
) -> Result<Vec<PairOffset>> {
    let count = recordings.len();
    let of = |&(a, b): &(usize, usize)| {
        let found = find_offset(recordings[a], recordings[b], seconds, &mut Unwatched)?;
        let interval = recordings[b].frame_interval();
        Ok(found.map(|found| (by_barcodes(&found, [a, b], interval), found)))
    };
    let (mut found, mut proposed) = (Vec::new(), Vec::new());
    for beyond in [false, true] {
        let pairs = match beyond {
            false => asked(count),
            // Cameras that have nothing in common, in two halls say, would outvote those that started together.
            true if started_together(count, &found) => Vec::new(),
            true => asked_beyond(count, &found),
        };
        // The second half may have nothing to do.
        let before = if beyond { 0.5 } else { 0.0 };
        for (i, chunk) in pairs.chunks(4).enumerate() {
            report(watch, Stage::TimeOffset, before + 0.5 * 4.0 * i as f64 / pairs.len() as f64)?;
            for (offset, of_pair) in
                chunk.par_iter().map(of).collect::<Result<Vec<_>>>()?.into_iter().flatten()
            {
                found.push(offset);
                proposed.push(of_pair);
            }
        }
    }
    if started_together(count, &found) {
        return Ok(found);
    }
    let open = unvouched(count, &found);
    for (k, &i) in open.iter().enumerate() {
        let PairOffset { a, b, .. } = found[i];
        let mut of_all =
            |stage, done| watch.keep_going(stage, 0.5 + 0.5 * (k as f64 + done) / open.len() as f64);
        found[i] = by_geometry([recordings[a], recordings[b]], &proposed[i], found[i], &mut of_all)?;
    }
    Ok(found)
}

/// How well two recordings agree at known offsets of their clocks: how likely they are to show the same.
///
/// # Errors
/// None that input can cause.
pub fn likeness(a: &Recording, b: &Recording, seconds: f64) -> Result<f64> {
    score_at_offset(a, b, seconds / b.frame_interval())
}

/// One offset a camera from those of pairs.
pub fn agreed(count: usize, pairs: &[PairOffset]) -> Offsets {
    if started_together(count, pairs) {
        return Offsets { seconds: vec![0.0; count], together: true, given: false };
    }
    let between = |a: usize, b: usize| {
        pairs.iter().find_map(|p| match (p.a, p.b) {
            pair if pair == (a, b) => Some(p.seconds),
            pair if pair == (b, a) => Some(-p.seconds),
            _ => None,
        })
    };
    // A pair counts by how clear it is by itself, and the more the more triangles it closes.
    let weight = |p: &PairOffset| {
        let closes = |c: usize| match (between(p.a, c), between(c, p.b)) {
            (Some(there), Some(on)) => (there + on - p.seconds).abs() < limits::OFFSETS_AGREE,
            _ => false,
        };
        let triangles = (0..count).filter(|&c| c != p.a && c != p.b && closes(c)).count();
        p.score.max(0.0) * (CLEAR - p.runner_up).max(UNCLEAR) * (ALONE + triangles as f64)
    };
    let mut order: Vec<(f64, &PairOffset)> = pairs.iter().map(|p| (weight(p), p)).collect();
    order.sort_by(|p, q| q.0.total_cmp(&p.0).then((p.1.a, p.1.b).cmp(&(q.1.a, q.1.b))));
    let mut seconds = spanning(count, &order);
    // The mean of all that agree, a few times over.
    for _ in 0..ROUNDS {
        for camera in 1..count {
            let said: Vec<(f64, f64)> = order
                .iter()
                .filter_map(|(weight, p)| {
                    let from = |other: usize, by: f64| Some((seconds[other] + by, *weight));
                    let said = match camera {
                        c if c == p.b => from(p.a, p.seconds),
                        c if c == p.a => from(p.b, -p.seconds),
                        _ => None,
                    }?;
                    ((said.0 - seconds[camera]).abs() < limits::OFFSETS_AGREE).then_some(said)
                })
                .collect();
            let all: f64 = said.iter().map(|s| s.1).sum();
            if all > 0.0 {
                seconds[camera] = said.iter().map(|s| s.0 * s.1).sum::<f64>() / all;
            }
        }
    }
    Offsets { seconds, together: false, given: false }
}

/// Whether a pair agrees without an offset about as well as with the best.
fn says_together(p: &PairOffset) -> bool {
    p.seconds.abs() < limits::NO_OFFSET || p.unshifted >= limits::NO_OFFSET_SHARE * p.score
}

/// Whether most pairs agree without an offset about as well as with the best, and no camera's pairs have one in common.
fn started_together(count: usize, pairs: &[PairOffset]) -> bool {
    let together = pairs.iter().filter(|p| says_together(p)).count() as f64;
    !pairs.is_empty()
        && together >= limits::NO_OFFSET_PAIRS * pairs.len() as f64
        && !(0..count).any(|camera| started_apart(camera, pairs))
}

/// Whether most pairs of a camera agree on one offset that is not nought: it alone was started at another time.
fn started_apart(camera: usize, pairs: &[PairOffset]) -> bool {
    let own = || pairs.iter().filter(|p| p.a == camera || p.b == camera);
    let apart = own().filter(|p| !says_together(p));
    let offsets: Vec<f64> = apart.map(|p| if p.b == camera { p.seconds } else { -p.seconds }).collect();
    let agreeing = |at: f64| offsets.iter().filter(|s| (*s - at).abs() < limits::OFFSETS_AGREE).count();
    let most = offsets.iter().map(|&at| agreeing(at)).max().unwrap_or(0);
    most >= 2 && 2 * most > own().count()
}

/// Offsets along the tree of the heaviest pairs; NaN where none leads to the first camera.
fn spanning(count: usize, order: &[(f64, &PairOffset)]) -> Vec<f64> {
    let mut group: Vec<usize> = (0..count).collect();
    let mut seconds = vec![0.0; count];
    for (_, p) in order {
        let (one, other) = (group[p.a], group[p.b]);
        if one == other {
            continue;
        }
        let shift = seconds[p.a] + p.seconds - seconds[p.b];
        for camera in 0..count {
            if group[camera] == other {
                group[camera] = one;
                seconds[camera] += shift;
            }
        }
    }
    let (first, start) = (group[0], seconds[0]);
    (0..count).map(|c| if group[c] == first { seconds[c] - start } else { f64::NAN }).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn offsets(truth: &[f64], wrong: &[(usize, usize, f64)]) -> Vec<PairOffset> {
        asked(truth.len())
            .into_iter()
            .map(|(a, b)| {
                let lie = wrong.iter().find(|w| (w.0, w.1) == (a, b)).map(|w| w.2);
                let noise = 0.02 * (((a * 7 + b * 3) % 5) as f64 - 2.0);
                PairOffset {
                    a,
                    b,
                    seconds: lie.unwrap_or(truth[b] - truth[a] + noise),
                    score: if lie.is_some() { 6.0 } else { 5.0 },
                    unshifted: 1.0,
                    runner_up: 0.5,
                }
            })
            .collect()
    }

    #[test]
    fn cycles_outvote_wrong_pairs() {
        for count in [3, 4, 6, 9, 20] {
            let truth: Vec<f64> =
                (0..count).map(|c| if c == 0 { 0.0 } else { 3.7 * c as f64 - 11.0 }).collect();
            let all: &[(usize, usize, f64)] = &[(0, 1, 5.5), (1, 3, -9.0)];
            let wrong = &all[..(count - 3).min(2)];
            let found = agreed(count, &offsets(&truth, wrong));
            for (camera, seconds) in found.seconds.iter().enumerate() {
                assert!(
                    (seconds - truth[camera]).abs() < 0.15,
                    "{count} {camera}: {seconds} {}",
                    truth[camera]
                );
            }
            assert!(!found.together);
        }
    }

    #[test]
    fn cameras_that_started_together_have_no_offset() {
        let truth = vec![0.0; 5];
        let found = agreed(5, &offsets(&truth, &[(0, 3, 7.0)]));
        assert!(found.together && found.seconds.iter().all(|s| *s == 0.0));
    }

    #[test]
    fn a_camera_that_started_apart_from_many_has_its_offset() {
        for (late, count) in [(4, 5), (0, 6), (7, 8)] {
            let mut truth = vec![0.0; count];
            truth[late] = 5.0;
            let mut pairs = offsets(&truth, &[]);
            for p in &mut pairs {
                let clear = p.a == late || p.b == late;
                p.unshifted = if clear { 1.0 } else { p.score };
            }
            let found = agreed(count, &pairs);
            assert!(!found.together, "{count}");
            for (camera, seconds) in found.seconds.iter().enumerate() {
                assert!((seconds - (truth[camera] - truth[0])).abs() < 0.15, "{count} {camera}: {seconds}");
            }
            // One of which every pair says another thing is no such camera.
            for (k, p) in pairs.iter_mut().filter(|p| p.a == late || p.b == late).enumerate() {
                p.seconds = 3.0 * (k + 1) as f64;
            }
            assert!(agreed(count, &pairs).together, "{count}");
        }
    }

    #[test]
    fn a_camera_that_nothing_leads_to_has_none() {
        let pairs: Vec<_> = offsets(&[0.0, 2.0, 5.0, 1.0], &[]).into_iter().filter(|p| p.b != 3).collect();
        let found = agreed(4, &pairs);
        assert!(found.seconds[3].is_nan() && (found.seconds[2] - 5.0).abs() < 0.1);
        assert!(agreed(3, &[]).seconds[0] == 0.0);
    }
}
