//! How far may `F` turn without losing evidence?
//!
//! Where what moves keeps to a plane, `F = [e']× H` explains it for any `e'` (Hartley and Zisserman §11.9), and only what lies off
//! the plane knows better. So of the planes that `F` allows the one is taken to which half of the matched points keep closest: the
//! floor, a path, a slab. About it `e'` is moved to all sides, until the geometries are far apart over the images, and least squares may
//! turn them back. Where one neither comes back nor loses evidence, it may be the truth as well. That is asked of the silhouettes
//! and not of the covariance, which knows what is near the answer, and takes what meets under it for true.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rayon::prelude::*;

use super::over_image::image_distance;
use super::plane::Plane;
use super::rivals::Winner;
use super::thresholds::{DEEP_TURNED_SHARE, DEPTH, MIN_POINTS, TURNED_SHARE, larger, reaches};
use crate::frontier::volume::{Correspondence, disagreement};
use crate::frontier::{TangentMatch, Views};
use crate::geometry::Fundamental;
use crate::geometry::fundamental::normaliser;
use crate::refine::refine;

/// How far apart over the images turned geometries start, pixels of a 640×480 image.
const AWAY: [f64; 2] = [10.0, 20.0];
/// To how many sides the epipole is moved.
const SIDES: usize = 8;
/// Rounds of refinement that may turn a geometry back.
const ROUNDS: usize = 3;
/// The epipole is moved by no more than this, radians in normalised coordinates.
const FARTHEST: f64 = 0.8;
/// Halvings that find the angle.
const HALVINGS: usize = 24;

/// How far off geometries are that turned about a plane and kept their evidence, the farthest, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turned {
    /// Over the images.
    pub image: f64,
    /// Over the volume where things moved.
    pub volume: f64,
}

impl Turned {
    const NONE: Self = Self { image: 0.0, volume: 0.0 };
    const UNKNOWN: Self = Self { image: f64::NAN, volume: f64::NAN };

    /// The larger of each.
    fn or_larger(self, other: Self) -> Self {
        Self { image: larger(self.image, other.image), volume: larger(self.volume, other.volume) }
    }
}

/// How far `F` may turn; where matched points keep to no plane, only by what keeps more of the evidence. NaN where that cannot be told.
pub fn may_turn(
    views: &Views,
    winner: &Winner,
    matches: &[TangentMatch],
    plane_residual: f64,
    volume: &[Correspondence],
) -> Turned {
    if plane_residual.is_nan() || matches.len() < MIN_POINTS {
        return Turned::UNKNOWN;
    }
    let Some(plane) = Plane::new(&winner.fundamental, matches.iter(), views.sizes()) else {
        return Turned::UNKNOWN;
    };
    let turns = Turns { of: &winner.fundamental, views, plane };
    let share = if reaches(plane_residual, DEPTH) { DEEP_TURNED_SHARE } else { TURNED_SHARE };
    turns
        .turned(views.pixel_scale())
        .par_iter()
        .filter_map(|turned| refine(views, turned, &[winner.radius], ROUNDS))
        .filter(|turned| reaches(winner.share(turned), share))
        .map(|turned| Turned {
            image: image_distance(&winner.fundamental, &turned, views.sizes()),
            volume: disagreement(volume, &turned),
        })
        .reduce(|| Turned::NONE, Turned::or_larger)
}

/// Geometries that turn about a plane.
struct Turns<'f> {
    of: &'f Fundamental,
    views: &'f Views,
    plane: Plane,
}

impl Turns<'_> {
    /// `[e']× H` with the epipole moved by an angle towards one side.
    fn with_epipole(&self, side: &Vector3<f64>, angle: f64) -> Option<Fundamental> {
        let [a, b] = self.views.sizes();
        let epipole = self.plane.epipole_b * angle.cos() + side * angle.sin();
        let matrix =
            normaliser(b).transpose() * epipole.cross_matrix() * self.plane.homography * normaliser(a);
        Fundamental::from_matrix(&matrix, a, b)
    }

    /// The geometries that are [`AWAY`] over the images, to all sides.
    fn turned(&self, scale: f64) -> Vec<Fundamental> {
        let e = self.plane.epipole_b;
        let across = e.cross(&Vector3::ith(e.iamin(), 1.0)).normalize();
        let along = e.cross(&across);
        let sides = (0..SIDES).map(|k| {
            let (sin, cos) = (k as f64 * TAU / SIDES as f64).sin_cos();
            across * cos + along * sin
        });
        sides.flat_map(|side| AWAY.map(|away| self.away(&side, away * scale))).flatten().collect()
    }

    /// The geometry that is so many pixels away over the images.
    fn away(&self, side: &Vector3<f64>, pixels: f64) -> Option<Fundamental> {
        let nearer = |angle| {
            let distance =
                self.with_epipole(side, angle).map(|f| image_distance(self.of, &f, self.views.sizes()));
            distance.is_some_and(|distance| distance < pixels)
        };
        let (mut low, mut high) = (0.0, FARTHEST);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if nearer(middle) { low = middle } else { high = middle }
        }
        self.with_epipole(side, low)
    }
}
