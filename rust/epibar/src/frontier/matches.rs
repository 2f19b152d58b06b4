//! Tangents that meet, and scores summed over them.

use std::ops::AddAssign;

use crate::geometry::median::deviation;

/// What a silhouette's tangent is the edge of: below a *top* is its object, above a *bottom*.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// The object lies below (larger y).
    Top,
    /// The object lies above.
    Bottom,
}

/// Index of a pair of frames among those of some [`Views`](super::Views): neither a frame of A nor one of B.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct CommonFrame(pub u32);

impl CommonFrame {
    /// The index.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A tangent point of A and the one of B that it meets: images of one frontier point, if `F` is right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TangentMatch {
    /// When.
    pub frame: CommonFrame,
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

/// Robust standard deviation of the distances, pixels; NaN of no matches.
pub fn robust_deviation(matches: &[TangentMatch]) -> f64 {
    deviation(matches.iter().map(|p| p.distance)).unwrap_or(f64::NAN)
}

/// Score of one class of tangents.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ClassScore {
    /// Tangents of A in the frames used.
    pub tangents: usize,
    /// Tangents of A that met a tangent of B.
    pub matches: usize,
    /// How many would by chance.
    pub expected: f64,
    /// Excess over chance, each match weighed by how unlikely it was.
    pub excess: f64,
}

/// What became of a silhouette.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Outcome {
    /// The view ends at both of its ends, or the epipole lies inside.
    #[default]
    Hidden,
    /// It met nothing.
    Missed,
    /// One end met an end of a silhouette whose other end shows and was not met by its own.
    Torn,
    /// One end met, and the other of either silhouette is cut off.
    Cut,
    /// Both ends met those of one silhouette.
    Whole,
}

/// Score of whole silhouettes (`score/objects.rs`).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ObjectScore {
    /// Silhouettes of A of which an end shows.
    pub silhouettes: usize,
    /// Silhouettes of A both of whose ends meet the ends of one silhouette of B.
    pub whole: usize,
    /// Silhouettes of A of which one end meets, and the other, which shows in both views, does not.
    pub torn: usize,
    /// Likelihood ratio against chance, its logarithm.
    pub evidence: f64,
}

impl ObjectScore {
    pub(super) fn add(&mut self, outcome: Outcome, evidence: f64) {
        self.silhouettes += usize::from(outcome != Outcome::Hidden);
        self.whole += usize::from(outcome == Outcome::Whole);
        self.torn += usize::from(outcome == Outcome::Torn);
        self.evidence += evidence;
    }
}

/// Score of an `F`, class by class, and by whole silhouettes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrontierScore {
    /// Tangents with the object below.
    pub tops: ClassScore,
    /// Tangents with the object above.
    pub bottoms: ClassScore,
    /// Silhouettes.
    pub objects: ObjectScore,
}

impl AddAssign for ClassScore {
    fn add_assign(&mut self, other: Self) {
        self.tangents += other.tangents;
        self.matches += other.matches;
        self.expected += other.expected;
        self.excess += other.excess;
    }
}

impl AddAssign for ObjectScore {
    fn add_assign(&mut self, other: Self) {
        self.silhouettes += other.silhouettes;
        self.whole += other.whole;
        self.torn += other.torn;
        self.evidence += other.evidence;
    }
}

impl AddAssign for FrontierScore {
    fn add_assign(&mut self, other: Self) {
        self.tops += other.tops;
        self.bottoms += other.bottoms;
        self.objects += other.objects;
    }
}

impl FrontierScore {
    /// Evidence of whole silhouettes.
    pub fn total(&self) -> f64 {
        self.objects.evidence
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
