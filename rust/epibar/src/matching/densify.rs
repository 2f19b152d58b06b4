//! More lines where lines inform.
//!
//! Border-to-border lines are drawn before anything is known of the scene, and under low cameras three in four
//! are uninformative: everything moves in one band of the image. Silhouettes give the barcode of *any* line (a line
//! meets a connected component exactly when it meets its convex hull), so more lines can be drawn afterwards, near
//! those that turned out informative: one of them is picked, and both ends are moved along the border.

use rand::RngExt;

use super::hull_barcodes::hull_barcodes;
use crate::image::{ImageSize, Line, Segment};
use crate::random::generator;
use crate::recording::{Barcodes, Recording};

/// How far an end moves at most, as a share of the border.
const REACH: f64 = 0.06;

/// Position along the border, clockwise from the top left corner, 0 to 1, and back.
fn border_point(at: f64, size: ImageSize) -> [f64; 2] {
    let (w, h) = (size.x_max(), size.y_max());
    let along = at.rem_euclid(1.0) * 2.0 * (w + h);
    let [x, y] = match along {
        s if s < w => [s, 0.0],
        s if s < w + h => [w, s - w],
        s if s < 2.0 * w + h => [2.0 * w + h - s, h],
        s => [0.0, 2.0 * (w + h) - s],
    };
    [x.round(), y.round()]
}

fn border_position(p: [f64; 2], size: ImageSize) -> f64 {
    let (w, h) = (size.x_max(), size.y_max());
    let along = if p[1] <= 0.0 {
        p[0]
    } else if p[0] >= w {
        w + p[1]
    } else if p[1] >= h {
        2.0 * w + h - p[0]
    } else {
        2.0 * (w + h) - p[1]
    };
    along / (2.0 * (w + h))
}

/// `count` more lines near the informative ones in `rows`, with their barcodes over `frames`.
pub(crate) fn more_lines(
    recording: &Recording,
    rows: &[u32],
    frames: &[u32],
    count: usize,
    seed: u64,
) -> (Vec<Segment>, Barcodes) {
    let size = recording.size;
    let (segments, lines): (Vec<Segment>, Vec<Line>) = (0..if rows.is_empty() { 0 } else { count })
        .filter_map(|k| {
            let mut random = generator(seed, k as u64);
            let near = recording.segments[rows[random.random_range(0..rows.len())] as usize];
            let mut moved = |p: [f64; 2]| {
                let by = REACH * (2.0 * random.random::<f64>() - 1.0);
                border_point(border_position(p, size) + by, size)
            };
            let ([x0, y0], [x1, y1]) = (moved([near.x0, near.y0]), moved([near.x1, near.y1]));
            let segment = Segment { x0, y0, x1, y1 };
            // Both ends on one side make no line through the image.
            let same_side = (x0 == x1 && (x0 == 0.0 || x0 == size.x_max()))
                || (y0 == y1 && (y0 == 0.0 || y0 == size.y_max()));
            Some((segment, segment.line().filter(|_| !same_side)?))
        })
        .unzip();
    let barcodes = hull_barcodes(&recording.silhouettes, frames, &lines);
    (segments, barcodes)
}
