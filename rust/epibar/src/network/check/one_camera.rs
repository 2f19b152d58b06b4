//! Another pose of a camera, or another focal length: by the new footage, with all other cameras held.

use nalgebra::{Rotation3, Vector3};
use rayon::prelude::*;

use super::clocks::{beside_held, with_offsets_wrong};
use super::stretch::{PARTS, Stretch};
use crate::network::evidence::covariance::{Covariance, covariance};
use crate::network::evidence::stated_errors::{NINE_IN_TEN, length_quantile};
use crate::network::model::beliefs::{Belief, Beliefs};
use crate::network::model::camera::{Camera, FOCAL, POSITION, ROTATION};
use crate::network::model::joint::JointProblem;
use crate::network::observations::survey::Survey;
use crate::network::observations::time_parts::TimeParts;
use crate::network::solve::relocate::Placed;
use crate::network::solve::settle::{Settled, settle};
use crate::network::thresholds as limits;
use crate::network::verdict::rig;

/// Turns that are tried about each axis, degrees.
const TURNS: [f64; 9] = [-6.0, -4.0, -2.5, -1.2, 0.0, 1.2, 2.5, 4.0, 6.0];
/// Rolls that go with each.
const ROLLS: [f64; 3] = [-2.5, 0.0, 2.5];
/// Radius at which these are compared, pixels of a 640×480 image.
pub const ROUGH: f64 = 8.0;
/// The best of them that are solved for, on some of the frames.
const SOLVED: usize = 2;
/// Radius from which the best of these is solved for on all frames, pixels of a 640×480 image.
pub const CLOSE: f64 = 6.0;

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
    /// Another focal length alone would explain about as much as this pose.
    pub or_zoomed: bool,
    /// By how many standard deviations over parts of the footage it agrees better there.
    pub gain: f64,
    /// How much better, as evidence.
    pub better: f64,
    /// Part of the time of its own pairs from which on it does.
    pub from: usize,
    /// Part of the time of all pairs from which on it does.
    pub from_of_all: usize,
    /// When that part begins, the network's time.
    pub since: f64,
    /// What is compared with it before that, as a share of all that is.
    pub before: f64,
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
            or_zoomed: false,
            gain: 0.0,
            better: 0.0,
            from: 0,
            from_of_all: 0,
            since: f64::NEG_INFINITY,
            before: 0.0,
        }
    }

    /// The pose of another solution, in numbers.
    pub fn with_pose_of(self, other: &Self) -> Self {
        let Self { turned, turned_error, shifted, shifted_error, .. } = *other;
        Self { turned, turned_error, shifted, shifted_error, ..self }
    }

    /// This move with errors to state: what is stored is wrong by more than its own scatter.
    pub fn beside_stored(&self) -> Self {
        let [turned_error, shifted_error, focal_error] =
            [self.turned_error, self.shifted_error, self.focal_error].map(|e| limits::STORED_WRONG * e);
        Self { turned_error, shifted_error, focal_error, ..*self }
    }

    /// Whether it is turned or shifted by more than errors make.
    pub fn is_reposed(&self) -> bool {
        self.turned > limits::MOVED * self.turned_error || self.shifted > limits::MOVED * self.shifted_error
    }

    /// Whether its focal length changed by more than errors make.
    pub fn is_zoomed(&self) -> bool {
        self.focal.abs() > limits::MOVED * self.focal_error
    }

    /// Whether it agrees best so far away that nobody can say that it stands, however few moments say so.
    pub fn is_far(&self) -> bool {
        let beyond = |size: f64, error: f64| size > limits::SEEMS_MOVED * error;
        let far = beyond(self.turned, self.turned_error)
            || beyond(self.shifted, self.shifted_error)
            || beyond(self.focal.abs(), self.focal_error);
        far && self.better > 0.0
    }

    /// Whether it was filmed.
    pub fn is_within(&self) -> bool {
        self.before > limits::MOVED_LATER
    }

    /// Whether so much speaks for a move in the midst of the footage, which is asked for at every moment of it.
    pub fn is_clear_within(&self) -> bool {
        self.is_clear() && self.is_within() && self.gain > limits::MOVED_WITHIN_DEVIATES
    }

    /// Whether so much speaks for it that it moved.
    pub fn is_clear(&self) -> bool {
        let far = if self.zoomed { self.is_zoomed() } else { self.is_reposed() };
        far && self.gain > limits::MOVED_DEVIATES
    }
}

/// New footage against which the cameras of a network are held.
pub struct StretchCase<'a> {
    /// What of it is compared, part by part.
    pub stretch: &'a Stretch<'a>,
    /// The footage on which cameras are solved for: all of the stretch, or its end.
    pub fitted: &'a Stretch<'a>,
    pub beliefs: &'a [Beliefs],
    /// The cameras, where each is held while another is asked for.
    pub network: &'a Placed,
}

/// Evidence of the pairs of a network, part by part.
pub struct Standing {
    pub pairs: Vec<(usize, usize)>,
    pub parts: Vec<[f64; PARTS]>,
}

impl Standing {
    /// The excess of cameras over a stretch of footage.
    pub fn of(stretch: &Stretch, network: &Placed) -> Self {
        let pairs = network.pairs();
        let parts = stretch.all.excess_of_pairs(&network.cameras, &pairs, limits::COMPARED, &stretch.parts);
        Self { pairs, parts }
    }
}

impl StretchCase<'_> {
    /// All pairs of a camera.
    pub fn pairs_of(&self, camera: usize) -> Vec<(usize, usize)> {
        let others = (0..self.beliefs.len()).filter(|&o| o != camera);
        others.map(|o| (o.min(camera), o.max(camera))).collect()
    }

    /// The network with a camera elsewhere.
    pub fn with(&self, camera: usize, at: Camera) -> Vec<Camera> {
        let mut cameras = self.network.cameras.clone();
        cameras[camera] = at;
        cameras
    }

    /// What is believed of all cameras where the pose of one is free.
    pub fn beliefs_free(&self, camera: usize) -> Vec<Beliefs> {
        let mut beliefs = self.beliefs.to_vec();
        beliefs[camera] = Beliefs { posed: false, ..beside_held(self.beliefs, camera) };
        beliefs
    }

    /// Excess over chance of the pairs of a camera that is at some place.
    pub fn excess(&self, survey: &Survey, camera: usize, at: Camera, radius: f64) -> f64 {
        survey
            .scores(&self.with(camera, at), &self.pairs_of(camera), radius, 0)
            .iter()
            .map(|s| s.excess)
            .sum()
    }

    /// The pose of a camera by the new footage; `None` where it shows too little.
    pub fn elsewhere(&self, camera: usize) -> Option<Move> {
        let beliefs = self.beliefs_free(camera);
        let stored = self.network.cameras[camera];
        let mut starts: Vec<(f64, Camera)> = turned(&stored)
            .into_par_iter()
            .map(|at| (self.excess(&self.fitted.few, camera, at, ROUGH), at))
            .collect();
        starts.sort_by(|p, q| q.0.total_cmp(&p.0));
        starts.truncate(SOLVED);
        starts.push((0.0, stored));
        let solved = starts.into_iter().map(|(_, at)| {
            let found = self.settled(&self.fitted.some, camera, at, &beliefs, None).cameras[camera];
            (self.excess(&self.fitted.some, camera, found, limits::COMPARED), found)
        });
        let (_, start) = solved.max_by(|p, q| p.0.total_cmp(&q.0))?;
        self.measured(camera, start, &beliefs)
    }

    /// The pose of a camera that is no further off than tangents reach; `None` where the footage shows too little.
    pub fn nearby(&self, camera: usize) -> Option<Move> {
        let beliefs = self.beliefs_free(camera);
        let stored = self.network.cameras[camera];
        let start = self.settled(&self.fitted.some, camera, stored, &beliefs, None).cameras[camera];
        self.measured(camera, start, &beliefs)
    }

    /// Whether much less speaks for a camera where it is stored at the end than at the start.
    pub fn fades(&self, camera: usize) -> bool {
        let parts = self.parts(camera, self.network.cameras[camera], &self.own_time(camera));
        let sum = |parts: &[f64]| parts.iter().sum::<f64>();
        let (start, end) = (sum(&parts[..PARTS / 3]), sum(&parts[PARTS - PARTS / 3..]));
        end < limits::FADES * start
    }

    fn settled(
        &self,
        survey: &Survey,
        camera: usize,
        start: Camera,
        beliefs: &[Beliefs],
        from: Option<f64>,
    ) -> Settled {
        settle(survey, &self.with(camera, start), beliefs, &self.pairs_of(camera), &self.alone(camera), from)
    }

    fn alone(&self, camera: usize) -> Vec<bool> {
        (0..self.beliefs.len()).map(|c| c == camera).collect()
    }

    /// A camera that is solved for from a start that is close, with all others held, beside what is stored of it.
    pub fn measured(&self, camera: usize, start: Camera, beliefs: &[Beliefs]) -> Option<Move> {
        let settled = self.settled(&self.fitted.all, camera, start, beliefs, Some(CLOSE));
        let found = self.covariance(&settled, camera, beliefs)?;
        let (before, after) = (&self.network.cameras[camera], &settled.cameras[camera]);
        let posed = Move {
            focal: after.log_focal - before.log_focal,
            focal_error: focal_error(&found, camera).unwrap_or(f64::NAN),
            ..self.gained(camera, &Move::none(*after))
        };
        if beliefs[camera].posed {
            return Some(posed);
        }
        let error = |from: usize| pose_error(&found, camera, from);
        // One that is larger than the rig says that nothing tells of a shift, as where who sees the same stands on one line with the camera.
        let rig = rig(&self.network.cameras, &self.network.pairs());
        let shifted_error = error(POSITION)?;
        Some(Move {
            turned: before.rotation.angle_to(&after.rotation),
            turned_error: error(ROTATION)?,
            shifted: (before.position - after.position).norm(),
            shifted_error: if shifted_error > rig { f64::INFINITY } else { shifted_error },
            reposed: true,
            ..posed
        })
    }

    fn covariance(&self, settled: &Settled, camera: usize, beliefs: &[Beliefs]) -> Option<Covariance> {
        let problem = JointProblem {
            pairs: &settled.pairs,
            beliefs,
            scale: settled.scale,
            prior_weight: settled.prior_weight,
            moving: self.alone(camera),
        };
        // What outlines are wrong by was the same when the network was calibrated, so it does not move a camera.
        let scatter = covariance(&problem, &settled.cameras, &vec![0.0; settled.cameras.len()])?;
        with_offsets_wrong(scatter, &problem, &settled.cameras, self.fitted.all.observed)
    }

    /// Parts of the time in which a camera is compared with others: it may have filmed, or seen anything, for a part of theirs alone.
    pub fn own_time(&self, camera: usize) -> TimeParts {
        self.stretch.all.time_parts(&self.network.cameras, &self.pairs_of(camera), PARTS)
    }

    /// Excess over chance of the pairs of a camera that is at some place, part by part.
    pub fn parts(&self, camera: usize, at: Camera, time: &TimeParts) -> [f64; PARTS] {
        let pairs = self.pairs_of(camera);
        self.stretch.all.excess_by_part(&self.with(camera, at), &pairs, limits::COMPARED, time)
    }

    /// How much better the footage agrees with a camera that moved, and from when on.
    fn gained(&self, camera: usize, found: &Move) -> Move {
        // By the same clock and inset, which are of the footage and not of the pose.
        let Camera { offset, drift, insets, .. } = found.camera;
        let held = Camera { offset, drift, insets, ..self.network.cameras[camera] };
        let time = self.own_time(camera);
        let [old, stored, new] =
            [self.network.cameras[camera], held, found.camera].map(|at| self.parts(camera, at, &time));
        let better: Vec<f64> = (0..PARTS).map(|k| new[k] - old[k].max(stored[k])).collect();
        // Where the sum from here on is greatest it began.
        let tail = |from: usize| better[from..].iter().sum::<f64>();
        let from = (0..PARTS).max_by(|&p, &q| tail(p).total_cmp(&tail(q)).then(q.cmp(&p))).unwrap_or(0);
        let (since, before) = (time.start(from), self.stretch.before_part(from));
        let from_of_all = if from == 0 { 0 } else { self.stretch.parts.of(since) };
        let gain = deviates(&better[from..]);
        Move { gain, better: tail(from), from, from_of_all, since, before, ..*found }
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

/// Nine in ten errors of a turn or of a shift, by the first of its three parameters, are below this; the stored pose is about as
/// uncertain.
pub fn pose_error(found: &Covariance, camera: usize, from: usize) -> Option<f64> {
    Some(length_quantile(&(found.block(camera, from)? * 2.0)))
}

/// Nine in ten errors of a change of the log of the focal length are below this; the stored one is about as uncertain.
pub fn focal_error(found: &Covariance, camera: usize) -> Option<f64> {
    let at = found.row(camera, FOCAL)?;
    Some(NINE_IN_TEN * (2.0 * found.matrix[(at, at)].max(0.0)).sqrt())
}
