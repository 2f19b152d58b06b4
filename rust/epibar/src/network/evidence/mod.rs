//! What speaks for a network that was solved for, and how wrong it may be.
//!
//! * `support`: what speaks for each camera on moments kept aside.
//! * `knocks`, `slight_knocks`: was a camera knocked far while it filmed, or turned a little at half time?
//! * `outlines`: by how much outlines of each camera are wrong.
//! * `covariance`: how well all is known together.
//! * `stated_errors`: errors to expect of each camera.
//! * `cheirality`: do rays that meet do so before their cameras?
//! * `planes`: where all keeps to a plane, is it the same to all pairs?
//! * `parallax`: do rays of a camera meet those of others at an angle?
//! * `relief`: how far from one plane is all that is seen, where nothing tells focal lengths?
//! * `floor_errors`: by how much the floor is wrong since cameras are.
//! * `alternatives`: networks in which something that was given is solved for after all.
//! * `contradictions`: does what was given of a camera agree with what moves?
//! * `clocks_by_motion`: does what moves tell the clocks that nobody gave?
//! * `doubts`: how much what was given may be wrong without being contradicted.

pub mod alternatives;
pub mod cheirality;
pub mod clocks_by_motion;
pub mod contradictions;
pub mod covariance;
pub mod doubts;
pub mod floor_errors;
pub mod knocks;
pub mod outlines;
pub mod parallax;
pub mod planes;
pub mod relief;
pub mod slight_knocks;
pub mod stated_errors;
pub mod support;
