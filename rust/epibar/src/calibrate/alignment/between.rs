//! Silhouettes between two frames.
//!
//! The hull a share `t` of the way from `P` to `Q` is the Minkowski sum `(1 − t) P ⊕ t Q`: its support function, and so
//! the place of its tangent of every direction, moves in a straight line from that of `P` to that of `Q`.

use super::links::Links;
use crate::recording::Silhouettes;

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

/// `(1 − share) p ⊕ share q` of two convex polygons, both clockwise on the screen, by merging their edges by direction.
fn mixture(p: &[[f64; 2]], q: &[[f64; 2]], share: f64) -> Vec<[f64; 2]> {
    let (p, q) = (from_the_top(p), from_the_top(q));
    let edge = |polygon: &[[f64; 2]], i: usize, scale: f64| {
        let (from, to) = (polygon[i % polygon.len()], polygon[(i + 1) % polygon.len()]);
        [scale * (to[0] - from[0]), scale * (to[1] - from[1])]
    };
    let mut at = [(1.0 - share) * p[0][0] + share * q[0][0], (1.0 - share) * p[0][1] + share * q[0][1]];
    let mut sum = Vec::with_capacity(p.len() + q.len());
    let (mut i, mut j) = (0, 0);
    while i < p.len() || j < q.len() {
        sum.push(at);
        let (u, v) = (edge(&p, i, 1.0 - share), edge(&q, j, share));
        // The edge that turns less comes first; parallel edges are one.
        let turn = if i == p.len() {
            -1.0
        } else if j == q.len() {
            1.0
        } else {
            u[0] * v[1] - u[1] * v[0]
        };
        if turn >= 0.0 {
            at = [at[0] + u[0], at[1] + u[1]];
            i += 1;
        }
        if turn <= 0.0 {
            at = [at[0] + v[0], at[1] + v[1]];
            j += 1;
        }
    }
    sum
}

/// The polygon from its topmost corner on, the left one of two.
fn from_the_top(polygon: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let before = |p: &[f64; 2], q: &[f64; 2]| p[1].total_cmp(&q[1]).then(p[0].total_cmp(&q[0]));
    let first = (0..polygon.len()).min_by(|&i, &j| before(&polygon[i], &polygon[j])).unwrap_or(0);
    (0..polygon.len()).map(|k| polygon[(first + k) % polygon.len()]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn support(polygon: &[[f64; 2]], angle: f64) -> f64 {
        polygon.iter().map(|p| p[0] * angle.cos() + p[1] * angle.sin()).fold(f64::NEG_INFINITY, f64::max)
    }

    #[test]
    fn tangents_move_in_a_straight_line() {
        let p = [[10.0, 4.0], [14.0, 4.0], [18.0, 9.0], [12.0, 15.0], [7.0, 9.0]];
        let q = [[17.0, 7.0], [22.0, 7.0], [22.0, 13.0], [17.0, 13.0]];
        for share in [0.1, 0.5, 0.8] {
            let mixed = mixture(&p, &q, share);
            for k in 0..64 {
                let angle = f64::from(k) * 0.1;
                let expected = (1.0 - share) * support(&p, angle) + share * support(&q, angle);
                assert!((support(&mixed, angle) - expected).abs() < 1e-12, "{share} {angle}");
            }
            // Convex, and clockwise on the screen.
            let n = mixed.len();
            for i in 0..n {
                let (a, b, c) = (mixed[i], mixed[(i + 1) % n], mixed[(i + 2) % n]);
                assert!((b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) > 0.0);
            }
        }
    }
}
