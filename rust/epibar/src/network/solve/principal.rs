//! How far principal points are from the middle of their images.
//!
//! A principal point off the middle and a turn of the camera look nearly the same, so how far off it may be is a belief of its own: a
//! standard deviation, one for all cameras. What the tangents say of it is the evidence of each, with what the cameras may be
//! otherwise integrated out ([`laplace`]). Where the tangents say nothing of principal points no belief is preferred.

use super::networks::Solved;
use crate::network::given::input::{AS_SOLD, PRINCIPAL_LEVELS, PRINCIPAL_SHARES};
use crate::network::model::beliefs::Beliefs;
use crate::network::model::camera::Camera;
use crate::network::model::laplace;
use crate::network::thresholds as limits;

/// Steps of the solver at a level.
const STEPS: usize = 25;

/// Beliefs with principal points that are believed to be about the middle as far from it as this, in widths.
pub fn at_level(beliefs: &[Beliefs], cameras: &[Camera], level: f64) -> Vec<Beliefs> {
    let mut beliefs = beliefs.to_vec();
    for (belief, camera) in beliefs.iter_mut().zip(cameras) {
        if belief.centred {
            for k in 2..4 {
                belief.intrinsic[k].deviation = level * camera.size.width as f64;
            }
        }
    }
    beliefs
}

/// How likely each of [`PRINCIPAL_LEVELS`] is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Likely([f64; PRINCIPAL_LEVELS.len()]);

impl Likely {
    /// From the evidence of each, nats against it; none is, where that of any is not known.
    fn by(nats: [f64; PRINCIPAL_LEVELS.len()]) -> Self {
        let least = nats.into_iter().fold(f64::INFINITY, f64::min);
        Self(std::array::from_fn(|k| PRINCIPAL_SHARES[k] * (least - nats[k]).exp())).of_one()
    }

    fn of_one(self) -> Self {
        let sum: f64 = self.0.iter().sum();
        Self(self.0.map(|share| share / sum))
    }

    /// Without levels below that of cameras as they are sold.
    pub fn not_below_sold(self) -> Self {
        let mut shares = self.0;
        shares[..AS_SOLD].fill(0.0);
        // Those that are left may all be too unlikely to be told from nothing.
        if shares.iter().sum::<f64>() == 0.0 { Self::only(AS_SOLD) } else { Self(shares).of_one() }
    }

    /// One of the levels alone.
    pub const fn only(level: usize) -> Self {
        let mut shares = [0.0; PRINCIPAL_LEVELS.len()];
        shares[level] = 1.0;
        Self(shares)
    }

    /// The level that is most likely; that of cameras as they are sold, where it is not known.
    pub fn level(&self) -> f64 {
        let known = (0..self.0.len()).filter(|&k| self.0[k].is_finite());
        PRINCIPAL_LEVELS[known.max_by(|&k, &l| self.0[k].total_cmp(&self.0[l])).unwrap_or(AS_SOLD)]
    }

    /// Levels that count, and by how much.
    pub fn levels(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let likely = PRINCIPAL_LEVELS.into_iter().zip(self.0);
        likely.filter(|(_, share)| *share >= limits::PRINCIPAL_LEAST_LIKELY)
    }
}

/// The cost at the optimum with other beliefs, nats.
fn cost(solved: &Solved, beliefs: &[Beliefs]) -> f64 {
    solved.problem(beliefs).solve(&solved.network.cameras, STEPS).1 / solved.settled.prior_weight
}

/// What speaks against some beliefs, nats.
fn against(solved: &Solved, beliefs: &[Beliefs]) -> f64 {
    let problem = solved.problem(beliefs);
    laplace::against(&problem, &problem.solve(&solved.network.cameras, STEPS).0)
}

/// How far principal points may be from the middle, as the tangents of a network say.
pub fn likely(solved: &Solved) -> Likely {
    let stand = solved.network.placed.iter();
    if !solved.beliefs.iter().zip(stand).any(|(belief, stands)| belief.centred && *stands) {
        return Likely::only(AS_SOLD);
    }
    let of_level = |level: f64| against(solved, &at_level(&solved.beliefs, &solved.network.cameras, level));
    Likely::by(PRINCIPAL_LEVELS.map(of_level))
}

/// Whether the tangents would pay more than a wider belief costs by itself for principal points, those that are given among them,
/// elsewhere than they are believed to be; also where that is not known.
pub fn is_strained(solved: &Solved) -> bool {
    let cameras = &solved.network.cameras;
    let believed = at_level(&solved.beliefs, cameras, PRINCIPAL_LEVELS[AS_SOLD]);
    let mut free = believed.clone();
    let mut by_itself = 0.0;
    for (c, belief) in free.iter_mut().enumerate().filter(|(c, b)| solved.network.placed[*c] && !b.posed) {
        let width = cameras[c].size.width as f64;
        for k in 2..4 {
            let deviation = &mut belief.intrinsic[k].deviation;
            let before = if *deviation > 0.0 { *deviation } else { PRINCIPAL_LEVELS[AS_SOLD] * width };
            *deviation = limits::PRINCIPAL_STRAINED * width;
            by_itself += (*deviation / before).ln();
        }
    }
    let strain = cost(solved, &believed) - cost(solved, &free) - by_itself - limits::PRINCIPAL_NATS;
    strain > 0.0 || strain.is_nan()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::given::input::Knowledge;
    use crate::network::model::beliefs::Belief;
    use crate::network::solve::relocate::Placed;
    use crate::network::solve::settle::tests::seen;
    use crate::recording::{Recording, RecordingParts};

    /// Four cameras of which nothing is known but the lens, with principal points so many pixels right of the middle.
    fn solved(aside: [f64; 4]) -> Solved {
        let mut settled = seen([0.1; 4]);
        for p in &mut settled.pairs {
            for m in &mut p.meetings {
                m.a[0] += aside[p.a];
                m.b[0] += aside[p.b];
            }
        }
        settled.scale = 0.2;
        settled.prior_weight = 0.1;
        let mut parts = RecordingParts::new([640, 480], vec![0.0]);
        parts.heat = vec![0; 640 * 480];
        let recording = Recording::try_from(parts).unwrap();
        let (_, mut one) = Knowledge::new().distortions([0.0; 5]).beliefs(&recording);
        one.clock = [Belief::fixed(0.0); 2];
        let beliefs = vec![one; 4];
        let network = Placed { cameras: settled.cameras.clone(), placed: vec![true; 4] };
        Solved { network, settled, beliefs, excess: 1.0 }
    }

    #[test]
    fn what_tangents_call_for_is_how_far_principal_points_are() {
        let centred = likely(&solved([0.0; 4]));
        assert!(centred.level() <= PRINCIPAL_LEVELS[AS_SOLD], "{centred:?}");
        let aside = likely(&solved([9.0, -7.0, 11.0, -8.0]));
        assert_eq!(aside.level(), 0.012, "{aside:?}");
        let far = likely(&solved([60.0, -50.0, 40.0, -70.0]));
        assert!(far.level() >= 0.04, "{far:?}");
    }

    #[test]
    fn where_tangents_say_nothing_no_belief_is_preferred() {
        let mut nothing = solved([0.0; 4]);
        nothing.settled.prior_weight = 1e6;
        let Likely(shares) = likely(&nothing);
        for (share, before) in shares.iter().zip(PRINCIPAL_SHARES) {
            assert!((share / before - 1.0).abs() < 0.2, "{shares:?}");
        }
    }

    #[test]
    fn what_is_given_is_not_asked_for() {
        let mut given = solved([60.0, -50.0, 40.0, -70.0]);
        for belief in &mut given.beliefs {
            belief.centred = false;
            belief.intrinsic[2].deviation = 0.0;
            belief.intrinsic[3].deviation = 0.0;
        }
        assert_eq!(likely(&given), Likely::only(AS_SOLD));
        assert_eq!(at_level(&given.beliefs, &given.network.cameras, 0.12), given.beliefs);
        assert!(is_strained(&given) && !is_strained(&solved([0.0; 4])));
    }

    #[test]
    fn cameras_that_do_not_stand_or_are_held_say_nothing() {
        let four = solved([3.0, -2.0, 4.0, -3.0]);
        let without = |change: fn(&mut Solved)| {
            let mut three = four.clone();
            three.network.placed[3] = false;
            three.settled.pairs.retain(|p| p.b != 3);
            change(&mut three);
            (likely(&three), is_strained(&three))
        };
        let far = |three: &mut Solved| three.network.cameras[3].principal[0] += 100.0;
        assert_eq!(without(far), without(|_| ()));
        // A camera that is held has a principal point, and no belief in it.
        let mut held = solved([0.0; 4]);
        for belief in &mut held.beliefs[..3] {
            *belief = Beliefs { intrinsic: [Belief::fixed(0.0); 7], centred: false, posed: true, ..*belief };
        }
        assert!(!is_strained(&held));
        for p in &mut held.settled.pairs {
            p.meetings.iter_mut().filter(|_| p.b == 3).for_each(|m| m.b[0] += 60.0);
        }
        assert!(is_strained(&held));
    }

    #[test]
    fn levels_share_what_is_likely() {
        let even = Likely::by([3.0; 5]);
        assert!(even.0.iter().zip(PRINCIPAL_SHARES).all(|(p, q)| (p - q).abs() < 1e-12));
        let unknown = Likely::by([f64::NAN, 3.0, 3.0, f64::NAN, f64::INFINITY]);
        assert_eq!(unknown.levels().count() + unknown.not_below_sold().levels().count(), 0);
        assert_eq!(Likely::by([900.0, 3.0, 3.0, 900.0, f64::INFINITY]).levels().count(), 2);
        let sold = Likely::by([0.0, 2.0, 2.0, 900.0, 900.0]);
        assert_eq!((sold.level(), sold.not_below_sold().level()), (0.001, 0.004));
        assert!((sold.not_below_sold().levels().map(|(_, share)| share).sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(Likely::by([0.0, 900.0, 900.0, 900.0, 900.0]).not_below_sold().level(), 0.004);
    }
}
