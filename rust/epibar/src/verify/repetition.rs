//! Does what moves look the same again a while later, with others in its place?
//!
//! A column of equal people in step, or a carousel of equal seats: moved on by one place it looks the same, so the geometry that
//! takes each for its neighbour explains everything as well as the true one, in all frames, and no evidence tells the two apart.
//! Barcodes then correlate with their own past. So they do where the same things come back to their own places, as a pendulum or people
//! who pace do; that repeats in time alone, and the geometry is none the worse. The two are told apart by following silhouettes.

use std::ops::Range;

use super::split::{among, autocorrelation_among, moving_lines};
use crate::recording::tracker::{Links, Outline};
use crate::recording::{Barcodes, FramePair, LONG_STEP, RecordedFrame, Recording, fullest};

/// Common frames of which it is asked.
const FRAMES: usize = 3000;
/// Largest time after which it is asked, of that stretch: columns and carousels had moved on by a place after 0.01 to 0.14 of it, and
/// what was alike only after more than half of it were two people who happened to.
const LATEST: f64 = 0.5;
/// Barcodes that correlate with their own past by less have left it.
const LEFT: f64 = 0.2;
/// The first time after which both cameras' barcodes are as alike as this share of the most alike ones.
const FIRST: f64 = 0.8;
/// Moments from which silhouettes are followed.
const MOMENTS: usize = 200;
/// Boxes about two silhouettes at one place overlap by this share of their union.
const SAME_PLACE: f64 = 0.3;
/// A silhouette that changed too much to be followed is the only one at its place up to so many frames later, and no more than this
/// part of the time, in which a pattern moves on by as much of a place.
const BRIDGED: usize = 3;
const BRIDGED_SHARE: usize = 20;
/// Fewest silhouettes that, followed for as long as it takes, show that no others are in the places.
const FOLLOWED: usize = 10;
/// Share of the likeness that is left after twice the time where the pattern goes on: 0.94 to 1.1 before columns and carousels, 0.54 and
/// 0.58 before people who pace.
const PERSISTS: f64 = 0.8;

/// How much both cameras' barcodes resemble those of a later moment at which others are in the places: a correlation; 0 where the
/// same things are, NaN where no line says anything. Times after which too few moments say something are passed over.
pub fn repeats(recordings: [&Recording; 2], common: &[FramePair]) -> f64 {
    let common = &common[busiest(recordings, common)];
    let frames = FramePair::indices(common);
    // That nobody is there for a while, and then somebody is again, is no likeness.
    let busy = [0, 1].map(|k| busy_bits(recordings[k], &frames[k]));
    let lines: [Barcodes; 2] = [0, 1].map(|k| among(&moving_lines(recordings[k], &frames[k]), &busy[k]));
    if lines.iter().any(|lines| lines.count == 0) {
        return f64::NAN;
    }
    let alike = |lag: usize| {
        let [p, q] = [0, 1].map(|k| autocorrelation_among(&lines[k], &busy[k], lag, 1.0 - LATEST));
        if p.is_nan() || q.is_nan() { f64::NAN } else { p.min(q) }
    };
    let alike: Vec<f64> = (0..(LATEST * common.len() as f64) as usize).map(alike).collect();
    let Some(left) = alike.iter().position(|&a| a < LEFT) else { return 0.0 };
    let most = alike[left..].iter().copied().fold(0.0, f64::max);
    if most < LEFT {
        return most;
    }
    let Some(lag) = (left..alike.len()).find(|&lag| alike[lag] >= FIRST * most) else { return most };
    // Up to the top of it.
    let lag = (lag..alike.len() - 1)
        .find(|&lag| alike[lag + 1].is_nan() || alike[lag + 1] <= alike[lag])
        .unwrap_or(lag);
    let mut sums = Replacements::default();
    for (recording, frames) in recordings.into_iter().zip(&frames) {
        sums.follow(recording, frames, lag);
    }
    let replaced = 2 * sums.replaced > sums.all || sums.all < FOLLOWED && persists(&alike, lag);
    if replaced { most } else { 0.0 }
}

/// The stretch of at most [`FRAMES`] common frames in which most show something in both cameras; of equals that closest to the middle.
fn busiest(recordings: [&Recording; 2], common: &[FramePair]) -> Range<usize> {
    let shows = |p: &FramePair| recordings[0].shows(p.a) && recordings[1].shows(p.b);
    let busy: Vec<bool> = common.iter().map(shows).collect();
    fullest(&busy, FRAMES, common.len().saturating_sub(FRAMES) / 2)
}

/// A bit for each frame: whether anything moves.
fn busy_bits(recording: &Recording, frames: &[u32]) -> Vec<u64> {
    let mut bits = vec![0; frames.len().div_ceil(64)];
    for (i, &frame) in frames.iter().enumerate() {
        bits[i / 64] |= u64::from(recording.shows(RecordedFrame(frame))) << (i % 64);
    }
    bits
}

/// Whether barcodes are as alike after twice the time, as those of an endless column are and those of people who pace are not, who
/// fall out of step; also where that is not known.
fn persists(alike: &[f64], lag: usize) -> bool {
    let about = 2 * lag - lag / 10..=2 * lag + lag / 10;
    let known = alike.get(about).into_iter().flatten().copied().filter(|a| !a.is_nan());
    known.reduce(f64::max).is_none_or(|then| then >= PERSISTS * alike[lag])
}

/// Silhouettes that were followed.
#[derive(Debug, Default)]
struct Replacements {
    all: usize,
    /// Silhouettes that went on, and in whose place is another.
    replaced: usize,
}

impl Replacements {
    fn follow(&mut self, recording: &Recording, frames: &[u32], lag: usize) {
        let follower = Follower::new(recording, lag);
        let starts = frames.len() - lag;
        for start in (0..starts).step_by(starts.div_ceil(MOMENTS)) {
            let (from, to) = (frames[start], frames[start + lag]);
            for hull in follower.hulls(from) {
                let Some(now) = follower.later(hull, from, to) else { continue };
                self.all += 1;
                let replaced =
                    !follower.same_place(hull, now) && follower.at_place_of(hull, to).next().is_some();
                self.replaced += usize::from(replaced);
            }
        }
    }
}

/// Follows silhouettes for some time.
struct Follower<'r> {
    recording: &'r Recording,
    links: Links,
    /// Frames that may be bridged.
    bridged: u32,
    /// Seconds that may not be: frames are lacking.
    long: f64,
}

impl<'r> Follower<'r> {
    fn new(recording: &'r Recording, lag: usize) -> Self {
        let bridged = BRIDGED.min(lag / BRIDGED_SHARE) as u32;
        let long = (f64::from(bridged) + LONG_STEP - 1.0) * recording.frame_interval();
        Self { recording, links: Links::new(recording), bridged, long }
    }

    fn hulls(&self, frame: u32) -> Range<usize> {
        self.recording.silhouettes.hulls(frame as usize)
    }

    fn outline(&self, hull: usize) -> Outline {
        Outline::of(self.recording.silhouettes.hull(hull).iter().map(|p| p.map(f64::from)))
    }

    fn same_place(&self, hull: usize, other: usize) -> bool {
        self.outline(hull).overlap(&self.outline(other)) >= SAME_PLACE
    }

    fn at_place_of(&self, hull: usize, frame: u32) -> impl Iterator<Item = usize> {
        self.hulls(frame).filter(move |&other| self.same_place(hull, other))
    }

    /// What a silhouette of one frame is in another; `None` where it is lost.
    fn later(&self, hull: usize, from: u32, to: u32) -> Option<usize> {
        let (mut now, mut frame) = (hull, from);
        while frame < to {
            let next = self.links.next(now).map(|next| (next, frame + 1));
            (now, frame) = next.or_else(|| self.bridge(now, frame, to))?;
        }
        Some(now)
    }

    /// The silhouette that is soon after at its place, and when: each the only one at the place of the other.
    fn bridge(&self, hull: usize, frame: u32, to: u32) -> Option<(usize, u32)> {
        let time = |frame: u32| self.recording.times[frame as usize];
        let then = (frame + 1..=to.min(frame + self.bridged))
            .find(|&then| self.at_place_of(hull, then).next().is_some())?;
        let only = self.only_one_at_place_of(hull, then)?;
        let is_mutual = self.only_one_at_place_of(only, frame) == Some(hull);
        (is_mutual && time(then) - time(frame) <= self.long).then_some((only, then))
    }

    fn only_one_at_place_of(&self, hull: usize, frame: u32) -> Option<usize> {
        let mut there = self.at_place_of(hull, frame);
        there.next().filter(|_| there.next().is_none())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ImageSize;
    use crate::recording::{Recorder, RecorderOptions};

    /// Squares of 10 pixels, at so many places in each frame.
    fn recorded(frames: usize, places: impl Fn(usize) -> Vec<[usize; 2]>) -> Recording {
        let size = ImageSize::new(160, 80).unwrap();
        let mut recorder = Recorder::new(size, RecorderOptions::new().lines(800)).unwrap();
        for frame in 0..frames {
            let mut mask = vec![0; size.pixels()];
            for [x, y] in places(frame) {
                (y..y + 10).for_each(|y| mask[y * 160 + x..y * 160 + x + 10].fill(1));
            }
            recorder.push(&mask, frame as f64 / 25.0).unwrap();
        }
        recorder.finish().unwrap()
    }

    fn of(places: impl Fn(usize) -> Vec<[usize; 2]>) -> f64 {
        let recording = recorded(240, places);
        let common: Vec<FramePair> = (0..240).map(|i| FramePair::new(i, i)).collect();
        repeats([&recording, &recording], &common)
    }

    #[test]
    fn silhouettes_are_followed_though_some_are_missed() {
        // To and fro, and every ninth frame shows nothing.
        let there_and_back = |t: usize| if t % 120 < 60 { t % 120 } else { 120 - t % 120 };
        let missed = |t: usize| if t % 9 == 4 { vec![] } else { vec![[20 + there_and_back(t), 30]] };
        let recording = recorded(240, missed);
        let mut followed = Replacements::default();
        followed.follow(&recording, &(0..240).collect::<Vec<u32>>(), 120);
        assert!(followed.all > 50 && followed.replaced == 0, "{followed:?}");
        // Two that meet, and one that is left, may have changed places.
        let meet = |t: usize| if t < 120 { vec![[t / 2, 30], [120 - t / 2, 30]] } else { vec![[t / 2, 30]] };
        let mut followed = Replacements::default();
        followed.follow(&recorded(240, meet), &(0..240).collect::<Vec<u32>>(), 180);
        assert_eq!(followed.all, 0);
        // A pattern that moves on by a place soon is not bridged: what is there then may be another.
        let column = recorded(240, |t| if t % 9 == 4 { vec![] } else { vec![[(2 * t) % 100 + 20, 30]] });
        let mut followed = Replacements::default();
        followed.follow(&column, &(0..240).collect::<Vec<u32>>(), 10);
        assert_eq!(followed.all, 0);
    }

    #[test]
    fn that_nobody_is_there_for_a_while_is_no_likeness() {
        // Two that wander about, then nobody, then they again elsewhere.
        let wander =
            |t: usize| vec![[(t * t / 30) % 140, (t * 7 / 5) % 60], [(t * t / 17) % 140, (t * 3) % 60]];
        let gone = |t: usize| if (90..150).contains(&t) { vec![] } else { wander(t) };
        assert!(of(gone) < 0.4, "{}", of(gone));
        // A column is one though it pauses.
        let column = |t: usize| (0..4).map(|k| [(2 * t) % 20 + 20 + 20 * k, 30]).collect();
        let paused = of(|t| if (90..150).contains(&t) { vec![] } else { column(t) });
        assert!(paused > 0.9, "{paused}");
    }

    #[test]
    fn what_is_alike_after_more_than_half_of_the_time_is_so_by_chance() {
        let wander =
            |t: usize| vec![[(t * t / 30) % 140, (t * 7 / 5) % 60], [(t * t / 17) % 140, (t * 3) % 60]];
        let once_more = of(|t| wander(t % 130));
        assert!(once_more < 0.4, "{once_more}");
    }

    #[test]
    fn a_column_is_one_however_long_a_camera_films_on() {
        let column = |t: usize| (0..4).map(|k| [(2 * t) % 20 + 20 + 20 * k, 30]).collect::<Vec<_>>();
        let (short, long) =
            (recorded(240, column), recorded(6000, |t| if t < 240 { column(t) } else { vec![] }));
        let common: Vec<FramePair> = (0..240).map(|i| FramePair::new(i, i)).collect();
        let repeats = repeats([&short, &long], &common);
        assert!(repeats > 0.9, "{repeats}");
    }

    #[test]
    fn a_long_time_in_which_nobody_is_there_leaves_lines_to_ask() {
        // One that wanders through, in 140 of 3000 frames.
        let recording = recorded(3000, |t| {
            if (1400..1540).contains(&t) { vec![[t - 1400, (t * t / 60) % 60]] } else { vec![] }
        });
        let common: Vec<FramePair> = (0..3000).map(|i| FramePair::new(i, i)).collect();
        let repeats = repeats([&recording; 2], &common);
        assert!(repeats < 0.4, "{repeats}");
    }

    #[test]
    fn times_after_which_nothing_is_seen_are_no_sign_that_motion_has_left() {
        // One that wanders, in every fourth frame.
        let wander = |t: usize| vec![[(t * t / 480) % 140, (t * 7 / 20) % 60]];
        let seldom = of(|t| if t.is_multiple_of(4) { wander(t) } else { vec![] });
        assert!(seldom < 0.4, "{seldom}");
    }

    #[test]
    fn what_is_asked_is_the_stretch_in_which_most_moves() {
        let recording = recorded(4000, |t| if t >= 3500 { vec![[t % 140, 30]] } else { vec![] });
        let common: Vec<FramePair> = (0..4000).map(|i| FramePair::new(i, i)).collect();
        assert_eq!(busiest([&recording; 2], &common), 1000..4000);
        let always = recorded(3200, |t| vec![[t % 140, 30]]);
        assert_eq!(busiest([&always; 2], &common[..3200]), 100..3100);
        assert_eq!(busiest([&always; 2], &common[..200]), 0..200);
    }

    #[test]
    fn others_in_the_places_are_told_from_the_same_ones() {
        // A column, each where the one before it was ten frames ago.
        let column = of(|t| (0..4).map(|k| [(2 * t) % 20 + 20 + 20 * k, 30]).collect());
        assert!(column > 0.9, "{column}");
        // One that goes to and fro.
        let there_and_back = |t: usize| if t % 60 < 30 { 3 * (t % 60) } else { 3 * (60 - t % 60) };
        assert_eq!(of(|t| vec![[20 + there_and_back(t), 30]]), 0.0);
        // Two that go to and fro, out of step: one is where it was, the other is not, and nobody has its place.
        let other = |t: usize| if t % 74 < 37 { 2 * (t % 74) } else { 2 * (74 - t % 74) };
        assert!(of(|t| vec![[20 + there_and_back(t), 15], [20 + other(t), 55]]) < 0.4);
        // One that goes where it has not been.
        let wanders = of(|t| vec![[(t * t / 30) % 140, (t * 7 / 5) % 60]]);
        assert!(wanders < 0.4, "{wanders}");
    }
}
