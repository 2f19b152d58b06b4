//! Which frames are fitted to, which test the fit, and which lie between.
//!
//! Who walks where the fitted frames end walks on into the next ones, so that a geometry which fits the former by
//! chance fits the latter for a while as well. A gap of the time for which motion stays where it is keeps the two apart:
//! its frames belong to neither. Where those that are kept aside show too little to decide, [`Fold::Second`] keeps others aside.

use std::ops::Range;

use crate::geometry::median::median;
use crate::recording::{Barcodes, FramePair, Recording};

/// Share of the frames that test.
const TESTED: f64 = 0.2;
/// Stretches of frames that test, where the recording is long enough for the gaps between them.
const STRETCHES: usize = 3;
/// Largest share of the frames in all gaps together; a single gap may take as much where motion is slower than that.
const GAPS: f64 = 0.15;

/// Which frames are kept aside: none of the one are of the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fold {
    /// The end of each stretch of the recording.
    First,
    /// What lies half way between them.
    Second,
}

/// Common frames, divided.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Split {
    /// Common frames that may be fitted to.
    pub fitted: Vec<FramePair>,
    /// Frames that may be fitted to and in which both cameras see something.
    pub fitted_busy: Vec<FramePair>,
    /// Stretches of the busy frames that test.
    pub tested: Vec<Range<usize>>,
    /// Common frames that at least lie between a fitted frame and a tested one.
    pub gap: usize,
    /// Busy frames, one after the other, for which motion stays where it is; no more of them than gaps may have.
    pub stay: usize,
}

impl Split {
    /// Divides `common` frames, of which `busy` are some, in the same order.
    pub fn new(common: &[FramePair], busy: &[FramePair], stay: Stay, fold: Fold) -> Self {
        let of_gaps = |frames: &[FramePair]| (GAPS * frames.len() as f64) as usize;
        let (n, most) = (busy.len(), of_gaps(common));
        let gap = stay.common.clamp(1, most.max(1));
        let stay = stay.busy.clamp(1, of_gaps(busy).max(1));
        // The last stretch ends the recording, so that k stretches have 2k − 1 seams.
        let stretches = (1..=STRETCHES).rev().find(|k| (2 * k - 1) * gap <= most).unwrap_or(1);
        let length = (TESTED * n as f64 / stretches as f64) as usize;
        let halves = |k: usize| if fold == Fold::First { 2 * k } else { 2 * k - 1 };
        let ends = (1..=stretches).map(|k| halves(k) * n / (2 * stretches));
        let tested: Vec<_> = ends.map(|end| end - length..end).filter(|r| !r.is_empty()).collect();
        // By place among the common frames: where no frame is busy time passes as well.
        let place = |i: usize| common.partition_point(|p| p.a < busy[i].a);
        let closed: Vec<_> = tested.iter().map(|r| (place(r.start), place(r.end - 1))).collect();
        let free = |&i: &usize| closed.iter().all(|&(first, last)| i + gap < first || i > last + gap);
        let fitted: Vec<_> = (0..common.len()).filter(free).map(|i| common[i]).collect();
        let fitted_busy = busy.iter().copied().filter(|p| fitted.binary_search(p).is_ok()).collect();
        Self { fitted, fitted_busy, tested, gap, stay }
    }
}

/// Lines of each camera that say how long motion stays.
const LINES: usize = 300;
/// Motion has left where barcodes correlate with their own past by less than this.
const LEFT: f64 = 0.2;

/// For how many frames motion stays where it is: the time after which the barcodes of either camera no longer resemble themselves.
/// Whether anybody is there says nothing of that, so it is asked of frames in which something moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stay {
    /// Busy frames, one after the other.
    pub busy: usize,
    /// As many in common frames.
    pub common: usize,
}

impl Stay {
    /// Of the `busy` ones among `common` frames.
    pub fn new(a: &Recording, b: &Recording, common: &[FramePair], busy: &[FramePair]) -> Self {
        let [frames_a, frames_b] = FramePair::indices(busy);
        let stay = stay_in(a, &frames_a).max(stay_in(b, &frames_b));
        Self { busy: stay, common: in_common_frames(stay, common, busy) }
    }
}

/// As many busy frames in common ones: the median over the recording, as others may lie between them.
fn in_common_frames(stay: usize, common: &[FramePair], busy: &[FramePair]) -> usize {
    let place = |i: usize| common.partition_point(|p| p.a < busy[i].a);
    let spans = (0..busy.len().saturating_sub(stay)).map(|i| (place(i + stay) - place(i)) as f64);
    median(spans).map_or(stay, |span| stay.max(span as usize))
}

/// Barcodes over some frames of some lines on which things move in those of the frames in which anything does.
pub(super) fn moving_lines(recording: &Recording, frames: &[u32]) -> Barcodes {
    let rows = recording.informative_lines(frames.iter().copied());
    let step = rows.len().div_ceil(LINES).max(1);
    let some: Vec<u32> = rows.into_iter().step_by(step).collect();
    recording.barcodes.select_rows(&some).select_frames(frames)
}

fn stay_in(recording: &Recording, frames: &[u32]) -> usize {
    let barcodes = moving_lines(recording, frames);
    let most = frames.len() / 2;
    (1..most).find(|&lag| autocorrelation(&barcodes, lag) < LEFT).unwrap_or(most)
}

/// Correlation of all barcodes with themselves `lag` frames later, about the mean of each; 0 where nothing changes.
pub(super) fn autocorrelation(barcodes: &Barcodes, lag: usize) -> f64 {
    correlation(barcodes, lag, (barcodes.frames, barcodes.frames - lag))
}

/// Correlation of all barcodes with themselves `lag` frames later over those of the frames, a bit each, at which, and `lag` frames later, something moves; NaN where these are less than so
/// large a share of them, and say nothing. `barcodes`: where nothing moves, nothing either ([`among`]).
pub(super) fn autocorrelation_among(barcodes: &Barcodes, busy: &[u64], lag: usize, least: f64) -> f64 {
    let frames = busy.iter().map(|w| w.count_ones() as usize).sum();
    let both = ones_that_return(busy, lag);
    if (both as f64) < least * frames as f64 { f64::NAN } else { correlation(barcodes, lag, (frames, both)) }
}

/// Barcodes in some of their frames, a bit each, and nought in the others: what moves there is specks.
pub(super) fn among(barcodes: &Barcodes, busy: &[u64]) -> Barcodes {
    let is_busy = |frame: usize| busy[frame / 64] >> (frame % 64) & 1 == 1;
    let moves = |line: usize, frame: usize| barcodes.row(line)[frame / 64] >> (frame % 64) & 1 == 1;
    Barcodes::from_fn(barcodes.count, barcodes.frames, |line, frame| is_busy(frame) && moves(line, frame))
}

/// How many bits are set that are so again `lag` bits later. Beyond the last all are nought, so that nothing is counted twice.
fn ones_that_return(row: &[u64], lag: usize) -> usize {
    let later = |k: usize| {
        let (word, bit) = ((k * 64 + lag) / 64, lag % 64);
        let low = row.get(word).map_or(0, |w| w >> bit);
        let high = if bit == 0 { 0 } else { row.get(word + 1).map_or(0, |w| w << (64 - bit)) };
        low | high
    };
    (0..row.len()).map(|k| (row[k] & later(k)).count_ones() as usize).sum()
}

/// Of barcodes that are those of so many frames, so many of which are compared.
fn correlation(barcodes: &Barcodes, lag: usize, (frames, compared): (usize, usize)) -> f64 {
    let n = compared as f64;
    let (mut covariance, mut variance) = (0.0, 0.0);
    for i in 0..barcodes.count {
        let common = ones_that_return(barcodes.row(i), lag);
        let mean = f64::from(barcodes.ones(i)) / frames as f64;
        covariance += common as f64 / n - mean * mean;
        variance += mean * (1.0 - mean);
    }
    if variance > 0.0 { covariance / variance } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(frames: impl Iterator<Item = u32>) -> Vec<FramePair> {
        frames.map(|i| FramePair::new(i, i + 7)).collect()
    }

    /// As where all frames are busy.
    fn alike(stay: usize) -> Stay {
        Stay { busy: stay, common: stay }
    }

    #[test]
    fn no_tested_frame_is_near_a_fitted_one() {
        for (frames, stay) in [(16, 30), (60, 1), (240, 8), (400, 20), (400, 90), (800, 20), (5000, 25)] {
            let common = pairs(0..frames);
            // Nobody is there for a while, and now and then.
            let busy = pairs((0..frames).filter(|i| i % 11 != 3 && !(frames / 5..frames / 4).contains(i)));
            let splits =
                [Fold::First, Fold::Second].map(|fold| Split::new(&common, &busy, alike(stay), fold));
            let of = |split: &Split| -> Vec<u32> {
                split.tested.iter().flat_map(Clone::clone).map(|i| busy[i].a.0).collect()
            };
            assert!(of(&splits[1]).iter().all(|t| !of(&splits[0]).contains(t)), "{frames} {stay}");
            for split in splits {
                let (tested, gap) = (of(&split), split.gap as u32);
                assert!(
                    gap >= 1 && (gap as usize == stay || stay * 8 > frames as usize),
                    "{frames} {stay}: {gap}"
                );
                for fitted in split.fitted.iter().map(|p| p.a.0) {
                    assert!(tested.iter().all(|t| t.abs_diff(fitted) > gap), "{frames} {stay}: {fitted}");
                }
                assert!(split.fitted_busy.iter().all(|p| busy.contains(p) && split.fitted.contains(p)));
                let [tested, fitted] =
                    [tested.len(), split.fitted_busy.len()].map(|n| n as f64 / busy.len() as f64);
                assert!((0.14..0.21).contains(&tested), "{frames} {stay}: {tested}");
                assert!((0.45..0.8).contains(&fitted), "{frames} {stay}: {fitted}");
            }
        }
        // Longer recordings have room for more gaps.
        let stretches = |frames| {
            let common = pairs(0..frames);
            Split::new(&common, &common, alike(20), Fold::First).tested.len()
        };
        assert_eq!([300, 500, 2000].map(stretches), [1, 2, 3]);
    }

    #[test]
    fn frames_between_busy_ones_count() {
        let common = pairs(0..400);
        assert_eq!(in_common_frames(20, &common, &common), 20);
        // Every second frame; and a pause, which says nothing.
        assert_eq!(in_common_frames(20, &common, &pairs((0..400).step_by(2))), 40);
        assert_eq!(in_common_frames(20, &common, &pairs((0..120).chain(280..400))), 20);
        assert_eq!([in_common_frames(5, &common, &[]), in_common_frames(0, &common, &common)], [5, 0]);
        // Bursts with long pauses: most of them in between in common frames, and none in busy ones.
        let bursts = pairs((0..400).filter(|i| i % 100 < 20));
        let stay = Stay { busy: 12, common: in_common_frames(12, &common, &bursts) };
        let split = Split::new(&common, &bursts, stay, Fold::First);
        assert_eq!((stay.common, split.gap, split.stay), (92, 60, 12));
    }

    #[test]
    fn specks_while_nobody_is_there_are_no_motion() {
        let on = |line: usize, frame: usize| frame >= 128 || (frame / (3 + line)).is_multiple_of(2);
        let busy = [u64::MAX, u64::MAX, 0, 0];
        let first = Barcodes::from_fn(3, 128, on);
        let all = Barcodes::from_fn(3, 256, on);
        for lag in [1, 7, 40] {
            let among = autocorrelation_among(&among(&all, &busy), &busy, lag, 0.0);
            assert!((among - autocorrelation(&first, lag)).abs() < 1e-12, "{lag}");
        }
    }

    #[test]
    fn time_passes_where_nobody_is_seen() {
        // Somebody in the first and in the last frames, and a long time nobody.
        let common = pairs(0..400);
        let busy = pairs((0..120).chain(370..400));
        let split = Split::new(&common, &busy, alike(30), Fold::First);
        assert_eq!((split.tested, split.fitted_busy.len()), (vec![Range { start: 120, end: 150 }], 120));
    }

    #[test]
    fn autocorrelation_counts_as_one_would() {
        let on = |line: usize, frame: usize| (frame * frame / (5 + line) + line) % 7 < 3;
        let (count, frames) = (4, 150);
        let packed = Barcodes::from_fn(count, frames, on);
        for lag in [1, 5, 63, 64, 65, 100] {
            let (mut covariance, mut variance) = (0.0, 0.0);
            for line in 0..count {
                let share = |n: usize, of: usize| n as f64 / of as f64;
                let mean = share((0..frames).filter(|&t| on(line, t)).count(), frames);
                let both = (0..frames - lag).filter(|&t| on(line, t) && on(line, t + lag)).count();
                covariance += share(both, frames - lag) - mean * mean;
                variance += mean * (1.0 - mean);
            }
            assert!((autocorrelation(&packed, lag) - covariance / variance).abs() < 1e-12, "{lag}");
        }
        assert_eq!(autocorrelation(&Barcodes::from_fn(2, 80, |_, _| true), 3), 0.0);
    }
}
