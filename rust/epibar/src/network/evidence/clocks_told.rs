//! Does what moves tell the clocks that nobody gave?
//!
//! Where all moves one way at one speed, a camera that filmed later sees what one sees that stands further on, in every pair and round every cycle: a network
//! fits with clocks and places that are wrong alike. So it is asked of pairs by their own geometries, which follow other clocks
//! ([`other_clocks`](crate::verify::other_clocks)).

use rayon::prelude::*;

use crate::clock::{Aligned, Clock};
use crate::frontier::Up;
use crate::geometry::Fundamental;
use crate::image::ImageSize;
use crate::network::given::input::CameraInput;
use crate::network::given::pair::PairFound;
use crate::network::observations::evenly::evenly;
use crate::network::thresholds as limits;
use crate::recording::tracker::Links;
use crate::verify::other_clocks::other_clocks;

/// Pairs that are asked, at the most.
const PAIRS: usize = 24;

/// Of each camera whether what moves leaves its clock open in half or more of those of some pairs that it is in.
pub fn left_open(inputs: &[CameraInput], pairs: &[&PairFound]) -> Vec<bool> {
    let asked: Vec<&PairFound> = evenly(pairs.len(), PAIRS).map(|k| pairs[k]).collect();
    let open: Vec<bool> = asked.par_iter().map(|pair| is_open(inputs, pair)).collect();
    let of = |camera: usize| {
        let own = asked.iter().zip(&open).filter(move |(p, _)| p.a == camera || p.b == camera);
        let (count, open) = (own.clone().count(), own.filter(|(_, open)| **open).count());
        open > 0 && 2 * open >= count
    };
    (0..inputs.len()).map(of).collect()
}

/// Whether another clock has a geometry of its own that explains as much of what a pair sees.
fn is_open(inputs: &[CameraInput], pair: &PairFound) -> bool {
    let [a, b] = [pair.a, pair.b].map(|c| inputs[c].recording);
    let Some(f) = Fundamental::from_matrix(&pair.geometries[0].0, a.size(), b.size()) else { return false };
    let (clock, links) = (Clock::of_frames(pair.offset, pair.frames_per_frame, a, b), Links::new(b));
    let later = |frames| Aligned::new(a, b, &links, clock.later(frames), [Up::IMAGE; 2]);
    let pixels = limits::CLOCK_OPEN * ImageSize::pixel_scale([a.size(), b.size()]);
    other_clocks(later, &f, None, 0).iter().any(|other| other.is_open(pixels))
}
