//! New footage against a network that is known: which camera has moved?
//!
//! Clocks are found anew, poses stay as they are stored. Then every camera by itself is solved for with all others held. The one that
//! agrees most clearly better with another pose than the stored one has moved; it is put there, and the others are asked again, until
//! none moves any more: beside a camera that moved all others seem to have.

use nalgebra::{Matrix3, Rotation3, Vector3};
use rayon::prelude::*;

use super::camera::{Camera, POSITION, ROTATION};
use super::clocks::Offsets;
use super::covariance::{Covariance, covariance, length_quantile};
use super::input::INSET;
use super::joint::{Belief, Beliefs, Problem};
use super::observed::Observed;
use super::relocate::Placed;
use super::result::{CameraCheck, CheckStatus};
use super::settle::settle;
use super::solve::COMPARED;
use super::stated::{EXPECTED, Stated};
use super::support::Support;
use super::survey::Survey;
use super::thresholds as limits;
use crate::error::{Error, Result};
use crate::recording::Recording;
use crate::watch::{Stage, Watch, report};

/// A camera as it is stored, and what it saw since.
#[derive(Debug, Clone, Copy)]
pub struct StoredCamera<'r> {
    /// Name, for messages and results.
    pub name: &'r str,
    /// New footage, in raw pixels of the stored lens.
    pub recording: &'r Recording,
    /// The camera matrix, pixels.
    pub matrix: Matrix3<f64>,
    /// `k₁ k₂ p₁ p₂ k₃` of `OpenCV`; the tangential ones are not used.
    pub distortions: [f64; 5],
    /// `R` of `X_c = R X + t`.
    pub rotation: Matrix3<f64>,
    /// `t` of `X_c = R X + t`.
    pub translation: Vector3<f64>,
}

/// Frames of each camera that are looked at.
const FRAMES: usize = 400;
/// Frames on which turns are tried.
const FEW: usize = 60;
/// Turns that are tried about each axis, degrees.
const TURNS: [f64; 9] = [-6.0, -4.0, -2.5, -1.2, 0.0, 1.2, 2.5, 4.0, 6.0];
/// Rolls that go with each.
const ROLLS: [f64; 3] = [-2.5, 0.0, 2.5];
/// Radius at which these are compared, pixels of a 640×480 image.
const ROUGH: f64 = 8.0;
/// The best of them that are solved for.
const SOLVED: usize = 3;
/// Parts of the footage by which poses are compared.
const PARTS: usize = 48;

/// Which of the cameras of a network has moved since it was calibrated.
///
/// # Errors
/// [`Error::Argument`] for fewer than two cameras, for two of one name, and for numbers that no camera has,
/// [`Error::Interrupted`].
pub fn check_network(
    cameras: &[StoredCamera],
    clocks: &Offsets,
    watch: &mut dyn Watch,
) -> Result<Vec<CameraCheck>> {
    refuse(cameras, clocks)?;
    let observed: Vec<Observed> = cameras.iter().map(|c| Observed::new(c.recording)).collect();
    let survey = Survey::new(&observed, FRAMES);
    let few = Survey::new(&observed, FEW);
    let (mut now, beliefs) = by_new_clocks(cameras, clocks, &survey);
    let stored = now.cameras.clone();
    let case = Case { survey: &survey, few: &few, beliefs: &beliefs };
    let mut moved: Vec<Option<Move>> = vec![None; cameras.len()];
    // What was found of the others in the last round, beside all that moved.
    let mut still: Vec<Option<Move>> = vec![None; cameras.len()];
    for round in 0..cameras.len() {
        report(watch, Stage::Network, round as f64 / cameras.len() as f64)?;
        let elsewhere = |c: usize| if moved[c].is_some() { None } else { case.elsewhere(&now, c) };
        still = (0..cameras.len()).map(elsewhere).collect();
        let found = still.iter().enumerate().filter_map(|(c, found)| Some((c, (*found)?)));
        let best = found.filter(|(_, m)| m.is_clear()).max_by(|p, q| p.1.gain.total_cmp(&q.1.gain));
        let Some((camera, found)) = best else { break };
        now.cameras[camera] = found.camera;
        moved[camera] = Some(found);
    }
    let support = Support::on(&survey, &now);
    Ok((0..cameras.len())
        .map(|c| {
            let deviate = support.cameras[c].tangents;
            let found = moved[c].or(still[c]);
            said(
                &cameras[c],
                &observed[c],
                &stored[c],
                found.as_ref(),
                moved[c].is_some(),
                deviate,
                cameras.len(),
            )
        })
        .collect())
}

impl StoredCamera<'_> {
    fn stated(&self) -> Stated<'_> {
        let Self { matrix, distortions, rotation, translation, .. } = self;
        Stated { matrix, distortions, rotation, translation }
    }
}

fn refuse(cameras: &[StoredCamera], clocks: &Offsets) -> Result<()> {
    let wrong = |name, value: String, expected| Err(Error::Argument { name, value, expected });
    if cameras.len() < 2 {
        return wrong("cameras", cameras.len().to_string(), "at least two cameras of the network");
    }
    if clocks.seconds.len() != cameras.len() {
        return wrong("clocks", clocks.seconds.len().to_string(), "a clock for each camera");
    }
    for (i, c) in cameras.iter().enumerate() {
        if cameras[..i].iter().any(|other| other.name == c.name) {
            return wrong("cameras", c.name.to_owned(), "names of cameras that differ");
        }
        if !c.stated().is_camera() {
            return wrong("camera", c.name.to_owned(), EXPECTED);
        }
    }
    Ok(())
}

/// The stored cameras with the clocks and insets of the new footage, and what is believed of each.
fn by_new_clocks(cameras: &[StoredCamera], clocks: &Offsets, survey: &Survey) -> (Placed, Vec<Beliefs>) {
    let beliefs: Vec<Beliefs> = (0..cameras.len())
        .map(|c| Beliefs {
            intrinsic: [Belief::fixed(0.0); 7],
            clock: clocks.beliefs(c),
            inset: INSET,
            posed: true,
        })
        .collect();
    let stored = |(c, beliefs): (&StoredCamera, &Beliefs)| Camera {
        offset: beliefs.clock[0].mean,
        inset: INSET.mean,
        ..c.stated().camera(c.recording.size())
    };
    let at: Vec<Camera> = cameras.iter().zip(&beliefs).map(stored).collect();
    let placed = vec![true; at.len()];
    let pairs = Placed { cameras: at.clone(), placed: placed.clone() }.pairs();
    let settled = settle(survey, &at, &beliefs, &pairs, &placed, None);
    (Placed { cameras: settled.cameras, placed }, beliefs)
}

/// Another pose of a camera.
#[derive(Debug, Clone, Copy)]
struct Move {
    /// The camera there.
    camera: Camera,
    turned: f64,
    turned_error: f64,
    shifted: f64,
    shifted_error: f64,
    /// By how many standard deviations over parts of the footage it agrees better there.
    gain: f64,
    /// Share of the footage at which it begins to.
    since: f64,
}

impl Move {
    fn is_clear(&self) -> bool {
        let far = |moved: f64, error: f64| moved > limits::MOVED * error;
        (far(self.turned, self.turned_error) || far(self.shifted, self.shifted_error))
            && self.gain > limits::MOVED_DEVIATES
    }
}

struct Case<'a> {
    survey: &'a Survey<'a>,
    few: &'a Survey<'a>,
    beliefs: &'a [Beliefs],
}

impl Case<'_> {
    /// The pose of a camera by the new footage with all others held; `None` where it shows too little.
    fn elsewhere(&self, network: &Placed, camera: usize) -> Option<Move> {
        let n = network.cameras.len();
        let pairs: Vec<(usize, usize)> =
            (0..n).filter(|&o| o != camera).map(|o| (o.min(camera), o.max(camera))).collect();
        let mut beliefs = self.beliefs.to_vec();
        beliefs[camera].posed = false;
        let mut moving = vec![false; n];
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
        let problem = Problem {
            pairs: &settled.pairs,
            beliefs: &beliefs,
            scale: settled.scale,
            prior_weight: settled.prior_weight,
            moving,
        };
        // What outlines are wrong by was the same when the network was calibrated, so it does not move a camera.
        let Covariance { active, matrix } = covariance(&problem, &settled.cameras, 0.0)?;
        let block = |from: usize| {
            let at: Option<Vec<usize>> =
                (from..from + 3).map(|k| active.iter().position(|p| *p == (camera, k))).collect();
            at.map(|at| Matrix3::from_fn(|i, j| matrix[(at[i], at[j])]))
        };
        let (before, after) = (&network.cameras[camera], &settled.cameras[camera]);
        // The stored pose is of other footage, and about as uncertain.
        let both = |m: Matrix3<f64>| length_quantile(&(m * 2.0));
        let (gain, since) = self.gain(network, &with(*after), camera, &pairs);
        Some(Move {
            camera: *after,
            turned: before.rotation.angle_to(&after.rotation),
            turned_error: both(block(ROTATION)?),
            shifted: (before.position - after.position).norm(),
            shifted_error: both(block(POSITION)?),
            gain,
            since,
        })
    }

    /// By how many standard deviations the footage agrees better with other cameras, and from when on.
    fn gain(
        &self,
        network: &Placed,
        other: &[Camera],
        camera: usize,
        pairs: &[(usize, usize)],
    ) -> (f64, f64) {
        let parts = |cameras: &[Camera]| self.survey.evidence_by_part::<PARTS>(cameras, pairs, COMPARED);
        // By the same clock and inset, which are of the footage and not of the pose.
        let mut held = network.cameras.clone();
        held[camera] =
            Camera { rotation: held[camera].rotation, position: held[camera].position, ..other[camera] };
        let (old, stored, new) = (parts(&network.cameras), parts(&held), parts(other));
        let better: Vec<f64> = (0..PARTS).map(|k| new[k] - old[k].max(stored[k])).collect();
        // Where the sum from here on is greatest it began.
        let tail = |from: usize| better[from..].iter().sum::<f64>();
        let start = (0..PARTS).max_by(|&p, &q| tail(p).total_cmp(&tail(q)).then(q.cmp(&p))).unwrap_or(0);
        let after = &better[start..];
        let n = after.len() as f64;
        let mean = after.iter().sum::<f64>() / n;
        let variance = after.iter().map(|b| (b - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        let z = if n > 2.0 { mean / (variance / n).sqrt().max(1e-9) } else { 0.0 };
        (z, start as f64 / PARTS as f64)
    }
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

fn said(
    camera: &StoredCamera,
    observed: &Observed,
    stored: &Camera,
    found: Option<&Move>,
    moved: bool,
    deviate: f64,
    cameras: usize,
) -> CameraCheck {
    let enough = deviate >= limits::CAMERA_DEVIATES;
    let status = match found {
        Some(_) if moved && enough => CheckStatus::Moved,
        Some(_) if enough => CheckStatus::Unmoved,
        _ => CheckStatus::Unsure,
    };
    let seconds = observed.times.last().copied().unwrap_or(0.0);
    let since = found.filter(|f| status == CheckStatus::Moved && f.since > 0.05).map(|f| f.since * seconds);
    let of = |value: fn(&Move) -> f64| found.map_or(f64::NAN, value);
    let turned = found.map_or(f64::NAN, |f| stored.rotation.angle_to(&f.camera.rotation));
    let shifted = found.map_or(f64::NAN, |f| (stored.position - f.camera.position).norm());
    let reason = match status {
        CheckStatus::Moved => {
            let when = since.map_or_else(|| "before this footage".to_owned(), |s| format!("at about {s:.0} s"));
            let which = if cameras == 2 { "it or the other camera" } else { "it" };
            format!(
                "{which} moved {when}: it is turned by {:.2} degrees (to {:.2}), and {:.3} from where it stood (to {:.3})",
                turned.to_degrees(),
                of(|f| f.turned_error).to_degrees(),
                shifted,
                of(|f| f.shifted_error)
            )
        }
        CheckStatus::Unmoved => format!(
            "it stands as stored: a turn of {:.2} degrees would have been noticed",
            limits::MOVED * of(|f| f.turned_error).to_degrees()
        ),
        CheckStatus::Unsure => {
            "what moves in it does not agree with the others: too little moved before several cameras, it moved by more than a few degrees, or it shows something else".to_owned()
        }
    };
    CameraCheck {
        name: camera.name.to_owned(),
        status,
        reason,
        turned,
        turned_error: of(|f| f.turned_error),
        shifted,
        shifted_error: of(|f| f.shifted_error),
        deviate,
        since,
    }
}
