//! Epipolar tangents under known cameras.
//!
//! The planes through two cameras turn about the line that joins them, and a ray lies in one of them: its *dihedral angle*.
//! A silhouette covers an interval of angles, and at its two ends a plane touches the object, in either view at the same
//! angle (a frontier point, Cipolla and Giblin 2000). So tangents meet where ends of intervals are equal, lower ends with
//! lower and upper with upper: which side the object is on, and that it is in front of both cameras, need no further
//! thought.
//!
//! Angles are measured in pixels: half a turn of an angle over the norm of its gradient to the pixel of A and of B is to first
//! order their Sampson distance.

use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

use super::ends::{CameraView, End, Ends, ends, wrapped};
use super::observed::{Moment, Observed};
use crate::network::model::camera::Camera;
use crate::network::model::residual::Meeting;
use crate::recording::RecordedFrame;
use crate::recording::at_moment::Between;

/// Frames of A with the moments of B at which they were seen.
fn common_moments(a: &CameraView, b: &CameraView, frames: &[RecordedFrame]) -> Vec<(RecordedFrame, Moment)> {
    let moment = |frame: RecordedFrame| {
        let time = a.camera.time_of(a.observed.times[frame.index()]);
        b.observed.moment(b.camera.clock_at(time))
    };
    frames.iter().filter_map(|&frame| Some((frame, moment(frame)?))).collect()
}

/// The network's times of frames of A at which B saw anything too.
pub fn common_times(
    (a, camera_a): (&Observed, &Camera),
    (b, camera_b): (&Observed, &Camera),
    frames: &[RecordedFrame],
) -> Vec<f64> {
    let times = frames.iter().map(|&frame| camera_a.time_of(a.times[frame.index()]));
    let sees = |moment: Moment| !b.of_frame(moment.frame).is_empty();
    times.filter(|time| b.moment(camera_b.clock_at(*time)).is_some_and(sees)).collect()
}

/// Ends of both cameras of a pair, and the moments that they have in common.
pub struct PairTangents<'a> {
    a: CameraView<'a>,
    b: CameraView<'a>,
    ends_a: Ends,
    ends_b: Ends,
    moments: Vec<(RecordedFrame, Moment)>,
    /// Angles of B's ends of either side over all moments, sorted, for chance.
    sorted_b: [Vec<f64>; 2],
}

/// Index of a moment among those that a pair has in common, from 0: no frame of either camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PairMoment(u32);

impl PairMoment {
    fn index(self) -> usize {
        self.0 as usize
    }
}

/// Two ends that meet, as indices; a [`Meeting`] is what is measured of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchedEnds {
    /// When they do.
    pub moment: PairMoment,
    /// 0 for lower ends, 1 for upper ones.
    pub side: u8,
    /// Silhouette of A.
    pub a: u32,
    /// Silhouette of B.
    pub b: Between<u32>,
    /// Pixels between them.
    pub distance: f64,
    /// `−ln` of the chance that some tangent of B lies within the radius at another moment.
    pub surprise: f64,
}

/// Of a lower end among those that met, in the order of [`PairTangents::meet`], the upper end of the same silhouettes, where that met
/// too.
pub fn other_end(met: &[MatchedEnds], lower: usize) -> Option<&MatchedEnds> {
    let low = met.get(lower).filter(|m| m.side == 0)?;
    let mut same_moment = met[lower + 1..].iter().take_while(|m| m.moment == low.moment);
    same_moment.find(|m| m.side == 1 && m.a == low.a && m.b == low.b)
}

/// Sum of what met, of one pair.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Score {
    /// Ends of A that could meet one.
    pub ends: usize,
    /// Silhouettes of A of which both ends met those of one silhouette of B.
    pub whole: usize,
    /// Evidence over chance, each meeting weighed by how unlikely it was.
    pub excess: f64,
}

impl<'a> PairTangents<'a> {
    /// Compares `a` with `b` at given frames of `a`; those of which B saw nothing are left out. Rays must be there of
    /// the silhouettes of these frames, and of those about the same moments in B.
    pub fn new(a: CameraView<'a>, b: CameraView<'a>, frames: &[RecordedFrame]) -> Self {
        let axis = b.camera.position - a.camera.position;
        let moments = common_moments(&a, &b, frames);
        let wanted_a = a.observed.wanted(moments.iter().map(|m| m.0));
        let wanted_b = b.observed.wanted(moments.iter().map(|m| m.1.frame));
        let (ends_a, ends_b) = rayon::join(|| ends(&a, &axis, &wanted_a), || ends(&b, &axis, &wanted_b));
        let mut found = Self { a, b, ends_a, ends_b, moments, sorted_b: Default::default() };
        found.sort_angles();
        found
    }

    fn sort_angles(&mut self) {
        let mut sorted: [Vec<f64>; 2] = Default::default();
        let mut seen = vec![];
        for (_, moment) in &self.moments {
            self.b.observed.between(*moment, &mut seen);
            for between in &seen {
                for (side, sorted) in sorted.iter_mut().enumerate() {
                    let angle = wrapped(self.end_of_b(between, side).angle);
                    if !angle.is_nan() {
                        sorted.push(angle);
                    }
                }
            }
        }
        for side in &mut sorted {
            side.sort_unstable_by(f64::total_cmp);
        }
        self.sorted_b = sorted;
    }

    /// The network's time of a moment.
    pub fn time(&self, moment: usize) -> f64 {
        self.a.camera.time_of(self.a.observed.times[self.moments[moment].0.index()])
    }

    /// Number of moments in common.
    pub fn moments(&self) -> usize {
        self.moments.len()
    }

    /// An end of B between two frames.
    fn end_of_b(&self, between: &Between<u32>, side: usize) -> End {
        let first = self.ends_b[between.first as usize][side];
        if between.first == between.last {
            return first;
        }
        let last = self.ends_b[between.last as usize][side];
        let angle = first.angle + between.share * wrapped(last.angle - first.angle);
        let mean = |p: f64, q: f64| p + between.share * (q - p);
        End {
            angle,
            per_pixel: mean(first.per_pixel, last.per_pixel),
            outward: [0, 1].map(|k| mean(first.outward[k], last.outward[k])),
            point: first.point,
        }
    }

    /// Chance that some tangent of B lies within so much of an angle at another moment.
    fn chance(&self, side: usize, angle: f64, within: f64) -> f64 {
        let sorted = &self.sorted_b[side];
        let count = |low: f64, high: f64| {
            sorted.partition_point(|x| *x <= high) - sorted.partition_point(|x| *x < low)
        };
        let angle = wrapped(angle);
        let mut n = count(angle - within, angle + within);
        // What lies within reach on the other side of the half turn.
        if angle - within < -PI {
            n += count(angle - within + TAU, f64::INFINITY);
        }
        if angle + within > PI {
            n += count(f64::NEG_INFINITY, angle + within - TAU);
        }
        -(-(n as f64 + 0.5) / self.moments.len().max(1) as f64).exp_m1()
    }

    /// The ends that meet within a radius, pixels, each the other's nearest, with B's moments moved on cyclically by
    /// `shift`; in the order of time.
    pub fn meet(&self, radius: f64, shift: usize) -> Vec<MatchedEnds> {
        let count = self.moments.len();
        let chunk = 64;
        let parts: Vec<Vec<MatchedEnds>> = (0..count.div_ceil(chunk))
            .into_par_iter()
            .map(|part| {
                let (mut found, mut seen) = (Vec::new(), Vec::new());
                for i in part * chunk..((part + 1) * chunk).min(count) {
                    let moment = self.moments[(i + shift) % count].1;
                    self.b.observed.between(moment, &mut seen);
                    self.meet_at(i, &seen, radius, &mut found);
                }
                found
            })
            .collect();
        parts.concat()
    }

    fn meet_at(&self, moment: usize, seen: &[Between<u32>], radius: f64, found: &mut Vec<MatchedEnds>) {
        let in_a = self.a.observed.of_frame(self.moments[moment].0);
        for side in 0..2 {
            let ends_b: Vec<End> = seen.iter().map(|between| self.end_of_b(between, side)).collect();
            let distance =
                |p: &End, q: &End| wrapped(p.angle - q.angle).abs() / p.per_pixel.hypot(q.per_pixel);
            for a in in_a.clone() {
                let end = &self.ends_a[a as usize][side];
                if end.angle.is_nan() {
                    continue;
                }
                let (mut least, mut nearest) = (radius, None);
                for (k, other) in ends_b.iter().enumerate() {
                    // Not so for what is NaN.
                    let d = distance(end, other);
                    if d < least {
                        (least, nearest) = (d, Some(k));
                    }
                }
                let Some(k) = nearest else { continue };
                let rivalled = |other: u32| {
                    other != a && distance(&self.ends_a[other as usize][side], &ends_b[k]) < least
                };
                if in_a.clone().any(rivalled) {
                    continue;
                }
                let within = radius * end.per_pixel.hypot(ends_b[k].per_pixel);
                let chance = self.chance(side, end.angle, within);
                found.push(MatchedEnds {
                    moment: PairMoment(moment as u32),
                    side: side as u8,
                    a,
                    b: seen[k],
                    distance: least,
                    surprise: -chance.ln(),
                });
            }
        }
    }

    /// What scores them at a radius, pixels.
    pub fn scorer(&self, radius: f64) -> ShiftScorer<'_> {
        let mut unmet = vec![Score::default(); self.moments.len()];
        for (score, (frame, _)) in unmet.iter_mut().zip(&self.moments) {
            for a in self.a.observed.of_frame(*frame) {
                for side in 0..2 {
                    let end = &self.ends_a[a as usize][side];
                    if end.angle.is_nan() {
                        continue;
                    }
                    // B's pixels are about as large as those of B's tangents on average.
                    let chance =
                        self.chance(side, end.angle, radius * end.per_pixel * std::f64::consts::SQRT_2);
                    score.ends += 1;
                    score.excess += -EXPECTED * chance * -chance.ln();
                }
            }
        }
        ShiftScorer { tangents: self, radius, unmet }
    }

    /// Where the object lies from both tangents of a meeting, along the images' `y` axes: 1 below, −1 above.
    pub fn below(&self, met: &MatchedEnds) -> [f64; 2] {
        let side = met.side as usize;
        [self.ends_a[met.a as usize][side].below(), self.end_of_b(&met.b, side).below()]
    }

    /// The pixels of a meeting, in A and in B.
    pub fn pixels(&self, met: &MatchedEnds) -> [[f64; 2]; 2] {
        let side = met.side as usize;
        let end = &self.ends_a[met.a as usize][side];
        let (a, b) = (&self.a, &self.b);
        let moved = |seen: &CameraView, silhouette: u32, p: [f64; 2], outward: [f64; 2]| {
            let inset = seen.inset(silhouette, outward);
            [0, 1].map(|k| p[k] + inset * outward[k])
        };
        [
            moved(a, met.a, a.observed.point(end.point), end.outward),
            moved(b, met.b.first, self.motion_of_b(&met.b, side).0, self.end_of_b(&met.b, side).outward),
        ]
    }

    /// How broad the silhouettes of A and B are of which two ends met, across the line from one end to the other, over its length.
    pub fn breadths(&self, one: &MatchedEnds, other: &MatchedEnds) -> [f64; 2] {
        let (p, q) = (self.pixels(one), self.pixels(other));
        let across = |observed: &Observed, silhouette: u32, p: [f64; 2], q: [f64; 2]| {
            let line = [p[0] - q[0], p[1] - q[1]];
            let square = line[0] * line[0] + line[1] * line[1];
            let places = observed.range(silhouette).map(|i| {
                let x = observed.point(i as u32);
                (line[0] * x[1] - line[1] * x[0]) / square
            });
            let (low, high) =
                places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            high - low
        };
        [across(self.a.observed, one.a, p[0], q[0]), across(self.b.observed, one.b.first, p[1], q[1])]
    }

    /// Meetings as measurements for the joint problem.
    pub fn measurements(&self, met: &[MatchedEnds]) -> Vec<Meeting> {
        let (a, b) = (self.a.observed, self.b.observed);
        met.iter()
            .map(|m| {
                let side = m.side as usize;
                let (frame, moment) = self.moments[m.moment.index()];
                let (pixel_b, velocity_b) = self.motion_of_b(&m.b, side);
                Meeting {
                    a: a.point(self.ends_a[m.a as usize][side].point),
                    b: pixel_b,
                    outward_a: self.ends_a[m.a as usize][side].outward,
                    outward_b: self.end_of_b(&m.b, side).outward,
                    smallness: [a.smallness(m.a), b.smallness(m.b.first)],
                    velocity_b,
                    time_a: a.times[frame.index()],
                    time_b: b.seconds(moment),
                    weight: m.surprise,
                }
            })
            .collect()
    }

    /// Where a tangent point of B is, and how fast it moves, pixels a second, where it is followed.
    fn motion_of_b(&self, between: &Between<u32>, side: usize) -> ([f64; 2], [f64; 2]) {
        let b = self.b.observed;
        let at = |h: u32| b.point(self.ends_b[h as usize][side].point);
        let usable = |h: u32| !self.ends_b[h as usize][side].angle.is_nan();
        let step =
            |p: [f64; 2], q: [f64; 2], seconds: f64| [(q[0] - p[0]) / seconds, (q[1] - p[1]) / seconds];
        let (first, last) = (between.first, between.last);
        if first != last {
            let (p, q) = (at(first), at(last));
            let pixel = [0, 1].map(|k| p[k] + between.share * (q[k] - p[k]));
            return (pixel, step(p, q, b.interval));
        }
        let (before, after) =
            (b.previous(first).filter(|&h| usable(h)), b.next(first).filter(|&h| usable(h)));
        let velocity = match (before, after) {
            (Some(p), Some(q)) => step(at(p), at(q), 2.0 * b.interval),
            (Some(p), None) => step(at(p), at(first), b.interval),
            (None, Some(q)) => step(at(first), at(q), b.interval),
            (None, None) => [0.0; 2],
        };
        (at(first), velocity)
    }
}

/// Mean quality of a meeting by chance: of `1 − d²/r²` for `d` uniform below `r`.
const EXPECTED: f64 = 2.0 / 3.0;

/// What two cameras have in common at one radius, by as many shifts of their clocks as one likes.
pub struct ShiftScorer<'t> {
    tangents: &'t PairTangents<'t>,
    radius: f64,
    /// Moment by moment what it costs that no end meets any: what each would get by chance, whatever the shift.
    unmet: Vec<Score>,
}

impl ShiftScorer<'_> {
    /// What the two cameras have in common with B's moments moved on by `shift`.
    pub fn score(&self, shift: usize) -> Score {
        self.by_moment(shift).into_iter().fold(Score::default(), |sum, s| sum.plus(&s))
    }

    /// What the two cameras have in common, moment by moment.
    pub fn by_moment(&self, shift: usize) -> Vec<Score> {
        let mut scores = self.unmet.clone();
        let met = self.tangents.meet(self.radius, shift);
        for (k, m) in met.iter().enumerate() {
            let score = &mut scores[m.moment.index()];
            score.excess += (1.0 - (m.distance / self.radius).powi(2)) * m.surprise;
            score.whole += usize::from(other_end(&met, k).is_some());
        }
        scores
    }
}

impl Score {
    /// The sum of two.
    #[must_use]
    pub fn plus(self, other: &Self) -> Self {
        Self {
            ends: self.ends + other.ends,
            whole: self.whole + other.whole,
            excess: self.excess + other.excess,
        }
    }
}
