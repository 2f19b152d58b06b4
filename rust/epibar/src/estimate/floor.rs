//! Hypotheses from the floor (DESIGN §4, the ground-plane trap, and §6).
//!
//! Under low cameras the best candidates are not epipolar: they are images of the same line on the floor, and fit
//! its homography `x_b = H x_a`, `l_a = Hᵀ l_b`. That homography is worth having: `F = [e']× H` leaves only the
//! epipole. Feet associate silhouettes (`H` sends the lowest point of one near the lowest point of the
//! other), and then the line joining `H top_a` and `top_b` passes through `e'` (plane and parallax, Hartley and
//! Zisserman §13.3). Two such lines make a hypothesis.

use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::frontier::Scorer;
use super::line_arrays::LineArrays;
use super::ransac::{Estimator, Watch, ransac};
use super::tracks::{Extremes, extremes};
use super::views::{View, Views};
use crate::Result;
use crate::geometry::Fundamental;
use crate::geometry::eight_point::least_matrix;
use crate::geometry::fundamental::{denormaliser, normaliser};
use crate::line::{ImageSize, Line, Segment};
use crate::matching::Candidate;

/// Draws of four line pairs.
const DRAWS: usize = 10_000;
/// A line fits where both ends of its segment lie within this share of the image diagonal.
const TOLERANCE: f64 = 0.006;

/// The homography of a plane on which things move.
#[derive(Debug, Clone)]
pub struct Floor {
    /// `x_b ~ H x_a`, pixels, Frobenius norm 1.
    pub homography: Matrix3<f64>,
    /// Candidates that fit it.
    pub inliers: usize,
    /// Those of them that do not pass through one common point, so that they tell more than a pencil would.
    pub spread: usize,
}

/// Finds homographies of line pairs.
struct FloorModel<'a> {
    candidates: &'a [Candidate],
    arrays: LineArrays,
    sizes: [ImageSize; 2],
}

/// Largest distance of a segment's ends from a line, pixels.
fn end_distance(line: &Vector3<f64>, segment: &Segment) -> f64 {
    Line::from_homogeneous(line).map_or(f64::INFINITY, |l| {
        let (p, q) = (l.signed_distance(segment.x0, segment.y0), l.signed_distance(segment.x1, segment.y1));
        p.abs().max(q.abs())
    })
}

impl FloorModel<'_> {
    fn fits(&self, h: &Matrix3<f64>, inverse: &Matrix3<f64>, c: &Candidate) -> bool {
        let to_a = h.tr_mul(&c.lines.b.homogeneous());
        if end_distance(&to_a, &c.segment_a) > TOLERANCE * self.sizes[0].diagonal() {
            return false;
        }
        let to_b = inverse.tr_mul(&c.lines.a.homogeneous());
        end_distance(&to_b, &c.segment_b) <= TOLERANCE * self.sizes[1].diagonal()
    }

    fn inliers(&self, h: &Matrix3<f64>) -> Vec<&Candidate> {
        let Some(inverse) = h.try_inverse() else { return Vec::new() };
        let tolerances = self.sizes.map(|size| TOLERANCE * size.diagonal());
        let mut inliers = Vec::new();
        self.arrays.fitting(h, &inverse, tolerances, |i| {
            let candidate = &self.candidates[i];
            if self.fits(h, &inverse, candidate) {
                inliers.push(candidate);
            }
        });
        inliers
    }

    /// `H` by DLT from line pairs, `l_a × Hᵀ l_b = 0`, in normalised coordinates.
    fn solve<'c>(&self, pairs: impl Iterator<Item = &'c Candidate>) -> Option<Matrix3<f64>> {
        let (da, db) = (denormaliser(self.sizes[0]).transpose(), denormaliser(self.sizes[1]).transpose());
        let mut normal = nalgebra::SMatrix::<f64, 9, 9>::zeros();
        for pair in pairs {
            let a = (da * pair.lines.a.homogeneous()).normalize();
            let b = (db * pair.lines.b.homogeneous()).normalize();
            for row in a.cross_matrix().row_iter() {
                let mut equation = nalgebra::SVector::<f64, 9>::zeros();
                for i in 0..3 {
                    for j in 0..3 {
                        equation[3 * i + j] = row[i] * b[j];
                    }
                }
                normal.ger(1.0, &equation, &equation, 1.0);
            }
        }
        let lines = least_matrix(&normal)?;
        if lines.determinant().abs() < 1e-7 {
            return None;
        }
        // Lines of B to lines of A by `lines` = Hᵀ in normalised coordinates.
        let h = denormaliser(self.sizes[1]) * lines.transpose() * normaliser(self.sizes[0]);
        let norm = h.norm();
        (norm.is_finite() && norm > 0.0).then(|| h / norm)
    }
}

impl Estimator for FloorModel<'_> {
    type Model = Matrix3<f64>;

    fn generate(&self, _index: usize, random: &mut Pcg64Mcg) -> Option<Matrix3<f64>> {
        let n = self.candidates.len();
        let drawn: [usize; 4] = std::array::from_fn(|_| random.random_range(0..n));
        self.solve(drawn.iter().map(|&i| &self.candidates[i]))
    }

    fn score(&self, model: &Matrix3<f64>) -> f64 {
        self.inliers(model).len() as f64
    }
}

/// Homographies that many candidates fit, best first; a different seed of the search each.
///
/// # Errors
/// [`crate::Error::Interrupted`].
pub fn find_floors(
    candidates: &[Candidate],
    sizes: [ImageSize; 2],
    seed: u64,
    keep: usize,
    watch: &mut dyn Watch,
) -> Result<Vec<Floor>> {
    if candidates.len() < 20 {
        return Ok(Vec::new());
    }
    let model = FloorModel { candidates, arrays: LineArrays::new(candidates), sizes };
    let found = ransac(&model, DRAWS, 4 * keep, seed, "floor", watch)?;
    let mut floors: Vec<Floor> = Vec::new();
    for start in found {
        let mut h = start.model;
        let mut inliers = model.inliers(&h);
        for _ in 0..5 {
            let Some(better) = model.solve(inliers.iter().copied()) else { break };
            let fitting = model.inliers(&better);
            if fitting.len() <= inliers.len() {
                break;
            }
            h = better;
            inliers = fitting;
        }
        if inliers.len() < 12 || floors.iter().any(|f| alike(&f.homography, &h, sizes)) {
            continue;
        }
        let spread = inliers.len() - largest_pencil(&inliers, sizes[0]);
        floors.push(Floor { homography: h, inliers: inliers.len(), spread });
    }
    floors.sort_by_key(|f| std::cmp::Reverse(f.inliers + f.spread));
    floors.truncate(keep);
    Ok(floors)
}

/// Whether two homographies agree within 1 % of the diagonal on the lower half of image A.
fn alike(p: &Matrix3<f64>, q: &Matrix3<f64>, sizes: [ImageSize; 2]) -> bool {
    let (x, y) = (sizes[0].x_max(), sizes[0].y_max());
    [[0.2 * x, 0.6 * y], [0.8 * x, 0.6 * y], [0.5 * x, 0.9 * y]].iter().all(|c| {
        let point = Vector3::new(c[0], c[1], 1.0);
        let (a, b) = (p * point, q * point);
        (a.x / a.z - b.x / b.z).hypot(a.y / a.z - b.y / b.z) < 0.01 * sizes[1].diagonal()
    })
}

/// The most lines of A that pass through one point, among intersections of a sample of them.
fn largest_pencil(inliers: &[&Candidate], size: ImageSize) -> usize {
    let tolerance = TOLERANCE * size.diagonal();
    let step = inliers.len().div_ceil(24).max(1);
    let sample: Vec<_> = inliers.iter().step_by(step).map(|c| c.lines.a.homogeneous()).collect();
    let mut most = 0;
    for (i, p) in sample.iter().enumerate() {
        for q in &sample[..i] {
            let meet = p.cross(q);
            // A line passes through the point where the pencil's line through its midpoint fits it at both ends.
            let through = inliers
                .iter()
                .filter(|c| {
                    let [x, y] = c.segment_a.midpoint();
                    end_distance(&meet.cross(&Vector3::new(x, y, 1.0)), &c.segment_a) <= tolerance
                })
                .count();
            most = most.max(through);
        }
    }
    most
}

/// Top and bottom of a silhouette in both views.
#[derive(Debug, Clone, Copy)]
struct Standing {
    top_a: [f64; 2],
    top_b: [f64; 2],
}

/// Draws epipoles for a known floor and scores with tangents.
pub struct FloorEpipoles<'a> {
    homography: Matrix3<f64>,
    standing: Vec<Standing>,
    scorer: &'a Scorer<'a>,
}

impl<'a> FloorEpipoles<'a> {
    /// Associates silhouettes by their feet. Without `upright` these may be either end of a silhouette, in A and in B:
    /// those that associate most are.
    pub fn new(floor: &Floor, association: &Views, scorer: &'a Scorer<'a>, upright: bool) -> Self {
        let h = floor.homography;
        let ends: &[[usize; 2]] = if upright { &[[1, 1]] } else { &[[1, 1], [0, 0], [0, 1], [1, 0]] };
        // Of equally many the first.
        let standing = ends.iter().rev().map(|feet| associated(&h, association, *feet));
        let standing = standing.max_by_key(Vec::len).unwrap_or_default();
        Self { homography: h, standing, scorer }
    }

    /// How many silhouettes were associated.
    pub fn associated(&self) -> usize {
        self.standing.len()
    }
}

/// Silhouettes whose feet `h` sends near each other; `feet` tells which of the extremes these are, in A and in B.
fn associated(h: &Matrix3<f64>, association: &Views, feet: [usize; 2]) -> Vec<Standing> {
    let near = 0.02 * association.b.size.diagonal();
    let mut standing = Vec::new();
    for frame in 0..association.frames() {
        let standing_in = |view: &View| -> Vec<Extremes> {
            view.hulls_of(frame).filter_map(|hull| extremes(view, hull)).collect()
        };
        let (in_a, in_b) = (standing_in(&association.a), standing_in(&association.b));
        for ends_a in &in_a {
            let foot_a = ends_a[feet[0]];
            let foot = h * Vector3::new(foot_a[0], foot_a[1], 1.0);
            let (x, y) = (foot.x / foot.z, foot.y / foot.z);
            let squared = |[bx, by]: [f64; 2]| (x - bx).powi(2) + (y - by).powi(2);
            let distances = in_b.iter().map(|ends_b| (squared(ends_b[feet[1]]), ends_b));
            if let Some((distance, ends_b)) = distances.min_by(|p, q| p.0.total_cmp(&q.0))
                && distance < near * near
            {
                standing.push(Standing { top_a: ends_a[1 - feet[0]], top_b: ends_b[1 - feet[1]] });
            }
        }
    }
    standing
}

impl Estimator for FloorEpipoles<'_> {
    type Model = Fundamental;

    fn generate(&self, _index: usize, random: &mut Pcg64Mcg) -> Option<Fundamental> {
        if self.standing.len() < 8 {
            return None;
        }
        let mut parallax = || {
            let s = self.standing[random.random_range(0..self.standing.len())];
            let top = self.homography * Vector3::new(s.top_a[0], s.top_a[1], 1.0);
            top.cross(&Vector3::new(s.top_b[0], s.top_b[1], 1.0)).try_normalize(1e-12)
        };
        let epipole_b = parallax()?.cross(&parallax()?).try_normalize(1e-9)?;
        let epipole_a = self.homography.try_inverse()? * epipole_b;
        Fundamental::from_parts(epipole_b.cross_matrix() * self.homography, epipole_a, epipole_b)
    }

    fn score(&self, model: &Fundamental) -> f64 {
        self.scorer.score(model)
    }

    fn glance(&self, model: &Fundamental) -> f64 {
        self.scorer.glance(model)
    }
}
