//! Does what moves tell the clocks, where nobody gave them, and does it bear those out that were given?
//!
//! Where all moves one way at one speed, a camera that filmed later sees what one sees that stands further on, in every pair and round every cycle: a network
//! fits with clocks and places that are wrong alike. So it is asked of pairs by their own geometries, which follow other clocks
//! ([`other_clocks`](crate::verify::other_clocks)). A clock that was given decides between such; but not where another one explains clearly more.

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

/// What is to be said of a camera's clock, by half or more of those of some pairs that it is in.
#[derive(Debug, Clone, Copy)]
pub struct ClockByMotion {
    /// What moves leaves it open.
    pub open: bool,
    /// What moves speaks against it.
    pub refuted: bool,
}

/// Of each camera what moves tells of its clock.
pub fn clocks_by_motion(inputs: &[CameraInput], pairs: &[&PairFound]) -> Vec<ClockByMotion> {
    let asked: Vec<&PairFound> = evenly(pairs.len(), PAIRS).map(|k| pairs[k]).collect();
    let of_pairs: Vec<ClockByMotion> = asked.par_iter().map(|pair| by_pair(inputs, pair)).collect();
    let half_of = |camera: usize, says: fn(&ClockByMotion) -> bool| {
        let own = asked.iter().zip(&of_pairs).filter(move |(p, _)| p.a == camera || p.b == camera);
        let (count, say_so) = (own.clone().count(), own.filter(|(_, clock)| says(clock)).count());
        say_so > 0 && 2 * say_so >= count
    };
    let of = |camera| ClockByMotion {
        open: half_of(camera, |clock| clock.open),
        refuted: half_of(camera, |clock| clock.refuted),
    };
    (0..inputs.len()).map(of).collect()
}

/// Whether another clock has a geometry of its own that explains as much of what a pair sees, and one that clearly explains more.
fn by_pair(inputs: &[CameraInput], pair: &PairFound) -> ClockByMotion {
    let [a, b] = [pair.a, pair.b].map(|c| inputs[c].recording);
    let Some(f) = Fundamental::from_matrix(&pair.geometries[0].0, a.size(), b.size()) else {
        return ClockByMotion { open: false, refuted: false };
    };
    let (clock, links) = (Clock::of_frames(pair.offset, pair.frames_per_frame, a, b), Links::new(b));
    let later = |frames| Aligned::new(a, b, &links, clock.later(frames), [Up::IMAGE; 2]);
    let pixels = limits::CLOCK_OPEN * ImageSize::pixel_scale([a.size(), b.size()]);
    let others = other_clocks(later, &f, None, 0);
    ClockByMotion {
        open: others.iter().any(|other| other.is_open(pixels)),
        refuted: others.iter().any(|other| other.is_better(pixels)),
    }
}
