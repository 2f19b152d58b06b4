//! Where a new camera stands among those that are held, what speaks for it, and by how much that may be wrong.

use nalgebra::Matrix3;

use super::held::{Given, Held};
use crate::error::Result;
use crate::network::case::{NetworkCase, Out};
use crate::network::evidence::alternatives::alternatives;
use crate::network::evidence::cheirality::behind;
use crate::network::evidence::contradictions::contradictions;
use crate::network::evidence::covariance::covariance_with_principal_points;
use crate::network::evidence::doubts::{doubts, with_doubts};
use crate::network::evidence::knocks::knocked;
use crate::network::evidence::outlines::{Shapes, outline_errors};
use crate::network::evidence::parallax::parallax;
use crate::network::evidence::planes::off_plane;
use crate::network::evidence::slight_knocks;
use crate::network::evidence::stated_errors::{Expected, NINE_IN_TEN, length_quantile};
use crate::network::evidence::support::{Deviates, Support};
use crate::network::given::input::{AS_SOLD, PRINCIPAL_LEVELS};
use crate::network::model::beliefs::Beliefs;
use crate::network::model::camera::{CLOCK, Camera, FOCAL, POSITION, ROTATION};
use crate::network::observations::survey::{Survey, shared};
use crate::network::result::{CameraStatus, NetworkCamera, NetworkPair};
use crate::network::solve::collapse::collapsed;
use crate::network::solve::networks::{FRAMES, FRAMES_IN_THE_END, Solved, settled};
use crate::network::solve::principal;
use crate::network::solve::relocate::{Placed, Tries, places};
use crate::network::solve::settle::Again;
use crate::network::thresholds as limits;
use crate::network::verdict::decide::{CameraFindings, is_as_good, stands_out, status};
use crate::network::verdict::{outside, prose, rig};

/// A new camera, the last of some of which all others are held.
pub struct Newcomer<'a> {
    case: NetworkCase<'a>,
    held: &'a Held<'a>,
    camera: usize,
}

/// A camera that stands, with what its errors are expected to be.
struct FoundCamera {
    solved: Solved,
    support: Support,
    expected: Expected,
    offset_error: f64,
    /// What was given of it and is contradicted by what moves, in words.
    contradicted: Option<String>,
    /// What was given of it and may be wrong, in words.
    doubted: String,
    /// The largest distance between two cameras.
    rig: f64,
}

impl<'a> Newcomer<'a> {
    /// With what is given of it.
    pub fn new(held: &'a Held<'a>, given: &'a Given<'a>) -> Self {
        let camera = held.cameras.len();
        let mut case = NetworkCase::new(&given.inputs, &given.pairs, &given.clocks);
        case.cameras[..camera].copy_from_slice(&held.cameras);
        case.beliefs[..camera].copy_from_slice(&held.beliefs);
        case.observed[..camera].clone_from_slice(&held.observed);
        Self { case, held, camera }
    }

    /// What is said of it, and its pairs with the cameras that are held.
    ///
    /// # Errors
    /// What `tell` fails with.
    pub fn judged(
        &self,
        tell: &mut dyn FnMut(f64) -> Result<()>,
    ) -> Result<(NetworkCamera, Vec<NetworkPair>)> {
        let found = self.found(tell)?;
        let (status, out) = match &found {
            Ok(found @ FoundCamera { contradicted, expected, rig, .. }) => {
                let contradicted = contradicted.is_some();
                (
                    status(&CameraFindings {
                        rivalled: false,
                        // Only of cameras that are calibrated together is it asked.
                        clock_doubted: false,
                        contradicted,
                        parallax: parallax(&found.solved.settled)[self.camera],
                        // The cameras that are there are held, and tell its focal length before a plane too.
                        relief: f64::INFINITY,
                        pair_refused: false,
                        expected,
                        rig: *rig,
                    }),
                    None,
                )
            }
            Err(out) => (out.status, Some(out)),
        };
        let (expected, rig) = found.as_ref().map_or((Expected::UNKNOWN, 1.0), |f| (f.expected, f.rig));
        let said = self.case.unplaced(self.camera, status, out, &expected, rig);
        let Ok(found) = found else {
            return Ok((said, (0..self.camera).map(|a| outside((a, self.camera))).collect()));
        };
        let cameras = &found.solved.network.cameras;
        let accepted = status == CameraStatus::Accepted;
        let pair = |a| {
            let both = [&cameras[a], &cameras[self.camera]];
            let pair = self.case.pair_of((a, self.camera), both, &found.support);
            // Its own error holds those of the cameras that it is beside.
            if accepted { pair.accepted_with_baseline(both, expected.position) } else { pair }
        };
        let pairs = (0..self.camera).map(pair).collect();
        let camera = NetworkCamera {
            reason: found.contradicted.clone().unwrap_or(said.reason + &found.doubted),
            camera: Some(cameras[self.camera]),
            expected: Some(expected),
            deviates: found.support.cameras[self.camera],
            offset_error: found.offset_error,
            ..said
        };
        Ok((camera, pairs))
    }

    /// The camera where it stands, or why it does not.
    fn found(
        &self,
        tell: &mut dyn FnMut(f64) -> Result<()>,
    ) -> Result<std::result::Result<FoundCamera, Out>> {
        let [few, some] = FRAMES.map(|frames| Survey::new(&self.case.observed, frames));
        let NetworkCase { cameras, beliefs, hypotheses, .. } = &self.case;
        let placed: Vec<bool> = (0..=self.camera).map(|c| c != self.camera).collect();
        let without = Placed { cameras: cameras.clone(), placed };
        let tried = places(&few, &without, beliefs, hypotheses, self.camera, Tries::MANY);
        tell(0.3)?;
        let Some((excess, best)) = tried.first().filter(|(excess, _)| *excess > 0.0) else {
            return Ok(Err(self.out(CameraStatus::NothingInCommon, None, Deviates::default())));
        };
        let apart = |at: &Camera| at.rotation.angle_to(&best.rotation) > limits::RIVAL_TURN;
        let others = tried[1..].iter().filter(|(of, at)| *of > limits::ADDED_RIVAL * excess && apart(at));
        let mut stand: Vec<(f64, Solved)> = [best]
            .into_iter()
            .chain(others.map(|(_, at)| at))
            .map(|at| on_all_pairs(&some, without.with(self.camera, *at), beliefs, None))
            .map(|solved| (self.excess(&some, &solved.network), solved))
            .collect();
        stand.sort_by(|p, q| q.0.total_cmp(&p.0));
        let now = stand.swap_remove(0).1;
        let rivals: Vec<Placed> = stand.into_iter().map(|(_, solved)| solved.network).collect();
        tell(0.6)?;
        let support = Support::of(&self.case.observed, &now);
        if let Some(out) = self.refused(&some, &now, &support, &rivals) {
            return Ok(Err(out));
        }
        tell(0.8)?;
        Ok(Ok(self.finished(&some, now, support)))
    }

    /// Excess over chance of the pairs of the camera.
    fn excess(&self, survey: &Survey, network: &Placed) -> f64 {
        let pairs = network.pairs_of(self.camera);
        survey.scores(&network.cameras, &pairs, limits::COMPARED, 0).iter().map(|s| s.excess).sum()
    }

    /// Why a camera does not stand where it is.
    fn refused(&self, some: &Survey, now: &Solved, support: &Support, rivals: &[Placed]) -> Option<Out> {
        let deviates = support.cameras[self.camera];
        let out = |status, at| Some(self.out(status, at, deviates));
        if !self.is_confirmed(support) {
            return out(CameraStatus::NothingInCommon, None);
        }
        let together = collapsed(&now.settled).iter().any(|&(a, b)| a == self.camera || b == self.camera);
        let all = vec![true; self.camera + 1];
        // All pairs are its own, and the others are held.
        let behind = behind(&now.settled, &all, &support.confirmed()).is_some();
        if together || behind || off_plane(&now.settled, &all, &support.confirmed()) == Some(self.camera) {
            return out(CameraStatus::Ambiguous, None);
        }
        let film = |time: f64| now.network.cameras[self.camera].clock_at(time);
        if let Some(knock) = knocked(some, &now.network, limits::KNOCKED)[self.camera] {
            return out(CameraStatus::Knocked, Some(film(knock.at)));
        }
        let little = slight_knocks::knocked_a_little(&self.case.observed, some, now);
        if let Some((_, at)) = little.filter(|(camera, _)| *camera == self.camera) {
            return out(CameraStatus::Knocked, Some(film(at)));
        }
        let rivalled = rivals
            .iter()
            .any(|rival| is_as_good(some, &now.network.pairs_of(self.camera), &now.network, rival));
        if rivalled { out(CameraStatus::Ambiguous, None) } else { None }
    }

    fn out(&self, status: CameraStatus, at: Option<f64>, deviates: Deviates) -> Out {
        Out { camera: self.camera, status, deviates, at }
    }

    /// Whether enough speaks for the camera where it is, in pairs with enough of those that are held.
    fn is_confirmed(&self, support: &Support) -> bool {
        stands_out(support, self.camera) && self.confirming(support).len() >= limits::CONFIRMED_PAIRS
    }

    /// Cameras that are held and confirm this one.
    fn confirming(&self, support: &Support) -> Vec<usize> {
        let pairs = support.confirmed().into_iter();
        pairs.filter(|(_, b)| *b == self.camera).map(|(a, _)| a).collect()
    }

    /// The camera over all frames, with its principal point as far from the middle as the tangents call for, and errors to expect.
    fn finished(&self, some: &Survey, now: Solved, support: Support) -> FoundCamera {
        let shapes = Shapes::of(&self.case.observed);
        let placed: Vec<bool> = (0..=self.camera).map(|c| c == self.camera).collect();
        let network = Placed { cameras: now.network.cameras.clone(), placed };
        let alone = Solved { network, ..now.clone() };
        let likely = principal::likely(&alone);
        let likely = if shapes == Shapes::Convex { likely.not_below_sold() } else { likely };
        let called = principal::at_level(&now.beliefs, &self.case.cameras, likely.level());
        let freed = shapes == Shapes::Masks && likely.level() > PRINCIPAL_LEVELS[AS_SOLD];
        let with_free_point = freed.then(|| {
            let radius = Some(Again::PRINCIPAL_POINTS.after(&now.settled));
            let free = on_all_pairs(some, now.network.clone(), &called, radius);
            let support = Support::of(&self.case.observed, &free);
            (free, support)
        });
        let is_better = |(free, support): &(Solved, Support)| {
            self.excess(some, &free.network) > self.excess(some, &now.network) && self.is_confirmed(support)
        };
        let (now, support) = with_free_point.filter(is_better).unwrap_or((now, support));
        let is_strained = shapes == Shapes::Convex && principal::is_strained(&alone);
        let shapes = if is_strained { Shapes::Strained } else { shapes };
        let many = Survey::new(&self.case.observed, shared(FRAMES_IN_THE_END, self.camera + 1));
        let radius = Some(Again::MORE_FRAMES.after(&now.settled));
        let confirmed = support.confirmed();
        let beside = |&(a, b): &(usize, usize)| b < self.camera || confirmed.contains(&(a, b));
        let pairs: Vec<(usize, usize)> = now.network.pairs().into_iter().filter(beside).collect();
        let solved = settled(&many, now.network, &now.beliefs, &pairs, radius);
        let outlines = outline_errors(&solved.settled, shapes);
        let alternatives = alternatives(&solved, &likely, shapes);
        let doubts = doubts(&solved.network.cameras, &alternatives);
        let errors = covariance_with_principal_points(&solved, &likely, &outlines)
            .and_then(|errors| with_doubts(errors, &doubts));
        let of_held = self.typical(&support);
        let (expected, offset_error) = errors.map_or((Expected::UNKNOWN, f64::NAN), |errors| {
            // NaN where it was not solved for, which it was of a camera that is new.
            let block =
                |from: usize| errors.block(self.camera, from).unwrap_or(Matrix3::from_element(f64::NAN));
            let focal = NINE_IN_TEN * errors.deviation(self.camera, FOCAL);
            let own = Expected::of_position(focal, length_quantile(&block(ROTATION)), block(POSITION));
            let expected = own.besides(&of_held);
            // One that is given and held is as good as whoever gave it says, but for what is doubted of it.
            let is_held = solved.beliefs[self.camera].intrinsic[FOCAL].deviation == 0.0;
            let focal = if is_held { focal } else { expected.focal };
            (Expected { focal, ..expected }, errors.deviation(self.camera, CLOCK))
        });
        let rig = rig(&solved.network.cameras, &solved.network.pairs());
        let contradicted = contradictions(&solved.network.cameras, &alternatives).map(|c| {
            let (given, fits) = (&solved.beliefs[self.camera], &c.cameras[self.camera]);
            c.found.iter().map(|one| prose::contradiction(one, given, fits)).collect()
        });
        let doubted = prose::doubted(&doubts, self.camera, &solved.network.cameras[self.camera]);
        FoundCamera { solved, support, expected, offset_error, contradicted, doubted, rig }
    }

    /// Root mean square of what the cameras that confirm this one are expected to be wrong by.
    fn typical(&self, support: &Support) -> Expected {
        let confirming = self.confirming(support);
        let of = |value: fn(&Expected) -> f64| {
            let squares = confirming.iter().map(|&c| value(&self.held.stored[c].expected).powi(2));
            (squares.sum::<f64>() / confirming.len() as f64).sqrt()
        };
        Expected::new(of(|e| e.focal), of(|e| e.rotation), of(|e| e.position))
    }
}

/// A network with the tangents of all its pairs found anew.
fn on_all_pairs(survey: &Survey, network: Placed, beliefs: &[Beliefs], from: Option<f64>) -> Solved {
    let pairs = network.pairs();
    settled(survey, network, beliefs, &pairs, from)
}
