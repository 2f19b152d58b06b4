//! What a verdict rests on, and how it is reached (DESIGN §7).

use std::collections::HashSet;

use rayon::prelude::*;

use super::error_map::{ErrorMap, Uncertainty};
use super::split::Split;
use super::verdict::{Kind, Verdict};
use super::{CalibrateOptions, Method, Rival, matched};
use crate::estimate::evidence::{evidence, evidence_by_frame, pixel_scale};
use crate::estimate::floor::Floor;
use crate::estimate::frontier::{FrontierPoint, spread};
use crate::estimate::optimise::SevenParameters;
use crate::estimate::search::Found;
use crate::estimate::views::Views;
use crate::estimate::volume::{disagreement, moving_correspondences};
use crate::geometry::Fundamental;
use crate::planarity::plane_residual;
use crate::verify::{
    Evidence, HeldOut, ShiftCurve, covariance, cross_validated, expected_error, paired_z, shift_curve,
    with_prior,
};

/// A floor worth reporting: many candidates fit it, and not because they all pass through one point.
pub(super) fn is_floor(floor: &Floor, candidates: usize) -> bool {
    floor.inliers * 5 >= candidates && floor.spread * 8 >= candidates && floor.spread >= 30
}

/// Evidence below this normal deviate on frames kept aside is none. Unrelated pairs were never seen to reach 3, true ones of
/// 400 frames stood at 7 and more.
pub(super) const MIN_Z: f64 = 5.0;
/// From this on there is something to be told of, if not enough.
const SOME_Z: f64 = 2.0;
/// Below this share of A's tangents that meet one of B, an `F` is not the geometry of the scene.
const MIN_EXPLAINED: f64 = 0.15;
/// Matched points must leave the best plane by this share of a silhouette's width: less is a path, a wall or no
/// baseline.
const MIN_DEPTH: f64 = 0.9;
/// Matched points at fewer different places say nothing: lamps that blink where they stand meet at the right moments under any
/// of many geometries. Such lamps were seen at 5 to 10 places, two walkers in 400 frames at 950.
const MIN_PLACES: usize = 50;
/// Size of a place, pixels of a 640×480 image.
const PLACE: f64 = 4.0;
/// Half of an image may be known no worse than this, pixels of a 640×480 image, by the covariance alone: of scenes with
/// depth it is 0.2 to 3.4, where all keep to one path 5 and more.
const MAX_BEYOND: f64 = 4.0;
/// A class of tangents below this normal deviate matches no better than chance.
const MIN_CLASS_Z: f64 = 2.0;
/// Below this on the frames kept aside a class is judged on all frames.
const FAINT_CLASS_Z: f64 = 3.0;
/// A different geometry whose evidence differs by less than this many standard deviations may be the truth as well.
const RIVAL_Z: f64 = 2.5;
/// Where nothing tells which end of what moves is up, the mirror of the truth may have more evidence than the truth, which
/// was seen with this share of it.
const MIRROR_SHARE: f64 = 0.65;
/// Share of the radius at which outlines agree that counts as a systematic error.
const COARSE_SHARE: f64 = 1.0;
/// Residuals of a fraction of a pixel are noise and average out; residuals of several pixels are outlines of different
/// shape, and do not. Their square over this many pixels of a 640×480 image counts as systematic.
const ROUGH_SPREAD: f64 = 1.2;
/// Shifts of the clocks that tell what is chance.
const SHIFTS: usize = 60;
/// Error that rasterisation leaves even in exact masks, pixels of a 640×480 image.
const GRID_ERROR: f64 = 0.06;
/// The covariance knows the noise of the outlines but not what all of them share; twice its error is what
/// `benchmarks/frontier.py` finds to hold for about nine pairs in ten.
const FIT_FACTOR: f64 = 2.0;

pub(super) struct Case<'a> {
    pub views: &'a Views,
    /// All frames in which both cameras see something.
    pub busy_views: &'a Views,
    /// Those of them that were fitted to.
    pub fitted_views: &'a Views,
    pub split: &'a Split,
    /// Fitted to all frames.
    pub fundamental: &'a Fundamental,
    pub found: &'a Found,
    pub options: &'a CalibrateOptions,
    pub frame_rate: f64,
}

pub(super) struct Judged {
    pub verdict: Verdict,
    pub expected_error: f64,
    pub evidence: Evidence,
    pub curve: ShiftCurve,
    pub rivals: Vec<Rival>,
    pub points: Vec<FrontierPoint>,
    pub uncertainty: Option<Uncertainty>,
}

/// The radius follows the masks: three times the spread of what matches at a generous one.
fn radius_of(generous: &[FrontierPoint], scale: f64) -> f64 {
    let radius = (3.0 * spread(generous)).clamp(1.0 * scale, 6.0 * scale);
    if radius.is_nan() { 3.0 * scale } else { radius }
}

/// The curve over time shifts, on the frames kept aside, of what the others were fitted with, and its sum. Where one class
/// stands out little on so few frames, its deviate is taken from all of them.
fn tested(case: &Case, fitted: &Fundamental) -> (ShiftCurve, Evidence) {
    let Case { busy_views, split, fitted_views, options, fundamental, .. } = case;
    let scale = pixel_scale(busy_views);
    let generous = matched(fitted_views, fitted, 6.0 * scale, options.upright);
    let held_out = HeldOut {
        views: busy_views,
        fitted: fitted_views,
        tested: &split.tested,
        stay: split.gap,
        radius: radius_of(&generous, scale).max(2.0 * scale),
        upright: options.upright,
    };
    let curve = shift_curve(&held_out, fitted, SHIFTS);
    let mut evidence = curve.evidence();
    if evidence.z >= MIN_Z && evidence.z_tops.min(evidence.z_bottoms) < FAINT_CLASS_Z {
        let of_all = cross_validated(busy_views, fundamental, &held_out, SHIFTS).evidence();
        (evidence.z_tops, evidence.z_bottoms) = (of_all.z_tops, of_all.z_bottoms);
    }
    (curve, evidence)
}

pub(super) fn judge(case: &Case) -> Judged {
    let Case { views, fundamental, found, options, frame_rate, .. } = case;
    let scale = pixel_scale(views);
    let upright = options.upright;
    let radius = radius_of(&matched(views, fundamental, 6.0 * scale, upright), scale);
    let points = matched(views, fundamental, radius, upright);

    let (curve, mut evidence_now) = found.fitted.map_or_else(Default::default, |f| tested(case, &f));
    evidence_now.plane_residual = plane_residual(views, &points);
    evidence_now.essential_deviation = views.cameras.map_or(f64::NAN, |k| k.deviation(fundamental));

    let second = if frame_rate.is_finite() { frame_rate.round().max(1.0) as usize } else { 25 };
    let parameters = SevenParameters::new(fundamental, views.sizes());
    let volume = moving_correspondences(views, fundamental, 400);
    let block = second.min((views.frames() / 12).max(1));
    let covariance = parameters.as_ref().and_then(|at| {
        let of_points = covariance(at, &points, block)?;
        match views.cameras {
            Some(cameras) => with_prior(&of_points, &cameras.information(at)),
            None => Some(of_points),
        }
    });
    let fit_error = match (&parameters, &covariance) {
        (Some(at), Some(covariance)) => expected_error(at, covariance, &volume),
        _ => f64::NAN,
    };

    let own = evidence(views, fundamental, upright);
    let by_frame = |f, radius| evidence_by_frame(views, f, radius, upright);
    let own_by_frame = by_frame(fundamental, own.radius);
    let others = if options.method == Method::Frontier { found.solutions.get(1..) } else { None };
    let mut rivals: Vec<Rival> = others
        .unwrap_or_default()
        .par_iter()
        .map(|solution| {
            let theirs = evidence(views, &solution.fundamental, upright);
            Rival {
                fundamental: solution.fundamental,
                share: theirs.total / own.total.max(1e-9),
                z: paired_z(&own_by_frame, &by_frame(&solution.fundamental, theirs.radius), block),
                distance: disagreement(&volume, &solution.fundamental),
                source: solution.source.name(),
            }
        })
        .collect();
    rivals.sort_by(|p, q| q.share.total_cmp(&p.share));
    // Solutions that the evidence cannot tell from the winner are as likely to be the truth as it is.
    let undecided: Vec<f64> =
        rivals.iter().filter(|r| r.z < RIVAL_Z && r.distance.is_finite()).map(|r| r.distance).collect();
    let spread_error = undecided.iter().copied().fold(0.0, f64::max);
    // Outlines that agree only at a wide radius are inconsistent between the views, and what they share of that
    // does not average out; exact masks still carry the grid of pixels.
    let rough = spread(&points);
    let roughness = if rough.is_nan() { 0.0 } else { rough * rough / (ROUGH_SPREAD * scale) };
    let coarseness = (COARSE_SHARE * (own.radius - 1.5 * scale).max(0.0)).hypot(roughness);
    let systematic = spread_error.hypot(coarseness).hypot(GRID_ERROR * scale);
    let error = (FIT_FACTOR * fit_error).hypot(systematic);
    let uncertainty = parameters.zip(covariance).map(|(at, covariance)| Uncertainty {
        at,
        covariance: covariance * FIT_FACTOR * FIT_FACTOR,
        systematic,
    });

    let beyond = uncertainty.as_ref().map_or(f64::NAN, beyond_motion);
    let verdict = decide(case, &evidence_now, &points, error, beyond, &rivals, radius);
    Judged { verdict, expected_error: error, evidence: evidence_now, curve, rivals, points, uncertainty }
}

/// At how many different places points are matched, in cells of both images together.
fn places(points: &[FrontierPoint], cell: f64) -> usize {
    let cells = |p: [f64; 2]| p.map(|v| (v / cell).round() as i64);
    points.iter().map(|p| (cells(p.a), cells(p.b))).collect::<HashSet<_>>().len()
}

/// The error that the covariance alone expects in half of either image, the larger of the two, pixels.
fn beyond_motion(uncertainty: &Uncertainty) -> f64 {
    let known = Uncertainty { systematic: 0.0, ..uncertainty.clone() };
    let median = |map: ErrorMap| {
        let mut values: Vec<f64> = map.values.into_iter().filter(|v| v.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    known.maps().map(median).into_iter().fold(0.0, f64::max)
}

/// How much suggests something, as a sentence begins.
pub(super) fn suggestion(z: f64) -> &'static str {
    if z < SOME_Z { "Nothing suggests" } else { "Too little suggests" }
}

/// What is told of a number that is too small must be too small as well.
pub(super) fn not_rounded_up(z: f64) -> f64 {
    (10.0 * z).floor() / 10.0
}

fn decide(
    case: &Case,
    evidence: &Evidence,
    points: &[FrontierPoint],
    error: f64,
    beyond: f64,
    rivals: &[Rival],
    radius: f64,
) -> Verdict {
    let limit = case.options.max_expected_error;
    if evidence.z < MIN_Z {
        return Verdict::new(
            Kind::NoCommonScene,
            format!(
                "{} that the two cameras see the same moving things at the same time: on frames kept \
                 aside the geometry stands {:.1} standard deviations above its own score with the clocks shifted, and {MIN_Z:.0} \
                 are needed.",
                suggestion(evidence.z),
                not_rounded_up(evidence.z)
            ),
        );
    }
    if !evidence.explained.is_finite() || evidence.explained < MIN_EXPLAINED {
        return Verdict::new(
            Kind::NoCommonScene,
            format!(
                "Only {:.0} % of the outlines' tangents in camera A meet one in camera B, too few to be the geometry of \
                 the scene.",
                100.0 * evidence.explained
            ),
        );
    }
    if evidence.z_tops < MIN_CLASS_Z || evidence.z_bottoms < MIN_CLASS_Z {
        let which = if evidence.z_tops < evidence.z_bottoms { "upper" } else { "lower" };
        return Verdict::new(
            Kind::Undetermined,
            format!(
                "The motion leaves the geometry undetermined: the {which} edges of what moves match no better than \
                 chance, so only part of the geometry is supported."
            ),
        );
    }
    let places = places(points, PLACE * pixel_scale(case.views));
    if places < MIN_PLACES {
        return Verdict::new(
            Kind::Undetermined,
            format!(
                "The motion leaves the geometry undetermined: whatever moves does so at the same {places} places, and many \
                 geometries fit so few."
            ),
        );
    }
    let plane = evidence.plane_residual;
    if plane < MIN_DEPTH {
        return Verdict::new(
            Kind::Undetermined,
            format!(
                "The motion leaves the geometry undetermined: everything keeps to one straight path or one plane, or the \
                 cameras stand at one place (most matched points lie within {:.0} % of a silhouette's width of a plane).",
                100.0 * plane
            ),
        );
    }
    if beyond > MAX_BEYOND * pixel_scale(case.views) {
        return Verdict::new(
            Kind::Undetermined,
            format!(
                "The motion leaves the geometry undetermined: it is known where things moved, but in half of an image it \
                 may be {beyond:.0} px off or more, because everything keeps to one path or about one plane."
            ),
        );
    }
    let upright = case.options.upright || case.options.method == Method::Lines;
    let as_likely = |r: &&Rival| r.z < RIVAL_Z || (!upright && r.share > MIRROR_SHARE);
    if let Some(rival) = rivals.iter().filter(as_likely).find(|r| r.distance > limit) {
        return Verdict::new(
            Kind::Ambiguous,
            format!(
                "A different geometry, {:.0} px away, explains the motion nearly as well ({:.0} % of the evidence); more \
                 varied motion would tell them apart.",
                rival.distance,
                100.0 * rival.share
            ),
        );
    }
    if error.is_nan() || error > limit {
        return Verdict::new(
            Kind::Inaccurate,
            if error.is_nan() {
                "Too few points of the outlines match to say how accurate the geometry is.".to_string()
            } else {
                format!("The expected error of {error:.1} px is above the limit of {limit:.1} px.")
            },
        );
    }
    Verdict::new(
        Kind::Accepted,
        format!(
            "{} matched outline points, {:.0} % of all in camera A, agree to {radius:.1} px; on frames kept aside the \
             geometry stands {:.0} standard deviations above chance, and the expected error is {error:.2} px.",
            points.len(),
            100.0 * evidence.explained,
            evidence.z
        ),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::frontier::Class;

    #[test]
    fn places_are_counted_once() {
        let point =
            |frame, a, b| FrontierPoint { frame, a, b, distance: 0.1, surprise: 1.0, class: Class::Top };
        let lamps: Vec<_> = (0..90).map(|k| point(k, [f64::from(k % 3) * 50.0, 7.0], [9.0, 9.0])).collect();
        assert_eq!(places(&lamps, 4.0), 3);
        let walk: Vec<_> = (0..90).map(|k| point(k, [f64::from(k) * 4.0, 7.0], [9.0, 9.0])).collect();
        assert_eq!(places(&walk, 4.0), 90);
        assert_eq!(places(&[], 4.0), 0);
    }
}
