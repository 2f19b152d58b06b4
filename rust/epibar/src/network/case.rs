//! What a network is made of, on its way from what is given to the verdict.

use super::evidence::contradictions::Contradiction;
use super::evidence::doubts::Doubt;
use super::evidence::floor_errors::FloorErrors;
use super::evidence::stated_errors::Expected;
use super::evidence::support::{Deviates, Support};
use super::given::clocks::Offsets;
use super::given::input::{Aspect, CameraInput, IntrinsicKind};
use super::given::pair::{PairFound, PairHypotheses};
use super::model::beliefs::Beliefs;
use super::model::camera::Camera;
use super::observations::observed::Observed;
use super::result::CameraStatus;
use super::solve::networks::Solved;
use super::solve::world::FloorFound;

/// What is given.
pub(super) struct NetworkCase<'a> {
    pub(super) inputs: &'a [CameraInput<'a>],
    pub(super) pairs: &'a [PairFound],
    pub(super) observed: Vec<Observed>,
    pub(super) cameras: Vec<Camera>,
    pub(super) beliefs: Vec<Beliefs>,
    pub(super) hypotheses: Vec<PairHypotheses>,
    /// Clocks were given, and are not asked for.
    pub(super) clocks_given: bool,
}

impl<'a> NetworkCase<'a> {
    /// Of what is given of each camera, pair and clock.
    pub(super) fn new(inputs: &'a [CameraInput], pairs: &'a [PairFound], clocks: &Offsets) -> Self {
        let observed = inputs.iter().map(|i| Observed::new(i.recording)).collect();
        let (mut cameras, mut beliefs): (Vec<Camera>, Vec<Beliefs>) =
            inputs.iter().map(|i| i.known.beliefs(i.recording)).unzip();
        for (i, (camera, beliefs)) in cameras.iter_mut().zip(&mut beliefs).enumerate() {
            beliefs.clock = clocks.beliefs(i);
            camera.offset = beliefs.clock[0].mean;
        }
        let hypotheses = pairs
            .iter()
            .filter(|p| clocks.seconds[p.a].is_finite() && clocks.seconds[p.b].is_finite())
            .filter_map(|p| p.hypotheses(inputs[p.a].recording, inputs[p.b].recording))
            .collect();
        Self { inputs, pairs, observed, cameras, beliefs, hypotheses, clocks_given: clocks.given }
    }

    /// Whether nobody gave what a camera is held to: pixels are taken for square unless it is said.
    pub(super) fn is_of_default(&self, camera: usize, kind: IntrinsicKind) -> bool {
        let known = &self.inputs[camera].known;
        kind == IntrinsicKind::Aspect && known.matrix.is_none() && known.aspect == Aspect::Square
    }

    pub(super) fn count(&self) -> usize {
        self.inputs.len()
    }

    /// Why there can be no network at all.
    pub(super) fn hopeless(&self) -> Option<CameraStatus> {
        if !self.are_enough(&vec![true; self.count()]) {
            return Some(CameraStatus::TooFew);
        }
        self.hypotheses.is_empty().then_some(CameraStatus::NothingInCommon)
    }

    /// Fewest cameras that make a network: two whose focal lengths are known, or three.
    pub(super) fn are_enough(&self, placed: &[bool]) -> bool {
        let known =
            self.inputs.iter().zip(placed).filter(|(i, placed)| **placed && i.known.has_focal()).count();
        placed.iter().filter(|p| **p).count() >= if known >= 2 { 2 } else { 3 }
    }
}

/// A camera that was taken out, and why.
#[derive(Debug, Clone, Copy)]
pub(super) struct Out {
    pub(super) camera: usize,
    pub(super) status: CameraStatus,
    pub(super) deviates: Deviates,
    /// Seconds of its own film at which it was knocked.
    pub(super) at: Option<f64>,
}

/// A network with all that is said of it.
pub(super) struct Finished {
    pub(super) solved: Solved,
    pub(super) support: Support,
    pub(super) expected: Vec<Expected>,
    pub(super) offsets: Vec<f64>,
    /// Of each camera, pixels of a 640×480 image.
    pub(super) parallax: Vec<f64>,
    /// Of each camera, as of `relief`.
    pub(super) relief: Vec<f64>,
    pub(super) floor: Option<FloorFound>,
    pub(super) floor_errors: FloorErrors,
    /// Silhouettes of shapes that stand for something else ask for other principal points than those believed in.
    pub(super) strained: bool,
    /// What was given, was contradicted by what moves, and was solved for.
    pub(super) contradicted: Vec<Contradiction>,
    /// What was given and may be wrong.
    pub(super) doubts: Vec<Doubt>,
}
