//! How much of its hull a silhouette fills: 0.5 to 0.9 of people and animals, 1 of boxes, ellipses and balls.

use super::silhouettes::Silhouettes;
use crate::geometry::median::median;

/// Silhouettes of fewer pixels say nothing of their shape.
const SHAPELY: u32 = 150;
/// Most silhouettes that are looked at.
const MOST: usize = 2000;

/// Median share of the pixels of a hull that are the silhouette's, of those that are large enough to tell, evenly over time; NaN of none.
pub fn fill(silhouettes: &Silhouettes) -> f64 {
    let large = shapely(silhouettes, |_| true);
    median(large.into_iter().map(|hull| filled(silhouettes, hull))).unwrap_or(f64::NAN)
}

/// Silhouettes that are large enough to tell their shape, and asked for, evenly over time.
pub(super) fn shapely(silhouettes: &Silhouettes, asked: impl Fn(usize) -> bool) -> Vec<usize> {
    let is_shapely = |&i: &usize| silhouettes.area(i) >= SHAPELY && asked(i);
    let all: Vec<usize> = (0..silhouettes.len()).filter(is_shapely).collect();
    let step = all.len().div_ceil(MOST).max(1);
    all.into_iter().step_by(step).collect()
}

/// The share of the pixels of a hull that are the silhouette's.
pub(super) fn filled(silhouettes: &Silhouettes, hull: usize) -> f64 {
    f64::from(silhouettes.area(hull)) / pixels_of(silhouettes.hull(hull))
}

/// Pixels in and on a convex polygon with corners at pixels (Pick's theorem).
pub(super) fn pixels_of(corners: &[[u16; 2]]) -> f64 {
    let (mut twice, mut on_edge) = (0i64, 0i64);
    for (k, p) in corners.iter().enumerate() {
        let q = corners[(k + 1) % corners.len()];
        let [x, y, u, v] = [p[0], p[1], q[0], q[1]].map(i64::from);
        twice += x * v - u * y;
        let (mut m, mut n) = ((u - x).abs(), (v - y).abs());
        while n > 0 {
            (m, n) = (n, m % n);
        }
        on_edge += m;
    }
    0.5 * twice.abs() as f64 + 0.5 * on_edge as f64 + 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_of_polygons_are_those_of_their_corners_and_edges_too() {
        assert_eq!(pixels_of(&[[2, 1], [5, 1], [5, 3], [2, 3]]), 12.0);
        assert_eq!(pixels_of(&[[0, 0], [4, 0], [0, 4]]), 15.0);
    }

    #[test]
    fn boxes_fill_their_hulls_and_what_is_too_small_is_not_asked() {
        // Squares of 20 by 20 pixels, of which so many are the silhouette's, and one of four.
        let of = |area: u32| Silhouettes {
            frame_start: vec![0, 2],
            hull_start: vec![0, 4, 8],
            points: vec![[5, 5], [24, 5], [24, 24], [5, 24], [0, 0], [1, 0], [1, 1], [0, 1]],
            area: vec![area, 4],
            border: vec![false; 2],
            outline_start: vec![0],
            outline_points: Vec::new(),
        };
        assert_eq!(fill(&of(400)), 1.0);
        assert_eq!(fill(&of(260)), 0.65);
        assert!(fill(&of(100)).is_nan());
    }
}
