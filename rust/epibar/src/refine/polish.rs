//! Refinement while the radius shrinks: tangents are found anew between rounds of least squares.

use super::essential::{EssentialPrior, WithPrior};
use super::least_squares::minimise;
use super::sampson::SampsonProblem;
use crate::frontier::matches::robust_deviation;
use crate::frontier::{TangentMatch, Views, symmetric_score, tangent_matches};
use crate::geometry::{Fundamental, SevenParameters};

/// Steps between two searches for tangents, which move the optimum by more than the last steps would.
const ITERATIONS: usize = 5;
/// Matches of neighbouring frames and of one outline say the same: so many count as one independent measurement.
const DEPENDENT: f64 = 100.0;
/// Fewest tangents that meet of which seven parameters are fitted.
const FEWEST: usize = 12;
/// Deviation that is not believed to be smaller, pixels.
const LEAST_DEVIATION: f64 = 0.25;

/// What a standard deviation of a prior is worth, in the unit of the cost of the matches.
pub(super) fn prior_weight(matches: &[TangentMatch]) -> f64 {
    let surprise = matches.iter().map(|p| p.surprise).sum::<f64>() / matches.len() as f64;
    DEPENDENT * surprise * robust_deviation(matches).max(LEAST_DEVIATION).powi(2)
}

/// Scale of the Cauchy loss for tangents that meet within a radius, pixels.
pub fn loss_scale(radius: f64) -> f64 {
    0.35 * radius
}

/// Refines `f` while the radius shrinks; each radius, in pixels, is used `repeats` times. `None` where too few
/// tangents meet.
pub fn refine(views: &Views, f: &Fundamental, radii: &[f64], repeats: usize) -> Option<Fundamental> {
    let mut current = *f;
    for &radius in radii {
        for _ in 0..repeats {
            let matches = tangent_matches(views, &current, radius);
            if matches.len() < FEWEST {
                return None;
            }
            let start = SevenParameters::new(&current, views.sizes())?;
            let points = SampsonProblem::new(&matches, loss_scale(radius));
            let prior = views.cameras.as_ref().map(|k| (EssentialPrior(k), prior_weight(&matches)));
            current = minimise(&WithPrior { points: &points, prior }, start, ITERATIONS).0.fundamental()?;
        }
    }
    Some(current)
}

/// Refines down to the radius that suits the masks.
pub fn polish(views: &Views, f: &Fundamental) -> Fundamental {
    let radius = symmetric_score(views, f).radius;
    let halved = |k: i32| radius * 2f64.powi(k);
    let first = refine(views, f, &[halved(1), radius], 2).unwrap_or(*f);
    // Closer in where that is where the score now is highest.
    let radius = symmetric_score(views, &first).radius;
    refine(views, &first, &[radius], 5).unwrap_or(first)
}

/// Ends on `views` what has been polished on most of their frames.
pub fn touch_up(views: &Views, f: &Fundamental) -> Fundamental {
    let radius = symmetric_score(views, f).radius;
    refine(views, f, &[radius], 3).unwrap_or(*f)
}
