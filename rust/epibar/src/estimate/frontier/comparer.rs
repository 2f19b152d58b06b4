//! The comparison of all tangents of two views under one `F`.
//!
//! A [`Comparer`] holds what depends on `F` alone; [`Comparer::meet`] finds for each tangent of A the one of B that it meets
//! when the clocks are shifted so far; [`Met::at`] tells what that is worth at a radius. Buffers are kept from one
//! comparison of a thread to its next.

use std::cell::Cell;

use nalgebra::Vector3;
use pulp::Arch;

use super::passes::{Buffers, Chances, Meetings, Sides, Touched, partner};
use super::tangents::BOTTOM;
use super::{Class, ClassScore, FrontierPoint, FrontierScore};
use crate::estimate::views::View;
use crate::geometry::Fundamental;
use crate::line::ImageSize;

thread_local! {
    static SPARE: Cell<Option<Box<Buffers>>> = const { Cell::new(None) };
}

/// Tangents of both views from the epipoles of one `F`, and how often B's lie where.
pub struct Comparer {
    buffers: Box<Buffers>,
    sides: Sides,
    arch: Arch,
}

impl Drop for Comparer {
    fn drop(&mut self) {
        SPARE.set(Some(std::mem::take(&mut self.buffers)));
    }
}

impl Comparer {
    /// Tangents of `a` and `b` under `f`, which is from `a` to `b`. `upright`: a top meets a top only.
    pub fn new(a: &View, b: &View, f: &Fundamental, upright: bool) -> Self {
        Self::on(Arch::new(), a, b, f, upright)
    }

    fn on(arch: Arch, a: &View, b: &View, f: &Fundamental, upright: bool) -> Self {
        let mut buffers = SPARE.take().unwrap_or_default();
        arch.dispatch(Touched { buffers: &mut buffers, a, b, f });
        Self { buffers, sides: Sides { same: keeps_side(f, a.size), upright }, arch }
    }

    /// Finds which tangents meet when frame `t` of A is compared with common frame `t + shift` of B, cyclically.
    ///
    /// Which of the two maps of rays `± F` holds shows on a few frames, by matches within `radius` pixels.
    pub fn meet(&mut self, shift: usize, radius: f64) -> Met<'_> {
        let buffers = &mut *self.buffers;
        let sign = self.arch.dispatch(Meetings { buffers, sides: self.sides, shift, radius });
        Met { comparer: self, sign }
    }
}

/// Tangents of A with those of B that they meet.
pub struct Met<'c> {
    comparer: &'c mut Comparer,
    sign: f64,
}

impl Met<'_> {
    /// What each match is worth within `radius` pixels.
    pub fn at(&mut self, radius: f64) -> AtRadius<'_> {
        let Comparer { buffers, sides, arch } = &mut *self.comparer;
        arch.dispatch(Chances { buffers, sides: *sides, sign: self.sign, radius });
        AtRadius { comparer: self.comparer, radius }
    }
}

/// Matches with their evidence at one radius.
pub struct AtRadius<'c> {
    comparer: &'c Comparer,
    radius: f64,
}

impl AtRadius<'_> {
    /// The evidence.
    pub fn score(&self) -> FrontierScore {
        let mut score = FrontierScore::default();
        let radius2 = self.radius * self.radius;
        let Buffers { a, sent, .. } = &*self.comparer.buffers;
        for (tangents, sent) in a.iter().zip(sent) {
            let mut of_class = [ClassScore::default(); 2];
            for i in 0..tangents.len() {
                let class = &mut of_class[usize::from(tangents.class[i] & BOTTOM != 0)];
                class.tangents += 1;
                class.matches += usize::from(sent.squared[i] < radius2);
                class.expected += sent.chance[i];
                class.excess += sent.excess[i];
            }
            for (sum, part) in [&mut score.tops, &mut score.bottoms].into_iter().zip(of_class) {
                sum.tangents += part.tangents;
                sum.matches += part.matches;
                sum.expected += part.expected;
                sum.excess += part.excess;
            }
        }
        score
    }

    /// Evidence of each frame of A; it sums to that of the score.
    pub fn per_frame(&self) -> Vec<f64> {
        let Buffers { a, sent, .. } = &*self.comparer.buffers;
        let of = |side: usize, frame: usize| sent[side].excess[a[side].of(frame)].iter().sum::<f64>();
        (0..a[0].frames()).map(|frame| of(0, frame) + of(1, frame)).collect()
    }

    /// The tangents that meet within the radius, by frames.
    pub fn points(&self) -> Vec<FrontierPoint> {
        let Buffers { a, b, sent, .. } = &*self.comparer.buffers;
        let mut points = Vec::new();
        for frame in 0..a[0].frames() {
            for side in 0..2 {
                let (tangents, sent) = (&a[side], &sent[side]);
                let targets = &b[partner(side, self.comparer.sides)];
                for i in tangents.of(frame) {
                    let distance = sent.squared[i].sqrt();
                    if distance < self.radius {
                        let j = sent.met[i] as usize;
                        points.push(FrontierPoint {
                            frame: frame as u32,
                            a: [tangents.x[i], tangents.y[i]],
                            b: [targets.x[j], targets.y[j]],
                            distance,
                            surprise: sent.surprise[i],
                            class: if tangents.class[i] & BOTTOM == 0 { Class::Top } else { Class::Bottom },
                        });
                    }
                }
            }
        }
        points
    }
}

/// Whether the 1-D homography of `F` keeps the sense of rotation between oriented pencils `e × x` and `F x`.
fn keeps_side(f: &Fundamental, size_a: ImageSize) -> bool {
    let (e, e_b) = (f.epipole_a(), f.epipole_b());
    // Two points whose epipolar lines differ: of three corners some pair always does.
    let (x, y) = (size_a.x_max(), size_a.y_max());
    let corners = [Vector3::new(0.0, 0.0, 1.0), Vector3::new(x, 0.0, 1.0), Vector3::new(0.0, y, 1.0)];
    let mut best = (0.0f64, true);
    for (p, q) in [(0, 1), (1, 2), (2, 0)] {
        let (p, q) = (corners[p], corners[q]);
        let in_a = e.dot(&p.cross(&q));
        let in_b = f.line_in_b(&p).cross(&f.line_in_b(&q)).dot(e_b);
        if in_a.abs() > best.0 {
            best = (in_a.abs(), in_a * in_b > 0.0);
        }
    }
    best.1
}
