//! The paper's estimator: fundamental matrices from pairs of lines (paper §3).
//!
//! Two pairs drawn in proportion to their correlation meet in the epipoles `e = l₁ × l₂`, `e' = l₁' × l₂'`; the
//! third is the candidate that minimises `d(l, e) + d(l', e')`; three pairs fix the homography of the pencils.
//! A candidate is an inlier where the image area between `l'` and the line that `F` gives `l` is below
//! `threshold × image width` (paper §3.2: 3).

use nalgebra::Vector3;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::optimise::{Information, Problem, SevenParameters, Step, cauchy, minimise};
use super::ransac::Estimator;
use crate::geometry::{Fundamental, LinePair, PencilHomography};
use crate::line::{Homogeneous, ImageSize, Line, area_between};
use crate::matching::Candidate;

/// Area threshold of an inlier in units of the image width (paper §3.2).
pub const AREA_THRESHOLD: f64 = 3.0;

/// Draws hypotheses from line pairs and counts line inliers.
pub struct LineModel<'a> {
    candidates: &'a [Candidate],
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
        Self { candidates, cumulative, sizes }
    }

    /// One candidate with probability proportional to its correlation.
    fn draw(&self, random: &mut Pcg64Mcg) -> Option<usize> {
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
        self.candidates
            .iter()
            .enumerate()
            .filter(|&(i, _)| i != first && i != second)
            .map(|(i, c)| {
                let da = (c.lines.a.homogeneous().dot(e) * se).abs();
                let db = (c.lines.b.homogeneous().dot(f) * sf).abs();
                (da + db, i)
            })
            .min_by(|p, q| p.0.total_cmp(&q.0))
            .map(|(_, i)| i)
    }

    /// Inlier test of one candidate.
    pub fn is_inlier(&self, f: &Fundamental, candidate: &Candidate) -> bool {
        let [x, y] = candidate.segment_a.midpoint();
        let size = self.sizes[1];
        let limit = AREA_THRESHOLD * size.width as f64;
        let Some(line) = Line::from_homogeneous(&f.line_in_b(&Vector3::new(x, y, 1.0))) else {
            return false;
        };
        // Cheap refusal: in the middle of its segment l' must be within the area's mean width.
        let [mx, my] = candidate.segment_b.midpoint();
        if line.signed_distance(mx, my).abs() * 0.5 * candidate.segment_b.length() > 4.0 * limit {
            return false;
        }
        area_between(&candidate.lines.b, &line, size) < limit
    }

    /// Which candidates are inliers.
    pub fn inliers(&self, f: &Fundamental) -> Vec<bool> {
        self.candidates.iter().map(|c| self.is_inlier(f, c)).collect()
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
            let inliers: Vec<&Candidate> =
                self.candidates.iter().filter(|c| self.is_inlier(&best, c)).collect();
            let Some(start) = SevenParameters::new(&best, self.sizes) else { break };
            if inliers.len() < 7 {
                break;
            }
            let scale = spread(&inliers, &start);
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

    fn generate(&self, _index: usize, random: &mut Pcg64Mcg) -> Option<Fundamental> {
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
        self.candidates.iter().filter(|c| self.is_inlier(model, c)).count() as f64
    }
}

/// Inlier lines against the lines that F gives them: distances at both ends of each segment, in both views.
struct LineProblem<'a> {
    inliers: Vec<&'a Candidate>,
    /// Scale of the Cauchy loss, pixels.
    scale: f64,
}

/// Median distance of the inliers, pixels, at least 0.3: good line pairs are sampled, not fitted, and their spread is
/// that of the sampling.
fn spread(inliers: &[&Candidate], at: &SevenParameters) -> f64 {
    let matrix = at.unscaled();
    let mut sizes: Vec<f64> =
        inliers.iter().flat_map(|c| LineProblem::residuals(&matrix, c)).map(f64::abs).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / 2).map_or(0.3, |m| m.max(0.3))
}

impl LineProblem<'_> {
    /// Four residuals of a candidate, pixels.
    fn residuals(f: &nalgebra::Matrix3<f64>, c: &Candidate) -> [f64; 4] {
        let [ax, ay] = c.segment_a.midpoint();
        let [bx, by] = c.segment_b.midpoint();
        let in_b = f * Vector3::new(ax, ay, 1.0);
        let in_a = f.tr_mul(&Vector3::new(bx, by, 1.0));
        let at = |l: &Vector3<f64>, x: f64, y: f64| {
            (l.x * x + l.y * y + l.z) / (l.x * l.x + l.y * l.y).sqrt().max(1e-300)
        };
        [
            at(&in_b, c.segment_b.x0, c.segment_b.y0),
            at(&in_b, c.segment_b.x1, c.segment_b.y1),
            at(&in_a, c.segment_a.x0, c.segment_a.y0),
            at(&in_a, c.segment_a.x1, c.segment_a.y1),
        ]
    }
}

impl Problem for LineProblem<'_> {
    fn linearise(&self, at: &SevenParameters) -> (f64, Information, Step) {
        // Central differences: the residual has no square root to lose digits in, and lines are few.
        const H: f64 = 1e-6;
        let matrix = at.unscaled();
        let around: [_; 7] = std::array::from_fn(|k| {
            let mut step = Step::zeros();
            step[k] = H;
            (at.stepped(&step).unscaled(), at.stepped(&-step).unscaled())
        });
        let (mut cost, mut normal, mut gradient) = (0.0, Information::zeros(), Step::zeros());
        for c in &self.inliers {
            let residuals = Self::residuals(&matrix, c);
            let sides =
                around.each_ref().map(|(plus, minus)| (Self::residuals(plus, c), Self::residuals(minus, c)));
            for (i, &r) in residuals.iter().enumerate() {
                let (loss, weight) = cauchy(r, self.scale);
                let row = Step::from_fn(|k, _| (sides[k].0[i] - sides[k].1[i]) / (2.0 * H));
                cost += loss;
                normal += row * row.transpose() * weight;
                gradient += row * (weight * r);
            }
        }
        (cost, normal, gradient)
    }
}
