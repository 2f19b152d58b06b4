//! More lines where lines inform.
//!
//! Border-to-border lines are drawn before anything is known of the scene, and under low cameras three in four
//! are uninformative: everything moves in one band of the image. Silhouettes give the barcode of *any* line (a line
//! meets a connected component exactly when it meets its convex hull), so more lines can be drawn afterwards, near
//! those that turned out informative: one of them is picked, and both ends are moved along the border.

use pulp::{Arch, Simd, WithSimd};
use rand::RngExt;
use rayon::prelude::*;

use crate::estimate::ransac::generator;
use crate::line::{ImageSize, Line, Segment};
use crate::recording::{Barcodes, Recording, Silhouettes};

/// How far an end moves at most, as a share of the border.
const REACH: f64 = 0.06;
/// A hull this near a line is met by the pixels of the line (half a pixel along the minor axis at most).
const HALF_WIDTH: f64 = 0.35;

/// Hulls with the circles around them, which most lines miss, frame after frame.
struct Discs {
    frame: Vec<u32>,
    x: Vec<f64>,
    y: Vec<f64>,
    /// How near a line comes that may meet the hull.
    reach: Vec<f64>,
    /// For each hull its first vertex, and the number of vertices as the last entry.
    start: Vec<u32>,
    vertices_x: Vec<f64>,
    vertices_y: Vec<f64>,
}

impl Discs {
    /// The hulls of some frames of a recording.
    fn new(silhouettes: &Silhouettes, frames: &[u32]) -> Self {
        let mut discs = Self {
            frame: Vec::new(),
            x: Vec::new(),
            y: Vec::new(),
            reach: Vec::new(),
            start: vec![0],
            vertices_x: Vec::new(),
            vertices_y: Vec::new(),
        };
        for (frame, &recorded) in frames.iter().enumerate() {
            for hull in silhouettes.hulls(recorded as usize).map(|h| silhouettes.hull(h)) {
                discs.push(frame as u32, hull);
            }
        }
        discs
    }

    fn push(&mut self, frame: u32, hull: &[[u16; 2]]) {
        let n = hull.len().max(1) as f64;
        let x = hull.iter().map(|p| f64::from(p[0])).sum::<f64>() / n;
        let y = hull.iter().map(|p| f64::from(p[1])).sum::<f64>() / n;
        let radius =
            hull.iter().map(|p| (f64::from(p[0]) - x).hypot(f64::from(p[1]) - y)).fold(0.0, f64::max);
        self.frame.push(frame);
        self.x.push(x);
        self.y.push(y);
        self.reach.push(radius + HALF_WIDTH);
        self.vertices_x.extend(hull.iter().map(|p| f64::from(p[0])));
        self.vertices_y.extend(hull.iter().map(|p| f64::from(p[1])));
        self.start.push(self.vertices_x.len() as u32);
    }
}

/// The barcode of a line, from hulls.
struct MetHulls<'a> {
    discs: &'a Discs,
    line: &'a Line,
    words: usize,
}

impl WithSimd for MetHulls<'_> {
    type Output = Vec<u64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Vec<u64> {
        let Self { discs, line, words } = self;
        let n = discs.frame.len();
        let (x, y, reach) = (&discs.x[..n], &discs.y[..n], &discs.reach[..n]);
        let mut near = vec![false; n];
        for i in 0..n {
            near[i] = line.signed_distance(x[i], y[i]).abs() <= reach[i];
        }
        let mut row = vec![0u64; words];
        for i in (0..n).filter(|&i| near[i]) {
            let (start, end) = (discs.start[i] as usize, discs.start[i + 1] as usize);
            let (mut below, mut above) = (false, false);
            for (x, y) in discs.vertices_x[start..end].iter().zip(&discs.vertices_y[start..end]) {
                let distance = line.signed_distance(*x, *y);
                below |= distance <= HALF_WIDTH;
                above |= distance >= -HALF_WIDTH;
            }
            let frame = discs.frame[i] as usize;
            row[frame / 64] |= u64::from(below & above) << (frame % 64);
        }
        row
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
    let discs = Discs::new(&recording.silhouettes, frames);
    let arch = Arch::new();
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
            let row = arch.dispatch(MetHulls { discs: &discs, line: &line, words: words_per });
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
