//! Cameras that do not stand, or stand where their pairs contradict, are tried elsewhere.
//!
//! The joint problem goes downhill; a camera that entered the wrong valley, because a pair was wrong or two are nearly in
//! line with a third, stays there. So it is lifted out and put wherever one of its pairs, with any of its geometries, any
//! length of the baseline and any focal length would have it; what all cameras see together decides, over tangents of
//! every pair, those that failed by themselves too.

use rayon::prelude::*;

use super::settle::settle;
use super::start::FOCALS;
use crate::network::given::pair::PairHypotheses;
use crate::network::given::pair_choice::all_pairs;
use crate::network::model::beliefs::Beliefs;
use crate::network::model::camera::Camera;
use crate::network::model::pose::{placed_beside, relative_pose};
use crate::network::model::residual::CameraPair;
use crate::network::observations::survey::{Rays, Survey};
use crate::network::thresholds as limits;

/// Lengths of the baseline that are tried, in mean distances of the cameras.
const LENGTHS: [f64; 7] = [0.12, 0.25, 0.5, 0.8, 1.2, 1.8, 3.0];
/// Focal lengths that are tried of a camera that stands, as multiples of its own.
const FOCALS_NEAR: [f64; 3] = [0.7, 1.0, 1.4];
/// Radius within which guesses are compared, pixels of a 640×480 image.
const RADIUS: f64 = 8.0;

/// Which places of a camera are tried.
#[derive(Debug, Clone, Copy)]
pub struct Tries {
    /// How many focal lengths and lengths of the baseline there are, for each of those that a new network is tried with.
    finer: usize,
    /// The best guesses, which are solved for.
    solved: usize,
}

impl Tries {
    /// Of one of many cameras, whose other pairs have asked before.
    pub const SOME: Self = Self { finer: 1, solved: 4 };
    /// Of a camera of which nobody has asked: a right guess that is solved for is clear, but hardly one in ten of the coarse ones is right.
    pub const MANY: Self = Self { finer: 3, solved: 16 };

    /// Numbers in rising order, and others evenly between them by their ratio.
    fn among(self, numbers: &[f64]) -> Vec<f64> {
        let between = |pair: &[f64]| {
            let (low, ratio) = (pair[0], pair[1] / pair[0]);
            (0..self.finer).map(move |k| low * ratio.powf(k as f64 / self.finer as f64)).collect::<Vec<_>>()
        };
        numbers.windows(2).flat_map(between).chain(numbers.last().copied()).collect()
    }
}

/// A network with which of its cameras stand.
#[derive(Debug, Clone)]
pub struct Placed {
    /// All cameras.
    pub cameras: Vec<Camera>,
    /// Which of them stand.
    pub placed: Vec<bool>,
}

impl Placed {
    /// Pairs among the cameras that stand.
    pub fn pairs(&self) -> Vec<(usize, usize)> {
        all_pairs(self.cameras.len()).filter(|&(a, b)| self.placed[a] && self.placed[b]).collect()
    }

    /// By how much each pair of cameras that stand is turned otherwise in another network, radians.
    pub fn turns(&self, other: &Self) -> impl Iterator<Item = f64> {
        self.pairs().into_iter().map(|(a, b)| self.turn(other, a, b))
    }

    fn turn(&self, other: &Self, a: usize, b: usize) -> f64 {
        let between = |n: &Self| n.cameras[a].rotation * n.cameras[b].rotation.inverse();
        between(self).angle_to(&between(other))
    }

    /// Cameras that stand, and most of which look the same ways in another network: those that do not, by more than an angle, radians.
    /// `None` where no more than half of them do, or none does not by itself.
    pub fn turned_elsewhere(&self, other: &Self, by: f64) -> Option<Vec<usize>> {
        let stand: Vec<usize> = (0..self.cameras.len()).filter(|&c| self.placed[c]).collect();
        let alike = |a: usize, b: usize| self.turn(other, a, b) <= by;
        let elsewhere =
            |than: &usize| -> Vec<usize> { stand.iter().copied().filter(|&c| !alike(*than, c)).collect() };
        let fewest = stand.iter().map(elsewhere).min_by_key(Vec::len)?;
        (!fewest.is_empty() && 2 * fewest.len() < stand.len()).then_some(fewest)
    }

    /// The network with a camera that stands at a place.
    #[must_use]
    pub fn with(&self, camera: usize, at: Camera) -> Self {
        let mut with = self.clone();
        with.cameras[camera] = at;
        with.placed[camera] = true;
        with
    }

    /// Cameras that stand beside one.
    pub fn others(&self, camera: usize) -> Vec<usize> {
        (0..self.cameras.len()).filter(|&c| c != camera && self.placed[c]).collect()
    }

    /// Pairs of a camera with others that stand.
    pub fn pairs_of(&self, camera: usize) -> Vec<(usize, usize)> {
        self.others(camera).into_iter().map(|o| (o.min(camera), o.max(camera))).collect()
    }

    /// Mean distance between the cameras that stand.
    fn size(&self) -> f64 {
        let pairs = self.pairs();
        let sum: f64 =
            pairs.iter().map(|&(a, b)| (self.cameras[a].position - self.cameras[b].position).norm()).sum();
        if pairs.is_empty() { 1.0 } else { sum / pairs.len() as f64 }
    }
}

/// Share of the tangents of a camera's pairs that agree with the network, over pairs with cameras that stand; 0 where
/// there are none.
pub fn agreement(network: &Placed, pairs: &[PairHypotheses], camera: usize, survey: &Survey) -> f64 {
    let (mut agreeing, mut all) = (0.0, 0.0);
    for p in pairs.iter().filter(|p| p.a == camera || p.b == camera) {
        let other = if p.a == camera { p.b } else { p.a };
        if !network.placed[other] {
            continue;
        }
        let geometry = CameraPair::new(&network.cameras[p.a], &network.cameras[p.b]);
        let within = limits::AGREE * survey.scale(p.a, p.b);
        let meetings = &p.hypotheses[0].meetings;
        let near = geometry.agreeing(meetings, within);
        // A pair with much evidence weighs more.
        let weight = p.hypotheses[0].score.max(0.0);
        agreeing += weight * near as f64 / meetings.len().max(1) as f64;
        all += weight;
    }
    if all > 0.0 { agreeing / all } else { 0.0 }
}

/// Tries every camera elsewhere that does not stand, or that its pairs contradict; the network with all that were improved.
pub fn relocate(survey: &Survey, network: Placed, beliefs: &[Beliefs], pairs: &[PairHypotheses]) -> Placed {
    let mut network = network;
    let mut order: Vec<(f64, usize)> = (0..network.cameras.len())
        .map(|c| (if network.placed[c] { agreement(&network, pairs, c, survey) } else { -1.0 }, c))
        .filter(|(share, _)| *share < limits::TRIED_ELSEWHERE)
        .collect();
    order.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
    for (_, camera) in order {
        if let Some(moved) = elsewhere(survey, &network, beliefs, pairs, camera) {
            network = moved;
        }
    }
    network
}

/// The network with a camera at the best of all places; `None` where that is no better than where it stands.
fn elsewhere(
    survey: &Survey,
    network: &Placed,
    beliefs: &[Beliefs],
    pairs: &[PairHypotheses],
    camera: usize,
) -> Option<Placed> {
    let (best, at) = *places(survey, network, beliefs, pairs, camera, Tries::SOME).first()?;
    let now = if network.placed[camera] { score(survey, network, camera) } else { 0.0 };
    if !(best > limits::ELSEWHERE_BETTER * now && best > 0.0) {
        return None;
    }
    Some(network.with(camera, at))
}

/// Excess over chance of a camera with all others that stand, where it is.
fn score(survey: &Survey, network: &Placed, camera: usize) -> f64 {
    let rays = survey.all_rays(&network.cameras);
    excess(survey, network, &rays, camera, &network.cameras[camera], &network.others(camera))
}

/// The best places of a camera among those where its pairs with cameras that stand would have it, so many of them solved for with all
/// others held: excess over chance, and the camera there; the best first.
pub fn places(
    survey: &Survey,
    network: &Placed,
    beliefs: &[Beliefs],
    pairs: &[PairHypotheses],
    camera: usize,
    tries: Tries,
) -> Vec<(f64, Camera)> {
    let others = network.others(camera);
    let rays = survey.all_rays(&network.cameras);
    let score_of_guess = |at: &Camera| excess(survey, network, &rays, camera, at, &others);
    let mut guesses: Vec<(f64, Camera)> = guesses(network, beliefs, pairs, camera, tries)
        .into_par_iter()
        .map(|at| (score_of_guess(&at), at))
        .filter(|g| g.0.is_finite())
        .collect();
    guesses.sort_by(|p, q| q.0.total_cmp(&p.0));
    guesses.truncate(tries.solved);
    let mut moving = vec![false; network.placed.len()];
    moving[camera] = true;
    let with = network.pairs_of(camera);
    let mut tried: Vec<(f64, Camera)> = guesses
        .into_iter()
        .map(|(_, at)| {
            let mut cameras = network.cameras.clone();
            cameras[camera] = at;
            let solved = settle(survey, &cameras, beliefs, &with, &moving, None).cameras[camera];
            // By its own clock, which asks the others for other frames.
            (score(survey, &network.with(camera, solved), camera), solved)
        })
        .collect();
    tried.sort_by(|p, q| q.0.total_cmp(&p.0));
    tried
}

/// Excess over chance of a camera at a place with all others.
fn excess(
    survey: &Survey,
    network: &Placed,
    rays: &[Rays],
    camera: usize,
    at: &Camera,
    others: &[usize],
) -> f64 {
    let mut cameras = network.cameras.clone();
    cameras[camera] = *at;
    let mut rays_now: Vec<Rays> = vec![Vec::new(); rays.len()];
    rays_now[camera] = survey.rays(&cameras, camera);
    others
        .iter()
        .map(|&other| {
            let (a, b) = (other.min(camera), other.max(camera));
            let of = |i: usize| if i == camera { &rays_now[i] } else { &rays[i] };
            survey
                .tangents_of(&cameras, of(a), of(b), a, b)
                .scorer(RADIUS * survey.scale(a, b))
                .score(0)
                .excess
        })
        .sum()
}

/// Wherever a pair would have a camera.
fn guesses(
    network: &Placed,
    beliefs: &[Beliefs],
    pairs: &[PairHypotheses],
    camera: usize,
    tries: Tries,
) -> Vec<Camera> {
    let now = network.cameras[camera];
    let focals: Vec<f64> = if beliefs[camera].has_focal() {
        vec![now.log_focal]
    } else if network.placed[camera] {
        FOCALS_NEAR.map(|f| now.log_focal + f.ln()).to_vec()
    } else {
        tries.among(&FOCALS).into_iter().map(|f| (f * now.size.width as f64).ln()).collect()
    };
    let (size, lengths) = (network.size(), tries.among(&LENGTHS));
    let mut found = Vec::new();
    for p in pairs.iter().filter(|p| p.a == camera || p.b == camera) {
        let other = if p.a == camera { p.b } else { p.a };
        if !network.placed[other] {
            continue;
        }
        for hypothesis in &p.hypotheses {
            for log_focal in &focals {
                let guess = Camera { log_focal: *log_focal, ..now };
                let (a, b) = if p.a == camera {
                    (&guess, &network.cameras[other])
                } else {
                    (&network.cameras[other], &guess)
                };
                let Some((rotation, t, _)) =
                    relative_pose(&hypothesis.fundamental, a, b, &hypothesis.meetings)
                else {
                    continue;
                };
                let (rotation, t) = if p.b == camera {
                    (rotation, t)
                } else {
                    (rotation.inverse(), -(rotation.inverse() * t))
                };
                let beside = |length: f64| {
                    placed_beside(&network.cameras[other], &guess, &rotation, &t, length * size)
                };
                found.extend(lengths.iter().map(|length| beside(*length)));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ImageSize;
    use nalgebra::Rotation3;

    #[test]
    fn those_that_look_elsewhere_are_told_from_most() {
        let by_turns = |turns: &[f64]| {
            let turned = |turn: &f64| Camera {
                rotation: Rotation3::from_euler_angles(0.0, *turn, 0.0),
                ..Camera::new(ImageSize::new(640, 480).unwrap(), 500.0)
            };
            Placed { cameras: turns.iter().map(turned).collect(), placed: vec![true; turns.len()] }
        };
        let still = by_turns(&[0.0; 5]);
        let elsewhere = |turns: &[f64]| still.turned_elsewhere(&by_turns(turns), 0.05);
        // Networks have no common frame: what all are turned by is nothing.
        assert_eq!(elsewhere(&[1.0; 5]), None);
        assert_eq!(elsewhere(&[1.0, 1.0, 1.2, 1.0, 1.04]), Some(vec![2]));
        assert_eq!(elsewhere(&[0.3, 1.0, 1.0, 1.0, -0.3]), Some(vec![0, 4]));
        assert_eq!(elsewhere(&[0.3, 0.5, 1.0, 1.0, 0.7]), None);
        assert_eq!(elsewhere(&[f64::NAN, 0.0, 0.0, 0.0, 0.0]), Some(vec![0]));
        // Whoever does not stand has no say.
        let four = Placed { placed: vec![true, true, false, true, true], ..still.clone() };
        assert_eq!(four.turned_elsewhere(&by_turns(&[0.0, 0.0, 0.9, 0.9, 0.9]), 0.05), None);
    }
}
