//! Is it true, and how far off may it be?
//!
//! * `split`: keeps frames aside.
//! * `shift_curve`, `independence`: a geometry on these against chance, which shifted clocks have to offer; what the shifts are worth.
//! * `split_views`, `case`, `second_look`: silhouettes at those frames, what is tested on what, and what other frames gave.
//! * `masks`: were silhouettes cut out, or do they stand in for something else?
//! * `evidence`: the numbers that this gives.
//! * `repetition`: does what moves look the same with others in its place?
//! * `throughout`, `sides`, `turned_in_part`: do all parts of the recording agree, on either side of any moment, or does a moved camera explain one?
//! * `halves`, `gains`: does either half ask for another geometry, and is what it gains by that more than chance?
//! * `planarity`, `plane`, `turning`: does one plane explain everything, which one is it, and how far may `F` turn about it?
//! * `from_cameras`, `given_cameras`: is it of any two cameras, and do camera matrices that were given agree with what moves?
//! * `other_clocks`: does another clock explain as much, with a geometry of its own?
//! * `room`: has what moves the depth of a room?
//! * `rivals`: does another geometry explain as much?
//! * `expected_error`, `covariance`: how far off it may be: by chance, alike, and by what other geometries ask for.
//! * `error_map`, `over_image`: where in the images, and places all over these.
//! * `untestable`, `trials`: what is refused before there is anything to test, and what is allowed for a searched offset.
//! * `findings`, `decide`, `thresholds`, `prose`: what the tests look at, the tests in their order, their numbers and their words.
//! * `allowed_beyond`: how far it may be uncertain beyond the motion, by the depth of that.
//! * `verdict`, `verified`: what comes out.

mod allowed_beyond;
mod case;
pub mod covariance;
pub mod decide;
pub mod error_map;
pub mod evidence;
mod expected_error;
mod findings;
mod from_cameras;
mod gains;
mod given_cameras;
mod halves;
mod independence;
mod masks;
pub mod other_clocks;
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
mod split_views;
pub mod thresholds;
mod throughout;
pub mod trials;
mod turned_in_part;
pub mod turning;
pub mod untestable;
pub mod verdict;
pub mod verified;

pub use case::Case;
pub use error_map::ErrorMap;
pub use evidence::Evidence;
pub use masks::are_masks;
pub use rivals::Rival;
pub use split_views::SplitViews;
pub use verdict::{Kind, Verdict};
pub use verified::Verified;

use crate::error::Result;
use crate::frontier::volume::{Correspondence, disagreement, met_correspondences};
use crate::frontier::{TangentMatch, meeting_radius, tangent_matches};
use crate::geometry::Fundamental;
use crate::watch::Watch;
use decide::decide;
use expected_error::{Away, Stated, beyond_chance};
use findings::Findings;
use from_cameras::{error_of, from_cameras};
use halves::halves;
use planarity::{median_width, plane_residual};
use repetition::repeats;
use rivals::{Winner, rivals};
use room::Room;
use second_look::{Earlier, LOOKS};
use shift_curve::{HeldOut, ShiftCurve, cross_validated, shift_curve};
use thresholds::{FAINT_CLASS_Z, LEAST_TESTED_RADIUS, MIN_Z, SHIFTS, larger, reaches, within};
use throughout::holds;
use trials::left;
use turning::may_turn;

/// Correspondences of the volume where things moved.
const VOLUME: usize = 400;

/// Tests a geometry, fitted to all frames.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn verify(case: &Case, fundamental: &Fundamental, watch: &mut dyn Watch) -> Result<Verified> {
    let views = case.views;
    let scale = views.pixel_scale();
    let radius = meeting_radius(views, fundamental);
    let matches = tangent_matches(views, fundamental, radius);
    let volume = met_correspondences(views, fundamental, &matches, VOLUME, case.seed);

    let (curve, mut evidence) = against_chance(case, fundamental, &volume);
    evidence.plane_residual = plane_residual(views, &matches, case.seed);
    evidence.essential_deviation = views.cameras.map_or(f64::NAN, |k| k.deviation(fundamental));
    let winner = Winner::new(views, fundamental, case.block());
    let rivals = rivals(&winner, case.found.solutions.get(1..).unwrap_or_default(), &volume);
    // Where nothing stands out that is the verdict.
    let (away, without_given_cameras) = if reaches(evidence.z, MIN_Z) {
        let away = questioned(case, &winner, &matches, &volume, &mut evidence, watch)?;
        (away, given_cameras::without_given_cameras(case.busy_views, fundamental))
    } else {
        (Away::default(), None)
    };

    let mut stated = Stated::new(case, &winner, &matches, &rivals, &evidence, away);
    let from_cameras = from_cameras(views, fundamental, stated.as_ref().map(|s| &s.uncertainty));
    if let Some(Stated { uncertainty, .. }) = &mut stated {
        uncertainty.systematic = uncertainty.systematic.hypot(error_of(views, from_cameras));
    }
    let expected_error = stated.as_ref().map_or(f64::NAN, |stated| stated.uncertainty.over(&volume));
    let verdict = decide(&Findings {
        evidence: &evidence,
        matches: &matches,
        radius,
        best_radius: winner.radius,
        expected_error,
        beyond_motion: stated.as_ref().map_or(f64::NAN, |stated| stated.beyond_motion),
        possible_beyond: stated.as_ref().map_or(f64::NAN, |stated| stated.uncertainty.beyond_motion()),
        rivals: &rivals,
        scale,
        upright: views.upright,
        from_cameras,
        without_given_cameras,
        max_expected_error: case.max_expected_error,
    });
    let uncertainty = stated.map(|stated| stated.uncertainty);
    Ok(Verified { verdict, expected_error, evidence, curve, rivals, radius, matches, volume, uncertainty })
}

/// What is asked of a geometry that stands out, and how far off others are that something asks for.
fn questioned(
    case: &Case,
    winner: &Winner,
    matches: &[TangentMatch],
    volume: &[Correspondence],
    evidence: &mut Evidence,
    watch: &mut dyn Watch,
) -> Result<Away> {
    let (views, fundamental) = (case.views, &winner.fundamental);
    let turned = may_turn(views, winner, matches, evidence.plane_residual, volume);
    evidence.may_turn = turned.image;
    let by_chance = 1.0 - beyond_chance(evidence) / evidence.explained;
    let widths = [&views.a, &views.b].map(median_width);
    let room = Room::new(fundamental, matches, by_chance, views.sizes(), widths);
    (evidence.spread_of_bottoms, evidence.tops_off_floor) = (room.area, room.height);
    evidence.holds = holds(case.busy_views, fundamental, winner.radius, watch)?;
    let halves = halves(case.busy_views, fundamental, volume, case.seed);
    evidence.halves_apart = halves.apart;
    evidence.repeats = repeats(case.recordings, case.common);
    Ok(Away { by_halves: halves.away, by_turning: turned.volume })
}

/// What the fitted frames gave, on those kept aside and with clocks shifted, together with what other frames gave where that is the same
/// geometry; and how far from the one of all frames either is.
fn against_chance(
    case: &Case,
    fundamental: &Fundamental,
    volume: &[Correspondence],
) -> (ShiftCurve, Evidence) {
    let apart = |f: &Fundamental| disagreement(volume, f);
    let alike = case.earlier.filter(|earlier| within(apart(&earlier.fitted), case.max_expected_error));
    let fitted = case.found.fitted;
    let (curve, mut evidence) =
        fitted.map_or_else(Default::default, |f| tested(case, &f, fundamental, alike));
    evidence.tested_distance = fitted.map_or(f64::NAN, |f| apart(&f));
    if let Some(earlier) = alike {
        evidence.tested_distance = larger(evidence.tested_distance, apart(&earlier.fitted));
    }
    if case.earlier.is_some() && alike.is_none() {
        evidence.z = left(evidence.z, LOOKS);
    }
    (curve, evidence)
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
    let held_out = HeldOut {
        views: case.busy_views,
        fitted: case.fitted_views,
        tested: &case.split.tested,
        stay: case.split.stay,
        radius: meeting_radius(case.fitted_views, fitted).max(LEAST_TESTED_RADIUS * scale),
    };
    let curve = shift_curve(&held_out, fitted, SHIFTS);
    let curve = match alike {
        Some(earlier) => curve.with(&earlier.curve),
        None => curve,
    };
    let mut evidence = curve.evidence();
    let parts = [evidence.z_tops, evidence.z_bottoms, evidence.z_whole];
    if reaches(evidence.z, MIN_Z) && !parts.into_iter().all(|z| reaches(z, FAINT_CLASS_Z)) {
        let all = cross_validated(case.busy_views, fundamental, &held_out, SHIFTS);
        // Where the shifts of all frames are too few to say, what was kept aside has the word.
        if all.can_say() {
            let all = all.evidence();
            let clearer = |own: f64, all: f64| if reaches(own, FAINT_CLASS_Z) { own } else { all };
            evidence = Evidence {
                z_tops: clearer(evidence.z_tops, all.z_tops),
                z_bottoms: clearer(evidence.z_bottoms, all.z_bottoms),
                z_whole: clearer(evidence.z_whole, all.z_whole),
                on_all_frames: true,
                ..evidence
            };
        }
    }
    (curve, evidence)
}
