//! Does what moves tell when the cameras filmed?
//!
//! What moves one way at one speed looks to a camera that films later as it looks to one that stands further on: clock and place are traded for
//! one another, on any frames. Shifted clocks under one geometry ([`shift_curve`](super::shift_curve)) show nothing of it, since the geometry must follow the
//! clock. So the clock is moved step by step to either side, and the geometry refined at each from that of the step before, for as long as it keeps
//! its evidence.

use std::collections::{HashMap, HashSet};

use rayon::prelude::*;

use super::gains::deviate;
use super::prose;
use super::thresholds::{CLOCK_GAIN, CLOCK_LOST, CLOCK_SHARE, reaches, within};
use super::verdict::{Kind, Verdict};
use crate::clock::Aligned;
use crate::frontier::symmetric::symmetric_score_by_frame;
use crate::frontier::volume::{disagreement, met_correspondences};
use crate::frontier::{Views, busy_frames, symmetric_score, tangent_matches};
use crate::geometry::{CameraMatrices, Fundamental};
use crate::recording::RecordedFrame;
use crate::refine::refine;

/// Frames with which clocks are compared.
const FRAMES: usize = 300;
/// The longest step, seconds, or a frame where that is longer; and how often it may be halved for tangents still to be found after it.
const STEP: f64 = 0.04;
const HALVINGS: i32 = 6;
/// Tangents are still found where this share of the evidence is left under the geometry as it was.
const STILL_FOUND: f64 = 0.7;
/// As good as no step, frames.
const BETWEEN: f64 = 1e-6;
/// Steps to either side, at the most: a stride takes 0.9 to 1.3 s, and walkers look alike after it.
const STEPS: i32 = 40;
/// Clocks that are so many of the longest steps away say what is chance.
const CHANCE: [f64; 4] = [-80.0, -48.0, 48.0, 80.0];
/// Rounds of refinement at each radius.
const ROUNDS: usize = 2;
/// Correspondences of the volume where things moved.
const VOLUME: usize = 200;

/// Another clock, with the geometry that explains most there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OtherClock {
    /// By how many frames of B what is at one moment in A is later in B.
    pub later: f64,
    /// Its evidence as a share of that of the clock as found, both without what chance has to offer.
    pub share: f64,
    /// By how many standard errors it explains more than the clock as found on the same frames.
    pub gain: f64,
    /// How far its geometry is from the one as found over the volume where things moved, pixels.
    pub distance: f64,
}

impl OtherClock {
    /// Whether it may be the truth as well, and its geometry is further away than so many pixels.
    pub fn is_open(&self, pixels: f64) -> bool {
        reaches(self.share, CLOCK_SHARE) && !within(self.distance, pixels)
    }

    /// Whether it explains more beyond chance, and its geometry is further away than so many pixels. Only of one that is whole frames away: silhouettes that are
    /// drawn between frames meet less exactly, which tells frames from what is between them and nothing else.
    pub fn is_better(&self, pixels: f64) -> bool {
        reaches(self.gain, CLOCK_GAIN) && !within(self.distance, pixels) && self.later.fract() == 0.0
    }

    /// What is said of a geometry beside which it is open; frames of B are so many seconds apart.
    pub fn verdict(&self, frame_interval: f64) -> Verdict {
        Verdict::new(Kind::Ambiguous, prose::clock_open(self.later * frame_interval, self.distance))
    }

    /// What is said of a geometry whose clock was given, where this one is better.
    pub fn verdict_of_given(&self, frame_interval: f64) -> Verdict {
        let seconds = self.later * frame_interval;
        Verdict::new(Kind::Ambiguous, prose::given_clock_doubted(seconds, self.distance, self.gain))
    }

    /// What is added to the verdict on a geometry whose clock was given, beside which it is open.
    pub fn remark_on_given(&self, frame_interval: f64) -> String {
        prose::given_clock_believed(self.later * frame_interval, self.distance)
    }
}

/// Clocks about the one that was found under which a geometry of its own keeps most of the evidence. `later` has the recordings with what is in A so
/// many frames of B later than as found.
pub fn other_clocks<'r>(
    later: impl Fn(f64) -> Aligned<'r> + Sync,
    found: &Fundamental,
    cameras: Option<CameraMatrices>,
    seed: u64,
) -> Vec<OtherClock> {
    let own = later(0.0);
    let busy = busy_frames(own.a(), own.b(), &own.frame_pairs(), Some(FRAMES));
    let taken: HashSet<RecordedFrame> = busy.iter().map(|p| p.a).collect();
    let at = |frames: f64| {
        let aligned = later(frames);
        let mut pairs = aligned.frame_pairs();
        pairs.retain(|p| taken.contains(&p.a));
        (2 * pairs.len() > taken.len()).then(|| {
            let views = aligned.views(&pairs).with_cameras(cameras);
            let frames: Vec<RecordedFrame> = pairs.iter().map(|p| p.a).collect();
            (frames, views)
        })
    };
    // Between frames silhouettes are drawn, which not all can be; so they are where they are compared with such.
    let Some((frames, views)) = at(BETWEEN) else { return Vec::new() };
    let radius = symmetric_score(&views, found).radius;
    // Refined on the frames on which the others are.
    let Some(own_best) = refine(&views, found, &[radius], ROUNDS) else { return Vec::new() };
    let longest = (STEP / own.b().frame_interval()).round().max(1.0);
    let by_chance: Vec<f64> =
        CHANCE.into_par_iter().filter_map(|k| Some(score(&at(k * longest)?.1, &own_best))).collect();
    let chance = by_chance.iter().sum::<f64>() / by_chance.len().max(1) as f64;
    let (whole, own_scores) = by_frame(&views, frames, &own_best);
    let share = |score: f64| (score - chance) / (whole - chance);
    let is_found =
        |step: &f64| at(*step).is_some_and(|(_, v)| reaches(share(score(&v, &own_best)), STILL_FOUND));
    let steps = (0..=HALVINGS).map(|k| longest * 0.5_f64.powi(k));
    let Some(step) = steps.into_iter().find(is_found) else { return Vec::new() };
    let matches = tangent_matches(&views, &own_best, radius);
    let gain = |scores: Vec<(RecordedFrame, f64)>| {
        let scores: HashMap<RecordedFrame, f64> = scores.into_iter().collect();
        let both = own_scores.iter().filter_map(|(frame, own)| Some(scores.get(frame)? - own));
        deviate(&both.collect::<Vec<_>>())
    };
    let volume = met_correspondences(&views, &own_best, &matches, VOLUME, seed);
    let to_one_side = |side: f64| {
        let mut followed = own_best;
        let mut others = Vec::new();
        for later in (1..=STEPS).map(|k| side * step * f64::from(k)) {
            let Some((frames, views)) = at(later) else { break };
            let Some(f) = refine(&views, &followed, &[4.0 * radius, 2.0 * radius, radius], ROUNDS) else {
                break;
            };
            let (score, scores) = by_frame(&views, frames, &f);
            let share = share(score);
            if !reaches(share, CLOCK_LOST) {
                break;
            }
            let gain = gain(scores);
            others.push(OtherClock { later, share, gain, distance: disagreement(&volume, &f) });
            followed = f;
        }
        others
    };
    [-1.0, 1.0].into_par_iter().flat_map_iter(to_one_side).collect()
}

/// [`score`], and the evidence of each of the frames by its number in A.
fn by_frame(views: &Views, frames: Vec<RecordedFrame>, f: &Fundamental) -> (f64, Vec<(RecordedFrame, f64)>) {
    let (score, by_frame) = symmetric_score_by_frame(views, f);
    (score.total / views.frames() as f64, frames.into_iter().zip(by_frame).collect())
}

/// Evidence of a frame.
fn score(views: &Views, f: &Fundamental) -> f64 {
    symmetric_score(views, f).total / views.frames() as f64
}
