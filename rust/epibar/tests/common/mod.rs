//! What the tests share: masks without geometry, cameras, and a scene of flying boxes.

#![allow(dead_code, reason = "every test is a crate of its own and uses a part of this")]

pub mod cameras;
pub mod flying;
pub mod masks;
