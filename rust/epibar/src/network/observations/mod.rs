//! What cameras saw at the same moments, and what of it meets under given cameras.
//!
//! * `observed`: outlines of silhouettes in raw pixels.
//! * `ends`: the two planes through both cameras between which a silhouette lies.
//! * `tangents`: epipolar tangents that meet in a pair.
//! * `figures`: what stands upright.
//! * `floor`: the plane on which it stands.
//! * `evenly`: some of many moments.
//! * `time_parts`: parts of the time in which something is compared.
//! * `survey`: all of that, over all pairs.

pub mod ends;
pub mod evenly;
pub mod figures;
pub mod floor;
pub mod observed;
pub mod survey;
pub mod tangents;
pub mod time_parts;
