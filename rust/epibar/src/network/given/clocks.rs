//! The clocks of all cameras, before any geometry is known.
//!
//! Clocks belong to cameras, not to pairs: an offset each, so that they agree round every cycle. For some pairs the offset is
//! found from barcodes, with now and then a wrong one among them; three cameras whose offsets add up to nought vouch for
//! each other.

use rayon::prelude::*;

use super::pair_choice::{ALL_PAIRS, all_pairs};
use crate::clock::{TimeOffset, find_offset, score_at_offset};
use crate::error::Result;
use crate::network::model::joint::Belief;
use crate::network::thresholds as limits;
use crate::recording::Recording;
use crate::watch::{Stage, Unwatched, Watch, report};

/// No clock is wrong by a tenth, ppm.
pub const MOST_DRIFT: f64 = 1e5;

/// A search starts from a found offset rounded to this, seconds, which it sharpens anyway: so it is the same one though one more camera
/// moved all offsets by a millisecond.
pub const GRID: f64 = 0.04;

/// What the barcodes of a pair say of its clocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairOffset {
    /// Index of camera A.
    pub a: usize,
    /// Index of camera B.
    pub b: usize,
    /// What is at `t` seconds in A, since its first frame, is at about `t + seconds` in B.
    pub seconds: f64,
    /// How well the best pairs of lines agree there.
    pub score: f64,
    /// How well they agree without an offset; −∞ where too few frames are common then.
    pub unshifted: f64,
    /// Score of the best other offset as a share of the best.
    pub runner_up: f64,
}

/// Offsets of all cameras.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Offsets {
    /// For each camera: what is at `t` in the first camera is at `t + seconds` in this one; NaN where nothing tells.
    pub seconds: Vec<f64>,
    /// All cameras started together, as far as barcodes tell.
    pub together: bool,
    /// They were given, and are not solved for.
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

    /// What is believed of the offset and the drift of a camera's clock.
    pub(in crate::network) fn beliefs(&self, camera: usize) -> [Belief; 2] {
        let seconds = self.seconds[camera];
        let [offset, drift] = if self.given {
            [0.0; 2]
        } else {
            [if self.together { limits::CLOCK_TOGETHER } else { limits::CLOCK_FOUND }, limits::DRIFT]
        };
        [Belief::about(if seconds.is_finite() { seconds } else { 0.0 }, offset), Belief::about(0.0, drift)]
    }
}

/// Neighbours that each of more cameras is asked with first.
const NEIGHBOURS: usize = 3;
/// So many triangles vouch for a camera: one may add up to nought by chance.
const VOUCHED: usize = 2;
/// More pairs that are asked for, at the most, for each camera where too little vouches for some.
const MOST_BEYOND: usize = 15;
/// What an offset weighs whose runner-up has nothing of its score, and one whose runner-up has all.
const CLEAR: f64 = 1.05;
const UNCLEAR: f64 = 0.05;
/// What it weighs where it closes no triangle, against 1 more for each that it closes.
const ALONE: f64 = 0.2;
/// Rounds of taking means.
const ROUNDS: usize = 20;

/// Pairs of `count` cameras whose offsets are asked for first: all of few cameras, neighbours in the list of more.
pub fn asked(count: usize) -> Vec<(usize, usize)> {
    all_pairs(count).filter(|&(a, b)| count <= ALL_PAIRS || apart(count, a, b) <= NEIGHBOURS).collect()
}

/// How far apart two cameras `a < b` are in the list, which ends where it begins.
fn apart(count: usize, a: usize, b: usize) -> usize {
    (b - a).min(count - (b - a))
}

/// More pairs to ask for, of cameras that too little vouches for by what was found of neighbours in the list, or that triangles do not join:
/// neighbours in the list need not be neighbours in space. The nearest first, and not more than so many for each camera. Asked in one go, as the
/// more is asked the more triangles add up to nought by chance.
fn asked_beyond(count: usize, found: &[PairOffset]) -> Vec<(usize, usize)> {
    if count <= ALL_PAIRS {
        return Vec::new();
    }
    let (triangles, group) = vouched(count, found);
    let is_open = |&(a, b): &(usize, usize)| group[a] != group[b] || triangles[a].min(triangles[b]) < VOUCHED;
    let further = |&(a, b): &(usize, usize)| apart(count, a, b) > NEIGHBOURS;
    let mut beyond: Vec<(usize, usize)> =
        all_pairs(count).filter(|pair| further(pair) && is_open(pair)).collect();
    beyond.sort_by_key(|&(a, b)| apart(count, a, b));
    beyond.truncate(MOST_BEYOND * count);
    beyond
}

/// How many triangles each camera is in whose offsets add up to nought, and a group for all that such triangles join.
fn vouched(count: usize, found: &[PairOffset]) -> (Vec<usize>, Vec<usize>) {
    let mut between = vec![f64::NAN; count * count];
    for p in found {
        between[p.a * count + p.b] = p.seconds;
    }
    let (mut triangles, mut group) = (vec![0; count], (0..count).collect::<Vec<_>>());
    for p in found {
        for c in p.b + 1..count {
            let round = p.seconds + between[p.b * count + c] - between[p.a * count + c];
            if round.abs() < limits::OFFSETS_AGREE {
                for camera in [p.a, p.b, c] {
                    triangles[camera] += 1;
                    let (one, other) = (group[p.a], group[camera]);
                    group.iter_mut().filter(|g| **g == other).for_each(|g| *g = one);
                }
            }
        }
    }
    (triangles, group)
}

/// What the barcodes of two recordings say of their clocks, within so many seconds; `None` where nothing.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn pair_offset(
    recordings: [&Recording; 2],
    [a, b]: [usize; 2],
    seconds: f64,
    watch: &mut dyn Watch,
) -> Result<Option<PairOffset>> {
    let found = find_offset(recordings[0], recordings[1], seconds, watch)?;
    let interval = recordings[1].frame_interval();
    Ok(found.map(|f| PairOffset {
        a,
        b,
        seconds: f.offset * interval,
        score: f.score,
        unshifted: f.unshifted,
        runner_up: f.runner_up.map_or(0.0, |r| r.share),
    }))
}

/// Offsets of pairs: those asked for by [`asked`], and more where these leave cameras that nothing vouches for.
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
        pair_offset([recordings[a], recordings[b]], [a, b], seconds, &mut Unwatched)
    };
    let mut found = Vec::new();
    for beyond in [false, true] {
        let pairs = if beyond { asked_beyond(count, &found) } else { asked(count) };
        // Of more cameras the second half may have nothing to do.
        let before = if beyond { 0.5 } else { 0.0 };
        let of_all = if count <= ALL_PAIRS { 1.0 } else { 0.5 };
        for (i, chunk) in pairs.chunks(4).enumerate() {
            report(watch, Stage::TimeOffset, before + of_all * 4.0 * i as f64 / pairs.len() as f64)?;
            for offset in chunk.par_iter().map(of).collect::<Result<Vec<_>>>()? {
                found.extend(offset);
            }
        }
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
mod tests {
    use super::*;

    fn offsets(truth: &[f64], wrong: &[(usize, usize, f64)]) -> Vec<PairOffset> {
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

    /// What is found of a pair of cameras along a corridor, in which each sees what two on either side see; others have any offset.
    fn along_a_corridor(
        truth: &[f64],
        place: &[usize],
        (a, b): (usize, usize),
        draw: &mut u64,
    ) -> PairOffset {
        *draw = draw.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let chance = 42.0 * ((*draw >> 33) as f64 / f64::from(1_u32 << 31) - 0.5);
        let sees = place[a].abs_diff(place[b]) <= 2;
        PairOffset {
            a,
            b,
            seconds: if sees { truth[b] - truth[a] } else { chance },
            score: 5.0,
            unshifted: 1.0,
            runner_up: if sees { 0.6 } else { 0.9 },
        }
    }

    #[test]
    fn cameras_need_not_be_listed_in_the_order_in_which_they_stand() {
        for (count, seed) in [(8, 1), (12, 2), (20, 3), (30, 4)] {
            let truth: Vec<f64> = (0..count).map(|c| (f64::from(c) * 7.3) % 19.0 - 9.0).collect();
            let count = count as usize;
            // A step that has nothing in common with the count: neighbours in the list are far from each other.
            let step =
                [5, 7, 11, 13].into_iter().find(|s| !count.is_multiple_of(*s) && 2 * s < count + 6).unwrap();
            let place: Vec<usize> = (0..count).map(|c| c * step % count).collect();
            let mut draw = seed;
            let mut ask = |pairs: Vec<(usize, usize)>| -> Vec<PairOffset> {
                pairs.into_iter().map(|pair| along_a_corridor(&truth, &place, pair, &mut draw)).collect()
            };
            let mut found = ask(asked(count));
            found.extend(ask(asked_beyond(count, &found)));
            let seconds = agreed(count, &found).seconds;
            let right = |c: &usize| (seconds[*c] - (truth[*c] - truth[0])).abs() < 0.3;
            assert_eq!((0..count).filter(right).count(), count, "{count}: {seconds:?} {truth:?}");
        }
    }

    #[test]
    fn no_more_is_asked_where_triangles_join_all() {
        let truth: Vec<f64> = (0..20).map(|c| f64::from(c) * 0.7).collect();
        let found = offsets(&truth, &[]);
        assert_eq!(asked_beyond(20, &found), []);
        assert_eq!(asked_beyond(6, &[]), []);
        // One that nothing vouches for is asked with those further off.
        let without: Vec<PairOffset> = found.into_iter().filter(|p| p.a != 4 && p.b != 4).collect();
        let beyond = asked_beyond(20, &without);
        assert_eq!((beyond.len(), &beyond[..2]), (13, &[(0, 4), (4, 8)][..]));
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
