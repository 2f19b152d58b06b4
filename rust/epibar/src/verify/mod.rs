//! Is it true, and how far off may it be?
//!
//! * `split`: keeps frames aside.
//! * `shift_curve`, `independence`: a geometry on these against chance, which shifted clocks have to offer; what the shifts are worth.
//! * `evidence`, `second_look`: the numbers that this gives, and with them what other frames gave.
//! * `repetition`: does what moves look the same with others in its place?
//! * `throughout`, `sides`, `moved`: do all parts of the recording agree, on either side of any moment, or does a moved camera explain one?
//! * `halves`: does either half ask for another geometry?
//! * `planarity`, `plane`, `turning`: does one plane explain everything, which one is it, and how far may `F` turn about it?
//! * `room`: has what moves the depth of a room?
//! * `rivals`: does another geometry explain as much?
//! * `covariance`, `error_map`, `over_image`: how far off it may be, where in the images, and places all over these.
//! * `untestable`, `trials`: what is refused before there is anything to test, and what is allowed for a searched offset.
//! * `findings`, `decide`, `thresholds`, `prose`: what the tests look at, the tests in their order, their numbers and their words.
//! * `verdict`, `verified`: what comes out.

pub mod covariance;
pub mod decide;
pub mod error_map;
pub mod evidence;
mod findings;
mod halves;
mod independence;
mod moved;
mod over_image;
pub mod planarity;
mod plane;
mod prose;
mod repetition;
pub mod rivals;
mod room;
pub mod second_look;
pub mod shift_curve;
pub mod sides;
pub mod split;
pub mod thresholds;
mod throughout;
pub mod trials;
pub mod turning;
pub mod untestable;
pub mod verdict;
pub mod verified;

pub use error_map::{ErrorMap, Uncertainty};
pub use evidence::Evidence;
pub use rivals::Rival;
pub use split::Split;
pub use verdict::{Kind, Verdict};
pub use verified::Verified;

use crate::error::Result;
use crate::frontier::matches::robust_deviation;
use crate::frontier::volume::{disagreement, met_correspondences};
use crate::frontier::{TangentMatch, Views, compare};
use crate::geometry::seven_parameters::Information;
use crate::geometry::{Fundamental, SevenParameters};
use crate::recording::fill::fill;
use crate::recording::{FramePair, Recording};
use crate::refine::essential::EssentialPrior;
use crate::refine::loss_scale;
use crate::search::Found;
use crate::watch::Watch;
use covariance::{covariance, covariance_alike, with_prior};
use decide::decide;
use findings::Findings;
use halves::{Halves, halves};
use planarity::{median_width, plane_residual};
use repetition::repeats;
use rivals::{Winner, rivals};
use room::Room;
use second_look::{Earlier, LOOKS};
use shift_curve::{HeldOut, ShiftCurve, cross_validated, shift_curve};
use thresholds::{
    CLEAN_RADIUS, COARSE_SHARE, CONVEX, FAINT_CLASS_Z, FIT_FACTOR, GENEROUS_RADIUS, GRID_ERROR,
    LEAST_EXPLAINED, LEAST_RADIUS, LEAST_TESTED_RADIUS, MIN_Z, NEIGHBOUR, NEIGHBOUR_SHARE, RADIUS_DEVIATIONS,
    ROUGH_DEVIATION, SHIFTS, STANDS_IN, UNKNOWN_RADIUS, larger, reaches, within,
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
    /// Seed of every random draw but those of [`turning`].
    pub seed: u64,
}

/// Tests a geometry, fitted to all frames.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn verify(case: &Case, fundamental: &Fundamental, watch: &mut dyn Watch) -> Result<Verified> {
    let views = case.views;
    let scale = views.pixel_scale();
    let radius = radius_of(&compare(views, fundamental, GENEROUS_RADIUS * scale).matches, scale);
    let matches = compare(views, fundamental, radius).matches;

    let fitted = case.found.fitted;
    let volume = met_correspondences(views, fundamental, &matches, VOLUME, case.seed);
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
        let by_chance = 1.0 - beyond_chance(&evidence) / evidence.explained;
        let widths = [&views.a, &views.b].map(median_width);
        let room = Room::new(fundamental, &matches, by_chance, views.sizes(), widths);
        (evidence.spread_of_bottoms, evidence.tops_off_floor) = (room.area, room.height);
        evidence.holds = holds(case.busy_views, fundamental, best_radius, watch)?;
        let Halves { apart, away } = halves(case.busy_views, fundamental, &volume, case.seed);
        (evidence.halves_apart, of_halves) = (apart, away);
        evidence.repeats = repeats(case.recordings, case.common);
    }
    // A geometry that fewer frames gave is as likely to be the truth as a rival that is not behind.
    let others = undecided(&rivals).chain(neighbours(&rivals, scale));
    let of_others = others.fold(evidence.tested_distance.max(0.0).max(of_halves), f64::max);
    let stand_in = of_stand_ins(case);
    let systematic = of_others.hypot(of_outlines(&matches, best_radius, scale, stand_in));
    // What outlines are off alike is what lets a geometry turn: one error, seen twice.
    let systematic = larger(systematic, of_turned);
    let fit = Fit {
        fundamental,
        matches: &compare(views, fundamental, best_radius).matches,
        radius: best_radius,
        beyond_chance: beyond_chance(&evidence),
    };
    let known = known(views, &fit, block, systematic);
    let expected_error = known.as_ref().map_or(f64::NAN, |k| k.uncertainty.over(&volume));

    let verdict = decide(&Findings {
        evidence: &evidence,
        matches: &matches,
        radius,
        best_radius,
        expected_error,
        beyond_motion: known.as_ref().map_or(f64::NAN, |k| k.beyond_motion),
        possible_beyond: known.as_ref().map_or(f64::NAN, |k| k.uncertainty.beyond_motion()),
        rivals: &rivals,
        scale,
        upright: views.upright,
        max_expected_error: case.max_expected_error,
    });
    let uncertainty = known.map(|k| k.uncertainty);
    Ok(Verified { verdict, expected_error, evidence, curve, rivals, matches, uncertainty })
}

/// The radius follows the masks: three times the deviation of what meets at a generous one.
fn radius_of(generous: &[TangentMatch], scale: f64) -> f64 {
    let radius = RADIUS_DEVIATIONS * robust_deviation(generous);
    let radius = radius.clamp(LEAST_RADIUS * scale, GENEROUS_RADIUS * scale);
    if radius.is_nan() { UNKNOWN_RADIUS * scale } else { radius }
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
    let generous = compare(case.fitted_views, fitted, GENEROUS_RADIUS * scale).matches;
    let held_out = HeldOut {
        views: case.busy_views,
        fitted: case.fitted_views,
        tested: &case.split.tested,
        stay: case.split.gap,
        radius: radius_of(&generous, scale).max(LEAST_TESTED_RADIUS * scale),
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
    rivals.iter().filter(|r| r.is_undecided() && r.distance.is_finite()).map(|r| r.distance)
}

/// How far off the solutions are that lie near the winner and have nearly its evidence, pixels.
fn neighbours(rivals: &[Rival], scale: f64) -> impl Iterator<Item = f64> {
    let near = move |r: &&Rival| reaches(r.share, NEIGHBOUR_SHARE) && within(r.distance, NEIGHBOUR * scale);
    rivals.iter().filter(near).map(|r| r.distance)
}

/// The share of the tangents that the geometry explains and chance does not.
fn beyond_chance(evidence: &Evidence) -> f64 {
    let Evidence { explained, explained_by_chance, .. } = *evidence;
    ((explained - explained_by_chance) / (1.0 - explained_by_chance)).clamp(LEAST_EXPLAINED, 1.0)
}

/// Pixels of error that no number of points averages out: outlines that agree only at a wide radius are inconsistent
/// between the views, and what they share of that stays; exact masks still carry the grid of pixels.
fn of_outlines(matches: &[TangentMatch], best_radius: f64, scale: f64, stand_in: f64) -> f64 {
    let rough = robust_deviation(matches);
    let roughness = if rough.is_nan() { 0.0 } else { rough.max(rough * rough / (ROUGH_DEVIATION * scale)) };
    let coarseness = (COARSE_SHARE * (best_radius - CLEAN_RADIUS * scale).max(0.0)).hypot(roughness);
    coarseness.hypot(GRID_ERROR * scale).hypot(stand_in)
}

/// Pixels by which shapes are wrong that may stand in for something else, as boxes and ellipses do for people; 0 of masks that were cut out.
fn of_stand_ins(case: &Case) -> f64 {
    let [p, q] = case.recordings.map(|recording| fill(&recording.silhouettes));
    let width = 0.5 * (median_width(&case.views.a) + median_width(&case.views.b));
    // Of silhouettes too small to tell it is not known that they are masks.
    if within(p, CONVEX) && within(q, CONVEX) { 0.0 } else { STANDS_IN * width }
}

/// A geometry, and the tangents that it was fitted to.
struct Fit<'a> {
    fundamental: &'a Fundamental,
    matches: &'a [TangentMatch],
    /// Within which they meet, pixels.
    radius: f64,
    /// The share of the tangents that meets, and not by chance.
    beyond_chance: f64,
}

/// What is known of a geometry.
struct Known {
    uncertainty: Uncertainty,
    /// Half of an image is known no worse than this by the covariance alone, pixels.
    beyond_motion: f64,
}

/// `None` where the matches do not determine the geometry.
fn known(views: &Views, fit: &Fit, block: usize, systematic: f64) -> Option<Known> {
    let at = SevenParameters::new(fit.fundamental, views.sizes())?;
    let of_points = covariance(&at, fit.matches, loss_scale(fit.radius), block)?;
    let with_cameras = |of_points: Information| match &views.cameras {
        Some(cameras) => with_prior(&of_points, &EssentialPrior(cameras).information(&at)),
        None => Some(of_points),
    };
    let (alone, none) = (with_cameras(of_points)?, Information::zeros());
    let taken_for_true = Uncertainty { at: at.clone(), covariance: alone, alike: none, systematic: 0.0 };
    // What meets by chance would meet under a neighbour as well: it says nothing, and is weighed as if it did.
    let diluted = with_cameras(of_points / fit.beyond_chance.powi(2))?;
    let off_alike = robust_deviation(fit.matches);
    let alike = with_cameras(covariance_alike(&at, fit.matches, loss_scale(fit.radius), off_alike)?)?;
    let uncertainty = Uncertainty { at, covariance: diluted * FIT_FACTOR * FIT_FACTOR, alike, systematic };
    Some(Known { uncertainty, beyond_motion: taken_for_true.beyond_motion() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hypotheses::Source;

    #[test]
    fn what_is_explained_beyond_chance() {
        let share = |explained, explained_by_chance| {
            beyond_chance(&Evidence { explained, explained_by_chance, ..Evidence::default() })
        };
        assert_eq!(share(1.0, 0.3), 1.0);
        assert!((share(0.65, 0.3) - 0.5).abs() < 1e-12);
        assert_eq!([share(0.3, 0.3), share(0.1, 0.3)], [LEAST_EXPLAINED; 2]);
        assert!(share(1.0, 1.0).is_nan() && share(f64::NAN, 0.3).is_nan());
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
