//! The whole job: recordings in, one network out.

use rayon::prelude::*;

use super::given::clocks::{Offsets, agreed, likeness, pair_offsets};
use super::given::input::CameraInput;
use super::given::pair::PairFound;
use super::given::pair_choice::{ALL_PAIRS, all_pairs, chosen};
use super::join::join;
use super::result::Network;
use crate::calibrate::calibrate_watched;
use crate::calibration::Calibration;
use crate::clock::TimeOffset;
use crate::error::{Error, Result};
use crate::geometry::CameraMatrices;
use crate::options::{CalibrateOptions, SEARCH_SECONDS};
use crate::recording::Recording;
use crate::watch::{Stage, Unwatched, Watch, report};

/// What is known of the clocks of a network.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum NetworkTime {
    /// For each camera: what is at `t` seconds in the first camera is at `t` plus this many in this one.
    Known(Vec<f64>),
    /// Found from barcodes within this many seconds either way; cameras that started together are found to have.
    Search {
        /// Largest offset considered, seconds.
        seconds: f64,
    },
}

/// Options of [`calibrate_network`].
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct NetworkOptions {
    /// Options of each pair; their time offsets and camera matrices come from the network.
    pub pairs: CalibrateOptions,
    /// Clocks.
    pub time: NetworkTime,
}

impl NetworkTime {
    fn check(&self, cameras: usize) -> Result<()> {
        match self {
            Self::Known(seconds) if seconds.len() == cameras && seconds.iter().all(|s| s.is_finite()) => {
                Ok(())
            }
            Self::Known(seconds) => Err(Error::Argument {
                name: "time",
                value: format!("{seconds:?}"),
                expected: "a finite number of seconds for each camera",
            }),
            Self::Search { seconds } if seconds.is_finite() && *seconds > 0.0 => Ok(()),
            Self::Search { seconds } => Err(Error::Argument {
                name: "seconds",
                value: seconds.to_string(),
                expected: "a positive number of seconds to search",
            }),
        }
    }
}

impl Default for NetworkOptions {
    fn default() -> Self {
        Self { pairs: CalibrateOptions::default(), time: NetworkTime::Search { seconds: SEARCH_SECONDS } }
    }
}

impl NetworkOptions {
    /// The defaults.
    pub fn new() -> Self {
        Self::default()
    }

    /// With options of each pair.
    #[must_use]
    pub fn pairs(self, pairs: CalibrateOptions) -> Self {
        Self { pairs, ..self }
    }

    /// With what is known of the clocks.
    #[must_use]
    pub fn time(self, time: NetworkTime) -> Self {
        Self { time, ..self }
    }
}

/// Calibrates all cameras of a network together: focal lengths, lenses, rotations, positions and clocks, of which nothing has to
/// be known.
///
/// Refusing is a result, not an error: see [`Network::accepted`], and each camera. What is known of a camera before is told by
/// [`Knowledge`](super::Knowledge). The result depends on the recordings and the options, not on the number of threads.
///
/// # Errors
/// [`Error::Argument`] for options out of range, for no camera, or for two of one name.
pub fn calibrate_network(cameras: &[CameraInput], options: &NetworkOptions) -> Result<Network> {
    calibrate_network_watched(cameras, options, &mut Unwatched)
}

/// [`calibrate_network`] with progress, and a way to stop.
///
/// # Errors
/// [`Error::Interrupted`] where `watch` says so, and those of [`calibrate_network`].
pub fn calibrate_network_watched(
    cameras: &[CameraInput],
    options: &NetworkOptions,
    watch: &mut dyn Watch,
) -> Result<Network> {
    check(cameras)?;
    options.time.check(cameras.len())?;
    options.pairs.check()?;
    if let [first, second] = cameras {
        if !(first.known.has_focal() && second.known.has_focal()) {
            // No search can help: it is said what is missing.
            return join(cameras, &[], &Offsets::given(vec![0.0; 2]), watch);
        }
        if let NetworkTime::Search { seconds } = options.time {
            let pair = unsynchronised([first, second], &options.pairs, seconds, watch)?;
            let found: Vec<PairFound> = PairFound::of(0, 1, &pair).into_iter().collect();
            return join(cameras, &found, &offsets_of_pair(second.recording, &pair), watch);
        }
    }
    let recordings: Vec<&Recording> = cameras.iter().map(|c| c.recording).collect();
    let offsets = clock_offsets(&recordings, &options.time, watch)?;
    let searched = pairs_to_search(&recordings, &offsets)?;
    let mut found = Vec::new();
    for (i, &(a, b)) in searched.iter().enumerate() {
        report(watch, Stage::Pairs, i as f64 / searched.len() as f64)?;
        let options = options_of_pair(cameras, options, &offsets, a, b);
        let mut inner =
            |_: Stage, _: f64| report(watch, Stage::Pairs, i as f64 / searched.len() as f64).is_ok();
        let calibration = calibrate_watched(recordings[a], recordings[b], &options, &mut inner)?;
        found.extend(PairFound::of(a, b, &calibration));
    }
    join(cameras, &found, &offsets, watch)
}

/// One offset for each camera.
///
/// # Errors
/// [`Error::Argument`] where the number of given offsets is not that of the cameras, [`Error::Interrupted`].
pub fn clock_offsets(
    recordings: &[&Recording],
    time: &NetworkTime,
    watch: &mut dyn Watch,
) -> Result<Offsets> {
    time.check(recordings.len())?;
    match time {
        NetworkTime::Known(seconds) => Ok(Offsets::given(seconds.clone())),
        NetworkTime::Search { seconds } => {
            let found = pair_offsets(recordings, *seconds, watch)?;
            Ok(agreed(recordings.len(), &found))
        }
    }
}

/// The pairs `a < b` that are searched, of cameras that filmed at the same time for a while: all of few cameras, of many those that are
/// likeliest to see the same.
///
/// # Errors
/// [`Error::Argument`] where there is not an offset for each camera.
pub fn pairs_to_search(recordings: &[&Recording], offsets: &Offsets) -> Result<Vec<(usize, usize)>> {
    let n = recordings.len();
    if offsets.seconds.len() != n {
        return Err(Error::Argument {
            name: "offsets",
            value: offsets.seconds.len().to_string(),
            expected: "an offset for each camera",
        });
    }
    let filmed = |&(a, b): &(usize, usize)| offsets.overlap(a, b, recordings[a], recordings[b]);
    let all: Vec<(usize, usize)> = all_pairs(n).filter(filmed).collect();
    let likely: Vec<(usize, usize, f64)> = if n <= ALL_PAIRS {
        Vec::new()
    } else {
        let of = |&(a, b): &(usize, usize)| {
            let between = offsets.seconds[b] - offsets.seconds[a];
            Ok((a, b, likeness(recordings[a], recordings[b], between)?))
        };
        all.par_iter().map(of).collect::<Result<Vec<_>>>()?
    };
    Ok(chosen(n, &likely).into_iter().filter(|pair| all.contains(pair)).collect())
}

/// Options with which a pair is searched.
fn options_of_pair(
    cameras: &[CameraInput],
    options: &NetworkOptions,
    offsets: &Offsets,
    a: usize,
    b: usize,
) -> CalibrateOptions {
    let pair = with_matrices(options.pairs.clone(), [&cameras[a], &cameras[b]]);
    pair.time_offset(offsets.frames_between(a, b, cameras[b].recording))
}

/// With the matrices of two cameras, where these are known and no lens bends their images.
fn with_matrices(pair: CalibrateOptions, [a, b]: [&CameraInput; 2]) -> CalibrateOptions {
    match (a.known.matrix, b.known.matrix) {
        (Some(p), Some(q)) if a.known.is_undistorted() && b.known.is_undistorted() => {
            match CameraMatrices::new(p, q) {
                Ok(matrices) => pair.cameras(matrices),
                Err(_) => pair,
            }
        }
        _ => pair,
    }
}

/// Two cameras that may or may not have been started together: no other pair can vouch for an offset that barcodes find.
fn unsynchronised(
    cameras: [&CameraInput; 2],
    options: &CalibrateOptions,
    seconds: f64,
    watch: &mut dyn Watch,
) -> Result<Calibration> {
    let [a, b] = cameras.map(|camera| camera.recording);
    let options = with_matrices(options.clone(), cameras).time_offset(TimeOffset::Auto { seconds });
    let mut share = 0.0;
    let mut inner = |stage: Stage, _: f64| {
        if stage == Stage::TimeOffset {
            share = 0.5;
        }
        report(watch, Stage::Pairs, share).is_ok()
    };
    calibrate_watched(a, b, &options, &mut inner)
}

/// Clocks of the two cameras of a pair, whose offset was tried or searched for.
fn offsets_of_pair(second: &Recording, pair: &Calibration) -> Offsets {
    let offset = pair.timing.offset * second.frame_interval();
    Offsets { together: offset == 0.0, ..Offsets::found(vec![0.0, offset]) }
}

fn check(cameras: &[CameraInput]) -> Result<()> {
    let refuse = |value: String, expected| Err(Error::Argument { name: "cameras", value, expected });
    if cameras.len() < 2 {
        return refuse(cameras.len().to_string(), "a network has at least two cameras");
    }
    for (i, camera) in cameras.iter().enumerate() {
        if cameras[..i].iter().any(|other| other.name == camera.name) {
            return refuse(camera.name.to_owned(), "names of cameras that differ");
        }
        camera.known.check()?;
    }
    Ok(())
}
