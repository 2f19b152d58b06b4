//! The offset before any `F` is known: barcodes of the two cameras correlate at the true shift.

use rayon::prelude::*;

use super::clock::common_frames;
use super::timing::RunnerUp;
use crate::error::{Error, Result};
use crate::matching::mutual_matches;
use crate::recording::{Barcodes, FramePair, Informative, RecordedFrame, Recording, fullest};
use crate::watch::{Stage, Watch, report};

/// What the barcodes say of the offset.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundOffset {
    /// The shift whose best pairs of lines correlate most, frames of B.
    pub offset: f64,
    /// The best shift that is not beside it.
    pub runner_up: Option<RunnerUp>,
    /// Others that may be it, none beside another, best first.
    pub others: Vec<f64>,
    /// How many shifts were tried.
    pub trials: usize,
    /// How well the best pairs of lines agree there: the mean of Fisher's z.
    pub score: f64,
    /// The score without a shift; −∞ where too few frames are common then.
    pub unshifted: f64,
}

/// Lines of each camera with which every shift is tried, and with which the best of those are weighed.
const LINES: [usize; 2] = [700, 2500];
/// How many of the best mutual pairs speak for a shift.
const BEST: usize = 25;
/// Frames of A that take part: those of the busiest stretch of so many.
const FRAMES: usize = 3000;
/// Shifts tried first are this far apart, seconds: less than an object needs to cross a line.
const STEP_SECONDS: f64 = 0.08;
/// Barcodes are not more alike than this: outlines are of pixels.
const MAX_CORRELATION: f64 = 0.98;
/// Shifts within so many seconds of the best are not a different offset.
const APART_SECONDS: f64 = 1.0;
/// Nor do others within so many seconds of each other differ.
const OTHERS_APART_SECONDS: f64 = 0.4;
/// Shifts that may be the offset. Of 47 development pairs it was the best of all in 32, among the best 24 in 41, and among the best 48 in 43.
const PROPOSED: usize = 32;
/// The best of the shifts tried first that are weighed.
const WEIGHED: usize = 48;
/// The best of these that are looked at frame by frame, within so many steps.
const REFINED: usize = 3;
const REFINED_STEPS: i64 = 3;
/// Steps either way: an hour of video has 45,000.
const MOST_TRIED: i64 = 1_000_000;

/// The offset, in frames of B, at which the best barcode correlations stand highest.
///
/// Every few frames with few lines, the best of these with many, and every frame about the best of those. `None`
/// where no shift leaves enough to compare.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn find_offset(
    a: &Recording,
    b: &Recording,
    seconds: f64,
    watch: &mut dyn Watch,
) -> Result<Option<FoundOffset>> {
    find_offset_among(a, b, |_| true, seconds, watch)
}

/// [`find_offset`] by some of A's frames alone.
///
/// # Errors
/// As [`find_offset`].
pub fn find_offset_among(
    a: &Recording,
    b: &Recording,
    of_a: impl Fn(RecordedFrame) -> bool,
    seconds: f64,
    watch: &mut dyn Watch,
) -> Result<Option<FoundOffset>> {
    let rate = 1.0 / b.frame_interval();
    let reach = (seconds * rate).ceil() as i64;
    let searched = reach.min(overlapping(a, b, rate));
    let step = ((STEP_SECONDS * rate) as i64).max(1);
    if searched / step > MOST_TRIED || step > MOST_TRIED {
        return Err(Error::Argument {
            name: "search_seconds",
            value: seconds.to_string(),
            expected: "fewer: with these frame times there are more than a million offsets within it",
        });
    }
    let coarse: Vec<i64> = (-(searched / step)..=searched / step).map(|k| k * step).collect();
    let mut going = |done: f64| report(watch, Stage::TimeOffset, done);
    let taken: Vec<u32> = busiest(a).filter(|&frame| of_a(RecordedFrame(frame))).collect();
    let few = Shifts::new(a, b, &taken, LINES[0]);
    let mut tried = Vec::with_capacity(coarse.len());
    for batch in coarse.chunks(32) {
        going(0.7 * tried.len() as f64 / coarse.len() as f64)?;
        tried.extend(few.scores(batch)?);
    }
    let many = Shifts::new(a, b, &taken, LINES[1]);
    let mut weighed: Vec<(f64, i64)> = Vec::new();
    for batch in best(&tried, WEIGHED).chunks(8) {
        going(0.7 + 0.2 * weighed.len() as f64 / WEIGHED as f64)?;
        weighed.extend(many.scores(batch)?);
    }
    going(0.9)?;
    let known: Vec<i64> = weighed.iter().map(|(_, s)| *s).collect();
    let near = best(&weighed, REFINED).into_iter().flat_map(|s| {
        let within = REFINED_STEPS * step;
        (s - within..=s + within).filter(|t| t.abs() <= reach && !known.contains(t))
    });
    let mut near: Vec<i64> = near.collect();
    near.sort_unstable();
    near.dedup();
    weighed.extend(many.scores(&near)?);

    let Some(&offset) = best(&weighed, 1).first() else { return Ok(None) };
    let score_of =
        |shift: i64| weighed.iter().find(|(_, s)| *s == shift).map_or(f64::NAN, |(score, _)| *score);
    let apart = (APART_SECONDS * rate).ceil() as i64;
    let others: Vec<(f64, i64)> =
        weighed.iter().copied().filter(|(_, s)| (s - offset).abs() > apart).collect();
    let runner_up = best(&others, 1)
        .first()
        .map(|&s| RunnerUp { offset: s as f64, share: score_of(s) / score_of(offset) });
    Ok(Some(FoundOffset {
        offset: offset as f64,
        runner_up,
        others: others_apart(offset, [&weighed, &tried], OTHERS_APART_SECONDS * rate),
        trials: 2 * searched as usize + 1,
        score: score_of(offset),
        unshifted: many.score(0)?,
    }))
}

/// The best shifts beside an offset, of each list in turn, of which none is as near as `apart` to another.
fn others_apart(offset: i64, scored: [&[(f64, i64)]; 2], apart: f64) -> Vec<f64> {
    let mut kept = vec![offset];
    for shift in scored.into_iter().flat_map(|list| best(list, list.len())) {
        if kept.len() >= PROPOSED {
            break;
        }
        if kept.iter().all(|k| (k - shift).abs() as f64 > apart) {
            kept.push(shift);
        }
    }
    kept[1..].iter().map(|&shift| shift as f64).collect()
}

/// How well the best pairs of lines agree at an offset, frames of B, as [`FoundOffset::score`]; −∞ where too few frames are
/// common.
///
/// # Errors
/// None that input can cause.
pub fn score_at_offset(a: &Recording, b: &Recording, offset: f64) -> Result<f64> {
    let taken: Vec<u32> = busiest(a).collect();
    Shifts::new(a, b, &taken, LINES[1]).score_at(offset)
}

/// The largest shift either way at which the recordings overlap, frames of B.
fn overlapping(a: &Recording, b: &Recording, rate: f64) -> i64 {
    let duration = a.times[a.frames() - 1] - a.times[0];
    ((duration * rate).ceil() as i64).saturating_add(1).max(b.frames() as i64)
}

/// The shifts with the highest finite scores, best first; of equals the smaller.
fn best(scored: &[(f64, i64)], count: usize) -> Vec<i64> {
    let mut sorted: Vec<_> = scored.iter().filter(|(score, _)| score.is_finite()).collect();
    sorted.sort_by(|p, q| q.0.total_cmp(&p.0).then(p.1.abs().cmp(&q.1.abs())).then(p.1.cmp(&q.1)));
    sorted.into_iter().take(count).map(|(_, shift)| *shift).collect()
}

/// What every shift is scored with.
struct Shifts<'a> {
    a: &'a Recording,
    b: &'a Recording,
    lines_a: Barcodes,
    lines_b: Barcodes,
    /// Frames of A that take part, in their order.
    taken: &'a [u32],
}

impl<'a> Shifts<'a> {
    fn new(a: &'a Recording, b: &'a Recording, taken: &'a [u32], lines: usize) -> Self {
        let rows_a = a.informative_lines(taken.iter().copied());
        let rows_b = b.informative_lines(0..b.frames() as u32);
        Self { a, b, lines_a: thinned(a, rows_a, lines), lines_b: thinned(b, rows_b, lines), taken }
    }

    fn scores(&self, shifts: &[i64]) -> Result<Vec<(f64, i64)>> {
        shifts.par_iter().map(|&shift| Ok((self.score(shift)?, shift))).collect()
    }

    /// How well the best pairs of lines agree at a shift; −∞ where too few frames are common.
    ///
    /// The mean of Fisher's z. What a line sees between two changes is one observation, however many frames it lasts:
    /// a pair of lines that change but seldom, or a short overlap, correlates by chance.
    fn score(&self, shift: i64) -> Result<f64> {
        self.score_at(shift as f64)
    }

    fn score_at(&self, offset: f64) -> Result<f64> {
        let mut pairs = common_frames(self.a, self.b, offset);
        pairs.retain(|p| self.taken.binary_search(&p.a.0).is_ok());
        // Of a camera that films faster each frame of the other has one.
        let slower = (self.a.frame_interval() / self.b.frame_interval()).min(1.0);
        let most = (self.taken.len() as f64 * slower) as usize;
        let least = (most.min(self.b.frames()) / 3).max(16);
        if pairs.len() < least {
            return Ok(f64::NEG_INFINITY);
        }
        let [frames_a, frames_b] = FramePair::indices(&pairs);
        let (bits_a, changes_a) = informative(&self.lines_a, &frames_a);
        let (bits_b, changes_b) = informative(&self.lines_b, &frames_b);
        let mut z: Vec<f64> = mutual_matches(&bits_a, &bits_b, 1)?
            .into_iter()
            .map(|m| {
                let changes = changes_a[m.a as usize].min(changes_b[m.b as usize]);
                let observations = f64::from(changes.saturating_sub(3));
                f64::from(m.correlation).min(MAX_CORRELATION).atanh() * observations.sqrt()
            })
            .collect();
        z.sort_by(|p, q| q.total_cmp(p));
        Ok(z.iter().take(BEST).sum::<f64>() / BEST as f64)
    }
}

/// Those lines that are informative over some frames, over these frames, and how often each changes.
fn informative(lines: &Barcodes, frames: &[u32]) -> (Barcodes, Vec<u32>) {
    let bits = lines.select_frames(frames);
    let bits = bits.select_rows(&bits.informative(&Informative::default()));
    let changes = (0..bits.count).map(|i| bits.transitions(i)).collect();
    (bits, changes)
}

/// Some of a recording's lines, thinned evenly.
fn thinned(recording: &Recording, rows: Vec<u32>, limit: usize) -> Barcodes {
    let step = rows.len().div_ceil(limit).max(1);
    recording.barcodes.select_rows(&rows.into_iter().step_by(step).collect::<Vec<_>>())
}

/// The stretch of at most [`FRAMES`] frames in which most frames show something that moves.
fn busiest(recording: &Recording) -> std::ops::Range<u32> {
    let busy: Vec<bool> =
        (0..recording.frames() as u32).map(|frame| recording.shows(RecordedFrame(frame))).collect();
    let found = fullest(&busy, FRAMES, 0);
    found.start as u32..found.end as u32
}
