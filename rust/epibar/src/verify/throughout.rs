//! Does a geometry hold throughout the recording?
//!
//! Where a camera was turned while it filmed, the geometry of one part is right, stands far above chance, and is wrong for all
//! that is filmed from now on. Then little meets before some moment or after it. So it does where each camera sees what the other
//! does not for a while; but there no other geometry explains more, or one of them sees less.

use super::sides::{MOMENTS, PARTS, SHIFTS, beyond_chance, rate};
use super::thresholds::{
    HOLDS_AS_MUCH, HOLDS_CLEAR, HOLDS_DIFFERS, HOLDS_LESS, HOLDS_NOTHING, HOLDS_OTHER, HOLDS_SHOWS,
};
use super::turned_in_part::moved_for;
use crate::error::Result;
use crate::frontier::{Comparer, Views};
use crate::geometry::Fundamental;
use crate::watch::{Stage, Watch, report};

/// Evidence beyond chance, from A to B and back, and the tangents of either camera.
#[derive(Debug, Clone, Copy, Default)]
struct Side {
    excess: f64,
    tangents: [f64; 2],
    /// Of each part those of the camera that sees less: no more could meet.
    ends: f64,
    parts: f64,
}

impl Side {
    fn of(parts: &[Self]) -> Self {
        parts.iter().fold(Self::default(), |sum, part| Self {
            excess: sum.excess + part.excess,
            tangents: [0, 1].map(|k| sum.tangents[k] + part.tangents[k]),
            ends: sum.ends + part.ends,
            parts: sum.parts + part.parts,
        })
    }

    fn rate(&self) -> f64 {
        rate(self.excess, self.ends)
    }

    /// What each camera sees as a share of what it sees in the other side, of the two the less.
    fn seen_beside(&self, other: &Self) -> f64 {
        let share = |k: usize| (self.tangents[k] / self.parts) / (other.tangents[k] / other.parts).max(1.0);
        share(0).min(share(1))
    }
}

/// Whether `F` explains the recording from its start to its end. It is cut in two at each of some moments; where the rate of what meets
/// is lower on one side, the evidence there is divided by that of a geometry which explains that side better. The least of these shares
/// is returned: 1 where as much meets on either side of each moment, or what is missing may never have been there. NaN where the evidence
/// is no number.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn holds(views: &Views, f: &Fundamental, radius: f64, watch: &mut dyn Watch) -> Result<f64> {
    let parts = Of { views, f, radius }.parts(views);
    if parts.iter().any(|part| !part.excess.is_finite()) {
        return Ok(f64::NAN);
    }
    let mut least = 1.0_f64;
    for boundary in MOMENTS {
        report(watch, Stage::Settle, 1.0)?;
        least = least.min(held(views, f, radius, &parts, boundary));
    }
    Ok(least)
}

/// [`holds`] of one moment.
fn held(views: &Views, f: &Fundamental, radius: f64, parts: &[Side; PARTS], boundary: usize) -> f64 {
    let (before, after) = parts.split_at(boundary);
    let sides = [Side::of(before), Side::of(after)];
    let worst = usize::from(sides[1].rate() < sides[0].rate());
    let (worse, better) = (sides[worst], sides[1 - worst]);
    let share = worse.rate() / better.rate();
    let tells = better.excess > HOLDS_CLEAR
        && worse.ends > HOLDS_SHOWS * better.ends
        && share < HOLDS_LESS
        && difference(before, after) > HOLDS_DIFFERS;
    if !tells {
        return 1.0;
    }
    let first = frames_to(views, boundary);
    let frames: Vec<usize> =
        if worst == 0 { (0..first).collect() } else { (first..views.frames()).collect() };
    let side = |moved: Fundamental| {
        let parts = Of { views, f: &moved, radius }.parts(&views.chosen(&frames));
        let (before, after) = parts.split_at(boundary);
        Side::of(if worst == 0 { before } else { after })
    };
    let other = moved_for(views, &frames, f, radius).map(side).unwrap_or_default();
    if other.excess > HOLDS_CLEAR && other.rate() > HOLDS_OTHER * better.rate() {
        worse.excess.max(0.0) / other.excess
    } else if share < HOLDS_NOTHING && worse.seen_beside(&better) > HOLDS_AS_MUCH {
        share
    } else {
        1.0
    }
}

/// The first frame that is not in so many parts.
fn frames_to(views: &Views, parts: usize) -> usize {
    parts * views.frames() / PARTS
}

/// How far the rates of two sides are apart, in standard errors by how those of their parts scatter (two samples of one variance).
fn difference(before: &[Side], after: &[Side]) -> f64 {
    let [m, n] = [before.len(), after.len()].map(|n| n as f64);
    let mean = |side: &[Side]| side.iter().map(Side::rate).sum::<f64>() / side.len() as f64;
    let squares = |side: &[Side]| side.iter().map(|part| (part.rate() - mean(side)).powi(2)).sum::<f64>();
    let variance = (squares(before) + squares(after)) / (m + n - 2.0);
    (mean(before) - mean(after)).abs() / (variance * (1.0 / m + 1.0 / n)).sqrt()
}

/// A geometry whose evidence is asked for.
#[derive(Clone, Copy)]
struct Of<'a> {
    views: &'a Views,
    f: &'a Fundamental,
    radius: f64,
}

impl Of<'_> {
    /// Its evidence in all parts; `meant` are the frames that it is meant for, which tell the sign of the map of rays.
    fn parts(self, meant: &Views) -> [Side; PARTS] {
        let comparers: [fn(&Views, &Fundamental) -> Comparer; 2] = [Comparer::new, Comparer::reversed];
        let mut parts = [Side { parts: 1.0, ..Side::default() }; PARTS];
        for (k, comparer) in comparers.into_iter().enumerate() {
            let sign = comparer(meant, self.f).sign(0, self.radius);
            self.add(&mut parts, k, &mut comparer(self.views, self.f), sign);
        }
        for part in &mut parts {
            part.ends = part.tangents[0].min(part.tangents[1]);
        }
        parts
    }

    /// Adds what tangents of camera `k` say of each part; evidence counts half, as that of the other camera comes as well.
    fn add(self, parts: &mut [Side; PARTS], k: usize, comparer: &mut Comparer, sign: f64) {
        let Self { views, radius, .. } = self;
        for shift in 0..=SHIFTS {
            let mut paired = comparer.pair_by(sign, shift * views.frames() / (SHIFTS + 1));
            let weighed = paired.weigh(radius);
            for (i, part) in parts.iter_mut().enumerate() {
                let frames: Vec<usize> = (frames_to(views, i)..frames_to(views, i + 1)).collect();
                let score = weighed.score_of(&frames);
                part.excess += beyond_chance(0.5 * score.total(), shift);
                if shift == 0 {
                    part.tangents[k] += score.tangents() as f64;
                }
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::frontier::View;
    use crate::image::ImageSize;
    use crate::random::generator;
    use crate::recording::FramePair;
    use crate::watch::Unwatched;
    use rand::RngExt;

    /// Boxes that jump about, seen by two cameras side by side; from one frame on the second looks so many pixels further down, and
    /// so many of the four boxes that it sees are others.
    pub fn seen(frames: usize, from: usize, lower: f64, others: usize) -> (Views, Fundamental) {
        let size = ImageSize::new(640, 480).unwrap();
        let mut random = generator(11, 0);
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let mut views: [Vec<Vec<Vec<[f64; 2]>>>; 2] = [vec![], vec![]];
        for frame in 0..frames {
            let boxes: Vec<_> =
                (0..4).map(|_| [between(60.0, 500.0), between(50.0, 300.0), between(0.0, 50.0)]).collect();
            let strangers = if frame >= from { others } else { 0 };
            let strange: Vec<_> = (0..strangers)
                .map(|_| [between(60.0, 500.0), between(50.0, 300.0), between(0.0, 50.0)])
                .collect();
            for (k, view) in views.iter_mut().enumerate() {
                let hull = |&[x, y, near]: &[f64; 3]| {
                    let x = if k == 0 { x } else { x - near };
                    let y = if k == 1 && frame >= from { y + lower } else { y };
                    vec![[x, y], [x + 30.0, y + 5.0], [x + 40.0, y + 60.0], [x - 5.0, y + 55.0]]
                };
                let boxes =
                    if k == 0 { boxes.iter().chain(&[]) } else { strange.iter().chain(&boxes[strangers..]) };
                view.push(boxes.map(hull).collect());
            }
        }
        let [a, b] = views.map(|frames| View::made_up(size, &frames));
        let pairs = (0..frames as u32).map(|i| FramePair::new(i, i)).collect();
        let rows = nalgebra::Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0);
        (Views::of(a, b, pairs), Fundamental::from_matrix(&rows, size, size).unwrap())
    }

    #[test]
    fn a_camera_that_was_moved_is_noticed() {
        let of = |from, lower| {
            let (views, f) = seen(240, from, lower, 0);
            holds(&views, &f, 2.0, &mut Unwatched).unwrap()
        };
        assert!(of(0, 0.0) > 0.8, "{}", of(0, 0.0));
        for from in [80, 120, 170] {
            assert!(of(from, 25.0) < 0.1, "{from}: {}", of(from, 25.0));
        }
        // A few pixels, of which two thirds of the tangents that met still do.
        let (views, f) = seen(240, 120, 4.0, 0);
        let share = holds(&views, &f, 4.0, &mut Unwatched).unwrap();
        assert!(share < 0.5, "{share}");
        // Of hardly anything nothing is told.
        let (views, f) = seen(4, 2, 25.0, 0);
        assert_eq!(holds(&views, &f, 2.0, &mut Unwatched).unwrap(), 1.0);
    }
    #[test]
    fn people_who_go_where_one_camera_looks_are_no_move() {
        for others in [1, 2] {
            // The second camera sees nothing then but so many others.
            let (mut views, f) = seen(240, 160, 0.0, others);
            let strangers = |frame: usize| if frame < 160 { usize::MAX } else { others };
            let size = views.b.size;
            let b: Vec<Vec<Vec<[f64; 2]>>> = (0..240)
                .map(|t| views.b.hulls_of(t).take(strangers(t)).map(<[_]>::to_vec).collect())
                .collect();
            views.b = View::made_up(size, &b);
            let swapped = views.swapped();
            for (views, f) in [(views, f), (swapped, f.transposed())] {
                let share = holds(&views, &f, 2.0, &mut Unwatched).unwrap();
                assert_eq!(share, 1.0, "{others}");
            }
        }
    }

    #[test]
    fn what_one_camera_alone_sees_is_no_move() {
        for others in [2, 3] {
            let (views, f) = seen(240, 160, 0.0, others);
            let parts = Of { views: &views, f: &f, radius: 2.0 }.parts(&views);
            let rates = [&parts[..5], &parts[6..]].map(|side| Side::of(side).rate());
            assert!(
                rates[1] < HOLDS_LESS * rates[0] && difference(&parts[..5], &parts[6..]) > HOLDS_DIFFERS,
                "{rates:?}"
            );
            let share = holds(&views, &f, 2.0, &mut Unwatched).unwrap();
            assert!(share > 0.8, "{others}: {share}");
        }
    }
}
