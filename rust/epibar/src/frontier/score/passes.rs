//! The passes of a comparison, over flat arrays that the compiler vectorises for what the CPU has.
//!
//! Tangents whose objects lie on corresponding sides are compared with each other only, so everything is done twice, once
//! for each side of A.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::angles::PencilAngles;
use super::arrays::{Sent, Targets, pixels_per_radian};
use super::elementary::{decay, logarithm};
use super::objects::Objects;
use super::tangents::{EITHER, LANES, NONE, Sides, Tangents, fill, partner};
use crate::frontier::views::View;
use crate::geometry::Fundamental;

/// About so many frames in which both cameras see something decide the sign of the map of rays, and no more than one in [`SIGN_STEP`] of these;
/// all of them where nothing meets in those.
const SIGN_FRAMES: usize = 24;
const SIGN_STEP: usize = 4;

/// For each tangent of B in a frame the nearest of A.
#[derive(Debug, Default)]
struct NearestOfA {
    /// Squared distance.
    distance: Vec<f64>,
    /// Index of the tangent of A.
    of: Vec<f64>,
}

/// What a comparison writes.
#[derive(Debug, Default)]
pub(super) struct Buffers {
    pub(super) a: [Tangents; 2],
    pub(super) b: [Tangents; 2],
    pub(super) sent: [Sent; 2],
    pub(super) targets: [Targets; 2],
    pub(super) objects: Objects,
    pub(super) sides: Vec<u8>,
    nearest: NearestOfA,
}

/// Pass: everything that depends on `f` alone.
pub(super) struct Touched<'p> {
    pub(super) buffers: &'p mut Buffers,
    pub(super) a: &'p View,
    pub(super) b: &'p View,
    pub(super) f: &'p Fundamental,
}

impl WithSimd for Touched<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        self.buffers.touch(self.a, self.b, self.f);
    }
}

/// Pass: the comparison the other way.
pub(super) struct Reversed<'p> {
    pub(super) buffers: &'p mut Buffers,
    pub(super) b: &'p View,
    pub(super) f: &'p Fundamental,
}

impl WithSimd for Reversed<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        self.buffers.reverse(self.b, self.f);
    }
}

/// Pass: whether rays go by `F` or by `−F`, by matches within the radius on a few frames.
pub(super) struct Sign<'p> {
    pub(super) buffers: &'p mut Buffers,
    pub(super) sides: Sides,
    pub(super) shift: usize,
    pub(super) radius: f64,
}

impl WithSimd for Sign<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        self.buffers.sign(simd, self.sides, self.shift, self.radius)
    }
}

/// Pass: which tangents meet.
pub(super) struct Meetings<'p> {
    pub(super) buffers: &'p mut Buffers,
    pub(super) sides: Sides,
    pub(super) shift: usize,
    pub(super) sign: f64,
}

impl WithSimd for Meetings<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.buffers.meet(simd, self.sides, self.shift, self.sign);
    }
}

/// Pass: chance, surprise and excess of every tangent of A at a radius, and the evidence of silhouettes where it is asked for.
pub(super) struct Chances<'p> {
    pub(super) buffers: &'p mut Buffers,
    pub(super) sides: Sides,
    pub(super) sign: f64,
    pub(super) radius: f64,
    pub(super) objects: bool,
}

impl WithSimd for Chances<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        self.buffers.weigh(self.sides, self.sign, self.radius);
        if self.objects {
            let Buffers { a, b, sent, objects, .. } = self.buffers;
            objects.fill(a, b, sent, self.sides, self.radius);
        }
    }
}

/// Indices of the lanes of a vector.
const COUNTED: [f64; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// Part of some values as whole vectors.
#[inline(always)]
fn vectors<'v, S: Simd>(values: &'v [f64], part: &Range<usize>) -> &'v [S::f64s] {
    S::as_simd_f64s(&values[part.clone()]).0
}

/// The least of some values and which it is, the first of equal ones; [`NONE`] where none is finite.
#[inline(always)]
fn first_least<S: Simd>(simd: S, values: S::f64s, which: S::f64s) -> (f64, u32) {
    let least = simd.reduce_min_f64s(values);
    if least == f64::INFINITY {
        return (f64::INFINITY, NONE);
    }
    let equal = simd.equal_f64s(values, simd.splat_f64s(least));
    let index = simd.reduce_min_f64s(simd.select_f64s(equal, which, simd.splat_f64s(f64::INFINITY)));
    (least, index as u32)
}

impl Buffers {
    /// Everything that depends on `f` alone.
    #[inline(always)]
    fn touch(&mut self, a: &View, b: &View, f: &Fundamental) {
        fill(&mut self.a, a, f.epipole_a(), &mut self.sides);
        fill(&mut self.b, b, f.epipole_b(), &mut self.sides);
        self.send(b, f);
    }

    /// From the other view to this one, `f` being that from there: the tangents of both are as they are.
    #[inline(always)]
    fn reverse(&mut self, b: &View, f: &Fundamental) {
        std::mem::swap(&mut self.a, &mut self.b);
        self.send(b, f);
    }

    /// Where tangents of either view are seen in the pencil of B.
    #[inline(always)]
    fn send(&mut self, b: &View, f: &Fundamental) {
        let pencil = PencilAngles::new(f.epipole_b(), b.size);
        for side in 0..2 {
            self.targets[side].fill(&self.b[side], f, &pencil);
            self.sent[side].fill(&self.a[side], f, &pencil);
        }
    }

    /// Which tangents meet.
    #[inline(always)]
    fn meet<S: Simd>(&mut self, simd: S, sides: Sides, shift: usize, sign: f64) {
        for side in 0..2 {
            for frame in 0..self.a[side].frames() {
                self.meet_frame(simd, sides, side, frame, shift, sign);
            }
            let targets = &self.targets[partner(side, sides)];
            let sent = &mut self.sent[side];
            for i in 0..sent.met.len() {
                let j = sent.met[i] as usize;
                if sent.met[i] != NONE {
                    sent.lever[i] = pixels_per_radian(sent.norm2[i], targets.back_norm2[j], targets.lever[j]);
                }
            }
        }
    }

    /// Whether rays go by `F` or by `−F`.
    #[inline(always)]
    fn sign<S: Simd>(&mut self, simd: S, sides: Sides, shift: usize, radius: f64) -> f64 {
        let some = |busy: usize| (busy / SIGN_FRAMES).max(SIGN_STEP);
        let mut votes = self.votes(simd, sides, shift, radius, some);
        if votes[0] == votes[1] {
            votes = self.votes(simd, sides, shift, radius, |_| 1);
        }
        if votes[1] > votes[0] { -1.0 } else { 1.0 }
    }

    /// What meets by `F` and by `−F` in one of so many of the frames in which there is something to meet; `step`: of their number.
    #[inline(always)]
    fn votes<S: Simd>(
        &mut self,
        simd: S,
        sides: Sides,
        shift: usize,
        radius: f64,
        step: impl Fn(usize) -> usize,
    ) -> [f64; 2] {
        let mut votes = [0.0; 2];
        for side in 0..2 {
            let frames = self.a[side].frames();
            let busy: Vec<usize> =
                (0..frames).filter(|&frame| self.is_busy(side, sides, frame, shift)).collect();
            for &frame in busy.iter().step_by(step(busy.len())) {
                for (vote, sign) in votes.iter_mut().zip([1.0, -1.0]) {
                    self.meet_frame(simd, sides, side, frame, shift, sign);
                    for i in self.a[side].of(frame) {
                        *vote += (1.0 - self.sent[side].squared[i] / (radius * radius)).max(0.0);
                    }
                }
            }
        }
        votes
    }

    /// Whether A has tangents of a side in a frame, and B any that these may meet.
    #[inline(always)]
    fn is_busy(&self, side: usize, sides: Sides, frame: usize, shift: usize) -> bool {
        let b = &self.b[partner(side, sides)];
        !self.a[side].of(frame).is_empty() && !b.of((frame + shift) % b.frames()).is_empty()
    }

    /// For each tangent of A in a frame the nearest of B that it may meet, if that has none nearer.
    #[inline(always)]
    fn meet_frame<S: Simd>(
        &mut self,
        simd: S,
        sides: Sides,
        side: usize,
        frame: usize,
        shift: usize,
        sign: f64,
    ) {
        let partner = partner(side, sides);
        let (a, b) = (&self.a[side], &self.b[partner]);
        let (sent, targets) = (&mut self.sent[side], &self.targets[partner]);
        let in_a = a.of(frame);
        let in_b = b.of((frame + shift) % b.frames());
        let first = in_b.start;
        // Whole vectors: what they read of the next frame is refused by its index.
        let read = first..first + in_b.len().next_multiple_of(LANES);
        let (x, y) = (vectors::<S>(&b.x, &read), vectors::<S>(&b.y, &read));
        let back = vectors::<S>(&targets.back_norm2, &read);
        let line = b.line.each_ref().map(|part| vectors::<S>(part, &read));
        let refused = b.refused.each_ref().map(|part| vectors::<S>(part, &read));
        let near = &mut self.nearest;
        for (values, empty) in [(&mut near.distance, f64::INFINITY), (&mut near.of, -1.0)] {
            values.clear();
            values.resize(read.len(), empty);
        }
        let distance = S::as_mut_simd_f64s(&mut near.distance).0;
        let of = S::as_mut_simd_f64s(&mut near.of).0;
        let index = S::as_simd_f64s(&COUNTED).0[0];
        let (zero, never) = (simd.splat_f64s(0.0), simd.splat_f64s(f64::INFINITY));
        let (step, count) = (simd.splat_f64s(S::F64_LANES as f64), simd.splat_f64s(in_b.len() as f64));
        let dot = |p: [S::f64s; 3], q: [S::f64s; 3]| {
            let first = simd.add_f64s(simd.mul_f64s(p[0], q[0]), simd.mul_f64s(p[1], q[1]));
            simd.add_f64s(first, simd.mul_f64s(p[2], q[2]))
        };
        for i in in_a.clone() {
            let to = [0, 1, 2].map(|k| simd.splat_f64s(sent.line[k][i]));
            let ray = [0, 1, 2].map(|k| simd.splat_f64s(sent.line[k][i] * sign));
            let norm2 = simd.splat_f64s(sent.norm2[i]);
            let refused = refused[if sides.upright { (a.class[i] & EITHER) as usize } else { 0 }];
            let mine = simd.splat_f64s(i as f64);
            let (mut least, mut which, mut at) = (never, simd.splat_f64s(-1.0), index);
            for j in 0..x.len() {
                let algebraic = simd
                    .add_f64s(simd.add_f64s(simd.mul_f64s(x[j], to[0]), simd.mul_f64s(y[j], to[1])), to[2]);
                let square = simd.mul_f64s(algebraic, algebraic);
                let squared = simd.div_f64s(square, simd.add_f64s(norm2, back[j]));
                let along = dot([line[0][j], line[1][j], line[2][j]], ray);
                let value = simd.add_f64s(squared, refused[j]);
                let value = simd.select_f64s(simd.less_than_f64s(zero, along), value, never);
                let value = simd.select_f64s(simd.less_than_f64s(at, count), value, never);
                let nearer = simd.less_than_f64s(value, least);
                least = simd.select_f64s(nearer, value, least);
                which = simd.select_f64s(nearer, at, which);
                let nearer = simd.less_than_f64s(value, distance[j]);
                distance[j] = simd.select_f64s(nearer, value, distance[j]);
                of[j] = simd.select_f64s(nearer, mine, of[j]);
                at = simd.add_f64s(at, step);
            }
            (sent.squared[i], sent.met[i]) = first_least(simd, least, which);
        }
        // One to one: a match is the nearest of both.
        for i in in_a {
            let j = sent.met[i];
            if j != NONE && near.of[j as usize] == i as f64 {
                sent.met[i] = first as u32 + j;
            } else {
                (sent.squared[i], sent.met[i]) = (f64::INFINITY, NONE);
            }
        }
    }

    /// Chance, surprise and excess of every tangent of A at a radius.
    #[inline(always)]
    fn weigh(&mut self, sides: Sides, sign: f64, radius: f64) {
        let frames = self.b[0].frames() as f64;
        for side in 0..2 {
            let sent = &mut self.sent[side];
            let histogram = &self.targets[partner(side, sides)].histogram;
            let n = sent.met.len();
            let (chance, angles, levers) = (&mut sent.chance[..n], &sent.angle[..n], &sent.lever[..n]);
            let (squared, elsewhere) = (&sent.squared[..n], &sent.elsewhere[..n]);
            let radius2 = radius * radius;
            for i in 0..n {
                let turned = if sign > 0.0 { angles[i] } else { opposite(angles[i]) };
                let lever = if squared[i] < radius2 { levers[i] } else { elsewhere[i] };
                chance[i] = histogram.count(turned, radius / lever);
            }
            let (surprise, excess) = (&mut sent.surprise[..n], &mut sent.excess[..n]);
            for i in 0..n {
                // Poisson: the chance that at least one tangent of another moment lies this near.
                let q = 1.0 - decay((chance[i] + 0.5) / frames);
                let m = (1.0 - squared[i] / radius2).max(0.0);
                chance[i] = q;
                surprise[i] = -logarithm(q);
                excess[i] = (m - q * 2.0 / 3.0) * surprise[i];
            }
        }
    }
}

/// The angle of the line in the other direction.
#[inline(always)]
fn opposite(angle: f64) -> f64 {
    use std::f64::consts::PI;
    if angle > 0.0 { angle - PI } else { angle + PI }
}
