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

use std::ops::AddAssign;

mod arrays;
mod comparer;
mod elementary;
mod passes;
mod pencil;
mod scorer;
mod tangents;

pub use comparer::{AtRadius, Comparer, Met};
pub(super) use elementary::logarithm;
pub use scorer::Scorer;

use super::views::Views;
use crate::geometry::Fundamental;

/// What a silhouette's tangent is the edge of: below a *top* is its object, above a *bottom*.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// The object lies below (larger y).
    Top,
    /// The object lies above.
    Bottom,
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

/// Robust standard deviation of the distances, pixels; NaN of no points.
pub fn spread(points: &[FrontierPoint]) -> f64 {
    let mut distances: Vec<f64> = points.iter().map(|p| p.distance).collect();
    if distances.is_empty() {
        return f64::NAN;
    }
    let middle = distances.len() / 2;
    1.4826 * *distances.select_nth_unstable_by(middle, f64::total_cmp).1
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

impl AddAssign for ClassScore {
    fn add_assign(&mut self, other: Self) {
        self.tangents += other.tangents;
        self.matches += other.matches;
        self.expected += other.expected;
        self.excess += other.excess;
    }
}

impl AddAssign for FrontierScore {
    fn add_assign(&mut self, other: Self) {
        self.tops += other.tops;
        self.bottoms += other.bottoms;
    }
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

/// The comparison of all tangents under one `F`.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// Evidence for `F`.
    pub score: FrontierScore,
    /// The tangents that met, by frames.
    pub points: Vec<FrontierPoint>,
}

/// Compares all tangents of two views under `F`.
pub fn compare(views: &Views, f: &Fundamental, options: &FrontierOptions) -> Comparison {
    let mut comparer = Comparer::new(&views.a, &views.b, f, options.upright);
    let mut met = comparer.meet(options.shift, options.radius);
    let found = met.at(options.radius);
    Comparison { score: found.score(), points: found.points() }
}

/// The evidence for `F` alone.
pub fn frontier_score(views: &Views, f: &Fundamental, options: &FrontierOptions) -> FrontierScore {
    let mut comparer = Comparer::new(&views.a, &views.b, f, options.upright);
    comparer.meet(options.shift, options.radius).at(options.radius).score()
}
