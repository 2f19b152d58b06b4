//! Is it true, and how far off may it be? (DESIGN §7)
//!
//! A true `F` scores high at the true time offset and at chance level elsewhere. [`shift_curve`] scores `F` with B's
//! frames moved against A's, on frames that `F` was not fitted to; [`Evidence`] sums it up. [`covariance`]
//! turns the residuals of the frontier points into the uncertainty of the seven parameters, and
//! [`expected_error`] carries it to pixels over the volume where things moved.

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::estimate::frontier::{Comparer, FrontierPoint, FrontierScore};
use crate::estimate::optimise::{Information, SevenParameters, Step};
use crate::estimate::refine::residual_row;
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
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Evidence {
    /// Standard scores over the shifts of both classes together, and of tops and of bottoms.
    pub z: f64,
    /// Standard score of tops.
    pub z_tops: f64,
    /// Standard score of bottoms.
    pub z_bottoms: f64,
    /// Share of A's tangents that met a tangent of B.
    pub explained: f64,
    /// The same at the mean of the shifts.
    pub explained_by_chance: f64,
    /// How far four fifths of the matched points lie from the best plane, in widths of a silhouette
    /// ([`crate::planarity`]).
    pub plane_residual: f64,
}

/// Scores `F` at shift 0 and at about `count` others, none within `guard` frames of 0.
pub fn shift_curve(
    views: &Views,
    f: &Fundamental,
    radius: f64,
    upright: bool,
    guard: usize,
    count: usize,
) -> Vec<ShiftScore> {
    let frames = views.frames();
    let mut shifts = vec![0];
    if frames > 2 * guard {
        let span = frames - 2 * guard;
        let count = count.min(span);
        shifts.extend((0..count).map(|k| guard + k * span / count));
    }
    shifts
        .into_par_iter()
        .map_init(
            || Comparer::new(&views.a, &views.b, f, upright),
            |comparer, shift| ShiftScore { shift, score: comparer.meet(shift, radius).at(radius).score() },
        )
        .collect()
}

/// Standard scores of the first entry of a curve against the others.
pub fn evidence_of(curve: &[ShiftScore]) -> Evidence {
    let z = |of: &dyn Fn(&FrontierScore) -> f64| -> f64 {
        let rest: Vec<f64> = curve.iter().skip(1).map(|s| of(&s.score)).collect();
        if rest.len() < 8 {
            return 0.0;
        }
        let mean = rest.iter().sum::<f64>() / rest.len() as f64;
        let variance = rest.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (rest.len() - 1) as f64;
        // The floor of the deviation is that of a handful of counts: a curve without any chance matches is no proof.
        (of(&curve[0].score) - mean) / variance.sqrt().max(3.0)
    };
    let share = |s: &FrontierScore| s.matches() as f64 / (s.tangents().max(1)) as f64;
    let Some(first) = curve.first() else { return Evidence::default() };
    Evidence {
        z: z(&|s| s.total()),
        z_tops: z(&|s| s.tops.excess),
        z_bottoms: z(&|s| s.bottoms.excess),
        explained: share(&first.score),
        explained_by_chance: curve.iter().skip(1).map(|s| share(&s.score)).sum::<f64>()
            / (curve.len().saturating_sub(1)).max(1) as f64,
        plane_residual: f64::NAN,
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
    for p in points {
        let (residual, row) = residual_row(at, p);
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
