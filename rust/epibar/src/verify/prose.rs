//! The sentences of verdicts.

use std::fmt::Write;

use super::findings::Findings;
use super::gains::Gain;
use super::rivals::Rival;
use super::thresholds::{CAMERAS_DOUBTED, MIN_FRAMES, MIN_LINES, MIN_Z, SOME_Z, reaches};

/// How much suggests something, as a sentence begins.
fn suggestion(z: f64) -> &'static str {
    if z < SOME_Z { "Nothing suggests" } else { "Too little suggests" }
}

/// A number that is too small must be too small as printed as well.
fn not_rounded_up(z: f64) -> f64 {
    (10.0 * z).floor() / 10.0
}

/// A number that is above its limit must be above it as printed as well, with two decimals.
fn not_rounded_down(number: f64, limit: f64) -> f64 {
    let printed = |x: f64| (100.0 * x).round();
    if printed(number) > printed(limit) { number } else { (printed(limit) + 1.0) / 100.0 }
}

pub(super) fn few_common_frames(common: usize) -> String {
    format!("Only {common} frames are common to both cameras; at least {MIN_FRAMES} are needed.")
}

/// Of so many informative lines of A and of B.
pub(super) fn uninformative(a: usize, b: usize) -> String {
    let which = match (a < MIN_LINES, b < MIN_LINES) {
        (true, false) => "camera A",
        (false, true) => "camera B",
        _ => "either camera",
    };
    format!(
        "Too little changes in {which}: {a} lines of A and {b} of B are crossed by motion in some frames and \
         free of it in others, and at least {MIN_LINES} are needed in each."
    )
}

pub(super) const NO_CANDIDATES: &str = "No lines of the two cameras are crossed by motion at the same moments, so nothing suggests that they see \
     the same moving things at the same time.";

pub(super) fn few_silhouettes(busy: usize) -> String {
    format!(
        "Only {busy} frames show something larger than specks moving in both cameras; at least {MIN_FRAMES} \
         are needed."
    )
}

pub(super) const NO_HYPOTHESIS: &str = "No epipolar geometry explains what moves in both cameras, so nothing suggests that they see the same \
     moving things at the same time.";

pub(super) fn accepted(f: &Findings) -> String {
    let mut accepted = format!(
        "{} matched outline points, {:.0} % of all, agree to {:.1} px; on frames kept aside the \
         geometry stands {:.0} standard deviations above chance, and the expected error is {:.2} px.",
        f.matches.len(),
        100.0 * f.evidence.explained,
        f.radius,
        f.evidence.z,
        f.expected_error,
    );
    let beyond = f.evidence.may_turn.max(f.possible_beyond);
    if beyond > f.max_expected_error {
        let _ = write!(
            accepted,
            " That holds where things moved; in half of an image, beyond it, {beyond:.0} px are possible."
        );
    }
    if reaches(f.from_cameras, CAMERAS_DOUBTED) {
        let _ = write!(
            accepted,
            " No two cameras with {} have quite this geometry, it is off by {:.1} %: {LOOK_AT_THEM} {}",
            pixels_and_middle(f),
            100.0 * f.from_cameras,
            advice(f)
        );
    }
    accepted
}

const LOOK_AT_THEM: &str = "look whether the silhouettes of one camera lack the same part of everybody, as feet or dark trousers, or have too much, as a shadow or a reflection.";

/// What two cameras are taken to have.
fn pixels_and_middle(f: &Findings) -> &'static str {
    if f.without_given_cameras.is_some() {
        "the principal points that were given"
    } else {
        "square pixels and principal points in the middle"
    }
}

/// What else may be done.
fn advice(f: &Findings) -> &'static str {
    if f.without_given_cameras.is_some() {
        "Or are the intrinsics those of other cameras, or of images of another size?"
    } else {
        "Where images are cropped or stretched, or a lens bends strongly, give intrinsics."
    }
}

pub(super) fn no_cameras(f: &Findings) -> String {
    format!(
        "No two cameras with {} have this geometry, it is off by {:.0} %: {LOOK_AT_THEM} {}",
        pixels_and_middle(f),
        100.0 * f.from_cameras,
        advice(f)
    )
}

pub(super) fn contradicted(without: &Gain) -> String {
    format!(
        "The camera matrices that were given contradict what moves: without them {:.1} times as many outline points meet. Are they of these cameras, and of images of this \
         size? Or {LOOK_AT_THEM}",
        without.share
    )
}

pub(super) fn faint(z: f64) -> String {
    format!(
        "{} that the two cameras see the same moving things at the same time: on frames kept \
         aside the geometry stands {:.1} standard deviations above its own score with the clocks shifted, and {MIN_Z:.0} \
         are needed.",
        suggestion(z),
        not_rounded_up(z)
    )
}

pub(super) fn faint_for_trials(z: f64, trials: usize) -> String {
    format!(
        "{} that the two cameras see the same moving things: the best of {trials} time offsets stands \
         {:.1} standard deviations above chance when their number is allowed for, and {MIN_Z:.0} are needed; more \
         motion, or a search among fewer, may do.",
        suggestion(z),
        not_rounded_up(z)
    )
}

pub(super) fn unexplained(explained: f64) -> String {
    format!(
        "Only {:.0} % of the outlines' tangents meet one of the other camera, too few to be the geometry of the scene.",
        100.0 * explained
    )
}

pub(super) fn one_class(tops: bool) -> String {
    let which = if tops { "upper" } else { "lower" };
    format!(
        "The motion leaves the geometry undetermined: the {which} edges of what moves match no better than \
         chance, or next to none of them does, so only part of the geometry is supported."
    )
}

pub(super) fn torn(z_whole: f64) -> String {
    format!(
        "The motion leaves the geometry undetermined: upper and lower edges of what moves match, but hardly ever both of \
         one silhouette those of one other ({:.1} standard deviations above chance), as where only the floor is right.",
        not_rounded_up(z_whole)
    )
}

pub(super) fn few_places(places: usize) -> String {
    format!(
        "The motion leaves the geometry undetermined: whatever moves does so at the same {places} places, and many \
         geometries fit so few."
    )
}

pub(super) fn repeats(repeats: f64) -> String {
    if repeats.is_nan() {
        return unmeasured();
    }
    format!(
        "What moves repeats itself with others in the places ({:.0} % alike), as a column in step or a carousel does; the geometry \
         that takes each for its neighbour explains as much.",
        100.0 * repeats
    )
}

pub(super) fn knocked(holds: f64) -> String {
    if holds.is_nan() {
        return unmeasured();
    }
    format!(
        "The geometry holds in one part of the recording only: in the other {:.0} % of the evidence is left that should be there, \
         as if a camera had been moved in between. Calibrate the parts by themselves.",
        100.0 * holds
    )
}

pub(super) fn halves(apart: f64) -> String {
    if apart.is_nan() {
        return unmeasured();
    }
    format!(
        "The geometry is a compromise: what fits the first half of the recording is {apart:.1} px away from what fits the second, \
         as if a camera had been moved in between. Calibrate the parts by themselves."
    )
}

pub(super) fn flat(plane_residual: f64) -> String {
    if plane_residual.is_nan() {
        return unmeasured();
    }
    format!(
        "The motion leaves the geometry undetermined: most matched points lie within {:.0} % of a silhouette's width of one plane, \
         and outlines that agree no better than these do not say what lies off it.",
        100.0 * plane_residual
    )
}

pub(super) fn turns(may_turn: f64) -> String {
    if may_turn.is_nan() {
        return unmeasured();
    }
    format!(
        "The motion leaves the geometry undetermined: everything keeps to one straight path or one plane, or the \
         cameras stand at one place. Others that turn about that plane, up to {may_turn:.0} px away over the images, explain as \
         much."
    )
}

pub(super) fn unknown_beyond(beyond: f64) -> String {
    format!(
        "The motion leaves the geometry undetermined: it is known where things moved, but in half of an image it \
         may be {beyond:.1} px off or more, because too little of what moves lies off one path or plane."
    )
}

pub(super) fn otherwise(apart: f64) -> String {
    if apart.is_nan() {
        return "No geometry came of the frames that are fitted to, so that none could be tested on those kept aside.".into();
    }
    format!(
        "The geometry of all frames is another, {apart:.1} px away, than that of the fitted ones, which was tested on \
         frames kept aside; more varied motion would tell them apart."
    )
}

pub(super) fn unmeasured() -> String {
    "Too few points of the outlines match to say how accurate the geometry is.".into()
}

pub(super) fn rival(rival: &Rival) -> String {
    format!(
        "A different geometry, {:.0} px away, explains the motion nearly as well ({:.0} % of the evidence); more \
         varied motion would tell them apart.",
        rival.distance,
        100.0 * rival.share
    )
}

pub(super) fn clock_open(seconds: f64, distance: f64) -> String {
    format!(
        "What moves does not tell when the cameras filmed: with the offset changed by {seconds:+.2} s another geometry, {distance:.0} px away, \
         explains as much, as where all moves one way at one speed. Give the offset, or film what moves in different ways."
    )
}

pub(super) fn given_clock_doubted(seconds: f64, distance: f64, gain: f64) -> String {
    format!(
        "What moves speaks against the offset that was given: changed by {seconds:+.2} s another geometry, {distance:.0} px away, explains \
         more, by {gain:.1} standard errors. Have the offset found, or give the true one."
    )
}

pub(super) fn given_clock_believed(seconds: f64, distance: f64) -> String {
    format!(
        " The offset that was given is believed, as what moves does not tell it: changed by {seconds:+.2} s another geometry, {distance:.0} px \
         away, explains as much."
    )
}

pub(super) fn inaccurate(error: f64, limit: f64) -> String {
    if error.is_nan() {
        return unmeasured();
    }
    format!(
        "The expected error of {:.2} px is above the limit of {limit:.2} px.",
        not_rounded_down(error, limit)
    )
}
