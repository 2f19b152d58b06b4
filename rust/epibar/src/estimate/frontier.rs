//! The frontier score: epipolar tangents of A that meet tangents of B, over chance (DESIGN §6).
//!
//! For a proposed `F`, every silhouette has two tangents from the epipole. A tangent of A, sent to B, should
//! meet a tangent of B that has its object on the corresponding side. A match counts by how unlikely it was: with
//! `q` the chance that *some* tangent of B lies that near at any other time, a tangent of A contributes
//! `(m − ⅔ q) · (−ln q)`, where `m = max(0, 1 − d²/r²)` for the Sampson distance `d` of its match. Under chance
//! the expectation is nought wherever the epipoles lie: where everything is tangent at one place all the time (heads
//! on the horizon, an epipole on the border) `q ≈ 1` and nothing is gained. Tops and bottoms are summed apart.
//!
//! *Orientation.* Epipolar rays, not just lines, correspond (Laveau and Faugeras 1996): seen from both
//! cameras a point in front of both lies on one half of its epipolar line. The map of rays is `± F`; the map of
//! sides is fixed by `F` alone: it is the orientation of the 1-D homography.

use std::ops::Range;

use nalgebra::{Vector2, Vector3};
use rayon::prelude::*;

use super::pencil_angle::{AngleHistogram, PencilAngle, centre_of_line};
use super::views::{View, Views};
use crate::geometry::fundamental::{Fundamental, normaliser};
use crate::geometry::tangent::epipolar_tangents;
use crate::line::{Homogeneous, ImageSize};

/// What a silhouette's tangent is the edge of: below a *top* is its object, above a *bottom*.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// The object lies below (larger y).
    Top,
    /// The object lies above.
    Bottom,
}

/// A tangent point in one view.
#[derive(Debug, Clone, Copy)]
struct Tangent {
    point: Homogeneous,
    /// The object lies on the positive side of `e × point`.
    positive: bool,
    class: Class,
    /// The tangent is too near the vertical for its class to mean anything.
    steep: bool,
}

/// Below this share of the vertical in a tangent's normal, top and bottom mean nothing (12°).
const STEEP: f64 = 0.2;

/// Tangents of all frames from one epipole.
struct Tangents {
    frame_start: Vec<u32>,
    all: Vec<Tangent>,
}

impl Tangents {
    fn new(view: &View, epipole: &Homogeneous) -> Self {
        let mut frame_start = Vec::with_capacity(view.frames() + 1);
        let mut all = Vec::with_capacity(2 * view.hulls());
        frame_start.push(0);
        for frame in 0..view.frames() {
            for hull in view.hulls_of(frame) {
                for tangent in epipolar_tangents(hull, epipole).into_iter().flatten() {
                    if view.on_border(tangent.point) {
                        continue;
                    }
                    let point = Vector3::new(tangent.point[0], tangent.point[1], 1.0);
                    let line = epipole.cross(&point);
                    let norm2 = line.x * line.x + line.y * line.y;
                    let towards = if tangent.positive { line.y } else { -line.y };
                    all.push(Tangent {
                        point,
                        positive: tangent.positive,
                        class: if towards > 0.0 { Class::Top } else { Class::Bottom },
                        steep: line.y * line.y < STEEP * STEEP * norm2,
                    });
                }
            }
            frame_start.push(all.len() as u32);
        }
        Self { frame_start, all }
    }

    fn of(&self, frame: usize) -> &[Tangent] {
        &self.all[self.frame_start[frame] as usize..self.frame_start[frame + 1] as usize]
    }
}

/// A tangent point of A that meets one of B.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrontierPoint {
    /// Index of the common frame.
    pub frame: u32,
    /// Point in A, pixels.
    pub a: [f64; 2],
    /// Point in B, pixels.
    pub b: [f64; 2],
    /// Sampson distance, pixels.
    pub distance: f64,
    /// `−ln` of the chance of a match this near.
    pub surprise: f64,
    /// Top or bottom, as seen in A.
    pub class: Class,
}

/// Evidence of one class of tangents.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ClassScore {
    /// Tangents of A in the frames used.
    pub tangents: usize,
    /// Those that met a tangent of B.
    pub matches: usize,
    /// How many would by chance.
    pub expected: f64,
    /// Excess over chance, each match weighed by how unlikely it was.
    pub excess: f64,
}

/// Evidence for an `F`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrontierScore {
    /// Tangents with the object below.
    pub tops: ClassScore,
    /// Tangents with the object above.
    pub bottoms: ClassScore,
}

impl FrontierScore {
    /// Evidence of both classes together.
    pub fn total(&self) -> f64 {
        self.tops.excess + self.bottoms.excess
    }

    /// Matches of both classes.
    pub fn matches(&self) -> usize {
        self.tops.matches + self.bottoms.matches
    }

    /// Tangents of both classes.
    pub fn tangents(&self) -> usize {
        self.tops.tangents + self.bottoms.tangents
    }
}

/// How tangents are compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrontierOptions {
    /// Two tangents meet below this Sampson distance, pixels.
    pub radius: f64,
    /// Both cameras are the right way up: a top meets a top (DESIGN §6, the mirror).
    pub upright: bool,
    /// Frame `t` of A is compared with common frame `t + shift` of B (cyclically), for tests of chance.
    pub shift: usize,
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

/// The comparison of all tangents under one `F`.
pub struct Comparison {
    /// Evidence for `F`.
    pub score: FrontierScore,
    /// The tangents that met.
    pub points: Vec<FrontierPoint>,
    /// Evidence of each frame; it sums to that of the score.
    pub per_frame: Vec<f64>,
}

/// Compares all tangents of two views under `F`.
pub fn compare(views: &Views, f: &Fundamental, options: &FrontierOptions) -> Comparison {
    let mut of_radius =
        compare_radii(&views.a, &views.b, f, &[options.radius], options.upright, options.shift);
    of_radius.remove(0)
}

/// Compares all tangents of view `a` with those of view `b` at several radii at once, pixels; one [`Comparison`] each.
///
/// `f` is from `a` to `b`; `upright` and `shift` as in [`FrontierOptions`].
pub fn compare_radii(
    a: &View,
    b: &View,
    f: &Fundamental,
    radii: &[f64],
    upright: bool,
    shift: usize,
) -> Vec<Comparison> {
    let comparer = Comparer::new(a, b, f, upright);
    let sign = comparer.sign(radii, shift, 0..a.frames());
    comparer.run(radii, sign, shift, 0..a.frames())
}

/// Evidence for one `F` with B shifted in time.
pub struct ShiftedScorer<'a> {
    comparer: Comparer<'a>,
    radius: f64,
    sign: f64,
}

impl<'a> ShiftedScorer<'a> {
    /// What is chance is told from all frames of `views`; which of the two maps of rays holds, from those of `fitted`
    /// unshifted. `radius` and `upright` as in [`FrontierOptions`].
    pub fn new(views: &Views, fitted: &Views, f: &'a Fundamental, radius: f64, upright: bool) -> Self {
        let frames = 0..fitted.frames();
        let sign = Comparer::new(&fitted.a, &fitted.b, f, upright).sign(&[radius], 0, frames);
        Self { comparer: Comparer::new(&views.a, &views.b, f, upright), radius, sign }
    }

    /// Evidence of some frames of A, at each of several shifts of B, cyclic over all frames.
    pub fn scores(&self, frames: &[usize], shifts: &[usize]) -> Vec<FrontierScore> {
        let run = |shift| self.comparer.run(&[self.radius], self.sign, shift, frames.iter().copied());
        shifts.par_iter().map(|&shift| run(shift)[0].score).collect()
    }
}

/// One in so many frames decides the sign of the map of rays.
const SIGN_STEP: usize = 6;

/// A tangent of B as those of A see it.
struct Target {
    /// Its line, oriented.
    line: Homogeneous,
    /// Pixels that the line moves at its point per radian.
    lever: f64,
    /// Squared length of the normal of its point's epipolar line in A.
    back_norm2: f64,
}

/// Tangents of both views from the epipoles of one `F`, and how often B's lie where.
struct Comparer<'a> {
    f: &'a Fundamental,
    a: Tangents,
    b: Tangents,
    /// What is the same for every tangent of A that is held against one of B.
    targets: Vec<Target>,
    pencil: PencilAngle,
    histogram: AngleHistogram,
    same_side: bool,
    size_b: ImageSize,
    upright: bool,
}

impl<'a> Comparer<'a> {
    fn new(view_a: &View, view_b: &View, f: &'a Fundamental, upright: bool) -> Self {
        let a = Tangents::new(view_a, f.epipole_a());
        let b = Tangents::new(view_b, f.epipole_b());
        let pencil = PencilAngle::new(f.epipole_b(), view_b.size);
        let to_pixels = normaliser(view_b.size).transpose();
        let mut angles = Vec::with_capacity(b.all.len());
        let targets = b
            .all
            .iter()
            .map(|t| {
                let line = f.epipole_b().cross(&t.point);
                let c = pencil.coordinates(&line);
                angles.push((c.y.atan2(c.x), t.positive));
                let turned = to_pixels * (pencil.basis * Vector2::new(-c.y, c.x));
                let back = f.line_in_a(&t.point);
                Target {
                    line,
                    lever: turned.dot(&t.point).abs()
                        / (line.x * line.x + line.y * line.y).sqrt().max(1e-300),
                    back_norm2: back.x * back.x + back.y * back.y,
                }
            })
            .collect();
        Self {
            f,
            a,
            b,
            targets,
            histogram: AngleHistogram::new(&angles),
            pencil,
            same_side: keeps_side(f, view_a.size),
            size_b: view_b.size,
            upright,
        }
    }

    /// Which of the two maps of rays holds, `F` or `−F`: it shows on a few frames.
    fn sign(&self, radii: &[f64], shift: usize, frames: Range<usize>) -> f64 {
        let few = |sign| {
            let found = self.run(radii, sign, shift, frames.clone().step_by(SIGN_STEP));
            found.iter().map(|c| c.score.total()).sum::<f64>()
        };
        if few(-1.0) > few(1.0) { -1.0 } else { 1.0 }
    }

    /// Evidence of some frames under the map of rays `sign · F`, for each radius.
    fn run(
        &self,
        radii: &[f64],
        sign: f64,
        shift: usize,
        chosen: impl Iterator<Item = usize>,
    ) -> Vec<Comparison> {
        let frames = self.a.frame_start.len() - 1;
        let mut found: Vec<Comparison> = radii
            .iter()
            .map(|_| Comparison {
                score: FrontierScore::default(),
                points: Vec::new(),
                per_frame: vec![0.0; frames],
            })
            .collect();
        let mut scratch = Scratch::default();
        for frame in chosen {
            let frame_b = (frame + shift) % frames;
            let base = self.b.frame_start[frame_b] as usize;
            let (tangents_a, tangents_b) = (self.a.of(frame), self.b.of(frame_b));
            scratch.nearest(self, tangents_a, tangents_b, &self.targets[base..], sign);
            for (i, t) in tangents_a.iter().enumerate() {
                let line = scratch.lines[i] * sign;
                let c = self.pencil.coordinates(&line);
                let (squared, j) = scratch.best_a[i];
                // One to one: a match is the nearest of both.
                let met =
                    (squared.is_finite() && scratch.best_b[j].1 == i).then(|| (base + j, squared.sqrt()));
                let place = Place {
                    met: met.map(|(j, d)| {
                        let target = &self.targets[j];
                        (pixels_per_radian(&line, target.back_norm2, target.lever), d)
                    }),
                    elsewhere: {
                        let (point, lever) = centre_of_line(&self.pencil, &c, &line, self.size_b);
                        let back = self.f.line_in_a(&point);
                        pixels_per_radian(&line, back.x * back.x + back.y * back.y, lever)
                    },
                    angle: c.y.atan2(c.x),
                    positive: t.positive == self.same_side,
                };
                for (radius, comparison) in radii.iter().zip(&mut found) {
                    let gain = self.count(t, &place, *radius, comparison);
                    comparison.per_frame[frame] += gain.excess;
                    if let (true, Some((j, distance))) = (gain.matched, met) {
                        let (p, r) = (&t.point, &self.b.all[j].point);
                        comparison.points.push(FrontierPoint {
                            frame: frame as u32,
                            a: [p.x, p.y],
                            b: [r.x, r.y],
                            distance,
                            surprise: gain.surprise,
                            class: t.class,
                        });
                    }
                }
            }
        }
        found
    }

    /// Adds one tangent of A to the score of its class.
    fn count(&self, t: &Tangent, place: &Place, radius: f64, comparison: &mut Comparison) -> Gain {
        let class = match t.class {
            Class::Top => &mut comparison.score.tops,
            Class::Bottom => &mut comparison.score.bottoms,
        };
        let met = place.met.filter(|(_, distance)| *distance < radius);
        let half = radius / met.map_or(place.elsewhere, |(lever, _)| lever);
        // Poisson: the chance that at least one tangent of another moment lies this near.
        let near = self.histogram.count(place.angle, half, place.positive);
        let q = 1.0 - (-(near + 0.5) / (self.b.frame_start.len() - 1) as f64).exp();
        let surprise = -q.ln();
        let m = met.map_or(0.0, |(_, distance)| 1.0 - (distance / radius).powi(2));
        let excess = (m - q * 2.0 / 3.0) * surprise;
        class.tangents += 1;
        class.matches += usize::from(met.is_some());
        class.expected += q;
        class.excess += excess;
        Gain { excess, surprise, matched: met.is_some() }
    }
}

/// Pixels of Sampson distance per radian where `line` touches B at a point whose epipolar line in A has a normal
/// of squared length `back_norm2`.
///
/// A Sampson distance shares the gap between both views: near an epipole of A a pixel there is worth many in B,
/// and a wide range of angles is within the radius.
fn pixels_per_radian(line: &Homogeneous, back_norm2: f64, lever: f64) -> f64 {
    let share = back_norm2 / (line.x.powi(2) + line.y.powi(2)).max(1e-300);
    (lever / (1.0 + share).sqrt()).max(1e-9)
}

/// Where a tangent of A falls in the pencil of B.
struct Place {
    /// Pixels per radian and distance of the tangent that it meets.
    met: Option<(f64, f64)>,
    /// Pixels per radian where its line passes the image centre.
    elsewhere: f64,
    angle: f64,
    positive: bool,
}

/// What one tangent adds to the evidence.
struct Gain {
    excess: f64,
    surprise: f64,
    matched: bool,
}

/// Buffers of the nearest-tangent search of one frame.
#[derive(Default)]
struct Scratch {
    lines: Vec<Homogeneous>,
    best_a: Vec<(f64, usize)>,
    best_b: Vec<(f64, usize)>,
}

impl Scratch {
    /// For each tangent of A the nearest of B that it may meet, and the reverse, by squared Sampson distance.
    fn nearest(&mut self, comparer: &Comparer, a: &[Tangent], b: &[Tangent], targets: &[Target], sign: f64) {
        let Comparer { f, same_side, upright, .. } = *comparer;
        self.lines.clear();
        self.best_a.clear();
        self.best_b.clear();
        self.best_b.resize(b.len(), (f64::INFINITY, usize::MAX));
        for (i, t) in a.iter().enumerate() {
            let line = f.line_in_b(&t.point);
            let norm = line.x * line.x + line.y * line.y;
            let mut nearest = (f64::INFINITY, 0);
            for (j, u) in b.iter().enumerate() {
                if (t.positive == u.positive) != same_side {
                    continue;
                }
                if upright && t.class != u.class && !t.steep && !u.steep {
                    continue;
                }
                let target = &targets[j];
                if target.line.dot(&line) * sign <= 0.0 {
                    continue;
                }
                let algebraic = u.point.dot(&line);
                let squared = algebraic * algebraic / (norm + target.back_norm2).max(1e-300);
                if squared < nearest.0 {
                    nearest = (squared, j);
                }
                if squared < self.best_b[j].0 {
                    self.best_b[j] = (squared, i);
                }
            }
            self.lines.push(line);
            self.best_a.push(nearest);
        }
    }
}

/// The evidence for `F` alone.
pub fn frontier_score(views: &Views, f: &Fundamental, options: &FrontierOptions) -> FrontierScore {
    compare(views, f, options).score
}
