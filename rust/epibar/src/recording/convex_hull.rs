//! Convex hull of a component (Andrew's monotone chain over the ends of its rows).
//!
//! A line meets a connected component exactly when it meets its convex hull, so the hull is all that
//! lines and tangents need of a silhouette. Vertices are pixel centres: the hull is that of the
//! centres, half a pixel inside the outline of the pixels.

use super::components::Run;

/// Appends the hull of a component's runs, which are in raster order, to `points`.
///
/// Vertices `[x, y]` start at the left end of the top row and go clockwise as seen on the screen (y
/// down): the sum of xᵢ·yᵢ₊₁ − xᵢ₊₁·yᵢ is positive. Each is a strict corner: points on
/// an edge are left out. A single pixel is one vertex, pixels on one straight line are two.
pub fn convex_hull(runs: &[Run], points: &mut Vec<[u16; 2]>) {
    let Some(first) = runs.first() else { return };
    let start = points.len();
    points.push([first.x_first, first.y]);
    let rows = || runs.chunk_by(|a, b| a.y == b.y);
    // Down the right side, and from the lowest right end up the left side, to the start again.
    let mut base = start;
    for row in rows() {
        let run = row[row.len() - 1];
        extend(points, base, [run.x_last, run.y]);
    }
    base = points.len() - 1;
    for row in rows().rev() {
        extend(points, base, [row[0].x_first, row[0].y]);
    }
    if points.len() > start + 1 {
        points.pop();
    }
}

/// Adds a vertex to the chain that begins at `base`, removing those that are no corners any more.
fn extend(points: &mut Vec<[u16; 2]>, base: usize, point: [u16; 2]) {
    while points.len() > base + 1 && turn(points[points.len() - 2], points[points.len() - 1], point) <= 0 {
        points.pop();
    }
    if points[points.len() - 1] != point {
        points.push(point);
    }
}

/// Positive where a → b → c turns right on the screen, zero where it is straight.
fn turn(a: [u16; 2], b: [u16; 2], c: [u16; 2]) -> i64 {
    let [(ax, ay), (bx, by), (cx, cy)] = [a, b, c].map(|[x, y]| (i64::from(x), i64::from(y)));
    (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hull(runs: &[(u16, u16, u16)]) -> Vec<[u16; 2]> {
        let runs: Vec<Run> = runs.iter().map(|&(y, x_first, x_last)| Run { y, x_first, x_last }).collect();
        let mut points = vec![[77, 77]];
        convex_hull(&runs, &mut points);
        assert_eq!(points[0], [77, 77], "what was there stays");
        points.split_off(1)
    }

    #[test]
    fn degenerate_hulls() {
        assert!(hull(&[]).is_empty());
        assert_eq!(hull(&[(5, 3, 3)]), [[3, 5]]);
        assert_eq!(hull(&[(5, 3, 8)]), [[3, 5], [8, 5]]);
        assert_eq!(hull(&[(5, 3, 3), (6, 3, 3), (7, 3, 3)]), [[3, 5], [3, 7]]);
        assert_eq!(hull(&[(5, 3, 3), (6, 2, 2), (7, 1, 1)]), [[3, 5], [1, 7]]);
    }

    #[test]
    fn clockwise_from_the_top_left() {
        // A U, whose gap is inside the hull, with a point below.
        let u = [(1, 2, 3), (1, 7, 8), (2, 2, 3), (2, 7, 8), (3, 2, 8), (4, 5, 5)];
        assert_eq!(hull(&u), [[2, 1], [8, 1], [8, 3], [5, 4], [2, 3]]);
        assert_eq!(hull(&[(0, 2, 2), (1, 1, 3), (2, 0, 4)]), [[2, 0], [4, 2], [0, 2]]);
    }
}
