//! The homography of a floor.
//!
//! Under low cameras the best candidates are not epipolar: they are images of the same line on the floor, and fit
//! its homography `x_b = H x_a`, `l_a = Hᵀ l_b`. That homography is worth having: `F = [e']× H` leaves only the
//! epipole ([`FloorEpipoles`](super::floor_epipoles::FloorEpipoles)).

use nalgebra::{Matrix3, Vector3};
use rand::RngExt;

use super::line_arrays::LineArrays;
use super::ransac::{Estimator, ransac};
use crate::error::Result;
use crate::geometry::homography;
use crate::image::{ImageSize, Line, Segment};
use crate::matching::Candidate;
use crate::random::Generator;
use crate::watch::{Stage, Watch};

/// Draws of four line pairs.
const DRAWS: usize = 10_000;
/// A line fits where both ends of its segment lie within this share of the image diagonal.
const TOLERANCE: f64 = 0.006;
/// Fewest candidates of which a floor is asked, and fewest that fit one.
const FEWEST: usize = 20;
const FEWEST_INLIERS: usize = 12;
/// Rounds of fitting it anew to what fits.
const FITS: usize = 5;
/// Homographies that agree within this share of the diagonal are one floor.
const ALIKE: f64 = 0.01;
/// A floor is worth reporting where one candidate in so many fits it, and one in so many does that does not pass through one point with most of
/// the others: at least so many. It decides nothing but whether it is told of.
const SUPPORTED: usize = 5;
const OUTSIDE_PENCIL: usize = 8;
const LEAST_OUTSIDE_PENCIL: usize = 30;

/// The homography of a plane on which things move.
#[derive(Debug, Clone)]
pub struct FloorHomography {
    /// `x_b ~ H x_a`, pixels, Frobenius norm 1.
    pub homography: Matrix3<f64>,
    /// Candidates that fit it.
    pub inliers: usize,
    /// Candidates that fit it and do not belong to one pencil of lines through a common point, which fits many homographies.
    pub outside_pencil: usize,
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

impl FloorHomography {
    /// Whether it is worth reporting: many of the candidates fit it, and not because they all pass through one point.
    pub fn is_supported(&self, candidates: usize) -> bool {
        self.inliers * SUPPORTED >= candidates
            && self.outside_pencil * OUTSIDE_PENCIL >= candidates
            && self.outside_pencil >= LEAST_OUTSIDE_PENCIL
    }
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
        self.arrays.prefilter_homography(h, &inverse, tolerances, |i| {
            let candidate = &self.candidates[i];
            if self.fits(h, &inverse, candidate) {
                inliers.push(candidate);
            }
        });
        inliers
    }
}

impl Estimator for FloorModel<'_> {
    type Model = Matrix3<f64>;

    fn generate(&self, _index: usize, random: &mut Generator) -> Option<Matrix3<f64>> {
        let n = self.candidates.len();
        let drawn: [usize; 4] = std::array::from_fn(|_| random.random_range(0..n));
        homography::from_line_pairs(drawn.iter().map(|&i| &self.candidates[i].lines), self.sizes)
    }

    fn score(&self, model: &Matrix3<f64>) -> f64 {
        self.inliers(model).len() as f64
    }
}

/// Homographies that many candidates fit, best first, each different from those before.
///
/// # Errors
/// [`crate::Error::Interrupted`].
pub fn find_floors(
    candidates: &[Candidate],
    sizes: [ImageSize; 2],
    seed: u64,
    keep: usize,
    watch: &mut dyn Watch,
) -> Result<Vec<FloorHomography>> {
    if candidates.len() < FEWEST {
        return Ok(Vec::new());
    }
    let model = FloorModel { candidates, arrays: LineArrays::new(candidates), sizes };
    let found = ransac(&model, DRAWS, 4 * keep, seed, Stage::Floor, watch)?;
    let mut floors: Vec<FloorHomography> = Vec::new();
    for start in found {
        let mut h = start.model;
        let mut inliers = model.inliers(&h);
        for _ in 0..FITS {
            let Some(better) = homography::from_line_pairs(inliers.iter().map(|c| &c.lines), sizes) else {
                break;
            };
            let fitting = model.inliers(&better);
            if fitting.len() <= inliers.len() {
                break;
            }
            h = better;
            inliers = fitting;
        }
        if inliers.len() < FEWEST_INLIERS || floors.iter().any(|f| alike(&f.homography, &h, sizes)) {
            continue;
        }
        let outside_pencil = inliers.len() - largest_pencil(&inliers, sizes[0]);
        floors.push(FloorHomography { homography: h, inliers: inliers.len(), outside_pencil });
    }
    floors.sort_by_key(|f| std::cmp::Reverse(f.inliers + f.outside_pencil));
    floors.truncate(keep);
    Ok(floors)
}

/// Whether two homographies agree on the lower half of image A.
fn alike(p: &Matrix3<f64>, q: &Matrix3<f64>, sizes: [ImageSize; 2]) -> bool {
    let (x, y) = (sizes[0].x_max(), sizes[0].y_max());
    [[0.2 * x, 0.6 * y], [0.8 * x, 0.6 * y], [0.5 * x, 0.9 * y]].iter().all(|c| {
        let point = Vector3::new(c[0], c[1], 1.0);
        let (a, b) = (p * point, q * point);
        (a.x / a.z - b.x / b.z).hypot(a.y / a.z - b.y / b.z) < ALIKE * sizes[1].diagonal()
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
