//! Epipolar tangents of a convex silhouette (Cipolla and Giblin 2000).
//!
//! A plane through both camera centres that touches an object touches it at a frontier point, which both
//! cameras see: there the line through the epipole is tangent to the silhouette in either view.
//!
//! For an epipole `e` and consecutive vertices `v`, `w` of a convex polygon, the sign of `det(e, v, w)` says on which side
//! of the edge the epipole lies; the polygon is touched where this sign changes. Homogeneous `e` makes no
//! difference between near, far and infinite epipoles. Inside the polygon there is no change and no tangent.

use crate::image::Homogeneous;

/// A vertex where a line through the epipole touches a hull.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TangentPoint {
    /// The vertex, pixels.
    pub point: [f64; 2],
    /// `true` where the object lies on the positive side of the oriented line `e × point`.
    pub positive: bool,
}

/// The two tangent points of a convex polygon from `epipole`, or `None` where the epipole is inside or the polygon
/// has fewer than two vertices.
///
/// `hull` in either orientation, without repeated vertices. The first point has the object on its positive side.
pub fn epipolar_tangents(hull: &[[f64; 2]], epipole: &Homogeneous) -> Option<[TangentPoint; 2]> {
    if hull.len() < 2 {
        return None;
    }
    let (ex, ey, ew) = (epipole.x, epipole.y, epipole.z);
    // det(e, v, w) = (e × v) · (w, 1).
    let side = |v: &[f64; 2], w: &[f64; 2]| {
        ex * (v[1] - w[1]) + ey * (w[0] - v[0]) + ew * (v[0] * w[1] - v[1] * w[0])
    };
    let mut previous = side(&hull[hull.len() - 1], &hull[0]) > 0.0;
    let (mut rising, mut falling) = (None, None);
    for (i, v) in hull.iter().enumerate() {
        let next = side(v, &hull[(i + 1) % hull.len()]) > 0.0;
        if next && !previous {
            rising = Some(i);
        } else if previous && !next {
            falling = Some(i);
        }
        previous = next;
    }
    let (rising, falling) = (rising?, falling?);
    // At the rising vertex both the edge in and the edge out turn to the positive side of e × v.
    Some([
        TangentPoint { point: hull[rising], positive: true },
        TangentPoint { point: hull[falling], positive: false },
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// Every vertex on the side that the tangent claims.
    fn check(hull: &[[f64; 2]], e: &Homogeneous) {
        for tangent in epipolar_tangents(hull, e).unwrap() {
            let line = e.cross(&Vector3::new(tangent.point[0], tangent.point[1], 1.0));
            for v in hull {
                let d = line.dot(&Vector3::new(v[0], v[1], 1.0));
                assert!(if tangent.positive { d >= -1e-9 } else { d <= 1e-9 }, "{tangent:?} {v:?} {d}");
            }
        }
    }

    #[test]
    fn tangents_from_everywhere() {
        let hull = [[10.0, 10.0], [20.0, 8.0], [26.0, 15.0], [18.0, 25.0], [9.0, 18.0]];
        let reversed: Vec<_> = hull.iter().rev().copied().collect();
        for e in [
            Vector3::new(0.0, 0.0, 1.0),
            Vector3::new(500.0, 12.0, 1.0),
            Vector3::new(-500.0, -12.0, -1.0),
            Vector3::new(1.0, 0.3, 0.0),
            Vector3::new(15.0, 1e7, 1.0),
        ] {
            check(&hull, &e);
            check(&reversed, &e);
        }
        assert!(epipolar_tangents(&hull, &Vector3::new(16.0, 15.0, 1.0)).is_none());
        assert!(epipolar_tangents(&hull[..1], &Vector3::new(0.0, 0.0, 1.0)).is_none());
    }
}
