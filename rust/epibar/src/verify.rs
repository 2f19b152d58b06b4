//! Is it true, and how far off may it be? (DESIGN §7)
//!
//! A true `F` scores high at the true time offset and at chance level elsewhere. [`shift_curve`] scores `F` with B's
//! frames moved against A's, on frames that `F` was not fitted to; [`Evidence`] sums it up. [`covariance`]
//! turns the residuals of the frontier points into the uncertainty of the seven parameters, and
//! [`expected_error`] carries it to pixels over the volume where things moved.

use std::ops::Range;

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::estimate::frontier::{Comparer, FrontierPoint, FrontierScore};
use crate::estimate::optimise::{Information, SevenParameters, Step};
use crate::estimate::refine::polish;
use crate::estimate::refine::residual_rows;
use crate::estimate::views::Views;
use crate::estimate::volume::Correspondence;
use crate::geometry::Fundamental;

/// Score of `F` at one shift of B's frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShiftScore {
    /// Frames of shift, cyclic.
    pub shift: usize,
    /// Evidence at this shift.
    pub score: FrontierScore,
}

/// How `F` stands out against time shifts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Normal deviate of the evidence of both classes together against that at other shifts.
    pub z: f64,
    /// The same of tops.
    pub z_tops: f64,
    /// The same of bottoms.
    pub z_bottoms: f64,
    /// Share of A's tangents that met a tangent of B.
    pub explained: f64,
    /// The same at the mean of the shifts.
    pub explained_by_chance: f64,
    /// How far four fifths of the matched points lie from the best plane, in widths of a silhouette
    /// ([`crate::planarity`]).
    pub plane_residual: f64,
    /// `(s₁ − s₂) / (s₁ + s₂)` of the singular values of `K_bᵀ F K_a`, 0 for an essential matrix; NaN where the camera
    /// matrices are not known.
    pub essential_deviation: f64,
}

impl Default for Evidence {
    /// None.
    fn default() -> Self {
        Self {
            z: 0.0,
            z_tops: 0.0,
            z_bottoms: 0.0,
            explained: 0.0,
            explained_by_chance: 0.0,
            plane_residual: f64::NAN,
            essential_deviation: f64::NAN,
        }
    }
}

/// What a geometry is tested on.
#[derive(Debug, Clone)]
pub struct HeldOut<'a> {
    /// All common frames in which both cameras see something.
    pub views: &'a Views,
    /// The frames that the geometry was fitted to.
    pub fitted: &'a Views,
    /// Stretches of `views` that it was not fitted to, nor anything near them.
    pub tested: &'a [Range<usize>],
    /// For how many frames motion stays where it is; shifts by less say the same as none.
    pub stay: usize,
    /// Two tangents meet below this Sampson distance, pixels.
    pub radius: f64,
    /// Both cameras are the right way up.
    pub upright: bool,
}

/// Evidence over time shifts.
#[derive(Debug, Clone, Default)]
pub struct ShiftCurve {
    /// The frames tested, at no shift and then at others.
    pub scores: Vec<ShiftScore>,
    /// As many frames of A elsewhere, at the same shifts but the first.
    pub elsewhere: Vec<Vec<FrontierScore>>,
    /// How many of the shifts are independent of one another.
    pub independent: f64,
}

/// Scores `f` on the frames tested at no shift and at about `count` others, none within `stay` frames of it.
///
/// B's frames move cyclically through the whole recording, not among the tested ones alone: the deviation over shifts is
/// known no better than there are moments that differ. A frame of B that `f` was fitted to is no more in its favour
/// beside another frame of A than any other is.
pub fn shift_curve(held_out: &HeldOut, f: &Fundamental, count: usize) -> ShiftCurve {
    let HeldOut { views, fitted, tested, stay, radius, upright } = *held_out;
    let (frames, stay) = (views.frames(), stay.max(1));
    let span = frames.saturating_sub(2 * stay);
    let count = count.min(span);
    let shifts: Vec<usize> = std::iter::once(0).chain((0..count).map(|k| stay + k * span / count)).collect();
    let length = tested.iter().map(Range::len).max().unwrap_or(0).max(1);
    let total: usize = tested.iter().map(Range::len).sum();
    let moved = |by: usize| -> Vec<usize> {
        tested.iter().flat_map(Clone::clone).map(|i| (i + by) % frames.max(1)).collect()
    };
    let sets: Vec<Vec<usize>> = (0..(frames / total.max(1)).max(1)).map(|k| moved(k * length)).collect();
    // Which of the two maps of rays holds is no choice that the frames tested have.
    let sign = Comparer::new(&fitted.a, &fitted.b, f, upright).sign(0, radius);
    let scores: Vec<Vec<FrontierScore>> = shifts
        .par_iter()
        .map_init(
            || Comparer::new(&views.a, &views.b, f, upright),
            |comparer, &shift| {
                let mut met = comparer.meet_by(sign, shift);
                let found = met.at(radius);
                sets.iter().map(|set| found.score_of(set)).collect()
            },
        )
        .collect();
    ShiftCurve {
        scores: shifts.iter().zip(&scores).map(|(&shift, of)| ShiftScore { shift, score: of[0] }).collect(),
        elsewhere: (1..sets.len()).map(|k| scores[1..].iter().map(|of| of[k]).collect()).collect(),
        independent: span as f64 / (2 * stay) as f64,
    }
}

/// Parts into which [`cross_validated`] divides the frames.
const FOLDS: usize = 5;

/// As [`shift_curve`], of all frames: each fifth is tested with what `f` becomes when it is refined on the others.
///
/// Five times the frames of a test apart, for what is too faint there. `f` itself was chosen on all frames, so this is less
/// strict: it is for parts of the evidence of a geometry that passed the test.
pub fn cross_validated(views: &Views, f: &Fundamental, held_out: &HeldOut, count: usize) -> ShiftCurve {
    let n = views.frames();
    let mut whole = ShiftCurve::default();
    for fold in 0..FOLDS {
        let tested = fold * n / FOLDS..(fold + 1) * n / FOLDS;
        let apart = |i: &usize| i + held_out.stay < tested.start || *i >= tested.end + held_out.stay;
        let fitted = views.chosen(&(0..n).filter(apart).collect::<Vec<_>>());
        let refined = polish(&fitted, f, held_out.upright);
        let of = HeldOut { views, fitted: &fitted, tested: std::slice::from_ref(&tested), ..*held_out };
        let curve = shift_curve(&of, &refined, count);
        if whole.scores.is_empty() {
            whole = ShiftCurve { elsewhere: Vec::new(), ..curve };
        } else {
            whole.scores.iter_mut().zip(&curve.scores).for_each(|(sum, part)| sum.score += part.score);
        }
    }
    whole
}

/// Fewest shifts from which a deviation is taken.
const MIN_SHIFTS: usize = 8;
/// The floor of the deviation is that of a handful of counts: a curve without any chance matches is no proof.
const MIN_DEVIATION: f64 = 3.0;

fn mean_and_variance(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    (mean, values.map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0))
}

/// The normal deviate that is as unlikely as Student's `t` with `freedom` degrees of freedom (Wallace 1959).
pub fn normal_deviate(t: f64, freedom: f64) -> f64 {
    let (nu, sign) = (freedom, t.signum());
    sign * (8.0 * nu + 1.0) / (8.0 * nu + 3.0) * (nu * (t * t / nu).ln_1p()).sqrt()
}

impl ShiftCurve {
    /// How unlikely it is by chance that `of` is as large as at no shift, as a normal deviate; 0 where there are too few
    /// shifts to say.
    ///
    /// The mean is that of the frames tested. Their deviation is that of few independent shifts, so that of as many
    /// frames elsewhere is taken with it, and the larger of the two counts.
    fn deviate(&self, of: &dyn Fn(&FrontierScore) -> f64) -> f64 {
        let Some((first, rest)) = self.scores.split_first() else { return 0.0 };
        let freedom = (self.independent - 1.0) * (1 + self.elsewhere.len()) as f64;
        if rest.len() < MIN_SHIFTS || freedom < 1.0 {
            return 0.0;
        }
        let (mean, own) = mean_and_variance(rest.iter().map(|s| of(&s.score)));
        let others = self.elsewhere.iter().map(|scores| mean_and_variance(scores.iter().map(of)).1);
        let pooled = (own + others.sum::<f64>()) / (1 + self.elsewhere.len()) as f64;
        let deviation = own.max(pooled).sqrt().max(MIN_DEVIATION);
        // The mean itself is uncertain.
        let t = (of(&first.score) - mean) / (deviation * (1.0 + 1.0 / self.independent).sqrt());
        normal_deviate(t, freedom)
    }

    /// Standard scores of what is found at no shift.
    pub fn evidence(&self) -> Evidence {
        let Some((first, rest)) = self.scores.split_first() else { return Evidence::default() };
        let share = |s: &FrontierScore| s.matches() as f64 / (s.tangents().max(1)) as f64;
        Evidence {
            z: self.deviate(&FrontierScore::total),
            z_tops: self.deviate(&|s| s.tops.excess),
            z_bottoms: self.deviate(&|s| s.bottoms.excess),
            explained: share(&first.score),
            explained_by_chance: rest.iter().map(|s| share(&s.score)).sum::<f64>() / rest.len().max(1) as f64,
            ..Evidence::default()
        }
    }
}

/// Covariance of the seven parameters from frontier points, robust to points of one moment sharing their error.
///
/// `(JᵀJ)⁻¹ (Σ_blocks g gᵀ) (JᵀJ)⁻¹` with `g` the gradient of a block of consecutive frames (the sandwich
/// estimator with clusters): a walker whose outline is off in one frame is off in the next as well. `None` where
/// the points do not determine the parameters.
pub fn covariance(at: &SevenParameters, points: &[FrontierPoint], block: usize) -> Option<Information> {
    let mut normal = Information::zeros();
    let mut blocks: std::collections::BTreeMap<u32, Step> = std::collections::BTreeMap::new();
    for (p, (residual, row)) in points.iter().zip(residual_rows(at, points)) {
        normal.ger(1.0, &row, &row, 1.0);
        blocks.entry(p.frame / block.max(1) as u32).or_insert_with(Step::zeros).axpy(residual, &row, 1.0);
    }
    let count = blocks.len() as f64;
    if points.len() < 20 || count < 8.0 {
        return None;
    }
    let inverse = normal.try_inverse()?;
    let mut meat = Information::zeros();
    for gradient in blocks.values() {
        meat.ger(1.0, gradient, gradient, 1.0);
    }
    // Small-sample correction of clustered sandwiches: seven of the blocks' freedom went into the fit.
    let correction = count / (count - 7.0).max(1.0);
    let result = inverse * meat * inverse * correction;
    result.iter().all(|v| v.is_finite()).then_some(result)
}

/// A covariance once a prior of known information is taken into account.
///
/// `(C⁻¹ + P)⁻¹ = C (I + P C)⁻¹`, which asks for no inverse of `C`; `None` where it is not finite.
pub fn with_prior(covariance: &Information, prior: &Information) -> Option<Information> {
    let inverse = (Information::identity() + prior * covariance).try_inverse()?;
    let result = covariance * inverse;
    result.iter().all(|v| v.is_finite()).then_some(0.5 * (result + result.transpose()))
}

/// Expected symmetric epipolar distance over correspondences, pixels: mean over points of the mean of a folded normal.
pub fn expected_error(
    at: &SevenParameters,
    covariance: &Information,
    correspondences: &[Correspondence],
) -> f64 {
    let matrix = at.unscaled();
    let derivatives = at.derivatives();
    let mut sum = 0.0;
    for (a, b) in correspondences {
        let (xa, xb) = (Vector3::new(a[0], a[1], 1.0), Vector3::new(b[0], b[1], 1.0));
        let (in_b, in_a) = (matrix * xa, matrix.tr_mul(&xb));
        let scale = 0.5 * (1.0 / in_b.x.hypot(in_b.y).max(1e-300) + 1.0 / in_a.x.hypot(in_a.y).max(1e-300));
        let row = Step::from_fn(|k, _| xb.dot(&(derivatives[k] * xa)) * scale);
        sum += (row.dot(&(covariance * row)).max(0.0) * 2.0 / std::f64::consts::PI).sqrt();
    }
    sum / (correspondences.len().max(1)) as f64
}

/// Standard score of the difference in evidence between two geometries, from sums over blocks of frames.
///
/// What one frame says its neighbours repeat, so blocks, not frames, are the independent pieces.
pub fn paired_z(winner: &[f64], rival: &[f64], block: usize) -> f64 {
    let differences: Vec<f64> = winner
        .chunks(block.max(1))
        .zip(rival.chunks(block.max(1)))
        .map(|(p, q)| p.iter().sum::<f64>() - q.iter().sum::<f64>())
        .collect();
    let n = differences.len() as f64;
    if n < 4.0 {
        return 0.0;
    }
    let mean = differences.iter().sum::<f64>() / n;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
    mean / (variance / n).sqrt().max(1e-9)
}
