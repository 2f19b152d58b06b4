//! Hypotheses from the homography of a floor.
//!
//! Feet associate silhouettes (`H` sends the lowest point of one near the lowest point of the other), and then the line
//! joining `H top_a` and `top_b` passes through `e'` (plane and parallax, Hartley and Zisserman, *Multiple View
//! Geometry*, 13.3). Two such lines make a hypothesis `F = [e']× H`.

use nalgebra::{Matrix3, Vector3};
use rand::RngExt;

use super::floor::FloorHomography;
use super::ransac::Estimator;
use super::tracks::{Extremes, extremes};
use crate::frontier::{Scorer, View, Views};
use crate::geometry::Fundamental;
use crate::random::Generator;

/// Fewest silhouettes that are associated by their feet.
const FEWEST: usize = 8;

/// The tops of silhouettes of A and of B that stand at one place of the floor.
#[derive(Debug, Clone, Copy)]
struct Tops {
    a: [f64; 2],
    b: [f64; 2],
}

/// Draws epipoles for a known floor and scores with tangents.
pub struct FloorEpipoles<'a> {
    homography: Matrix3<f64>,
    tops: Vec<Tops>,
    scorer: &'a Scorer<'a>,
}

impl<'a> FloorEpipoles<'a> {
    /// Associates the silhouettes of `views` by their feet. Where these are not upright the feet may be either end of a
    /// silhouette, in A and in B: those that associate most are.
    pub fn new(floor: &FloorHomography, views: &Views, scorer: &'a Scorer<'a>) -> Self {
        let h = floor.homography;
        let ends: &[[usize; 2]] = if views.upright { &[[1, 1]] } else { &[[1, 1], [0, 0], [0, 1], [1, 0]] };
        // Of equally many the first.
        let tops = ends.iter().rev().map(|feet| associated(&h, views, *feet));
        let tops = tops.max_by_key(Vec::len).unwrap_or_default();
        Self { homography: h, tops, scorer }
    }
}

/// Silhouettes whose feet `h` sends near each other; `feet` says which of the extremes these are, in A and in B.
fn associated(h: &Matrix3<f64>, views: &Views, feet: [usize; 2]) -> Vec<Tops> {
    let near = 0.02 * views.b.size.diagonal();
    let mut tops = Vec::new();
    for frame in 0..views.frames() {
        let whole = |view: &View| -> Vec<Extremes> {
            view.hulls_of(frame).filter_map(|hull| extremes(view, hull)).collect()
        };
        let (in_a, in_b) = (whole(&views.a), whole(&views.b));
        for ends_a in &in_a {
            let foot_a = ends_a[feet[0]];
            let foot = h * Vector3::new(foot_a[0], foot_a[1], 1.0);
            let (x, y) = (foot.x / foot.z, foot.y / foot.z);
            let squared = |[bx, by]: [f64; 2]| (x - bx).powi(2) + (y - by).powi(2);
            let distances = in_b.iter().map(|ends_b| (squared(ends_b[feet[1]]), ends_b));
            if let Some((distance, ends_b)) = distances.min_by(|p, q| p.0.total_cmp(&q.0))
                && distance < near * near
            {
                tops.push(Tops { a: ends_a[1 - feet[0]], b: ends_b[1 - feet[1]] });
            }
        }
    }
    tops
}

impl Estimator for FloorEpipoles<'_> {
    type Model = Fundamental;

    fn generate(&self, _index: usize, random: &mut Generator) -> Option<Fundamental> {
        if self.tops.len() < FEWEST {
            return None;
        }
        let mut parallax = || {
            let Tops { a, b } = self.tops[random.random_range(0..self.tops.len())];
            let top = self.homography * Vector3::new(a[0], a[1], 1.0);
            top.cross(&Vector3::new(b[0], b[1], 1.0)).try_normalize(1e-12)
        };
        let epipole_b = parallax()?.cross(&parallax()?).try_normalize(1e-9)?;
        let epipole_a = self.homography.try_inverse()? * epipole_b;
        Fundamental::from_parts(epipole_b.cross_matrix() * self.homography, epipole_a, epipole_b)
    }

    fn score(&self, model: &Fundamental) -> f64 {
        self.scorer.score(model)
    }

    fn preview(&self, model: &Fundamental) -> f64 {
        self.scorer.preview(model)
    }
}
