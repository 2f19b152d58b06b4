//! How far principal points are from the middle of their images.
//!
//! A principal point off the middle and a turn of the camera look nearly the same, so it is believed to be near the middle
//! unless the tangents say otherwise: images that were cropped, or cameras that were once calibrated so. What they say is
//! the cost at the optimum with wider beliefs, in units in which a standard deviation of a belief costs ½: a Laplace
//! approximation of the evidence (`MacKay` 1992) whose volume terms are bounded by `ln` of the ratio of the widths.

use super::networks::Solved;
use crate::network::given::input::PRINCIPAL_LEVELS;
use crate::network::model::joint::Beliefs;
use crate::network::thresholds as limits;

/// Steps of the solver at a level.
const STEPS: usize = 25;

/// Beliefs with those of principal points that are not given at another level, or wider where they are.
pub fn at_level(beliefs: &[Beliefs], widths: &[f64], level: f64) -> Vec<Beliefs> {
    let mut beliefs = beliefs.to_vec();
    for (belief, width) in beliefs.iter_mut().zip(widths) {
        for k in 2..4 {
            if belief.intrinsic[k].deviation > 0.0 {
                belief.intrinsic[k].deviation = belief.intrinsic[k].deviation.max(level * width);
            }
        }
    }
    beliefs
}

/// What the tangents of a network say of principal points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Call {
    /// The level that they call for.
    pub level: f64,
    /// How many nats more than a wider belief costs by itself they would pay for principal points, those that are given
    /// among them, elsewhere than they are believed to be.
    pub strain: f64,
}

/// The cost at the optimum with other beliefs, in nats.
fn cost(solved: &Solved, beliefs: &[Beliefs]) -> f64 {
    solved.problem(beliefs).solve(&solved.network.cameras, STEPS).1 / solved.settled.prior_weight
}

/// What the tangents of a network call for.
pub fn call(solved: &Solved) -> Call {
    let cameras = &solved.network.cameras;
    let widths: Vec<f64> = cameras.iter().map(|c| c.size.width as f64).collect();
    let stand = solved.network.placed.iter().filter(|p| **p).count() as f64;
    let of_level = |level: f64| cost(solved, &at_level(&solved.beliefs, &widths, level));
    let start = of_level(PRINCIPAL_LEVELS[0]);
    let mut called = Call { level: PRINCIPAL_LEVELS[0], strain: f64::NEG_INFINITY };
    let mut now = start;
    for level in PRINCIPAL_LEVELS.into_iter().skip(1) {
        let wider = of_level(level);
        if now - wider > 2.0 * stand * (level / called.level).ln() + limits::PRINCIPAL_NATS {
            (called.level, now) = (level, wider);
        }
    }
    let free: Vec<Beliefs> = solved
        .beliefs
        .iter()
        .zip(&widths)
        .map(|(b, width)| {
            let mut b = *b;
            for k in 2..4 {
                b.intrinsic[k].deviation = limits::PRINCIPAL_STRAINED * width;
            }
            b
        })
        .collect();
    called.strain = start
        - cost(solved, &free)
        - 2.0 * stand * (limits::PRINCIPAL_STRAINED / PRINCIPAL_LEVELS[0]).ln()
        - limits::PRINCIPAL_NATS;
    called
}
