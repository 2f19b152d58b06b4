//! Silhouettes between two frames, drawn from those that are linked ([`mixture`]).

use crate::geometry::hull::mixture;
use crate::recording::Silhouettes;
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
    let still = |h: usize| Hull { vertices: corners(h), first: h, last: h };
    if share == 0.0 {
        return silhouettes.hulls(frame).filter(usable).map(still).collect();
    }
    let mut found = Vec::new();
    for h in silhouettes.hulls(frame).filter(usable) {
        match links.next(h).filter(usable) {
            Some(k) => {
                found.push(Hull { vertices: mixture(&corners(h), &corners(k), share), first: h, last: k });
            }
            None if share < 0.5 => found.push(still(h)),
            None => (),
        }
    }
    if share >= 0.5 {
        let new = silhouettes.hulls(frame + 1).filter(usable);
        let followed = |k: usize| links.previous(k).is_some_and(|h| usable(&h));
        found.extend(new.filter(|&k| !followed(k)).map(still));
    }
    found
}
