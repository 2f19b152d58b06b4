//! Many cameras at once: from recordings, clocks and pairs to one network.
//!
//! In the order of the data, called from [`calibrate_network`] and [`join()`]:
//!
//! * `calibrate`, `join`: the whole job; from recordings, clocks and pairs to one network.
//! * `given`: what is known of each camera before; which pairs are searched, and what they bring; clocks.
//! * `model`: what is solved for, how far two tangents are from meeting, the joint problem over cameras only.
//! * `observations`: outlines of silhouettes, their epipolar tangents under known cameras, and what stands on the floor, at some moments.
//! * `solve`: from the geometries of pairs to networks, and to the world that they stand in.
//! * `evidence`: what speaks for each camera on moments kept aside, and by how much it may be wrong.
//! * `case`, `result`: what a network is made of on its way to the verdict; what comes out.
//! * `verdict`, `thresholds`: the tests by name, in their order, and what is said of each camera, each pair and the whole; the numbers that decide.
//!
//! Of a network that stands:
//!
//! * `check`: whether a camera has moved, and where it stands now.
//! * `add`: one more camera.
//! * `walkers`: who walks, over all cameras and over time.
//!
//! ```no_run
//! use epibar::network::{CameraInput, NetworkOptions, calibrate_network};
//! # fn recordings() -> Vec<epibar::Recording> { Vec::new() }
//!
//! # fn main() -> epibar::Result<()> {
//! let recordings = recordings();
//! let names = ["hall", "door", "stairs"];
//! let cameras: Vec<CameraInput> = names
//!     .iter()
//!     .zip(&recordings)
//!     .map(|(name, recording)| CameraInput::new(name, recording))
//!     .collect();
//! let network = calibrate_network(&cameras, &NetworkOptions::new())?;
//! println!("{}", network.reason);
//! for camera in network.cameras.iter().filter(|c| c.accepted()) {
//!     println!("{}: {:?} {:?}", camera.name, camera.matrix(), camera.position());
//! }
//! # Ok(())
//! # }
//! ```

mod add;
mod calibrate;
mod case;
mod check;
mod evidence;
mod given;
mod join;
mod model;
mod observations;
mod result;
mod solve;
mod thresholds;
mod verdict;
mod walkers;

pub use add::{Added, add_cameras, pairs_to_add};
pub use calibrate::{
    NetworkOptions, NetworkTime, calibrate_network, calibrate_network_watched, clock_offsets, pairs_to_search,
};
pub use check::{StoredCamera, check_network};
pub use evidence::stated_errors::Expected;
pub use evidence::support::Deviates;
pub(crate) use evidence::{stated_errors, support};
pub use given::clocks::Offsets;
pub use given::input::{Aspect, CameraInput, Knowledge};
pub use given::pair::PairFound;
pub use given::posed::PosedCamera;
pub(crate) use given::{clocks, input, pair, pair_choice};
pub use join::join;
pub(crate) use model::optics;
pub use result::{
    CameraCheck, CameraStatus, CheckStatus, Network, NetworkCamera, NetworkPair, PairStatus, Place,
};
pub use solve::world::Ground;
pub use walkers::{TrackPoint, TrackSighting, TrackingCamera, walker_tracks};
