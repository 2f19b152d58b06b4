//! From the geometries of pairs to networks: starts, tangents found anew, cameras tried elsewhere.

use super::collapse::collapsed;
use super::relocate::{Placed, relocate};
use super::settle::{Settled, settle};
use super::start::{Started, Starter};
use crate::network::given::pair::PairHypotheses;
use crate::network::model::beliefs::Beliefs;
use crate::network::model::camera::Camera;
use crate::network::model::joint::JointProblem;
use crate::network::observations::observed::Observed;
use crate::network::observations::survey::{Survey, shared};
use crate::network::thresholds as limits;

/// Frames of each camera that are looked at while cameras are tried elsewhere, and until a network stands; of many cameras fewer.
pub const FRAMES: [usize; 2] = [80, 240];
/// Frames of each camera that are looked at in the end; of many cameras fewer.
pub const FRAMES_IN_THE_END: usize = 900;
/// Rounds of trying cameras elsewhere.
const ROUNDS: usize = 3;
/// A network with less than this share of the evidence of another is not worth improving.
const PROMISING: f64 = 0.5;
/// Cameras that are turned by less than this against each other, radians, stand alike: 1°.
const ALIKE: f64 = std::f64::consts::PI / 180.0;
/// Parts of the recording by which evidence is compared.
const PARTS: usize = 24;

/// A network with its last tangents.
#[derive(Debug, Clone)]
pub struct Solved {
    /// The cameras, and which of them stand.
    pub network: Placed,
    /// What met, and the weights of the last round.
    pub settled: Settled,
    /// What was believed of the cameras.
    pub beliefs: Vec<Beliefs>,
    /// Excess over chance on the frames that networks are compared on.
    pub excess: f64,
}

impl Solved {
    /// The joint problem over what met, with what is believed.
    pub fn problem<'p>(&'p self, beliefs: &'p [Beliefs]) -> JointProblem<'p> {
        JointProblem {
            pairs: &self.settled.pairs,
            beliefs,
            scale: self.settled.scale,
            prior_weight: self.settled.prior_weight,
            moving: self.network.placed.clone(),
        }
    }
}

/// What every network of some cameras is solved with.
pub struct Solver<'a> {
    few: Survey<'a>,
    /// Frames on which networks are compared.
    pub some: Survey<'a>,
    pairs: &'a [PairHypotheses],
}

impl<'a> Solver<'a> {
    /// With the silhouettes of all cameras, and what pairs brought.
    pub fn new(observed: &'a [Observed], pairs: &'a [PairHypotheses]) -> Self {
        let [few, some] = FRAMES.map(|frames| Survey::new(observed, shared(frames, observed.len())));
        Self { few, some, pairs }
    }

    /// Networks from pairs, most evidence first: the best one, and its rivals.
    pub fn networks(&self, cameras: &[Camera], beliefs: &[Beliefs]) -> Vec<Solved> {
        let starts = Starter::new(cameras, beliefs, self.pairs).networks();
        let settled = |start: Started| {
            let placed = Placed { cameras: start.cameras, placed: start.placed };
            self.settled(placed, beliefs, None)
        };
        let mut found: Vec<Solved> = starts.into_iter().map(settled).collect();
        let by_excess = |p: &Solved, q: &Solved| q.excess.total_cmp(&p.excess);
        found.sort_by(by_excess);
        let mut improved: Vec<Solved> = Vec::new();
        for network in found {
            let idle = improved.iter().any(|better| {
                network.excess < PROMISING * better.excess || is_part_of(&network.network, &better.network)
            });
            if !idle {
                improved.push(self.improved(network));
            }
        }
        improved.sort_by(by_excess);
        improved
    }

    /// A network with its tangents found anew, from a radius down to the one that suits the masks.
    pub fn settled(&self, network: Placed, beliefs: &[Beliefs], from: Option<f64>) -> Solved {
        let pairs = network.pairs();
        let mut solved = settled(&self.some, network, beliefs, &pairs, from);
        let empty = collapsed(&solved.settled);
        solved.excess = excess(&self.some, &solved.network, &empty);
        solved
    }

    /// Cameras tried elsewhere, and the whole solved for again, while that helps.
    fn improved(&self, mut now: Solved) -> Solved {
        for _ in 0..ROUNDS {
            let before = now.network.clone();
            let moved = relocate(&self.few, before.clone(), &now.beliefs, self.pairs);
            if moved.cameras == before.cameras {
                break;
            }
            let next = self.settled(moved, &now.beliefs, None);
            if next.excess <= now.excess {
                break;
            }
            now = next;
        }
        now
    }
}

/// A network with the tangents of some pairs found anew on the frames of a survey; of its evidence nothing is said.
pub fn settled(
    survey: &Survey,
    network: Placed,
    beliefs: &[Beliefs],
    pairs: &[(usize, usize)],
    from: Option<f64>,
) -> Solved {
    let settled = settle(survey, &network.cameras, beliefs, pairs, &network.placed, from);
    let network = Placed { cameras: settled.cameras.clone(), placed: network.placed };
    Solved { network, settled, beliefs: beliefs.to_vec(), excess: f64::NAN }
}

/// Whether all cameras that stand in one network do so in another, and look the same ways.
fn is_part_of(one: &Placed, other: &Placed) -> bool {
    one.placed.iter().zip(&other.placed).all(|(p, q)| !p || *q) && one.turns(other).all(|turn| turn < ALIKE)
}

/// Excess over chance of a network, less that of shifted clocks, but for pairs that say nothing.
fn excess(survey: &Survey, network: &Placed, empty: &[(usize, usize)]) -> f64 {
    let pairs: Vec<(usize, usize)> = network.pairs().into_iter().filter(|p| !empty.contains(p)).collect();
    survey.scores(&network.cameras, &pairs, limits::COMPARED, 3).iter().map(|s| s.excess).sum()
}

/// By which share of the evidence of some pairs a network is better than another, and by how many standard deviations over parts
/// of the recording.
pub fn gain(survey: &Survey, pairs: &[(usize, usize)], than: &Placed, network: &Placed) -> (f64, f64) {
    let parts = survey.time_parts(&than.cameras, pairs, PARTS);
    let of =
        |network: &Placed| survey.excess_by_part::<PARTS>(&network.cameras, pairs, limits::COMPARED, &parts);
    let (one, other) = (of(than), of(network));
    let differences: Vec<f64> = one.iter().zip(&other).map(|(p, q)| q - p).collect();
    let mean = differences.iter().sum::<f64>() / PARTS as f64;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (PARTS - 1) as f64;
    let total: f64 = one.iter().sum();
    (mean * PARTS as f64 / total.abs().max(1e-9), mean / (variance / PARTS as f64).sqrt().max(1e-9))
}
