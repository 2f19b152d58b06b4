//! Where cameras that moved stand now: all of them solved for at once, with those that did not move held.

use super::clocks::{beside_held, with_offsets_wrong};
use super::one_camera::{Move, deviates, focal_error, freed, pose_error};
use super::stretch::{FRAMES, PARTS};
use super::which_moved::Judged;
use crate::network::evidence::covariance::{Covariance, covariance};
use crate::network::evidence::outlines::{Shapes, outline_errors};
use crate::network::evidence::stated_errors::{Expected, NINE_IN_TEN, length_quantile};
use crate::network::evidence::support::{Deviates, Support};
use crate::network::model::beliefs::Beliefs;
use crate::network::model::camera::{Camera, FOCAL, POSITION, ROTATION};
use crate::network::model::joint::JointProblem;
use crate::network::observations::observed::Observed;
use crate::network::observations::survey::Survey;
use crate::network::result::Place;
use crate::network::solve::relocate::Placed;
use crate::network::solve::settle::settle;
use crate::network::thresholds as limits;

/// The new place of a camera, or why none is given.
pub type Replaced = Result<Place, NoPlace>;

/// Why no new place of a camera is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoPlace {
    /// It did not move.
    Stands,
    /// Another camera moved of which it is not known which.
    OneOfSeveral,
    /// Too few cameras that stand confirm it.
    Unconfirmed,
    /// The camera may have been zoomed instead.
    OrZoomed,
    /// A pair by itself agrees clearly better with another place.
    LeftOver,
}

/// New places of the cameras that moved, by the footage since the last of them did; what was found of them is told by these.
pub fn replaced(
    observed: &[Observed],
    stored: &[Camera],
    judged: &mut Judged,
    beliefs: &[Beliefs],
) -> Vec<Replaced> {
    let n = stored.len();
    if !judged.moved.contains(&true) {
        return vec![Err(NoPlace::Stands); n];
    }
    if judged.rivals.iter().any(|r| !r.is_empty()) {
        return vec![Err(NoPlace::OneOfSeveral); n];
    }
    if judged.moved.iter().filter(|m| !**m).count() < limits::CONFIRMED_PAIRS {
        return vec![Err(NoPlace::Unconfirmed); n];
    }
    let Some(solved) = Resolved::of(observed, judged, beliefs) else {
        return vec![Err(NoPlace::Unconfirmed); n];
    };
    (0..n).map(|c| solved.place(judged, stored, c)).collect()
}

/// All that moved, solved for at once.
struct Resolved<'a> {
    survey: Survey<'a>,
    beliefs: Vec<Beliefs>,
    cameras: Vec<Camera>,
    /// Errors of the moves, and of the places.
    errors: [Covariance; 2],
    pairs: Vec<((usize, usize), Deviates)>,
}

impl<'a> Resolved<'a> {
    fn of(observed: &'a [Observed], judged: &Judged, beliefs: &[Beliefs]) -> Option<Self> {
        let Judged { now, moved, found, .. } = judged;
        let since = last_move(moved, found);
        let survey = Survey::among(observed, FRAMES, |c, seconds| now.cameras[c].time_of(seconds) >= since);
        let beliefs: Vec<Beliefs> = (0..moved.len())
            .map(|c| match found[c].filter(|_| moved[c]) {
                Some(found) => solved_for(&found, &beside_held(beliefs, c)),
                None => beliefs[c],
            })
            .collect();
        let pairs: Vec<(usize, usize)> =
            now.pairs().into_iter().filter(|&(a, b)| moved[a] || moved[b]).collect();
        let settled = settle(&survey, &now.cameras, &beliefs, &pairs, moved, None);
        let problem = JointProblem {
            pairs: &settled.pairs,
            beliefs: &beliefs,
            scale: settled.scale,
            prior_weight: settled.prior_weight,
            moving: moved.clone(),
        };
        let outlines = outline_errors(&settled, Shapes::of(observed));
        let errors = |share: f64| {
            let outlines: Vec<f64> = outlines.iter().map(|error| share * error).collect();
            let scatter = covariance(&problem, &settled.cameras, &outlines)?;
            with_offsets_wrong(scatter, &problem, &settled.cameras, observed)
        };
        let errors = [errors(limits::OUTLINE_MOVED)?, errors(1.0)?];
        let network = Placed { cameras: settled.cameras.clone(), placed: now.placed.clone() };
        let pairs = Support::on(&survey, &network).pairs;
        Some(Self { survey, beliefs, cameras: settled.cameras, errors, pairs })
    }

    /// The place of a camera, where two that stand confirm it and nothing is left over.
    fn place(&self, judged: &mut Judged, stored: &[Camera], c: usize) -> Replaced {
        let moved = judged.moved.clone();
        let Some(m) = judged.found[c].as_mut().filter(|_| moved[c]) else { return Err(NoPlace::Stands) };
        let at = self.cameras[c];
        let seen: Vec<_> = self.pairs.iter().filter(|((a, b), _)| *a == c || *b == c).collect();
        let beside = |(a, b): (usize, usize)| if a == c { b } else { a };
        let confirm = seen.iter().map(|(pair, d)| (beside(*pair), d.tangents));
        let confirmed: Vec<usize> =
            confirm.filter(|(o, d)| !moved[*o] && *d >= limits::PAIR_DEVIATES).map(|(o, _)| o).collect();
        if confirmed.len() < limits::CONFIRMED_PAIRS {
            return Err(NoPlace::Unconfirmed);
        }
        measure(m, &at, &stored[c], &self.errors[0], c);
        if m.or_zoomed {
            return Err(NoPlace::OrZoomed);
        }
        if confirmed.iter().any(|&other| self.leaves_over(c, other)) {
            return Err(NoPlace::LeftOver);
        }
        Ok(Place {
            matrix: at.matrix(),
            rotation: at.rotation.into_inner(),
            translation: at.translation(),
            zoomed: m.zoomed,
            reposed: m.reposed,
            expected: expected(m, &self.errors[1], c),
            pairs: seen.iter().map(|(pair, d)| (beside(*pair), *d)).collect(),
        })
    }

    /// Whether a pair by itself agrees clearly better with another place of its camera than with the one that all pairs agree on.
    fn leaves_over(&self, camera: usize, other: usize) -> bool {
        let pair = [(camera.min(other), camera.max(other))];
        let mut beliefs = self.beliefs.clone();
        beliefs[camera].posed = false;
        let moving: Vec<bool> = (0..beliefs.len()).map(|c| c == camera).collect();
        let alone = settle(&self.survey, &self.cameras, &beliefs, &pair, &moving, None).cameras;
        let parts = self.survey.time_parts(&self.cameras, &pair, PARTS);
        let excess = |cameras: &[Camera]| {
            self.survey.excess_by_part::<PARTS>(cameras, &pair, limits::COMPARED, &parts)
        };
        let (by_itself, agreed) = (excess(&alone), excess(&self.cameras));
        let more: Vec<f64> = by_itself.iter().zip(&agreed).map(|(p, q)| p - q).collect();
        let share = more.iter().sum::<f64>() / by_itself.iter().sum::<f64>().max(1e-9);
        deviates(&more) > limits::MOVED_DEVIATES && share > limits::LEFT_OVER
    }
}

/// The network's time of the last move that was seen; before all footage where none was.
fn last_move(moved: &[bool], found: &[Option<Move>]) -> f64 {
    let of = |(m, moved): (&Option<Move>, &bool)| m.filter(|m| *moved && m.is_within()).map(|m| m.since);
    found.iter().zip(moved).filter_map(of).fold(f64::NEG_INFINITY, f64::max)
}

/// What changed of a camera is free.
fn solved_for(found: &Move, beliefs: &Beliefs) -> Beliefs {
    Beliefs { posed: !found.reposed, ..if found.zoomed { freed(beliefs) } else { *beliefs } }
}

/// How far it moved, by the place that all that moved agree on.
fn measure(found: &mut Move, at: &Camera, stored: &Camera, errors: &Covariance, camera: usize) {
    let error = |from: usize| pose_error(errors, camera, from);
    if let (Some(turned_error), Some(shifted_error)) = (error(ROTATION), error(POSITION)) {
        found.turned = stored.rotation.angle_to(&at.rotation);
        found.shifted = (stored.position - at.position).norm();
        (found.turned_error, found.shifted_error) = (turned_error, shifted_error);
    }
    if let Some(error) = focal_error(errors, camera) {
        (found.focal, found.focal_error) = (at.log_focal - stored.log_focal, error.max(found.focal_error));
    }
}

/// Errors to expect of what was solved for, with all that did not move where it stands; 0 of what was not.
fn expected(found: &Move, errors: &Covariance, camera: usize) -> Expected {
    let block = |from: usize| errors.block(camera, from).unwrap_or_default();
    let at = errors.row(camera, FOCAL).filter(|_| found.zoomed);
    let focal = |p: usize| NINE_IN_TEN * errors.matrix[(p, p)].max(0.0).sqrt();
    // What is said of the change is of two focal lengths that are about as well known.
    let of_change = found.focal_error / std::f64::consts::SQRT_2;
    let focal = at.map_or(0.0, |p| focal(p).max(of_change));
    Expected::of_position(focal, length_quantile(&block(ROTATION)), block(POSITION))
}
