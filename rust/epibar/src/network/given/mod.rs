//! What is known before anything is solved for.
//!
//! * `input`: of each camera: its recording, and what is known of its lens and focal length.
//! * `posed`: a camera with its pose as files state it.
//! * `pair_choice`: which pairs are searched for.
//! * `clock_pairs`: which pairs are asked for the offset between their clocks.
//! * `clocks`: offsets of all clocks from barcodes.
//! * `pair`: what a pair brings: geometries, and the tangents that meet under them.

pub mod clock_pairs;
pub mod clocks;
pub mod input;
pub mod pair;
pub mod pair_choice;
pub mod posed;
