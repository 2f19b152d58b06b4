//! How far `F` may be uncertain beyond what moved: the less depth the motion has, the less is allowed, as the less holds it there.

use super::findings::Findings;
use super::thresholds::{
    DEEP_POSSIBLE, DEPTH, FLAT, FLAT_BEYOND, FLAT_POSSIBLE, FLAT_TURN, MAX_BEYOND, MAX_TURN, ROOM_AREA,
    ROOM_HEIGHT, SHALLOW_POSSIBLE, SOME_AREA, SOME_AREA_POSSIBLE, reaches,
};

/// Little leaves the plane, as far as is known.
pub fn is_flat(f: &Findings) -> bool {
    !reaches(f.evidence.plane_residual, FLAT)
}

/// Not much leaves the plane, as far as is known: flat motion is that as well.
fn is_shallow(f: &Findings) -> bool {
    !reaches(f.evidence.plane_residual, DEPTH)
}

/// A limit for motion with depth, pixels: on small images no less than what is allowed where things moved, as outlines are of whole pixels.
fn with_depth(f: &Findings, most: f64) -> f64 {
    most.max(f.max_expected_error)
}

/// What moves fills a room, so that it does not matter how `F` goes on beyond it.
fn fills_a_room(f: &Findings) -> bool {
    reaches(f.evidence.spread_of_bottoms, ROOM_AREA) && reaches(f.evidence.tops_off_floor, ROOM_HEIGHT)
}

/// How far `F` may turn about a plane, pixels.
pub fn most_turned(f: &Findings) -> f64 {
    let most = f.scale * if is_flat(f) { FLAT_TURN } else { MAX_TURN };
    if fills_a_room(f) {
        f64::INFINITY
    } else if is_shallow(f) {
        most
    } else {
        with_depth(f, most)
    }
}

/// The largest expected error beyond the motion, pixels.
pub fn most_beyond(f: &Findings) -> f64 {
    let strictly = is_flat(f) && !fills_a_room(f);
    f.scale * if strictly { FLAT_BEYOND } else { MAX_BEYOND }
}

/// The largest error that is possible beyond the motion, pixels.
pub fn most_possible(f: &Findings) -> f64 {
    if fills_a_room(f) {
        f64::INFINITY
    } else if is_flat(f) && reaches(f.evidence.spread_of_bottoms, SOME_AREA) {
        SOME_AREA_POSSIBLE * f.scale
    } else if is_flat(f) {
        FLAT_POSSIBLE * f.scale
    } else if is_shallow(f) {
        SHALLOW_POSSIBLE * f.scale
    } else {
        with_depth(f, DEEP_POSSIBLE * f.scale)
    }
}
