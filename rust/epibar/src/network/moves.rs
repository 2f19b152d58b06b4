//! Another pose of a camera, or another focal length: by the new footage, with all other cameras held.

use nalgebra::{Rotation3, Vector3};
use rayon::prelude::*;

use super::camera::{Camera, POSITION, ROTATION};
use super::covariance::{Covariance, NINE_IN_TEN, covariance, length_quantile};
use super::joint::{Belief, Beliefs, Problem};
use super::relocate::Placed;
use super::settle::{Settled, settle};
use super::solve::COMPARED;
use super::survey::Survey;
use super::thresholds as limits;

/// Frames of each camera that are looked at.
pub const FRAMES: usize = 400;
/// Turns that are tried about each axis, degrees.
const TURNS: [f64; 9] = [-6.0, -4.0, -2.5, -1.2, 0.0, 1.2, 2.5, 4.0, 6.0];
/// Rolls that go with each.
const ROLLS: [f64; 3] = [-2.5, 0.0, 2.5];
/// Radius at which these are compared, pixels of a 640×480 image.
pub const ROUGH: f64 = 8.0;
/// The best of them that are solved for.
const SOLVED: usize = 3;
/// Parts of the footage by which poses are compared.
pub const PARTS: usize = 48;
/// A move after this share of the footage is one that was filmed.
pub const LATER: f64 = 0.05;
/// Where the log of the focal length is among the parameters of a camera.
pub const FOCAL: usize = 0;

/// Another pose or focal length of a camera.
#[derive(Debug, Clone, Copy)]
pub struct Move {
    /// The camera there.
    pub camera: Camera,
    pub turned: f64,
    pub turned_error: f64,
    pub shifted: f64,
    pub shifted_error: f64,
    /// Change of the log of the focal length.
    pub focal: f64,
    pub focal_error: f64,
    /// Whether the camera there has another focal length.
    pub zoomed: bool,
    /// Whether it may look another way or stand elsewhere.
    pub reposed: bool,
    /// By how many standard deviations over parts of the footage it agrees better there.
    pub gain: f64,
    /// Share of the footage at which it begins to.
    pub since: f64,
}

impl Move {
    /// A camera of which nothing has been measured.
    pub fn none(camera: Camera) -> Self {
        let unknown = f64::NAN;
        Self {
            camera,
            turned: unknown,
            turned_error: unknown,
            shifted: unknown,
            shifted_error: unknown,
            focal: unknown,
            focal_error: unknown,
            zoomed: false,
            reposed: false,
            gain: 0.0,
            since: 0.0,
        }
    }

    /// The errors of another solution's pose.
    pub fn with_errors_of(self, other: &Self) -> Self {
        Self { turned_error: other.turned_error, shifted_error: other.shifted_error, ..self }
    }

    /// Whether it is turned or shifted by more than errors make.
    pub fn is_reposed(&self) -> bool {
        self.turned > limits::MOVED * self.turned_error || self.shifted > limits::MOVED * self.shifted_error
    }

    /// The same of its focal length.
    pub fn is_zoomed(&self) -> bool {
        self.focal.abs() > limits::MOVED * self.focal_error
    }

    /// Whether so much speaks for a move in the midst of the footage, which is asked for at every moment of it.
    pub fn is_clear_within(&self) -> bool {
        self.is_clear() && self.since > LATER && self.gain > limits::MOVED_WITHIN_DEVIATES
    }

    /// Whether so much speaks for it that it moved.
    pub fn is_clear(&self) -> bool {
        let far = if self.zoomed { self.is_zoomed() } else { self.is_reposed() };
        far && self.gain > limits::MOVED_DEVIATES
    }
}

/// New footage against which cameras are held.
pub struct Case<'a> {
    /// All of it, on which cameras are compared part by part.
    pub whole: &'a Survey<'a>,
    /// That on which they are solved for: all, or the end.
    pub survey: &'a Survey<'a>,
    /// Few frames of that.
    pub few: &'a Survey<'a>,
    pub beliefs: &'a [Beliefs],
}

impl Case<'_> {
    /// All pairs of a camera.
    pub fn pairs_of(&self, camera: usize) -> Vec<(usize, usize)> {
        let others = (0..self.beliefs.len()).filter(|&o| o != camera);
        others.map(|o| (o.min(camera), o.max(camera))).collect()
    }

    /// The pose of a camera by the new footage; `None` where it shows too little.
    pub fn elsewhere(&self, network: &Placed, camera: usize) -> Option<Move> {
        let pairs = self.pairs_of(camera);
        let mut beliefs = self.beliefs.to_vec();
        beliefs[camera].posed = false;
        let mut moving = vec![false; beliefs.len()];
        moving[camera] = true;
        let with = |at: Camera| {
            let mut cameras = network.cameras.clone();
            cameras[camera] = at;
            cameras
        };
        let evidence = |survey: &Survey, cameras: &[Camera], radius: f64| -> f64 {
            survey.scores(cameras, &pairs, radius, 0).iter().map(|s| s.excess).sum()
        };
        let mut starts: Vec<(f64, Camera)> = turned(&network.cameras[camera])
            .into_par_iter()
            .map(|at| (evidence(self.few, &with(at), ROUGH), at))
            .collect();
        starts.sort_by(|p, q| q.0.total_cmp(&p.0));
        starts.truncate(SOLVED);
        starts.push((0.0, network.cameras[camera]));
        let solved = starts.into_iter().map(|(_, at)| {
            let settled = settle(self.survey, &with(at), &beliefs, &pairs, &moving, None);
            (evidence(self.survey, &settled.cameras, COMPARED), settled)
        });
        let (_, settled) = solved.max_by(|p, q| p.0.total_cmp(&q.0))?;
        self.measured_at(network, camera, &settled, &beliefs)
    }

    /// A camera that is solved for from a start with all others held, beside what is stored of it.
    pub fn measured(
        &self,
        network: &Placed,
        camera: usize,
        start: Camera,
        beliefs: &[Beliefs],
    ) -> Option<Move> {
        let mut cameras = network.cameras.clone();
        cameras[camera] = start;
        let mut moving = vec![false; cameras.len()];
        moving[camera] = true;
        let settled = settle(self.survey, &cameras, beliefs, &self.pairs_of(camera), &moving, None);
        self.measured_at(network, camera, &settled, beliefs)
    }

    fn measured_at(
        &self,
        network: &Placed,
        camera: usize,
        settled: &Settled,
        beliefs: &[Beliefs],
    ) -> Option<Move> {
        let mut moving = vec![false; beliefs.len()];
        moving[camera] = true;
        let problem = Problem {
            pairs: &settled.pairs,
            beliefs,
            scale: settled.scale,
            prior_weight: settled.prior_weight,
            moving,
        };
        // What outlines are wrong by was the same when the network was calibrated, so it does not move a camera.
        let found = covariance(&problem, &settled.cameras, 0.0)?;
        let (before, after) = (&network.cameras[camera], &settled.cameras[camera]);
        // The stored pose is of other footage, and about as uncertain.
        let error = |from: usize| Some(length_quantile(&(found.block(camera, from)? * 2.0)));
        let (gain, since) = self.gain(network, &settled.cameras, camera, &self.pairs_of(camera));
        Some(Move {
            turned: before.rotation.angle_to(&after.rotation),
            turned_error: error(ROTATION)?,
            shifted: (before.position - after.position).norm(),
            shifted_error: error(POSITION)?,
            focal: after.log_focal - before.log_focal,
            focal_error: focal_error(&found, camera).unwrap_or(f64::NAN),
            gain,
            since,
            reposed: true,
            ..Move::none(*after)
        })
    }

    /// Evidence over the parts of the footage.
    pub fn parts(&self, cameras: &[Camera], pairs: &[(usize, usize)]) -> [f64; PARTS] {
        self.whole.evidence_by_part::<PARTS>(cameras, pairs, COMPARED)
    }

    /// By how many standard deviations the footage agrees better with other cameras, and from when on.
    pub fn gain(
        &self,
        network: &Placed,
        other: &[Camera],
        camera: usize,
        pairs: &[(usize, usize)],
    ) -> (f64, f64) {
        // By the same clock and inset, which are of the footage and not of the pose.
        let mut held = network.cameras.clone();
        let Camera { offset, drift, inset, .. } = other[camera];
        held[camera] = Camera { offset, drift, inset, ..held[camera] };
        let parts = |cameras: &[Camera]| self.parts(cameras, pairs);
        let (old, stored, new) = (parts(&network.cameras), parts(&held), parts(other));
        let better: Vec<f64> = (0..PARTS).map(|k| new[k] - old[k].max(stored[k])).collect();
        // Where the sum from here on is greatest it began.
        let tail = |from: usize| better[from..].iter().sum::<f64>();
        let start = (0..PARTS).max_by(|&p, &q| tail(p).total_cmp(&tail(q)).then(q.cmp(&p))).unwrap_or(0);
        (deviates(&better[start..]), start as f64 / PARTS as f64)
    }
}

/// Mean of some parts in its own standard errors; 0 of too few.
pub fn deviates(parts: &[f64]) -> f64 {
    let n = parts.len() as f64;
    let mean = parts.iter().sum::<f64>() / n;
    let variance = parts.iter().map(|b| (b - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    if n > 2.0 { mean / (variance / n).sqrt().max(1e-9) } else { 0.0 }
}

/// A camera turned by a few degrees this way and that.
fn turned(camera: &Camera) -> Vec<Camera> {
    let mut all = Vec::new();
    for tilt in TURNS {
        for pan in TURNS {
            for roll in ROLLS {
                let turn = Rotation3::new(Vector3::new(tilt, pan, roll).map(f64::to_radians));
                all.push(Camera { rotation: turn * camera.rotation, ..*camera });
            }
        }
    }
    all
}

/// The focal length is solved for.
pub fn freed(beliefs: &Beliefs) -> Beliefs {
    let mut free = *beliefs;
    free.intrinsic[FOCAL] = Belief::about(free.intrinsic[FOCAL].mean, f64::INFINITY);
    free
}

/// Nine in ten errors of a change of the log of the focal length are below this; the stored one is about as uncertain.
pub fn focal_error(found: &Covariance, camera: usize) -> Option<f64> {
    let at = found.active.iter().position(|p| *p == (camera, FOCAL))?;
    Some(NINE_IN_TEN * (2.0 * found.matrix[(at, at)].max(0.0)).sqrt())
}
