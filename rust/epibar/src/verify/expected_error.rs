//! How far off a geometry may be: what points scatter, what no number of points averages out, and what other geometries ask for.

use super::case::Case;
use super::covariance::{covariance, covariance_alike, with_prior};
use super::error_map::Uncertainty;
use super::evidence::Evidence;
use super::planarity::median_width;
use super::rivals::{Rival, Winner};
use super::thresholds::{
    CLEAN_RADIUS, COARSE_SHARE, FIT_FACTOR, GRID_ERROR, LEAST_EXPLAINED, NEIGHBOUR, NEIGHBOUR_SHARE,
    ROUGH_DEVIATION, STANDS_IN, larger, reaches, within,
};
use crate::frontier::matches::robust_deviation;
use crate::frontier::{TangentMatch, Views, tangent_matches};
use crate::geometry::SevenParameters;
use crate::geometry::seven_parameters::Information;
use crate::refine::essential::EssentialPrior;
use crate::refine::loss_scale;

/// How far off geometries are that some of the evidence asks for, pixels over the volume where things moved.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Away {
    /// What either half of the recording asks for, the farther of the two.
    pub by_halves: f64,
    /// What turns about the plane of most points, and loses nothing by it.
    pub by_turning: f64,
}

/// What is stated of a geometry's errors.
pub(super) struct Stated {
    /// All that is known of it.
    pub uncertainty: Uncertainty,
    /// Half of an image is known no worse than this by the covariance alone, pixels.
    pub beyond_motion: f64,
}

impl Stated {
    /// Of the winner; `matches` are its tangents that meet. `None` where they do not determine it.
    pub fn new(
        case: &Case,
        winner: &Winner,
        matches: &[TangentMatch],
        rivals: &[Rival],
        evidence: &Evidence,
        away: Away,
    ) -> Option<Self> {
        let views = case.views;
        let scale = views.pixel_scale();
        // A geometry that fewer frames gave is as likely to be the truth as a rival that is not behind.
        let others = undecided(rivals).chain(neighbours(rivals, scale));
        let of_others = others.fold(evidence.tested_distance.max(0.0).max(away.by_halves), f64::max);
        let stand_in = of_stand_ins(case);
        let systematic = of_others.hypot(of_outlines(matches, winner.radius, scale, stand_in));
        // What outlines are off alike is what lets a geometry turn: one error, seen twice.
        let systematic = larger(systematic, away.by_turning);
        let fitted = tangent_matches(views, &winner.fundamental, winner.radius);
        of_matches(views, winner, &fitted, beyond_chance(evidence), case.block(), systematic)
    }
}

/// `None` where the tangents that it was fitted to do not determine the geometry.
fn of_matches(
    views: &Views,
    winner: &Winner,
    matches: &[TangentMatch],
    beyond_chance: f64,
    block: usize,
    systematic: f64,
) -> Option<Stated> {
    let at = SevenParameters::new(&winner.fundamental, views.sizes())?;
    let loss = loss_scale(winner.radius);
    let of_points = covariance(&at, matches, loss, block)?;
    let with_cameras = |of_points: Information| match &views.cameras {
        Some(cameras) => with_prior(&of_points, &EssentialPrior(cameras).information(&at)),
        None => Some(of_points),
    };
    let (alone, none) = (with_cameras(of_points)?, Information::zeros());
    let taken_for_true = Uncertainty { at: at.clone(), covariance: alone, alike: none, systematic: 0.0 };
    // What meets by chance would meet under a neighbour as well: it says nothing, and is weighed as if it did.
    let diluted = with_cameras(of_points / beyond_chance.powi(2))?;
    let alike = with_cameras(covariance_alike(&at, matches, loss, robust_deviation(matches))?)?;
    let uncertainty = Uncertainty { at, covariance: diluted * FIT_FACTOR * FIT_FACTOR, alike, systematic };
    Some(Stated { uncertainty, beyond_motion: taken_for_true.beyond_motion() })
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
pub(super) fn beyond_chance(evidence: &Evidence) -> f64 {
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
    let width = 0.5 * (median_width(&case.views.a) + median_width(&case.views.b));
    if case.masks { 0.0 } else { STANDS_IN * width }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Fundamental;
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
