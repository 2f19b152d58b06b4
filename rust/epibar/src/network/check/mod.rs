//! New footage against a network that is known: which camera has moved?
//!
//! Clocks are found anew, poses stay as they are stored. Then every camera by itself is solved for with all others held, by the whole of
//! the footage and by its end, for a camera that was knocked while it was filmed agrees as stored with a part of it. What each explains is
//! compared; the one that clearly explains most is put where it stands now, and the others are asked again, until none moves any more.
//!
//! * `clocks`: clocks of the new footage, by cameras that stand.
//! * `stretch`: new footage from some moment on.
//! * `one_camera`, `zoom`: another pose of one camera, another focal length, and what that explains.
//! * `which_moved`: which camera moved.
//! * `replace`: where those that moved stand now.
//! * `prose`: sentences.

mod clocks;
mod one_camera;
mod prose;
mod replace;
mod stretch;
mod which_moved;
mod zoom;

use clocks::later_by_poses;
use prose::{NewFootage, said};
use replace::replaced;
pub(super) use stretch::FRAMES;
use which_moved::{Footage, judged};

use super::evidence::stated_errors::Expected;
use super::evidence::support::Support;
use super::given::clocks::Offsets;
use super::given::input::INSET;
use super::given::posed::{EXPECTED, PosedCamera};
use super::model::beliefs::{Belief, Beliefs, InsetBeliefs};
use super::model::camera::Camera;
use super::model::insets::Insets;
use super::observations::observed::Observed;
use super::observations::survey::Survey;
use super::result::CameraCheck;
use super::solve::relocate::Placed;
use super::solve::settle::settle;
use super::thresholds as limits;
use crate::error::{Error, Result};
use crate::recording::Recording;
use crate::watch::Watch;

/// A camera as it is stored, and what it saw since.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct StoredCamera<'r> {
    /// Name, for messages and results.
    pub name: &'r str,
    /// New footage, in raw pixels of the stored lens.
    pub recording: &'r Recording,
    /// The camera, as it is stored.
    pub camera: PosedCamera,
    /// Errors to expect of it, as they are stored: those of a camera that is added hold them, a check does not ask.
    pub expected: Expected,
}

impl<'r> StoredCamera<'r> {
    /// A camera of a stored network, and what it saw since.
    pub fn new(name: &'r str, recording: &'r Recording, camera: PosedCamera, expected: Expected) -> Self {
        Self { name, recording, camera, expected }
    }

    /// What is solved for, as it is stored; its clock and inset not known.
    pub(super) fn solvable(&self) -> Camera {
        self.camera.solvable(self.recording.size())
    }
}

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
    refuse(cameras)?;
    if clocks.seconds.len() != cameras.len() {
        return refused("clocks", clocks.seconds.len().to_string(), "a clock for each camera");
    }
    let observed: Vec<Observed> =
        cameras.iter().map(|c| Observed::new(c.recording).through(&c.solvable())).collect();
    let survey = Survey::new(&observed, FRAMES);
    let (stored, beliefs) = by_new_clocks(cameras, clocks, &survey);
    let mut judged = judged(&Footage { observed: &observed, beliefs: &beliefs }, &stored, watch)?;
    let support = Support::on(&survey, &judged.now);
    let places = replaced(&observed, &stored.cameras, &mut judged, &beliefs);
    let names: Vec<&str> = cameras.iter().map(|c| c.name).collect();
    Ok((0..cameras.len())
        .zip(places)
        .map(|(c, place)| {
            let seen = NewFootage { names: &names, deviate: support.cameras[c].tangents };
            said(c, &seen, &judged, place)
        })
        .collect())
}

/// Refuses stored cameras that cannot be those of a network.
pub(super) fn refuse(cameras: &[StoredCamera]) -> Result<()> {
    if cameras.len() < 2 {
        return refused("cameras", cameras.len().to_string(), "at least two cameras of the network");
    }
    for (i, c) in cameras.iter().enumerate() {
        if cameras[..i].iter().any(|other| other.name == c.name) {
            return refused("cameras", c.name.to_owned(), "names of cameras that differ");
        }
        if !c.camera.is_camera() {
            return refused("camera", c.name.to_owned(), EXPECTED);
        }
    }
    Ok(())
}

pub(super) fn refused<T>(name: &'static str, value: String, expected: &'static str) -> Result<T> {
    Err(Error::Argument { name, value, expected })
}

/// The stored cameras with the clocks and insets of the new footage, and what is believed of each.
pub(super) fn by_new_clocks(
    cameras: &[StoredCamera],
    clocks: &Offsets,
    survey: &Survey,
) -> (Placed, Vec<Beliefs>) {
    let beliefs: Vec<Beliefs> = (0..cameras.len())
        .map(|c| Beliefs {
            intrinsic: [Belief::fixed(0.0); 7],
            clock: clocks.beliefs(c),
            insets: InsetBeliefs::all_around(INSET),
            centred: false,
            posed: true,
        })
        .collect();
    let stored = |(c, beliefs): (&StoredCamera, &Beliefs)| Camera {
        offset: beliefs.clock[0].mean,
        insets: Insets::all_around(INSET.mean),
        ..c.solvable()
    };
    let at: Vec<Camera> = cameras.iter().zip(&beliefs).map(stored).collect();
    let found = settled(survey, &at, beliefs);
    if clocks.given {
        return found;
    }
    let later = later_by_poses(survey, &at);
    // Within that they are solved for anyway.
    if later.iter().all(|seconds| seconds.abs() < limits::CLOCK_FOUND) {
        return found;
    }
    let mut beliefs = found.1.clone();
    for (belief, later) in beliefs.iter_mut().zip(&later).skip(1) {
        belief.clock[0] = Belief::about(belief.clock[0].mean + later, limits::CLOCK_FOUND);
    }
    let moved: Vec<Camera> =
        at.iter().zip(&later).map(|(c, later)| Camera { offset: c.offset + later, ..*c }).collect();
    let by_poses = settled(survey, &moved, beliefs);
    let explained = |(network, _): &(Placed, Vec<Beliefs>)| {
        let scores = survey.scores(&network.cameras, &network.pairs(), limits::COMPARED, 0);
        scores.iter().map(|s| s.excess).sum::<f64>()
    };
    if explained(&by_poses) > explained(&found) { by_poses } else { found }
}

/// Stored cameras with their clocks and insets solved for.
fn settled(survey: &Survey, cameras: &[Camera], beliefs: Vec<Beliefs>) -> (Placed, Vec<Beliefs>) {
    let placed = vec![true; cameras.len()];
    let pairs = Placed { cameras: cameras.to_vec(), placed: placed.clone() }.pairs();
    let settled = settle(survey, cameras, &beliefs, &pairs, &placed, None);
    (Placed { cameras: settled.cameras, placed }, beliefs)
}
