//! Many cameras at once: from recordings, clocks and pairs to one network.
//!
//! In the order of the data: what is known of each camera (`input`), offsets of all clocks (`clocks`), which pairs are
//! searched and what they bring (`graph`), triplets and growth (`start`, `pose`), the joint problem over cameras only (`joint`,
//! `residual`) with tangents found anew under it (`survey`, `ends`, `tangents`, `settle`), cameras tried elsewhere (`relocate`),
//! what speaks for each on moments kept aside (`support`), errors to expect (`covariance`), floor and vertical (`world`),
//! and the `verdict` by its `thresholds`, all called from [`join()`]. Of a network that stands, `tracks` of walkers.
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
mod check_words;
mod clocks;
mod covariance;
mod ends;
mod evenly;
mod graph;
mod input;
mod join;
mod joint;
mod median;
mod moves;
mod observed;
mod pose;
mod principal;
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
mod words;
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
pub use tracks::{TrackPoint, TrackingCamera, walker_tracks};
pub use world::Ground;
