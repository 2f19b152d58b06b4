//! Silhouettes between two frames, drawn from those that are linked ([`mixture`]).

use crate::geometry::hull::mixture;
use crate::recording::Silhouettes;
use crate::recording::at_moment::{Between, at_moment};
use crate::recording::tracker::Links;

/// A silhouette at a position between frames.
#[derive(Debug, Clone)]
pub struct Hull {
    /// Corners, pixels, clockwise on the screen.
    pub vertices: Vec<[f64; 2]>,
    /// The hull in the frame before (or at) the position, and that in the frame after; one of them where there is no
    /// link.
    pub first: usize,
    /// See `first`.
    pub last: usize,
}

/// The silhouettes at a position, in frames. One that is not followed to the other frame stands still in the nearer.
///
/// # Panics
/// If the position is outside the recording.
pub fn hulls(silhouettes: &Silhouettes, links: &Links, position: f64) -> Vec<Hull> {
    let (frame, share) = (position.floor() as usize, position.fract());
    let corners =
        |h: usize| -> Vec<[f64; 2]> { silhouettes.hull(h).iter().map(|p| p.map(f64::from)).collect() };
    let usable = |h: &usize| silhouettes.hull(*h).len() >= 3;
    let there = if share == 0.0 { 0..0 } else { silhouettes.hulls(frame + 1) };
    let all = at_moment(
        silhouettes.hulls(frame).filter(usable),
        there.filter(usable),
        |h| links.next(h).filter(usable),
        |h| links.previous(h).filter(usable),
        share,
    );
    let drawn = |Between { first, last, share }| {
        let vertices = match share {
            0.0 => corners(first),
            share => mixture(&corners(first), &corners(last), share),
        };
        Hull { vertices, first, last }
    };
    all.map(drawn).collect()
}
