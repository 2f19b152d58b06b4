//! A plane that a geometry allows.
//!
//! A fundamental matrix leaves a homography three parameters: those of the plane whose points it sends to each other (Hartley and
//! Zisserman §13.1).

use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rayon::prelude::*;

use crate::frontier::TangentMatch;
use crate::geometry::Fundamental;
use crate::geometry::fundamental::{denormaliser, normaliser};
use crate::geometry::homography::{PointMatch, compatible, transfer_distance};
use crate::image::ImageSize;
use crate::random::Stream;

/// Most points of which a plane is sought, and samples of three.
const POINTS: usize = 1500;
const SAMPLES: u64 = 400;
/// Rounds of fitting the plane to the half of the points that is nearest.
const FITS: usize = 5;

/// A plane that a geometry allows, in normalised coordinates.
pub struct Plane {
    /// From A to B.
    pub homography: Matrix3<f64>,
    /// The epipole in B, of length 1.
    pub epipole_b: Vector3<f64>,
    /// The geometry.
    matrix: Matrix3<f64>,
    normalisers: [Matrix3<f64>; 2],
}

impl Plane {
    /// The one to which half of the matches keep closest, by random samples, which are the same for any seed; `None` where all
    /// samples are degenerate.
    pub fn new<'m>(
        of: &Fundamental,
        matches: impl Iterator<Item = &'m TangentMatch>,
        sizes: [ImageSize; 2],
    ) -> Option<Self> {
        let normalisers = sizes.map(normaliser);
        let matrix = denormaliser(sizes[1]).transpose() * of.matrix() * denormaliser(sizes[0]);
        let epipole_b = (normalisers[1] * of.epipole_b()).normalize();
        let none = Self { homography: Matrix3::zeros(), epipole_b, matrix, normalisers };
        let matches: Vec<&TangentMatch> = matches.collect();
        let points: Vec<PointMatch> =
            matches.iter().step_by(matches.len().div_ceil(POINTS).max(1)).map(|m| none.on_line(m)).collect();
        let of_half = |chosen: &[PointMatch]| {
            let homography = compatible(&matrix, &epipole_b, chosen)?;
            let mut distances: Vec<f64> = points.iter().map(|m| transfer_distance(&homography, m)).collect();
            let half = distances.len() / 2;
            let (_, median, _) = distances.select_nth_unstable_by(half, f64::total_cmp);
            Some((*median, homography))
        };
        let sample = |k: u64| {
            let mut random = Stream::Turns.generator(0, k);
            let three: [PointMatch; 3] =
                std::array::from_fn(|_| points[random.random_range(0..points.len())]);
            of_half(&three)
        };
        if points.is_empty() {
            return None;
        }
        let mut best = (0..SAMPLES).into_par_iter().filter_map(sample).min_by(|p, q| p.0.total_cmp(&q.0))?;
        for _ in 0..FITS {
            let near = points.iter().filter(|m| transfer_distance(&best.1, m) <= best.0).copied();
            match of_half(&near.collect::<Vec<_>>()) {
                Some(closer) if closer.0 < best.0 => best = closer,
                _ => break,
            }
        }
        Some(Self { homography: best.1, ..none })
    }

    /// A match in normalised coordinates, its point of B moved onto the epipolar line of that of A.
    fn on_line(&self, p: &TangentMatch) -> PointMatch {
        let [ta, tb] = self.normalisers;
        let (a, b) = (ta * Vector3::new(p.a[0], p.a[1], 1.0), tb * Vector3::new(p.b[0], p.b[1], 1.0));
        let line = self.matrix * a;
        let off = line.dot(&b) / line.xy().norm_squared();
        (a, b - off * Vector3::new(line.x, line.y, 0.0))
    }

    /// How far a match is from where the plane sends its point: in B, and, the other way, in A; normalised coordinates, infinite where that is not known.
    pub fn distances(&self, p: &TangentMatch) -> [f64; 2] {
        let (a, b) = self.on_line(p);
        let back = self.homography.try_inverse().map_or(f64::INFINITY, |h| transfer_distance(&h, &(b, a)));
        [back, transfer_distance(&self.homography, &(a, b))]
    }
}
