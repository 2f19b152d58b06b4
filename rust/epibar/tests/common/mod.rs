//! What the tests share: masks without geometry, cameras, and a scene of flying boxes.

#![allow(dead_code, reason = "every test is a crate of its own and uses a part of this")]

pub mod cameras;
pub mod flying;
pub mod masks;
pub mod ring;

use epibar::internals::FramePair;

/// The first frames of both cameras, each with the one of the same number.
pub fn pairs(frames: u32) -> Vec<FramePair> {
    (0..frames).map(|k| FramePair::new(k, k)).collect()
}
