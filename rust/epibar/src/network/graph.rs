//! The graph of pairs: which are searched for, and what they bring into the network.

use nalgebra::Matrix3;

use super::residual::Meeting;
use super::start::{Hypothesis, PairHypotheses};
use super::thresholds as limits;
use crate::calibration::Calibration;
use crate::clock::{Aligned, Clock};
use crate::error::{Error, Result};
use crate::frontier::{Up, compare};
use crate::geometry::Fundamental;
use crate::recording::Recording;
use crate::recording::tracker::Links;

/// What was found of a pair by itself.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct PairFound {
    /// Index of camera A.
    pub a: usize,
    /// Index of camera B, the larger.
    pub b: usize,
    /// Geometries in raw pixels, `x_bᵀ F x_a = 0`, the best first, each with its score as a share of the best one's.
    pub geometries: Vec<(Matrix3<f64>, f64)>,
    /// Where A's first frame falls in B, frames of B.
    pub offset: f64,
    /// Frames of B for each frame of A.
    pub frames_per_frame: f64,
    /// Normal deviate of the best geometry on frames kept aside.
    pub z: f64,
    /// Whether it was accepted by itself.
    pub accepted: bool,
}

/// Rivals that go along: those with so much of the best one's score, and how many.
const RIVALS: (f64, usize) = (0.5, 3);

impl PairFound {
    /// Geometries of cameras `a < b` with clocks that run alike and started together, for which nothing speaks yet.
    ///
    /// # Errors
    /// [`Error::Argument`] where `a` is not the smaller, and without a geometry.
    pub fn new(a: usize, b: usize, geometries: Vec<(Matrix3<f64>, f64)>) -> Result<Self> {
        let refuse = |value: String, expected| Err(Error::Argument { name: "pair", value, expected });
        if a >= b {
            return refuse(format!("{a}, {b}"), "two cameras, the one with the smaller index first");
        }
        if geometries.is_empty() {
            return refuse(format!("{a}, {b}"), "a geometry");
        }
        Ok(Self { a, b, geometries, offset: 0.0, frames_per_frame: 1.0, z: 0.0, accepted: false })
    }

    /// With where A's first frame falls in B, frames of B, and how many frames of B there are for each of A.
    #[must_use]
    pub fn timing(self, offset: f64, frames_per_frame: f64) -> Self {
        Self { offset, frames_per_frame, ..self }
    }

    /// With the normal deviate of the best geometry, and whether it was accepted by itself.
    #[must_use]
    pub fn verdict(self, z: f64, accepted: bool) -> Self {
        Self { z, accepted, ..self }
    }

    /// Of a calibration of two recordings; `None` where it has no geometry.
    pub fn of(a: usize, b: usize, calibration: &Calibration) -> Option<Self> {
        let best = calibration.fundamental?;
        let rivals = calibration.rivals.iter().filter(|r| r.share > RIVALS.0).take(RIVALS.1);
        let others = rivals.map(|r| (*r.fundamental.matrix(), r.share));
        Some(Self {
            a,
            b,
            geometries: std::iter::once((*best.matrix(), 1.0)).chain(others).collect(),
            offset: calibration.timing.offset,
            frames_per_frame: calibration.timing.frames_per_frame,
            z: calibration.evidence.z,
            accepted: calibration.accepted(),
        })
    }

    /// What it brings into the network: its geometries with the tangents that meet under them; `None` where none do.
    pub(super) fn hypotheses(&self, a: &Recording, b: &Recording) -> Option<PairHypotheses> {
        let clock = Clock::of_frames(self.offset, self.frames_per_frame, a, b);
        let links = Links::new(b);
        let aligned = Aligned::new(a, b, &links, clock, [Up::IMAGE; 2]).thinned(FRAMES);
        let common = aligned.frame_pairs();
        let views = aligned.views(&common);
        let scale = 0.5 * (a.size().diagonal() + b.size().diagonal()) / 800.0;
        let mut hypotheses = Vec::new();
        for (matrix, share) in &self.geometries {
            let Some(f) = Fundamental::from_matrix(matrix, a.size(), b.size()) else { continue };
            let meetings: Vec<Meeting> = compare(&views, &f, RADIUS * scale)
                .matches
                .iter()
                .map(|m| Meeting {
                    a: m.a,
                    b: m.b,
                    outward_a: [0.0; 2],
                    outward_b: [0.0; 2],
                    velocity_b: [0.0; 2],
                    time_a: a.times()[common[m.frame.index()].a as usize] - a.times()[0],
                    time_b: 0.0,
                    weight: 1.0,
                })
                .collect();
            if meetings.len() >= limits::LEAST_MEETINGS {
                hypotheses.push(Hypothesis { fundamental: *f.matrix(), meetings, score: share * self.z });
            }
        }
        (!hypotheses.is_empty()).then_some(PairHypotheses { a: self.a, b: self.b, hypotheses })
    }
}

/// Common frames that a geometry is looked at with.
const FRAMES: usize = 400;
/// Radius within which tangents meet, pixels of a 640×480 image.
const RADIUS: f64 = 4.0;

/// Up to so many cameras, all pairs are searched, and asked for their clocks.
pub const ALL_PAIRS: usize = 6;
/// Pairs that each of more cameras is part of, where there are so many that are likely.
const EACH: usize = 5;
/// Pairs beyond those that a camera may have to help one that has too few.
const TO_HELP: usize = 2;
/// Pairs for each camera, at most.
const MOST: usize = 3;

/// All pairs `a < b` of so many cameras.
pub fn all_pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |a| (a + 1..count).map(move |b| (a, b)))
}

/// Which pairs of cameras to search, by how likely each pair is to show the same, a score for each: all pairs of few
/// cameras; of many the tree of the likeliest, further ones while both cameras have too few, and then the likeliest ones of
/// the camera that has the fewest. About `5/2` for each camera and never more than 3, however many there are.
pub fn chosen(count: usize, likeness: &[(usize, usize, f64)]) -> Vec<(usize, usize)> {
    if count <= ALL_PAIRS {
        return all_pairs(count).collect();
    }
    let mut order: Vec<&(usize, usize, f64)> = likeness.iter().collect();
    order.sort_by(|p, q| q.2.total_cmp(&p.2).then((p.0, p.1).cmp(&(q.0, q.1))));
    let order: Vec<(usize, usize)> = order.into_iter().map(|&(a, b, _)| (a, b)).collect();
    let mut group: Vec<usize> = (0..count).collect();
    let mut taken = Taken { pairs: Vec::new(), degree: vec![0; count] };
    for &(a, b) in &order {
        if group[a] != group[b] {
            let (one, other) = (group[a], group[b]);
            group.iter_mut().filter(|g| **g == other).for_each(|g| *g = one);
            taken.take(a, b);
        }
    }
    for &(a, b) in &order {
        if taken.degree[a] < EACH && taken.degree[b] < EACH && !taken.pairs.contains(&(a, b)) {
            taken.take(a, b);
        }
    }
    let mut hopeless = vec![false; count];
    while taken.pairs.len() < MOST * count {
        let poor = (0..count).filter(|&c| !hopeless[c] && taken.degree[c] < EACH);
        let Some(poorest) = poor.min_by_key(|&c| taken.degree[c]) else { break };
        let helps = |&&(a, b): &&(usize, usize)| {
            let other = if a == poorest { b } else { a };
            (a == poorest || b == poorest)
                && taken.degree[other] < EACH + TO_HELP
                && !taken.pairs.contains(&(a, b))
        };
        match order.iter().find(helps) {
            Some(&(a, b)) => taken.take(a, b),
            None => hopeless[poorest] = true,
        }
    }
    taken.pairs.sort_unstable();
    taken.pairs
}

/// Pairs that are searched, and of how many each camera is part.
struct Taken {
    pairs: Vec<(usize, usize)>,
    degree: Vec<usize>,
}

impl Taken {
    fn take(&mut self, a: usize, b: usize) {
        self.pairs.push((a, b));
        self.degree[a] += 1;
        self.degree[b] += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn searches_grow_with_the_cameras_and_reach_all() {
        for count in [7, 12, 20, 60] {
            // Cameras along a street see what their neighbours see.
            let likeness: Vec<(usize, usize, f64)> =
                all_pairs(count).map(|(a, b)| (a, b, 10.0 / (b - a) as f64)).collect();
            let taken = chosen(count, &likeness);
            assert!(taken.len() <= 3 * count, "{count}: {}", taken.len());
            let mut reached = vec![false; count];
            reached[0] = true;
            for _ in 0..count {
                for &(a, b) in &taken {
                    let either = reached[a] || reached[b];
                    (reached[a], reached[b]) = (either, either);
                }
            }
            assert!(reached.iter().all(|r| *r));
        }
        assert_eq!(chosen(4, &[]).len(), 6);
    }

    #[test]
    fn at_most_three_searches_for_each_camera_whatever_is_likely() {
        let mut random = 1_u64;
        for count in [7, 8, 12, 20, 50] {
            for hubs in 0..20 {
                // Some cameras see what everybody sees, the last one hardly anything, the others what chance gives.
                let likeness: Vec<(usize, usize, f64)> = all_pairs(count)
                    .map(|(a, b)| {
                        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                        let chance = (random >> 40) as f64 / (1_u64 << 24) as f64;
                        let hub = if a < hubs % 4 { 1.0 } else { 0.0 };
                        (a, b, if b == count - 1 { 0.01 * chance } else { chance + hub })
                    })
                    .collect();
                let taken = chosen(count, &likeness);
                assert!(taken.len() <= 3 * count, "{count}, {hubs}: {}", taken.len());
                for camera in 0..count {
                    let own = taken.iter().filter(|&&(a, b)| a == camera || b == camera).count();
                    assert!(own >= 4, "{count}, {hubs}: camera {camera} has {own}");
                }
            }
        }
    }
}
