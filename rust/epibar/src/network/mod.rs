//! Many cameras at once: from recordings, clocks and pairs to one network.
//!
//! In the order of the data, called from [`calibrate_network`] and [`join()`]:
//!
//! * `calibrate`, `join`: the whole job; from recordings, clocks and pairs to one network.
//! * `input`, `stated`: what is known of each camera before; a camera as files state it.
//! * `clocks`: offsets of all clocks from barcodes.
//! * `graph`: which pairs are searched, and what they bring.
//! * `case`, `observed`: what is given, in one place; outlines of silhouettes in raw pixels.
//! * `camera`, `optics`, `residual`, `joint`: what is solved for; where its pixels look; how far two tangents are from meeting; the
//!   joint problem over cameras only.
//! * `pose`, `start`: relative poses, triplets and growth.
//! * `ends`, `tangents`, `walkers`, `survey`: epipolar tangents under known cameras, and what stands on the floor, found at some moments.
//! * `settle`, `relocate`, `solve`: tangents found anew and the joint problem in turns; cameras tried elsewhere; from pairs to networks.
//! * `support`: what speaks for each camera on moments kept aside.
//! * `halves`: was a camera turned a little at half time?
//! * `principal`: how far principal points are from the middle.
//! * `covariance`, `outlines`: errors to expect; by how much outlines of each camera are wrong.
//! * `world`: floor, vertical and unit.
//! * `verdict`, `thresholds`, `prose`: what is said of each camera; the numbers that decide; sentences.
//! * `result`: what comes out.
//! * `evenly`: some of many.
//!
//! Of a network that stands:
//!
//! * `check`, `stretch`, `moves`, `zoom`, `suspects`: whether a camera has moved, by new footage, parts of it, other poses, other focal
//!   lengths, and what each explains.
//! * `replace`, `check_prose`: where it stands now; sentences.
//! * `tracks`: walkers over time.
//!
//! ```no_run
//! use epibar::network::{CameraInput, Knowledge, NetworkOptions, calibrate_network};
//! # fn recordings() -> Vec<epibar::Recording> { Vec::new() }
//!
//! # fn main() -> epibar::Result<()> {
//! let recordings = recordings();
//! let names = ["hall", "door", "stairs"];
//! let cameras: Vec<CameraInput> = names
//!     .iter()
//!     .zip(&recordings)
//!     .map(|(name, recording)| CameraInput { name, recording, known: Knowledge::default() })
//!     .collect();
//! let network = calibrate_network(&cameras, &NetworkOptions::new())?;
//! println!("{}", network.reason);
//! for camera in network.cameras.iter().filter(|c| c.accepted()) {
//!     println!("{}: {:?} {:?}", camera.name, camera.matrix(), camera.position());
//! }
//! # Ok(())
//! # }
//! ```

mod calibrate;
mod camera;
mod case;
mod check;
mod check_prose;
mod clocks;
mod covariance;
mod ends;
mod evenly;
mod graph;
mod halves;
mod input;
mod join;
mod joint;
mod moves;
mod observed;
mod optics;
mod outlines;
mod pose;
mod principal;
mod prose;
mod relocate;
mod replace;
mod residual;
mod result;
mod settle;
mod solve;
mod start;
mod stated;
mod stretch;
mod support;
mod survey;
mod suspects;
mod tangents;
mod thresholds;
mod tracks;
mod verdict;
mod walkers;
mod world;
mod zoom;

pub use calibrate::{
    NetworkOptions, NetworkTime, calibrate_network, calibrate_network_watched, clock_offsets, pairs_to_search,
};
pub use check::{StoredCamera, check_network};
pub use clocks::Offsets;
pub use covariance::Expected;
pub use graph::PairFound;
pub use input::{Aspect, CameraInput, Knowledge};
pub use join::join;
pub use result::{
    CameraCheck, CameraStatus, CheckStatus, Network, NetworkCamera, NetworkPair, PairStatus, Place,
};
pub use support::Deviates;
pub use tracks::{TrackPoint, TrackSighting, TrackingCamera, walker_tracks};
pub use world::Ground;
