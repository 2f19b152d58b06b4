//! Where the joint problem starts: from the geometries of pairs, with focal lengths guessed.
//!
//! With a guess of both focal lengths `F` is an essential matrix, near enough, and gives a relative pose. Three cameras
//! are checked against one another first: a wrong pair that is consistent with itself would put a whole network metres off.
//! From the best three the network grows camera by camera, each placed by its pairs with those that stand, and each step is
//! followed by the joint problem over the tangents that the pairs brought along.

use nalgebra::{Rotation3, Vector3};
use rayon::prelude::*;

use crate::network::given::pair::PairHypotheses;
use crate::network::model::beliefs::Beliefs;
use crate::network::model::camera::Camera;
use crate::network::model::joint::{JointProblem, PairMeetings, standing};
use crate::network::model::pose::{placed_beside, relative_pose};
use crate::network::model::residual::{CameraPair, Meeting};
use crate::network::observations::evenly::evenly;
use crate::network::thresholds as limits;

/// A network of some of the cameras.
#[derive(Debug, Clone)]
pub struct Started {
    /// All cameras; those that do not stand are as they were given.
    pub cameras: Vec<Camera>,
    /// Which of them stand.
    pub placed: Vec<bool>,
    /// Tangents of the pairs that agree with it, each weighed by how well it does.
    pub support: f64,
}

/// Focal lengths that are tried, in widths of the image.
pub const FOCALS: [f64; 6] = [0.5, 0.75, 1.1, 1.6, 2.4, 3.8];
/// Scales of the loss, pixels, one after the other.
const SCALES: [f64; 2] = [10.0, 3.0];
/// Steps of the solver at each.
const STEPS: usize = 15;
/// Guesses that are solved for, of those that cost least.
const SOLVED: usize = 5;
/// Scale of the loss of a guess, pixels.
const ROUGH: f64 = 20.0;
/// What a tangent costs that lies behind a camera, in the unit of that loss.
const BEHIND: f64 = 9.0;
/// Lengths of a triplet's second baseline that are tried, as multiples of its first.
const RATIOS: [f64; 7] = [0.3, 0.5, 0.75, 1.0, 1.35, 2.0, 3.3];
/// Tangents of each pair that are looked at.
const MEETINGS: usize = 160;
/// Triplets that are tried.
const TRIPLETS: usize = 16;
/// Lengths of a baseline that are tried, in mean distances of the cameras that stand.
const LENGTHS: [f64; 5] = [0.25, 0.5, 1.0, 1.8, 3.0];
/// Triplets that a network is grown from.
const GROWN: usize = 3;
/// What a standard deviation of a prior is worth against the tangents.
const PRIOR_WEIGHT: f64 = 30.0;

/// Starts for networks of these cameras, the most supported first.
pub struct Starter<'p> {
    cameras: &'p [Camera],
    beliefs: &'p [Beliefs],
    pairs: &'p [PairHypotheses],
    /// Tangents of the best hypothesis of each pair.
    thinned: Vec<Vec<Meeting>>,
}

impl<'p> Starter<'p> {
    /// `cameras` with focal lengths where they are known, and clocks.
    pub fn new(cameras: &'p [Camera], beliefs: &'p [Beliefs], pairs: &'p [PairHypotheses]) -> Self {
        let thinned = |meetings: &[Meeting]| evenly(meetings.len(), MEETINGS).map(|k| meetings[k]).collect();
        let thinned = pairs.iter().map(|p| thinned(&p.hypotheses[0].meetings)).collect();
        Self { cameras, beliefs, pairs, thinned }
    }

    fn guessed(&self, camera: usize, widths: f64) -> Camera {
        if self.beliefs[camera].has_focal() {
            return self.cameras[camera];
        }
        let given = self.cameras[camera];
        Camera { log_focal: (widths * given.size.width as f64).ln(), ..given }
    }

    fn pair(&self, a: usize, b: usize) -> Option<usize> {
        let (a, b) = (a.min(b), a.max(b));
        self.pairs.iter().position(|p| (p.a, p.b) == (a, b))
    }

    /// Pairs among the placed cameras, with their tangents.
    fn meetings(&self, placed: &[bool]) -> Vec<PairMeetings> {
        let among = self.pairs.iter().zip(&self.thinned).filter(|(p, _)| placed[p.a] && placed[p.b]);
        among.map(|(p, m)| PairMeetings { a: p.a, b: p.b, meetings: m.clone(), coarseness: 1.0 }).collect()
    }

    /// Cameras solved for over the pairs' own tangents.
    fn solved(&self, cameras: &[Camera], placed: &[bool], moving: &[bool], steps: usize) -> Vec<Camera> {
        let pairs = self.meetings(placed);
        let mut at = cameras.to_vec();
        for scale in SCALES {
            let problem = JointProblem {
                pairs: &pairs,
                beliefs: self.beliefs,
                scale,
                prior_weight: PRIOR_WEIGHT,
                moving: moving.to_vec(),
            };
            at = problem.solve(&at, steps).0;
        }
        at
    }

    fn support(&self, cameras: &[Camera], placed: &[bool]) -> f64 {
        let of_pair = |(p, m): (&PairHypotheses, &Vec<Meeting>)| {
            if placed[p.a] && placed[p.b] {
                CameraPair::new(&cameras[p.a], &cameras[p.b]).agreement(m, limits::START_AGREES)
            } else {
                0.0
            }
        };
        self.pairs.iter().zip(&self.thinned).map(of_pair).sum()
    }

    /// Networks grown from the best triplets, the most supported first.
    pub fn networks(&self) -> Vec<Started> {
        let n = self.cameras.len();
        let mut seeds = if n == 2 { self.couple() } else { self.triplets() };
        seeds.sort_by(|p, q| q.support.total_cmp(&p.support));
        let mut grown: Vec<Started> = Vec::new();
        for seed in seeds {
            if grown.len() == GROWN {
                break;
            }
            // From three that a network agrees with, the same network would grow.
            if !grown.iter().any(|network| self.agrees(network, &seed)) {
                grown.push(self.grown(seed));
            }
        }
        grown.sort_by(|p, q| q.support.total_cmp(&p.support));
        grown
    }

    /// Whether a network has the geometry of a seed: the tangents of most of its pairs lie alike in both.
    fn agrees(&self, network: &Started, seed: &Started) -> bool {
        let of_seed =
            self.pairs.iter().zip(&self.thinned).filter(|(p, _)| seed.placed[p.a] && seed.placed[p.b]);
        let alike = of_seed.map(|(p, meetings)| {
            if !(network.placed[p.a] && network.placed[p.b]) {
                return false;
            }
            let pair = |n: &'_ Started| (n.cameras[p.a], n.cameras[p.b]);
            let ((a, b), (c, d)) = (pair(network), pair(seed));
            let (one, other) = (CameraPair::new(&a, &b), CameraPair::new(&c, &d));
            let near = |m: &&Meeting| match (one.residual(m), other.residual(m)) {
                (Some(r), Some(s)) => (r - s).abs() < limits::START_AGREES,
                _ => false,
            };
            2 * meetings.iter().filter(near).count() > meetings.len()
        });
        alike.filter(|alike| *alike).count() >= 2
    }

    /// Two cameras whose matrices are known.
    fn couple(&self) -> Vec<Started> {
        let Some(pair) = self.pairs.first() else { return Vec::new() };
        let mut cameras = self.cameras.to_vec();
        let best = &pair.hypotheses[0];
        let Some((rotation, t, _)) =
            relative_pose(&best.fundamental, &cameras[pair.a], &cameras[pair.b], &best.meetings)
        else {
            return Vec::new();
        };
        cameras[pair.b] = placed_beside(&cameras[pair.a], &cameras[pair.b], &rotation, &t, 1.0);
        let placed = vec![true; 2];
        let cameras = self.solved(&cameras, &placed, &placed, STEPS);
        let support = self.support(&cameras, &placed);
        vec![Started { cameras, placed, support }]
    }

    /// The best of each triplet, of those with most evidence.
    fn triplets(&self) -> Vec<Started> {
        let n = self.cameras.len();
        let mut triplets: Vec<([usize; 3], [usize; 3], f64)> = Vec::new();
        for a in 0..n {
            for b in a + 1..n {
                for c in b + 1..n {
                    if let (Some(ab), Some(ac), Some(bc)) =
                        (self.pair(a, b), self.pair(a, c), self.pair(b, c))
                    {
                        let sides = [ab, ac, bc];
                        let least = sides.iter().map(|&p| self.pairs[p].hypotheses[0].score);
                        triplets.push(([a, b, c], sides, least.fold(f64::INFINITY, f64::min)));
                    }
                }
            }
        }
        triplets.sort_by(|p, q| q.2.total_cmp(&p.2).then(p.0.cmp(&q.0)));
        triplets.truncate(TRIPLETS);
        triplets.par_iter().filter_map(|(cameras, sides, _)| self.triplet(*cameras, *sides)).collect()
    }

    /// Three cameras from their pairs: of several focal lengths, and with each of the three pairs left out in turn, the best.
    fn triplet(&self, cameras: [usize; 3], sides: [usize; 3]) -> Option<Started> {
        let guesses = FOCALS.into_iter().flat_map(|focal| (0..3).map(move |tree| (focal, tree)));
        let mut guesses: Vec<(f64, Vec<Camera>)> =
            guesses.filter_map(|(focal, tree)| self.guessed_triplet(cameras, sides, focal, tree)).collect();
        guesses.sort_by(|p, q| p.0.total_cmp(&q.0));
        let mut placed = vec![false; self.cameras.len()];
        for camera in cameras {
            placed[camera] = true;
        }
        let started = guesses.iter().take(SOLVED).map(|(_, at)| {
            let cameras = self.solved(at, &placed, &placed, STEPS);
            // The pair that agrees least decides.
            let shares = sides.iter().map(|&s| self.share(s, &cameras));
            let least = shares.fold(f64::INFINITY, f64::min);
            let support = least * self.support(&cameras, &placed);
            Started { cameras, placed: placed.clone(), support }
        });
        started.filter(|s| s.support.is_finite()).max_by(|p, q| p.support.total_cmp(&q.support))
    }

    /// Three cameras from two of their pairs, the one left out being `tree`, and a focal length; with what the tangents of
    /// all three cost, generously.
    fn guessed_triplet(
        &self,
        cameras: [usize; 3],
        sides: [usize; 3],
        focal: f64,
        tree: usize,
    ) -> Option<(f64, Vec<Camera>)> {
        let mut at = self.cameras.to_vec();
        for camera in cameras {
            at[camera] = self.guessed(camera, focal);
        }
        // Sides in the order ab, ac, bc; the camera common to the two that are used comes first.
        let [a, b, c] = cameras;
        let (first, others, used) = match tree {
            0 => (c, [a, b], [sides[1], sides[2]]),
            1 => (b, [a, c], [sides[0], sides[2]]),
            _ => (a, [b, c], [sides[0], sides[1]]),
        };
        let poses: Vec<_> =
            used.iter().zip(others).map(|(&side, other)| self.pose_of(side, first, other, &at)).collect();
        let [Some((turn_p, t_p)), Some((turn_q, t_q))] = poses[..] else { return None };
        // The third side tells how long the second is as a multiple of the first.
        let p = placed_beside(&at[first], &at[others[0]], &turn_p, &t_p, 1.0);
        let with = |ratio: f64| {
            let mut at = at.clone();
            at[others[0]] = p;
            at[others[1]] = placed_beside(&at[first], &at[others[1]], &turn_q, &t_q, ratio);
            (sides.iter().map(|&side| self.rough_cost(side, &at)).sum::<f64>(), at)
        };
        RATIOS.into_iter().map(with).min_by(|x, y| x.0.total_cmp(&y.0))
    }

    /// Share of the tangents of a pair that agree with cameras.
    fn share(&self, pair: usize, cameras: &[Camera]) -> f64 {
        let (side, meetings) = (&self.pairs[pair], &self.thinned[pair]);
        let agreeing =
            CameraPair::new(&cameras[side.a], &cameras[side.b]).agreeing(meetings, limits::START_AGREES);
        agreeing as f64 / meetings.len().max(1) as f64
    }

    /// What the tangents of a pair cost, generously, for the guess of a focal length may be far off.
    fn rough_cost(&self, pair: usize, at: &[Camera]) -> f64 {
        let side = &self.pairs[pair];
        let geometry = CameraPair::new(&at[side.a], &at[side.b]);
        let cost = |m: &Meeting| geometry.residual(m).map_or(BEHIND, |r| (r / ROUGH).powi(2).ln_1p());
        self.thinned[pair].iter().map(cost).sum()
    }

    /// Rotation and translation from `from` to `to` by a pair of theirs.
    fn pose_of(
        &self,
        pair: usize,
        from: usize,
        to: usize,
        at: &[Camera],
    ) -> Option<(Rotation3<f64>, Vector3<f64>)> {
        let side = &self.pairs[pair];
        let best = &side.hypotheses[0];
        let (rotation, t, _) = relative_pose(&best.fundamental, &at[side.a], &at[side.b], &best.meetings)?;
        if (side.a, side.b) == (from, to) {
            return Some((rotation, t));
        }
        let back = rotation.inverse();
        Some((back, -(back * t)))
    }

    /// The network with one camera more at a time, while one agrees.
    fn grown(&self, mut network: Started) -> Started {
        let n = self.cameras.len();
        loop {
            let reach = |c: usize| -> f64 {
                let pairs = self
                    .pairs
                    .iter()
                    .filter(|p| (p.a == c && network.placed[p.b]) || (p.b == c && network.placed[p.a]));
                pairs.map(|p| p.hypotheses[0].score.max(0.0)).sum()
            };
            let mut waiting: Vec<(f64, usize)> =
                (0..n).filter(|&c| !network.placed[c]).map(|c| (reach(c), c)).collect();
            waiting.sort_by(|p, q| q.0.total_cmp(&p.0).then(p.1.cmp(&q.1)));
            let next = waiting.iter().find_map(|&(_, c)| self.with(&network, c));
            let Some(next) = next else { break };
            network = next;
        }
        let placed = network.placed.clone();
        network.cameras = self.solved(&network.cameras, &placed, &placed, 2 * STEPS);
        network.support = self.support(&network.cameras, &placed);
        network.cameras = standing(&network.cameras, &network.placed);
        network
    }

    /// The network with a camera placed by its pairs; `None` where it agrees with none of them.
    fn with(&self, network: &Started, camera: usize) -> Option<Started> {
        let neighbours: Vec<(usize, usize)> = (0..self.cameras.len())
            .filter(|&other| network.placed[other])
            .filter_map(|other| Some((other, self.pair(other, camera)?)))
            .collect();
        let mut placed = network.placed.clone();
        placed[camera] = true;
        let mut moving = vec![false; placed.len()];
        moving[camera] = true;
        let focals: &[f64] = if self.beliefs[camera].has_focal() { &[1.0] } else { &FOCALS };
        let size = mean_distance(network);
        let tried = neighbours.iter().flat_map(|&(other, pair)| {
            focals.iter().flat_map(move |&f| LENGTHS.map(|length| (other, pair, f, length * size)))
        });
        let mut guesses: Vec<(f64, Vec<Camera>)> = tried
            .filter_map(|(other, pair, focal, length)| {
                let mut at = network.cameras.clone();
                at[camera] = self.guessed(camera, focal);
                let (rotation, t) = self.pose_of(pair, other, camera, &at)?;
                at[camera] = placed_beside(&at[other], &at[camera], &rotation, &t, length);
                Some((neighbours.iter().map(|&(_, pair)| self.rough_cost(pair, &at)).sum(), at))
            })
            .collect();
        guesses.sort_by(|p, q| p.0.total_cmp(&q.0));
        guesses.truncate(SOLVED);
        let found: Vec<(f64, Vec<Camera>)> = guesses
            .par_iter()
            .map(|(_, at)| {
                let at = self.solved(at, &placed, &moving, STEPS);
                let support: f64 = neighbours
                    .iter()
                    .map(|&(other, pair)| {
                        let (p, q) = (other.min(camera), other.max(camera));
                        CameraPair::new(&at[p], &at[q]).agreement(&self.thinned[pair], limits::START_AGREES)
                    })
                    .sum();
                (support, at)
            })
            .collect();
        let (_, cameras) = found.into_iter().rev().max_by(|p, q| p.0.total_cmp(&q.0))?;
        if !neighbours.iter().any(|&(_, pair)| self.share(pair, &cameras) > limits::ENTERS) {
            return None;
        }
        let cameras = self.solved(&cameras, &placed, &placed, STEPS / 2);
        let support = self.support(&cameras, &placed);
        Some(Started { cameras, placed, support })
    }
}

/// Mean distance between the cameras that stand.
fn mean_distance(network: &Started) -> f64 {
    let placed: Vec<_> =
        network.cameras.iter().zip(&network.placed).filter(|(_, p)| **p).map(|(c, _)| c.position).collect();
    let mut sum = 0.0;
    for (i, p) in placed.iter().enumerate() {
        sum += placed[..i].iter().map(|q| (p - q).norm()).sum::<f64>();
    }
    let count = placed.len() * (placed.len() - 1) / 2;
    if count > 0 { sum / count as f64 } else { 1.0 }
}
