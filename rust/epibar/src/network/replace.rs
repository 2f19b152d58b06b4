//! Where cameras that moved stand now: all of them solved for at once, with those that did not move held.

use super::camera::{Camera, POSITION, ROTATION};
use super::covariance::{Covariance, Expected, NINE_IN_TEN, covariance, length_quantile};
use super::join::outline_error;
use super::joint::{Beliefs, Problem};
use super::moves::{FOCAL, FRAMES, LATER, Move, focal_error, freed};
use super::observed::Observed;
use super::relocate::Placed;
use super::result::Place;
use super::settle::settle;
use super::support::Support;
use super::survey::Survey;
use super::thresholds as limits;

/// New places of the cameras that moved, by the footage since the last of them did; what was found of them is told by these.
/// `None` of a camera that did not move, or whose place too few cameras that stand confirm: two give its distance.
pub fn replaced(
    observed: &[Observed],
    now: &Placed,
    stored: &[Camera],
    moved: &[bool],
    found: &mut [Option<Move>],
    beliefs: &[Beliefs],
) -> Vec<Option<Place>> {
    let n = stored.len();
    if !moved.contains(&true) || moved.iter().filter(|m| !**m).count() < limits::CONFIRMED_PAIRS {
        return vec![None; n];
    }
    let since = last_move(observed, now, moved, found);
    let survey = Survey::among(observed, FRAMES, |c, seconds| now.cameras[c].time_of(seconds) >= since);
    let beliefs: Vec<Beliefs> = (0..n)
        .map(|c| found[c].filter(|_| moved[c]).map_or(beliefs[c], |m| solved_for(&m, &beliefs[c])))
        .collect();
    let pairs: Vec<(usize, usize)> = now.pairs().into_iter().filter(|&(a, b)| moved[a] || moved[b]).collect();
    let settled = settle(&survey, &now.cameras, &beliefs, &pairs, moved, None);
    let problem = Problem {
        pairs: &settled.pairs,
        beliefs: &beliefs,
        scale: settled.scale,
        prior_weight: settled.prior_weight,
        moving: moved.to_vec(),
    };
    let errors = |outlines: f64| covariance(&problem, &settled.cameras, outlines);
    let (Some(of_move), Some(of_place)) = (errors(0.0), errors(outline_error(settled.scale, false))) else {
        return vec![None; n];
    };
    let support =
        Support::on(&survey, &Placed { cameras: settled.cameras.clone(), placed: now.placed.clone() });
    (0..n)
        .map(|c| {
            let m = found[c].as_mut().filter(|_| moved[c])?;
            let at = settled.cameras[c];
            let seen: Vec<_> = support.pairs.iter().filter(|((a, b), _)| *a == c || *b == c).collect();
            let beside = |(a, b): (usize, usize)| if a == c { b } else { a };
            let confirmed = seen
                .iter()
                .filter(|(pair, d)| !moved[beside(*pair)] && d.tangents >= limits::PAIR_DEVIATES)
                .count();
            if confirmed < limits::CONFIRMED_PAIRS {
                return None;
            }
            told(m, &at, &stored[c], &of_move, c);
            Some(Place {
                matrix: at.matrix(),
                rotation: at.rotation.into_inner(),
                translation: at.translation(),
                zoomed: m.zoomed,
                reposed: m.reposed,
                expected: expected(m, &of_place, c),
                pairs: seen.iter().map(|(pair, d)| (beside(*pair), *d)).collect(),
            })
        })
        .collect()
}

/// The network's time of the last move that was seen; before all footage where none was.
fn last_move(observed: &[Observed], now: &Placed, moved: &[bool], found: &[Option<Move>]) -> f64 {
    let of = |c: usize| {
        let m = found[c].filter(|m| moved[c] && m.since > LATER)?;
        Some(now.cameras[c].time_of(m.since * observed[c].times.last()?))
    };
    (0..moved.len()).filter_map(of).fold(f64::NEG_INFINITY, f64::max)
}

/// What changed of a camera is free.
fn solved_for(found: &Move, beliefs: &Beliefs) -> Beliefs {
    Beliefs { posed: !found.reposed, ..if found.zoomed { freed(beliefs) } else { *beliefs } }
}

/// The move by the place that all that moved agree on.
fn told(found: &mut Move, at: &Camera, stored: &Camera, errors: &Covariance, camera: usize) {
    let error = |from: usize| errors.block(camera, from).map(|block| length_quantile(&(block * 2.0)));
    if let (Some(turned_error), Some(shifted_error)) = (error(ROTATION), error(POSITION)) {
        found.turned = stored.rotation.angle_to(&at.rotation);
        found.shifted = (stored.position - at.position).norm();
        (found.turned_error, found.shifted_error) = (turned_error, shifted_error);
    }
    if let Some(error) = focal_error(errors, camera) {
        (found.focal, found.focal_error) = (at.log_focal - stored.log_focal, error);
    }
}

/// Errors to expect of what was solved for, with all that did not move where it stands; 0 of what was not.
fn expected(found: &Move, errors: &Covariance, camera: usize) -> Expected {
    let block = |from: usize| errors.block(camera, from).map_or(0.0, |block| length_quantile(&block));
    let focal = errors.active.iter().position(|p| *p == (camera, FOCAL));
    Expected {
        focal: focal
            .filter(|_| found.zoomed)
            .map_or(0.0, |p| NINE_IN_TEN * errors.matrix[(p, p)].max(0.0).sqrt()),
        rotation: block(ROTATION),
        position: block(POSITION),
    }
}
