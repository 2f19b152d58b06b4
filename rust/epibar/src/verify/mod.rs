//! Is it true, and how far off may it be?
//!
//! [`split`] keeps frames aside, [`mod@shift_curve`] tests a geometry on them against chance and [`evidence`] holds what that
//! gives, [`earlier`] with what other frames gave; [`repetition`] asks whether what moves looks the same with others in its place, [`throughout`] whether all parts of the recording
//! agree, or [`moved`] cameras explain one, [`mod@halves`] whether either half asks for another, [`planarity`] whether one plane explains
//! everything and [`turning`] what is known off it, [`mod@rivals`] whether another geometry explains as much, and [`mod@covariance`] how far off it may be, which [`error_map`] draws over the images. [`mod@decide`] goes through the tests, by
//! the [`thresholds`], and says why in the words of [`prose`]; [`early`] refuses before there is anything to test, and
//! [`trials`] takes account of a searched offset.

pub mod covariance;
pub mod decide;
pub mod earlier;
pub mod early;
pub mod error_map;
pub mod evidence;
mod findings;
mod halves;
mod moved;
mod over_image;
pub mod planarity;
mod prose;
mod repetition;
pub mod rivals;
pub mod shift_curve;
pub mod split;
pub mod thresholds;
mod throughout;
pub mod trials;
pub mod turning;
pub mod verdict;

pub use error_map::{ErrorMap, Uncertainty};
pub use evidence::Evidence;
pub use rivals::Rival;
pub use split::Split;
pub use verdict::{Kind, Verdict};

use crate::error::Result;
use crate::frontier::matches::robust_deviation;
use crate::frontier::volume::{Correspondence, disagreement, moving_correspondences};
use crate::frontier::{TangentMatch, Views, compare};
use crate::geometry::{Fundamental, SevenParameters};
use crate::recording::{FramePair, Recording};
use crate::refine::essential::EssentialPrior;
use crate::refine::loss_scale;
use crate::search::Found;
use crate::watch::Watch;
use covariance::{covariance, expected_error, with_prior};
use decide::decide;
use earlier::{Earlier, LOOKS};
use findings::Findings;
use halves::{Halves, halves};
use planarity::plane_residual;
use repetition::repeats;
use rivals::{Winner, rivals};
use shift_curve::{HeldOut, ShiftCurve, cross_validated, shift_curve};
use thresholds::{
    CLEAN_RADIUS, COARSE_SHARE, FAINT_CLASS_Z, FIT_FACTOR, GRID_ERROR, LEAST_EXPLAINED, MIN_Z, NEIGHBOUR,
    NEIGHBOUR_SHARE, RIVAL_Z, ROUGH_DEVIATION, SHIFTS, UNEXPLAINED_SHARE, larger, reaches, within,
};
use throughout::holds;
use trials::left;
use turning::may_turn;

/// Correspondences of the volume where things moved.
const VOLUME: usize = 400;
/// Blocks of frames that a short recording keeps.
const LEAST_BLOCKS: usize = 12;

/// A geometry and what it is tested on.
pub struct Case<'a> {
    /// All common frames.
    pub views: &'a Views,
    /// All frames in which both cameras see something.
    pub busy_views: &'a Views,
    /// Those of them that were fitted to.
    pub fitted_views: &'a Views,
    /// Which frames are which.
    pub split: &'a Split,
    /// What the views are of.
    pub recordings: [&'a Recording; 2],
    /// The frames of either that are common.
    pub common: &'a [FramePair],
    /// The winner, what is tested, and the rivals.
    pub found: &'a Found,
    /// What was tested on other frames, without deciding.
    pub earlier: Option<&'a Earlier>,
    /// A larger expected error is refused, pixels.
    pub max_expected_error: f64,
    /// Frames per second of A; NaN where unknown.
    pub frame_rate: f64,
    /// Seed of every random draw.
    pub seed: u64,
}

/// What the tests gave.
pub struct Verified {
    /// Accepted, or why not.
    pub verdict: Verdict,
    /// Pixels; NaN where unknown.
    pub expected_error: f64,
    /// The numbers behind the verdict.
    pub evidence: Evidence,
    /// Scores with the clocks shifted, on frames kept aside.
    pub curve: ShiftCurve,
    /// Other geometries.
    pub rivals: Vec<Rival>,
    /// Tangents that meet in all frames.
    pub matches: Vec<TangentMatch>,
    /// `None` where the matches do not determine it.
    pub uncertainty: Option<Uncertainty>,
}

/// Tests a geometry, fitted to all frames.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn verify(case: &Case, fundamental: &Fundamental, watch: &mut dyn Watch) -> Result<Verified> {
    let views = case.views;
    let scale = views.pixel_scale();
    let radius = radius_of(&compare(views, fundamental, 6.0 * scale).matches, scale);
    let matches = compare(views, fundamental, radius).matches;

    let fitted = case.found.fitted;
    let volume = moving_correspondences(views, fundamental, VOLUME, case.seed);
    let apart = |f: &Fundamental| disagreement(&volume, f);
    let alike = case.earlier.filter(|earlier| within(apart(&earlier.fitted), case.max_expected_error));
    let (curve, mut evidence) =
        fitted.map_or_else(Default::default, |f| tested(case, &f, fundamental, alike));
    evidence.tested_distance = fitted.map_or(f64::NAN, |f| apart(&f));
    if let Some(earlier) = alike {
        evidence.tested_distance = larger(evidence.tested_distance, apart(&earlier.fitted));
    }
    if case.earlier.is_some() && alike.is_none() {
        evidence.z = left(evidence.z, LOOKS);
    }
    evidence.plane_residual = plane_residual(views, &matches, case.seed);
    evidence.essential_deviation = views.cameras.map_or(f64::NAN, |k| k.deviation(fundamental));

    let block = block_of(case);
    let others = case.found.solutions.get(1..).unwrap_or_default();
    let winner = Winner::new(views, fundamental, block);
    let (rivals, best_radius) = (rivals(&winner, others, &volume), winner.radius);
    // Where nothing stands out that is the verdict.
    let (mut of_halves, mut of_turned) = (0.0, 0.0);
    if reaches(evidence.z, MIN_Z) {
        let turned = may_turn(views, &winner, &matches, evidence.plane_residual, &volume);
        (evidence.may_turn, of_turned) = (turned.image, turned.volume);
        evidence.holds = holds(case.busy_views, fundamental, best_radius, watch)?;
        let Halves { apart, away } = halves(case.busy_views, fundamental, &volume, case.seed);
        (evidence.halves_apart, of_halves) = (apart, away);
        evidence.repeats = repeats(case.recordings, case.common);
    }
    // A geometry that fewer frames gave is as likely to be the truth as a rival that is not behind.
    let others = undecided(&rivals).chain(neighbours(&rivals, scale));
    let of_others = others.fold(evidence.tested_distance.max(0.0).max(of_halves), f64::max);
    let of_chance = UNEXPLAINED_SHARE * best_radius * odds_of_chance(&evidence);
    let systematic = of_others.hypot(of_outlines(&matches, best_radius, scale)).hypot(of_chance);
    // What outlines are off alike, and what meets by chance, is what lets a geometry turn: one error, seen twice.
    let systematic = larger(systematic, of_turned);
    let fit =
        Fit { fundamental, matches: &compare(views, fundamental, best_radius).matches, radius: best_radius };
    let (fit_error, uncertainty) = uncertainty(views, &fit, &volume, block, systematic);
    let expected_error = (FIT_FACTOR * fit_error).hypot(systematic);

    let verdict = decide(&Findings {
        evidence: &evidence,
        matches: &matches,
        radius,
        best_radius,
        expected_error,
        beyond_motion: uncertainty.as_ref().map_or(f64::NAN, Uncertainty::beyond_motion),
        rivals: &rivals,
        scale,
        upright: views.upright,
        max_expected_error: case.max_expected_error,
    });
    Ok(Verified { verdict, expected_error, evidence, curve, rivals, matches, uncertainty })
}

/// The radius follows the masks: three times the deviation of what meets at a generous one.
fn radius_of(generous: &[TangentMatch], scale: f64) -> f64 {
    let radius = (3.0 * robust_deviation(generous)).clamp(1.0 * scale, 6.0 * scale);
    if radius.is_nan() { 3.0 * scale } else { radius }
}

/// The curve over time shifts, on the frames kept aside, of what the others were fitted with, and its sum: with that of other
/// frames where those gave the same geometry. Where one class stands out little on so few frames, its deviate is taken from all of them.
fn tested(
    case: &Case,
    fitted: &Fundamental,
    fundamental: &Fundamental,
    alike: Option<&Earlier>,
) -> (ShiftCurve, Evidence) {
    let scale = case.busy_views.pixel_scale();
    let generous = compare(case.fitted_views, fitted, 6.0 * scale).matches;
    let held_out = HeldOut {
        views: case.busy_views,
        fitted: case.fitted_views,
        tested: &case.split.tested,
        stay: case.split.gap,
        radius: radius_of(&generous, scale).max(2.0 * scale),
    };
    let curve = shift_curve(&held_out, fitted, SHIFTS);
    let curve = match alike {
        Some(earlier) => curve.with(&earlier.curve),
        None => curve,
    };
    let mut evidence = curve.evidence();
    let parts = [evidence.z_tops, evidence.z_bottoms, evidence.z_whole];
    if reaches(evidence.z, MIN_Z) && !parts.into_iter().all(|z| reaches(z, FAINT_CLASS_Z)) {
        let Evidence { z_tops, z_bottoms, z_whole, .. } =
            cross_validated(case.busy_views, fundamental, &held_out, SHIFTS).evidence();
        evidence = Evidence { z_tops, z_bottoms, z_whole, on_all_frames: true, ..evidence };
    }
    (curve, evidence)
}

/// Common frames that share their error: those of a second, or for which motion stays where it is; in a short recording
/// fewer.
fn block_of(case: &Case) -> usize {
    let rate = case.frame_rate;
    let second = if rate.is_finite() { rate.round().max(1.0) as usize } else { 25 };
    second.max(case.split.gap).min((case.views.frames() / LEAST_BLOCKS).max(1))
}

/// How far off the solutions are that the evidence cannot tell from the winner, pixels.
fn undecided(rivals: &[Rival]) -> impl Iterator<Item = f64> {
    rivals.iter().filter(|r| !reaches(r.z, RIVAL_Z) && r.distance.is_finite()).map(|r| r.distance)
}

/// How far off the solutions are that lie near the winner and have nearly its evidence, pixels.
fn neighbours(rivals: &[Rival], scale: f64) -> impl Iterator<Item = f64> {
    let near = move |r: &&Rival| reaches(r.share, NEIGHBOUR_SHARE) && within(r.distance, NEIGHBOUR * scale);
    rivals.iter().filter(near).map(|r| r.distance)
}

/// The share of the tangents that the geometry does not explain, over the share that it explains beyond chance.
fn odds_of_chance(evidence: &Evidence) -> f64 {
    let Evidence { explained, explained_by_chance, .. } = *evidence;
    let beyond_chance = (explained - explained_by_chance) / (1.0 - explained_by_chance);
    let beyond_chance = beyond_chance.clamp(LEAST_EXPLAINED, 1.0);
    (1.0 - beyond_chance) / beyond_chance
}

/// Pixels of error that no number of points averages out: outlines that agree only at a wide radius are inconsistent
/// between the views, and what they share of that stays; exact masks still carry the grid of pixels.
fn of_outlines(matches: &[TangentMatch], best_radius: f64, scale: f64) -> f64 {
    let rough = robust_deviation(matches);
    let roughness = if rough.is_nan() { 0.0 } else { rough * rough / (ROUGH_DEVIATION * scale) };
    let coarseness = (COARSE_SHARE * (best_radius - CLEAN_RADIUS * scale).max(0.0)).hypot(roughness);
    coarseness.hypot(GRID_ERROR * scale)
}

/// A geometry, and the tangents that it was fitted to.
struct Fit<'a> {
    fundamental: &'a Fundamental,
    matches: &'a [TangentMatch],
    /// Within which they meet, pixels.
    radius: f64,
}

/// The error that the fit expects over the volume, pixels, NaN where it is not known, and what is known of it elsewhere.
fn uncertainty(
    views: &Views,
    fit: &Fit,
    volume: &[Correspondence],
    block: usize,
    systematic: f64,
) -> (f64, Option<Uncertainty>) {
    let Some(at) = SevenParameters::new(fit.fundamental, views.sizes()) else { return (f64::NAN, None) };
    let of_points = covariance(&at, fit.matches, loss_scale(fit.radius), block);
    let covariance = of_points.and_then(|of_points| match &views.cameras {
        Some(cameras) => with_prior(&of_points, &EssentialPrior(cameras).information(&at)),
        None => Some(of_points),
    });
    let Some(covariance) = covariance else { return (f64::NAN, None) };
    let fit_error = expected_error(&at, &covariance, volume);
    let covariance = covariance * FIT_FACTOR * FIT_FACTOR;
    (fit_error, Some(Uncertainty { at, covariance, systematic }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hypotheses::Source;

    #[test]
    fn chance_pulls_the_more_the_less_is_explained() {
        let odds = |explained, explained_by_chance| {
            odds_of_chance(&Evidence { explained, explained_by_chance, ..Evidence::default() })
        };
        assert_eq!(odds(1.0, 0.3), 0.0);
        assert!((odds(0.65, 0.3) - 1.0).abs() < 1e-12);
        assert!((odds(0.3, 0.3) - 49.0).abs() < 1e-9 && odds(0.1, 0.3) == odds(0.3, 0.3));
        assert!(odds(1.0, 1.0).is_nan() && odds(f64::NAN, 0.3).is_nan());
    }

    #[test]
    fn a_neighbour_may_be_the_truth() {
        let f = Fundamental::from_matrix(
            &nalgebra::Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0),
            crate::image::ImageSize::new(640, 480).unwrap(),
            crate::image::ImageSize::new(640, 480).unwrap(),
        );
        let rival = |share, distance| Rival {
            fundamental: f.unwrap(),
            share,
            z: 4.0,
            distance,
            source: Source::Tracks,
        };
        let rivals = [rival(0.96, 1.5), rival(0.95, 9.0), rival(0.9, 2.0), rival(0.99, f64::NAN)];
        assert_eq!(neighbours(&rivals, 1.0).collect::<Vec<_>>(), [1.5]);
        assert_eq!(neighbours(&rivals, 2.0).collect::<Vec<_>>(), [1.5, 9.0]);
    }
}
