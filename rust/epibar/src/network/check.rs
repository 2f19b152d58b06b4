//! New footage against a network that is known: which camera has moved?
//!
//! Clocks are found anew, poses stay as they are stored. Then every camera by itself is solved for with all others held. The one that
//! agrees most clearly better with another pose or focal length than the stored one has moved; it is put there, and the others are
//! asked again, until none moves any more: beside a camera that moved all others seem to have. A camera that was knocked while it was
//! filmed agrees as stored with a part of the footage; so where all of it shows no move the end is asked by itself.

use nalgebra::{Matrix3, Vector3};

use super::camera::Camera;
use super::check_words::{Footage, said};
use super::clocks::Offsets;
use super::input::INSET;
use super::joint::{Belief, Beliefs};
use super::moves::{Case, FRAMES, Move};
use super::observed::Observed;
use super::relocate::Placed;
use super::replace::replaced;
use super::result::CameraCheck;
use super::settle::settle;
use super::stated::{EXPECTED, Stated};
use super::support::Support;
use super::survey::Survey;
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

/// Frames on which turns are tried.
const FEW: usize = 60;
/// Where the end begins, by which a camera is asked for that moved in the midst of the footage, as a share of it.
const END: f64 = 2.0 / 3.0;

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
    let ends: Vec<f64> = observed.iter().map(|o| END * o.times.last().copied().unwrap_or(0.0)).collect();
    let [last, last_few] =
        [FRAMES, FEW].map(|limit| Survey::among(&observed, limit, |c, seconds| seconds >= ends[c]));
    let case = Case { whole: &survey, survey: &survey, few: &few, beliefs: &beliefs };
    let at_end = Case { whole: &survey, survey: &last, few: &last_few, beliefs: &beliefs };
    let mut moved = vec![false; cameras.len()];
    let mut found: Vec<Option<Move>> = vec![None; cameras.len()];
    for round in 0..=cameras.len() {
        for c in (0..cameras.len()).filter(|&c| !moved[c]) {
            let asked = round * cameras.len() + c;
            report(watch, Stage::Network, asked as f64 / (cameras.len() * (cameras.len() + 1)) as f64)?;
            let of_all = case.found(&now, c);
            let within = || at_end.found(&now, c).filter(Move::is_clear_within);
            found[c] = of_all.filter(Move::is_clear).or_else(within).or(of_all);
        }
        let clear = (0..cameras.len()).filter(|&c| !moved[c]).filter_map(|c| Some((c, found[c]?)));
        let best = clear.filter(|(_, m)| m.is_clear()).max_by(|p, q| p.1.gain.total_cmp(&q.1.gain));
        let Some((camera, best)) = best else { break };
        now.cameras[camera] = best.camera;
        moved[camera] = true;
    }
    let support = Support::on(&survey, &now);
    let places = replaced(&observed, &now, &stored, &moved, &mut found, &beliefs);
    Ok((0..cameras.len())
        .zip(places)
        .map(|(c, place)| {
            let seen = Footage { observed: &observed[c], deviate: support.cameras[c].tangents };
            said(cameras[c].name, &seen, found[c].as_ref(), moved[c], place, cameras.len())
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
