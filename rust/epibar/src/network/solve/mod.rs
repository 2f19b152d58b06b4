//! From the geometries of pairs to cameras in a world.
//!
//! * `start`: triplets and growth: where the joint problem starts.
//! * `settle`: tangents found anew and the joint problem, in turns.
//! * `relocate`: cameras tried elsewhere.
//! * `collapse`: cameras that a solution has put at one place.
//! * `networks`: all three, for the best network and its rivals.
//! * `principal`: how far principal points are from the middle.
//! * `world`: floor, vertical and unit.

pub mod collapse;
pub mod networks;
pub mod principal;
pub mod relocate;
pub mod settle;
pub mod start;
pub mod world;
