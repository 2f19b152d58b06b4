//! More lines where lines inform.
//!
//! Border-to-border lines are drawn before anything is known of the scene, and under low cameras three in four
//! are uninformative: everything moves in one band of the image. Silhouettes give the barcode of *any* line (a line
//! meets a connected component exactly when it meets its convex hull), so more lines can be drawn afterwards, near
//! those that turned out informative: one of them is picked, and both ends are moved along the border.

use rand::RngExt;
use rayon::prelude::*;

use crate::estimate::ransac::generator;
use crate::line::{ImageSize, Segment};
use crate::recording::{Barcodes, Recording};

/// How far an end moves at most, as a share of the border.
const REACH: f64 = 0.06;
/// A hull this near a line is met by the pixels of the line (half a pixel along the minor axis at most).
const HALF_WIDTH: f64 = 0.35;

/// A hull with the circle around it, which most lines miss.
struct Disc<'a> {
    x: f64,
    y: f64,
    radius: f64,
    hull: &'a [[u16; 2]],
}

impl<'a> Disc<'a> {
    fn new(hull: &'a [[u16; 2]]) -> Self {
        let n = hull.len().max(1) as f64;
        let x = hull.iter().map(|p| f64::from(p[0])).sum::<f64>() / n;
        let y = hull.iter().map(|p| f64::from(p[1])).sum::<f64>() / n;
        let radius =
            hull.iter().map(|p| (f64::from(p[0]) - x).hypot(f64::from(p[1]) - y)).fold(0.0, f64::max);
        Self { x, y, radius, hull }
    }
}

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
    let silhouettes = &recording.silhouettes;
    let discs: Vec<Vec<Disc>> = frames
        .iter()
        .map(|&t| silhouettes.hulls(t as usize).map(|h| Disc::new(silhouettes.hull(h))).collect())
        .collect();
    let words_per = frames.len().div_ceil(64);
    let found: Vec<(Segment, Vec<u64>)> = (0..if rows.is_empty() { 0 } else { count })
        .into_par_iter()
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
            let line = segment.line().filter(|_| !same_side)?;
            let mut row = vec![0u64; words_per];
            for (t, discs) in discs.iter().enumerate() {
                let met = discs.iter().any(|disc| {
                    let centre = line.signed_distance(disc.x, disc.y).abs();
                    if centre > disc.radius + HALF_WIDTH {
                        return false;
                    }
                    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                    for p in disc.hull {
                        let d = line.signed_distance(f64::from(p[0]), f64::from(p[1]));
                        low = low.min(d);
                        high = high.max(d);
                    }
                    low <= HALF_WIDTH && high >= -HALF_WIDTH
                });
                row[t / 64] |= u64::from(met) << (t % 64);
            }
            Some((segment, row))
        })
        .collect();
    let mut barcodes = Barcodes::zeros(found.len(), frames.len());
    let mut segments = Vec::with_capacity(found.len());
    for (k, (segment, row)) in found.into_iter().enumerate() {
        segments.push(segment);
        barcodes.bits[k * words_per..(k + 1) * words_per].copy_from_slice(&row);
    }
    (segments, barcodes)
}
