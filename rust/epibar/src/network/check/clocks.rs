//! Clocks of new footage, by cameras that stand where they are stored.
//!
//! Barcodes know no geometry: where all walk one way at one speed the offsets that they find are wrong by seconds, and then cameras seem to have moved that stand.
//! Where two stand as stored, what moves meets at the true offset. So each pair is asked at many offsets about the one that was found, and the
//! clocks are taken on which all pairs agree most.

use rayon::prelude::*;

use crate::network::evidence::covariance::Covariance;
use crate::network::given::pair_choice::all_pairs;
use crate::network::model::beliefs::{Belief, Beliefs};
use crate::network::model::camera::Camera;
use crate::network::model::joint::JointProblem;
use crate::network::observations::evenly::evenly;
use crate::network::observations::observed::Observed;
use crate::network::observations::survey::Survey;
use crate::network::thresholds as limits;

/// Seconds between offsets that are tried, and how many to either side.
const STEP: f64 = 0.08;
const STEPS: i32 = 50;
/// Within which tangents meet that are half a step from their moment, times the radius at which networks are compared.
const WIDER: f64 = 2.0;
/// Pairs that are asked, at the most.
const PAIRS: usize = 40;
/// Rounds in which each camera's clock is chosen by those of the others.
const ROUNDS: usize = 20;

/// Evidence of a pair by how many steps B's clock is later against A's.
struct Curve {
    a: usize,
    b: usize,
    excess: Vec<f64>,
}

impl Curve {
    fn at(&self, later: i32) -> f64 {
        usize::try_from(later + STEPS).ok().and_then(|k| self.excess.get(k)).copied().unwrap_or(0.0)
    }

    /// The step at which there is most, and by how much that is above the middle one.
    fn peak(&self) -> (i32, f64) {
        let best = (-STEPS..=STEPS).max_by(|p, q| self.at(*p).total_cmp(&self.at(*q))).unwrap_or(0);
        let mut sorted = self.excess.clone();
        sorted.sort_by(f64::total_cmp);
        (best, self.at(best) - sorted[sorted.len() / 2])
    }
}

/// By how many seconds each clock is later than as found on what all pairs agree most, the first one's held.
pub fn later_by_poses(survey: &Survey, cameras: &[Camera]) -> Vec<f64> {
    let pairs: Vec<(usize, usize)> = all_pairs(cameras.len()).collect();
    let asked: Vec<(usize, usize)> = evenly(pairs.len(), PAIRS).map(|k| pairs[k]).collect();
    let curves: Vec<Curve> = asked.iter().map(|&(a, b)| curve(survey, cameras, a, b)).collect();
    let total = |steps: &[i32]| curves.iter().map(|c| c.at(steps[c.b] - steps[c.a])).sum::<f64>();
    let as_found = vec![0; cameras.len()];
    let by_peaks = climbed(&curves, along_peaks(&curves, cameras.len()));
    let best = if total(&by_peaks) > total(&as_found) { by_peaks } else { as_found };
    best.into_iter().map(|steps| STEP * f64::from(steps)).collect()
}

/// What is believed of a camera that is solved for beside others that are held: their clocks are held too, so that the first one's is no
/// better known against them than any other's.
pub fn beside_held(beliefs: &[Beliefs], camera: usize) -> Beliefs {
    let own = beliefs[camera];
    let as_any = |k: usize| beliefs.iter().map(|b| b.clock[k].deviation).fold(0.0, f64::max);
    Beliefs { clock: [0, 1].map(|k| Belief::about(own.clock[k].mean, as_any(k))), ..own }
}

/// What is believed of cameras where all but one are solved for: a clock of theirs is held, for without the first one's, which is the
/// network's, all would follow what was believed of them before.
pub fn anchored(beliefs: &[Beliefs], cameras: &[Camera], left_out: usize) -> Vec<Beliefs> {
    let mut beliefs = beliefs.to_vec();
    if left_out == 0 {
        beliefs[1].clock = [cameras[1].offset, cameras[1].drift].map(Belief::fixed);
    }
    beliefs
}

/// Errors of cameras with those of the offsets that were solved for beside them, which scatter does not tell: what is drawn between two
/// frames meets less closely than what is in one, which pulls offsets to whole frames, the nearer the less else tells of them where the
/// cameras follow; by no more than they are known before.
pub fn with_offsets_wrong(
    scatter: Covariance,
    problem: &JointProblem,
    cameras: &[Camera],
    observed: &[Observed],
) -> Option<Covariance> {
    let normal = problem.linear(cameras, &scatter.active).normal;
    scatter.with_offsets_wrong(&normal, |c, left| {
        let pulled = limits::PULLED_TO_FRAMES / (limits::PULLED_TO_FRAMES + left.max(0.0));
        let frames = limits::OFFSET_OF_FRAMES * pulled * frame_between(observed, c);
        problem.beliefs[c].clock[0].deviation.min(frames)
    })
}

/// Seconds between frames among which the offset of a camera is found: of its own, or of the others where the least of these is longer.
fn frame_between(observed: &[Observed], camera: usize) -> f64 {
    let others = observed.iter().enumerate().filter(|(c, _)| *c != camera).map(|(_, o)| o.interval);
    observed[camera].interval.max(others.fold(f64::INFINITY, f64::min))
}

fn curve(survey: &Survey, cameras: &[Camera], a: usize, b: usize) -> Curve {
    let excess = (-STEPS..=STEPS).into_par_iter().map(|step| {
        let mut later = cameras.to_vec();
        later[b].offset += STEP * f64::from(step);
        let [rays_a, rays_b] = [a, b].map(|camera| survey.rays(&later, camera));
        let tangents = survey.tangents_of(&later, &rays_a, &rays_b, a, b);
        tangents.scorer(WIDER * limits::COMPARED * survey.scale(a, b)).score(0).excess
    });
    Curve { a, b, excess: excess.collect() }
}

/// Clocks that follow the clearest peaks from the first camera on.
fn along_peaks(curves: &[Curve], cameras: usize) -> Vec<i32> {
    let peaks: Vec<(i32, f64)> = curves.iter().map(Curve::peak).collect();
    let mut steps: Vec<Option<i32>> = vec![None; cameras];
    steps[0] = Some(0);
    for _ in 1..cameras {
        let joins = curves.iter().zip(&peaks).filter(|(c, _)| steps[c.a].is_some() != steps[c.b].is_some());
        let Some((curve, &(peak, _))) = joins.max_by(|p, q| p.1.1.total_cmp(&q.1.1)) else { break };
        match (steps[curve.a], steps[curve.b]) {
            (Some(of_a), None) => steps[curve.b] = Some(of_a + peak),
            (None, Some(of_b)) => steps[curve.a] = Some(of_b - peak),
            _ => (),
        }
    }
    steps.into_iter().map(|step| step.unwrap_or(0)).collect()
}

/// Each clock in turn where it suits the others best, until none changes.
fn climbed(curves: &[Curve], mut steps: Vec<i32>) -> Vec<i32> {
    for _ in 0..ROUNDS {
        let before = steps.clone();
        for camera in 1..steps.len() {
            let of = |step: i32| -> f64 {
                curves
                    .iter()
                    .map(|c| match (c.a == camera, c.b == camera) {
                        (true, _) => c.at(steps[c.b] - step),
                        (_, true) => c.at(step - steps[c.a]),
                        _ => 0.0,
                    })
                    .sum()
            };
            let own = steps[camera];
            let best = (-2 * STEPS..=2 * STEPS).max_by(|p, q| of(*p).total_cmp(&of(*q)));
            steps[camera] = best.filter(|step| of(*step) > of(own)).unwrap_or(own);
        }
        if steps == before {
            break;
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ImageSize;
    use crate::network::model::beliefs::InsetBeliefs;

    fn curve(a: usize, b: usize, peaks: &[(i32, f64)]) -> Curve {
        let at = |step: i32| peaks.iter().filter(|(at, _)| *at == step).map(|(_, height)| height).sum();
        Curve { a, b, excess: (-STEPS..=STEPS).map(at).collect() }
    }

    #[test]
    fn all_pairs_decide_and_a_false_peak_does_not() {
        let curves =
            [curve(0, 1, &[(5, 9.0)]), curve(0, 2, &[(30, 8.0), (-20, 7.0)]), curve(1, 2, &[(-25, 6.0)])];
        assert_eq!(climbed(&curves, along_peaks(&curves, 3)), [0, 5, -20]);
    }

    fn about(offset: f64, drift: f64) -> Beliefs {
        Beliefs {
            intrinsic: [Belief::fixed(0.0); 7],
            clock: [Belief::about(1.0, offset), Belief::about(0.0, drift)],
            centred: false,
            insets: InsetBeliefs::all_around(Belief::fixed(0.0)),
            posed: true,
        }
    }

    #[test]
    fn without_the_first_camera_the_clock_of_another_is_held() {
        let found = [about(0.0, 0.0), about(0.1, 30.0), about(0.1, 30.0)];
        let at = |offset| Camera { offset, ..Camera::new(ImageSize::new(640, 480).unwrap(), 500.0) };
        let cameras = [0.0, 1.25, 2.5].map(at);
        let held = anchored(&found, &cameras, 0);
        assert_eq!([held[1].clock[0], held[1].clock[1]], [1.25, 0.0].map(Belief::fixed));
        assert_eq!([held[0], held[2]], [found[0], found[2]]);
        assert_eq!(anchored(&found, &cameras, 1), found);
    }

    #[test]
    fn beside_held_cameras_every_clock_is_known_as_well() {
        let found = [about(0.0, 0.0), about(0.1, 30.0), about(0.1, 30.0)];
        assert_eq!([0, 1].map(|c| beside_held(&found, c)), [found[1]; 2]);
        let given = [about(0.0, 0.0); 2];
        assert_eq!([0, 1].map(|c| beside_held(&given, c)), given);
    }

    #[test]
    fn what_is_beyond_all_that_was_tried_has_no_evidence() {
        let one = curve(0, 1, &[(STEPS, 1.0)]);
        assert_eq!([one.at(STEPS), one.at(STEPS + 1), one.at(-STEPS - 1)], [1.0, 0.0, 0.0]);
        assert_eq!(one.peak(), (STEPS, 1.0));
    }
}
