//! Convex polygons, as silhouettes are: extent, axis, chords, and what lies between two of them.
//!
//! Vertices are in order, pixels; clockwise on the screen where it matters.

use crate::image::Homogeneous;

/// Least and greatest coordinate of the vertices along a direction.
pub fn extent(hull: &[[f64; 2]], direction: [f64; 2]) -> [f64; 2] {
    let along = || hull.iter().map(|p| direction[0] * p[0] + direction[1] * p[1]);
    [along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max)]
}

/// The shorter side of the box around a hull, pixels; each vertex is a pixel wide.
pub fn shorter_side(hull: &[[f64; 2]]) -> f64 {
    let [width, height] = box_around(hull);
    width.min(height) + 1.0
}

/// The diagonal of the box around a hull, or around any points, pixels; not finite where there are none.
pub fn diagonal(hull: &[[f64; 2]]) -> f64 {
    let [width, height] = box_around(hull);
    width.hypot(height)
}

/// Sides of the box around the vertices.
fn box_around(hull: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|k| {
        let (low, high) =
            hull.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[k]), h.max(p[k])));
        high - low
    })
}

/// A point inside of a convex polygon: the mean of three of its vertices, picked one after the other.
pub fn mean_of_three(mut vertex: impl FnMut() -> [f64; 2]) -> [f64; 2] {
    let (p, q, r) = (vertex(), vertex(), vertex());
    [(p[0] + q[0] + r[0]) / 3.0, (p[1] + q[1] + r[1]) / 3.0]
}

/// The point a share `at` along the part of the line inside the hull; `None` where the line misses the hull.
pub fn on_chord(hull: &[[f64; 2]], line: &Homogeneous, at: f64) -> Option<[f64; 2]> {
    let distance = |p: &[f64; 2]| line.x * p[0] + line.y * p[1] + line.z;
    let mut ends: Vec<[f64; 2]> = Vec::with_capacity(2);
    for (i, p) in hull.iter().enumerate() {
        let q = &hull[(i + 1) % hull.len()];
        let (dp, dq) = (distance(p), distance(q));
        if (dp > 0.0) != (dq > 0.0) {
            let t = dp / (dp - dq);
            ends.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
        }
    }
    match ends.as_slice() {
        [p, q] => Some([p[0] + at * (q[0] - p[0]), p[1] + at * (q[1] - p[1])]),
        _ => None,
    }
}

/// The direction of the long axis of a polygon at twice its angle, as long as `(λ₁ − λ₂) / (λ₁ + λ₂)` of its second
/// moments; `None` for one without an area.
pub fn doubled_axis(hull: &[[f64; 2]]) -> Option<[f64; 2]> {
    let origin = *hull.first()?;
    // Sums over the triangles from the first vertex: area, first and second moments.
    let (mut area, mut first, mut second) = (0.0, [0.0; 2], [0.0; 3]);
    for edge in hull.windows(2).skip(1) {
        let [p, q] = [0, 1].map(|k| [edge[k][0] - origin[0], edge[k][1] - origin[1]]);
        let cross = p[0] * q[1] - p[1] * q[0];
        area += cross / 2.0;
        for k in 0..2 {
            first[k] += cross * (p[k] + q[k]) / 6.0;
        }
        let product = |i: usize, j: usize| p[i] * p[j] + q[i] * q[j] + 0.5 * (p[i] * q[j] + q[i] * p[j]);
        for (sum, (i, j)) in second.iter_mut().zip([(0, 0), (0, 1), (1, 1)]) {
            *sum += cross * product(i, j) / 12.0;
        }
    }
    let central = |sum: f64, i: usize, j: usize| (sum - first[i] * first[j] / area) / area;
    let (xx, xy, yy) = (central(second[0], 0, 0), central(second[1], 0, 1), central(second[2], 1, 1));
    let trace = xx + yy;
    (trace.is_finite() && trace > 0.0).then(|| [(xx - yy) / trace, 2.0 * xy / trace])
}

/// The hull a share of the way from `p` to `q`, both clockwise on the screen: the Minkowski sum
/// `(1 − share) p ⊕ share q`, by merging their edges by direction.
///
/// Its support function, and so the place of its tangent of every direction, moves in a straight line from that of `p`
/// to that of `q`.
pub fn mixture(p: &[[f64; 2]], q: &[[f64; 2]], share: f64) -> Vec<[f64; 2]> {
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

/// The corners of a hull, clockwise on the screen, moved outward by so many pixels along the middle of the normals of their sides, each with the
/// corner that it was; those that `stay` do not move. Inward a narrow hull moves by a quarter of its width at most, and corners that are none any more go.
pub fn moved_outward(
    hull: &[[f64; 2]],
    outward: f64,
    stays: impl Fn([f64; 2]) -> bool,
) -> Vec<([f64; 2], [f64; 2])> {
    let outward = outward.max(-0.25 * shorter_side(hull));
    let around = |i: usize| (hull[(i + hull.len() - 1) % hull.len()], hull[(i + 1) % hull.len()]);
    let normal = |p: [f64; 2], q: [f64; 2]| unit([q[1] - p[1], p[0] - q[0]]);
    let mut corners: Vec<_> = (0..hull.len())
        .map(|i| {
            let (corner, (before, after)) = (hull[i], around(i));
            if stays(corner) {
                return (corner, corner);
            }
            let (p, q) = (normal(before, corner), normal(corner, after));
            let middle = unit([p[0] + q[0], p[1] + q[1]]);
            ([corner[0] + outward * middle[0], corner[1] + outward * middle[1]], corner)
        })
        .collect();
    while let Some(i) = (0..corners.len()).find(|&i| !is_corner(&corners, i)) {
        corners.remove(i);
    }
    if corners.len() < 3 { hull.iter().map(|&p| (p, p)).collect() } else { corners }
}

fn unit([x, y]: [f64; 2]) -> [f64; 2] {
    let length = x.hypot(y).max(f64::MIN_POSITIVE);
    [x / length, y / length]
}

/// Whether a polygon turns clockwise at its `i`-th corner.
fn is_corner(corners: &[([f64; 2], [f64; 2])], i: usize) -> bool {
    let n = corners.len();
    let [(p, _), (q, _), (r, _)] = [(i + n - 1) % n, i, (i + 1) % n].map(|k| corners[k]);
    (q[0] - p[0]) * (r[1] - q[1]) - (q[1] - p[1]) * (r[0] - q[0]) > 0.0
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

    #[test]
    fn corners_move_along_their_normals() {
        // An octagon about a circle, and a thin triangle.
        let round: Vec<_> = (0..16)
            .map(|k| f64::from(k) * std::f64::consts::TAU / 16.0)
            .map(|angle| [40.0 + 20.0 * angle.cos(), 30.0 + 20.0 * angle.sin()])
            .collect();
        for outward in [-1.5, 0.0, 0.7, 2.0] {
            let moved = moved_outward(&round, outward, |_| false);
            assert_eq!(moved.len(), 16);
            for (k, (p, was)) in moved.iter().enumerate() {
                assert_eq!(*was, round[k]);
                assert!(((p[0] - 40.0).hypot(p[1] - 30.0) - 20.0 - outward).abs() < 1e-9, "{outward}");
            }
        }
        let kept = moved_outward(&round, 1.0, |[x, _]| x > 50.0);
        assert!(kept.iter().all(|(p, was)| (p == was) == (was[0] > 50.0)));
        let thin = [[0.0, 0.0], [2.0, 0.0], [1.0, 60.0]];
        for outward in [-9.0, -0.5, 0.5] {
            let moved: Vec<_> =
                moved_outward(&thin, outward, |_| false).into_iter().map(|(p, _)| p).collect();
            assert_eq!(moved.len(), 3);
            // It neither turns inside out nor moves by more than it is wide.
            let inside = (0..64).map(|k| f64::from(k) * 0.1).all(|angle| {
                let by = support(&moved, angle) - support(&thin, angle);
                (by * outward > -1e-9 || by.abs() < 0.8) && by.abs() < outward.abs().min(0.8) + 1e-9
            });
            assert!(inside, "{outward}: {moved:?}");
        }
    }

    #[test]
    fn a_rectangle_has_the_axis_it_is_drawn_with() {
        for (angle, length, width) in [(0.3f64, 9.0, 2.0), (-1.2, 4.0, 3.0), (2.5, 30.0, 1.0)] {
            let (sin, cos) = angle.sin_cos();
            let corner = |u: f64, v: f64| [70.0 + u * cos - v * sin, 50.0 + u * sin + v * cos];
            let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
            let mut hull: Vec<_> = corners.iter().map(|(u, v)| corner(u * length, v * width)).collect();
            let ratio: f64 = (width / length).powi(2);
            let elongation = (1.0 - ratio) / (1.0 + ratio);
            for _ in 0..2 {
                let [x, y] = doubled_axis(&hull).unwrap();
                assert!((x - elongation * (2.0 * angle).cos()).abs() < 1e-9);
                assert!((y - elongation * (2.0 * angle).sin()).abs() < 1e-9);
                hull.reverse();
            }
        }
        assert!(doubled_axis(&[[1.0, 1.0], [5.0, 3.0]]).is_none());
    }
}
