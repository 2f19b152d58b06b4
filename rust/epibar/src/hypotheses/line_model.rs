//! The paper's estimator: fundamental matrices from pairs of lines (paper §3).
//!
//! Two pairs drawn in proportion to their correlation meet in the epipoles `e = l₁ × l₂`, `e' = l₁' × l₂'`; the
//! third is the candidate that minimises `d(l, e) + d(l', e')`; three pairs fix the homography of the pencils.
//! A candidate is an inlier where the image area between `l'` and the line that `F` gives `l` is below
//! `threshold × image width` (paper §3.2: 3).

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use rand::RngExt;

use super::line_arrays::LineArrays;
use super::ransac::Estimator;
use crate::geometry::area::CutImage;
use crate::geometry::seven_parameters::{Information, Step};
use crate::geometry::{Fundamental, LinePair, PencilHomography, SevenParameters};
use crate::image::{Homogeneous, ImageSize, Line, Segment};
use crate::matching::Candidate;
use crate::random::Generator;
use crate::refine::least_squares::{Problem, cauchy, minimise};

/// Area threshold of an inlier in units of the image width (paper §3.2).
pub const AREA_THRESHOLD: f64 = 3.0;

/// Draws hypotheses from line pairs and counts line inliers.
pub struct LineModel<'a> {
    candidates: &'a [Candidate],
    arrays: LineArrays,
    /// Image B, cut by the line of each candidate.
    cut: Vec<CutImage>,
    cumulative: Vec<f64>,
    sizes: [ImageSize; 2],
}

impl<'a> LineModel<'a> {
    /// An estimator over `candidates` of images of the two sizes.
    pub fn new(candidates: &'a [Candidate], sizes: [ImageSize; 2]) -> Self {
        let mut sum = 0.0;
        let cumulative = candidates
            .iter()
            .map(|c| {
                sum += c.correlation.max(0.0);
                sum
            })
            .collect();
        let cut = candidates.iter().map(|c| CutImage::new(&c.lines.b, sizes[1])).collect();
        Self { candidates, arrays: LineArrays::new(candidates), cut, cumulative, sizes }
    }

    /// One candidate with probability proportional to its correlation.
    fn draw(&self, random: &mut Generator) -> Option<usize> {
        let total = *self.cumulative.last()?;
        let at = random.random::<f64>() * total;
        Some(self.cumulative.partition_point(|&c| c <= at).min(self.cumulative.len() - 1))
    }

    /// The candidate nearest to both epipoles, other than the two drawn.
    fn third(&self, e: &Homogeneous, f: &Homogeneous, first: usize, second: usize) -> Option<usize> {
        // Distances d(l, e) + d(l', e'); epipoles at infinity are compared by direction instead.
        let scale = |p: &Homogeneous, size: ImageSize| {
            let w = p.z.abs();
            let far = (p.x * p.x + p.y * p.y).sqrt() / (1e4 * size.diagonal());
            1.0 / w.max(far).max(f64::MIN_POSITIVE)
        };
        let (se, sf) = (scale(e, self.sizes[0]), scale(f, self.sizes[1]));
        self.arrays.nearest([(*e, se), (*f, sf)], [first, second])
    }

    /// Area below which a candidate is an inlier, pixels².
    fn limit(&self) -> f64 {
        AREA_THRESHOLD * self.sizes[1].width as f64
    }

    /// Whether a candidate that passed the prefilter is an inlier.
    fn is_inlier(&self, f: &Fundamental, candidate: usize) -> bool {
        let middle = point(self.candidates[candidate].segment_a.midpoint());
        Line::from_homogeneous(&f.line_in_b(&middle))
            .is_some_and(|line| self.cut[candidate].area_to(&line) < self.limit())
    }

    /// Which candidates are inliers.
    pub fn inliers(&self, f: &Fundamental) -> Vec<bool> {
        let mut inliers = vec![false; self.candidates.len()];
        self.arrays.prefilter_area(f, self.limit(), |i| inliers[i] = self.is_inlier(f, i));
        inliers
    }

    /// Local optimisation on the inliers, repeated with those of the result.
    ///
    /// The robust fit is kept although it may lose a few inliers at the rim: which candidates lie just within the
    /// area threshold is chance, their common geometry is not.
    pub fn optimise(&self, f: &Fundamental) -> Fundamental {
        const ROUNDS: usize = 8;
        const KEPT: f64 = 0.97;
        let (mut best, mut most) = (*f, self.score(f));
        for _ in 0..ROUNDS {
            let inliers = self.candidates.iter().zip(self.inliers(&best)).filter(|(_, inlier)| *inlier);
            let inliers: Vec<&Candidate> = inliers.map(|(candidate, _)| candidate).collect();
            let Some(start) = SevenParameters::new(&best, self.sizes) else { break };
            if inliers.len() < 7 {
                break;
            }
            let scale = median_residual(&inliers, &start);
            let (end, _) = minimise(&LineProblem { inliers, scale }, start, 30);
            let Some(refined) = end.fundamental() else { break };
            let count = self.score(&refined);
            if count < KEPT * most {
                break;
            }
            best = refined;
            most = most.max(count);
        }
        best
    }
}

impl Estimator for LineModel<'_> {
    type Model = Fundamental;

    fn generate(&self, _index: usize, random: &mut Generator) -> Option<Fundamental> {
        let (first, second) = (self.draw(random)?, self.draw(random)?);
        if first == second {
            return None;
        }
        let (p, q): (LinePair, LinePair) = (self.candidates[first].lines, self.candidates[second].lines);
        let e = p.a.homogeneous().cross(&q.a.homogeneous());
        let f = p.b.homogeneous().cross(&q.b.homogeneous());
        let (e, f) = (e.try_normalize(1e-12)?, f.try_normalize(1e-12)?);
        let third = self.candidates[self.third(&e, &f, first, second)?].lines;
        PencilHomography::from_line_pairs(&e, &f, &[p, q, third], self.sizes)?.fundamental()
    }

    fn score(&self, model: &Fundamental) -> f64 {
        let mut count = 0;
        self.arrays.prefilter_area(model, self.limit(), |i| count += usize::from(self.is_inlier(model, i)));
        count as f64
    }
}

/// Inlier lines against the lines that F gives them: distances at both ends of each segment, in both views.
struct LineProblem<'a> {
    inliers: Vec<&'a Candidate>,
    /// Scale of the Cauchy loss, pixels.
    scale: f64,
}

/// Median distance of the inliers, pixels, at least 0.3: good line pairs are sampled, not fitted, and their scatter is
/// that of the sampling.
fn median_residual(inliers: &[&Candidate], at: &SevenParameters) -> f64 {
    let matrix = at.unscaled();
    let mut sizes: Vec<f64> =
        inliers.iter().flat_map(|c| LineProblem::residuals(&matrix, c)).map(f64::abs).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / 2).map_or(0.3, |m| m.max(0.3))
}

/// Distance of a point `q` from a line `l`, pixels, and the derivative of it to the line.
fn distance(l: &Vector3<f64>, q: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let scale = 1.0 / (l.x * l.x + l.y * l.y).sqrt().max(1e-300);
    let distance = l.dot(q) * scale;
    (distance, (q - Vector3::new(l.x, l.y, 0.0) * (distance * scale)) * scale)
}

impl LineProblem<'_> {
    /// The line that `F` gives the middle of a candidate's segment in the other image, in B and in A.
    fn lines(f: &Matrix3<f64>, c: &Candidate) -> [Vector3<f64>; 2] {
        [f * point(c.segment_a.midpoint()), f.tr_mul(&point(c.segment_b.midpoint()))]
    }

    /// Four residuals of a candidate, pixels: of the ends in B, and of those in A.
    fn residuals(f: &Matrix3<f64>, c: &Candidate) -> [f64; 4] {
        let [in_b, in_a] = Self::lines(f, c);
        let [b0, b1] = ends(&c.segment_b).map(|end| distance(&in_b, &end).0);
        let [a0, a1] = ends(&c.segment_a).map(|end| distance(&in_a, &end).0);
        [b0, b1, a0, a1]
    }
}

fn point([x, y]: [f64; 2]) -> Vector3<f64> {
    Vector3::new(x, y, 1.0)
}

fn ends(segment: &Segment) -> [Vector3<f64>; 2] {
    [point([segment.x0, segment.y0]), point([segment.x1, segment.y1])]
}

impl Problem for LineProblem<'_> {
    fn linearise(&self, at: &SevenParameters) -> (f64, Information, Step) {
        // Summed over the nine entries of the matrix, column by column, and carried to the seven parameters once. What a
        // point changes in its line is the same for both ends: `aaᵀ` times the sum of what the ends make of the line.
        let matrix = at.unscaled();
        let mut cost = 0.0;
        let (mut normal, mut gradient) = (SMatrix::<f64, 9, 9>::zeros(), SVector::<f64, 9>::zeros());
        for c in &self.inliers {
            let lines = Self::lines(&matrix, c);
            for (line, from, to, in_b) in
                [(lines[0], c.segment_a, c.segment_b, true), (lines[1], c.segment_b, c.segment_a, false)]
            {
                let (mut square, mut slope) = (Matrix3::zeros(), Vector3::zeros());
                for end in ends(&to) {
                    let (residual, by_line) = distance(&line, &end);
                    let (loss, weight) = cauchy(residual, self.scale);
                    cost += loss;
                    square += by_line * (by_line * weight).transpose();
                    slope += by_line * (weight * residual);
                }
                let middle = point(from.midpoint());
                let outer = middle * middle.transpose();
                // Entry (i, j) of the matrix moves component i of the line in B by component j of the point of A.
                let (normals, slopes) = if in_b {
                    (outer.kronecker(&square), slope * middle.transpose())
                } else {
                    (square.kronecker(&outer), middle * slope.transpose())
                };
                normal += normals;
                gradient += SVector::<f64, 9>::from_column_slice(slopes.as_slice());
            }
        }
        let (information, gradient) = at.carried(&normal, &gradient);
        (cost, information, gradient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jacobian_equals_differences() {
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(800, 450).unwrap()];
        let matrix = Matrix3::new(1e-6, -3e-6, 2e-3, 5e-6, 2e-6, -9e-3, -4e-3, 6e-3, 1.0);
        let at = SevenParameters::new(&Fundamental::from_matrix(&matrix, sizes[0], sizes[1]).unwrap(), sizes);
        let at = at.unwrap();
        let segment = |x0, y0, x1, y1| Segment { x0, y0, x1, y1 };
        let (segment_a, segment_b) = (segment(0.0, 100.0, 639.0, 260.0), segment(120.0, 0.0, 700.0, 449.0));
        let lines = LinePair { a: segment_a.line().unwrap(), b: segment_b.line().unwrap() };
        let candidate = Candidate { lines, segment_a, segment_b, correlation: 1.0 };
        let problem = LineProblem { inliers: vec![&candidate], scale: 50.0 };
        let (_, normal, gradient) = problem.linearise(&at);
        let mut rows = [Step::zeros(); 4];
        for k in 0..7 {
            let moved = |size: f64| {
                let mut step = Step::zeros();
                step[k] = size;
                LineProblem::residuals(&at.stepped(&step).unscaled(), &candidate)
            };
            let (plus, minus) = (moved(1e-6), moved(-1e-6));
            for (i, row) in rows.iter_mut().enumerate() {
                row[k] = (plus[i] - minus[i]) / 2e-6;
            }
        }
        let (mut expected, mut slope) = (Information::zeros(), Step::zeros());
        for (row, residual) in rows.iter().zip(LineProblem::residuals(&at.unscaled(), &candidate)) {
            let weight = cauchy(residual, 50.0).1;
            expected += row * row.transpose() * weight;
            slope += row * (weight * residual);
        }
        assert!((normal - expected).norm() < 1e-5 * expected.norm(), "{normal} {expected}");
        assert!((gradient - slope).norm() < 1e-5 * slope.norm(), "{gradient} {slope}");
    }
}
