//! A pair of cameras, and what it brings into the network.

use nalgebra::Matrix3;

use crate::calibration::Calibration;
use crate::clock::{Aligned, Clock};
use crate::error::{Error, Result};
use crate::frontier::{Up, tangent_matches};
use crate::geometry::Fundamental;
use crate::image::ImageSize;
use crate::network::model::residual::Meeting;
use crate::network::thresholds as limits;
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

/// A geometry of a pair, with the tangents that meet under it.
#[derive(Debug, Clone)]
pub struct PairGeometry {
    /// `x_bᵀ F x_a = 0` in raw pixels.
    pub fundamental: Matrix3<f64>,
    /// What met.
    pub meetings: Vec<Meeting>,
    /// Its normal deviate as a pair's, times its share of the best one's.
    pub score: f64,
}

/// What is known of a pair.
#[derive(Debug, Clone)]
pub struct PairHypotheses {
    /// Index of camera A.
    pub a: usize,
    /// Index of camera B.
    pub b: usize,
    /// Most evidence first.
    pub hypotheses: Vec<PairGeometry>,
}

/// Other geometries of a pair that go along, at most.
pub const RIVALS: usize = 3;
/// The share of the best one's score that such a one has at the least.
pub const OFFERED_SHARE: f64 = 0.5;
/// Common frames that a geometry is looked at with.
const FRAMES: usize = 400;
/// Radius within which tangents meet, pixels of a 640×480 image.
const RADIUS: f64 = 4.0;

impl PairFound {
    /// Geometries of cameras `a < b` with clocks that run alike and started together, for which nothing speaks yet: of two cameras alone
    /// none is accepted without a [`verdict`](Self::verdict) of their pair.
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
        let rivals = calibration.rivals.iter().filter(|r| r.share > OFFERED_SHARE).take(RIVALS);
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
    pub(in crate::network) fn hypotheses(&self, a: &Recording, b: &Recording) -> Option<PairHypotheses> {
        let clock = Clock::of_frames(self.offset, self.frames_per_frame, a, b);
        let links = Links::new(b);
        let aligned = Aligned::new(a, b, &links, clock, [Up::IMAGE; 2]).thinned(FRAMES);
        let common = aligned.frame_pairs();
        let views = aligned.views(&common);
        let scale = ImageSize::pixel_scale([a.size(), b.size()]);
        let mut hypotheses = Vec::new();
        for (matrix, share) in &self.geometries {
            let Some(f) = Fundamental::from_matrix(matrix, a.size(), b.size()) else { continue };
            let meetings: Vec<Meeting> = tangent_matches(&views, &f, RADIUS * scale)
                .iter()
                .map(|m| Meeting {
                    a: m.a,
                    b: m.b,
                    outward_a: [0.0; 2],
                    outward_b: [0.0; 2],
                    smallness: [0.0; 2],
                    velocity_b: [0.0; 2],
                    time_a: a.times()[common[m.frame.index()].a.index()] - a.times()[0],
                    time_b: 0.0,
                    weight: 1.0,
                })
                .collect();
            if meetings.len() >= limits::LEAST_MEETINGS {
                hypotheses.push(PairGeometry { fundamental: *f.matrix(), meetings, score: share * self.z });
            }
        }
        (!hypotheses.is_empty()).then_some(PairHypotheses { a: self.a, b: self.b, hypotheses })
    }
}
