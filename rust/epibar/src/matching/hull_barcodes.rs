//! Barcodes of any lines, from hulls.
//!
//! A line meets a hull if vertices lie on both of its sides. How far a hull reaches to both sides of its centre is tabulated
//! for one direction, and lines of nearly that direction are compared with the table: only hulls that end very near the line
//! are looked at vertex by vertex.

use std::f64::consts::TAU;

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use crate::bits_of_bytes::{ones_of, word_of};
use crate::geometry::hull::mean_of_three;
use crate::image::{Homogeneous, Line};
use crate::recording::{Barcodes, Silhouettes};

/// A hull this near a line is met by the pixels of the line (half a pixel along the minor axis at most).
const HALF_WIDTH: f64 = 0.35;
/// Directions of lines that have a table of their own, fewest and most: a table pays where some tens of lines share it.
const DIRECTIONS: [usize; 2] = [16, 256];
/// About so many lines share a table.
const SHARED: usize = 32;
/// Share of coordinates that rounding may cost a distance, generously.
const ROUNDING: f64 = 16.0 * f32::EPSILON as f64;
/// Hulls whose bits are one word.
const WORD: usize = 64;

/// Hulls, frame after frame.
#[derive(Default)]
pub(super) struct Hulls {
    frame: Vec<u32>,
    /// Its centre: the mean of the vertices, rounded.
    x: Vec<f32>,
    y: Vec<f32>,
    /// Largest distance of a vertex from the centre.
    radius: Vec<f64>,
    /// For each hull its first vertex, and the number of vertices as the last entry.
    start: Vec<u32>,
    vertices_x: Vec<f64>,
    vertices_y: Vec<f64>,
}

impl Hulls {
    /// The hulls of some frames of a recording.
    pub(super) fn new(silhouettes: &Silhouettes, frames: &[u32]) -> Self {
        let mut hulls = Self { start: vec![0], ..Self::default() };
        for (frame, &recorded) in frames.iter().enumerate() {
            for hull in silhouettes.hulls(recorded as usize).map(|h| silhouettes.hull(h)) {
                hulls.push(frame as u32, hull);
            }
        }
        hulls
    }

    fn push(&mut self, frame: u32, hull: &[[u16; 2]]) {
        let n = hull.len().max(1) as f64;
        let mean = |k: usize| (hull.iter().map(|p| f64::from(p[k])).sum::<f64>() / n) as f32;
        let (x, y) = (mean(0), mean(1));
        let from_centre =
            |p: &[u16; 2]| (f64::from(p[0]) - f64::from(x)).hypot(f64::from(p[1]) - f64::from(y));
        let radius = hull.iter().map(from_centre).fold(0.0, f64::max);
        self.frame.push(frame);
        self.x.push(x);
        self.y.push(y);
        self.radius.push(radius);
        self.vertices_x.extend(hull.iter().map(|p| f64::from(p[0])));
        self.vertices_y.extend(hull.iter().map(|p| f64::from(p[1])));
        self.start.push(self.vertices_x.len() as u32);
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.frame.len()
    }

    /// A point inside of one, by three vertices that are picked of so many.
    pub(super) fn inside(&self, hull: usize, mut pick: impl FnMut(usize) -> usize) -> Homogeneous {
        let (first, end) = (self.start[hull] as usize, self.start[hull + 1] as usize);
        let [x, y] = mean_of_three(|| {
            let vertex = first + pick(end - first);
            [self.vertices_x[vertex], self.vertices_y[vertex]]
        });
        Homogeneous::new(x, y, 1.0)
    }

    fn vertices(&self, hull: usize) -> impl Iterator<Item = (f64, f64)> {
        let vertices = self.start[hull] as usize..self.start[hull + 1] as usize;
        self.vertices_x[vertices.clone()].iter().copied().zip(self.vertices_y[vertices].iter().copied())
    }
}

/// How far the centre of each hull may be from a line of about one direction: within the inner bound of a middle distance the hull is
/// met, outside the outer one it is missed.
struct Reach {
    middle: Vec<f32>,
    inner: Vec<f32>,
    outer: Vec<f32>,
}

impl Reach {
    /// For lines whose normal is within half a step of one of some directions.
    fn new(hulls: &Hulls, direction: usize, directions: usize) -> Self {
        let step = TAU / directions as f64;
        let (sin, cos) = (step * direction as f64).sin_cos();
        let mut reach = Self { middle: Vec::new(), inner: Vec::new(), outer: Vec::new() };
        for hull in 0..hulls.frame.len() {
            let (x, y, radius) = (f64::from(hulls.x[hull]), f64::from(hulls.y[hull]), hulls.radius[hull]);
            let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
            for (vx, vy) in hulls.vertices(hull) {
                let along = cos * (vx - x) + sin * (vy - y);
                (least, most) = (least.min(along), most.max(along));
            }
            let half = HALF_WIDTH + 0.5 * (most - least);
            // What half a step, and the rounding of directions to steps, may change; and that of numbers.
            let slack = radius * 0.501 * step + ROUNDING * (x + y + radius + 1.0);
            reach.middle.push((-0.5 * (least + most)) as f32);
            reach.inner.push((half - slack) as f32);
            reach.outer.push((half + slack) as f32);
        }
        reach
    }
}

/// Which step of the circle the normal of a line is nearest to.
fn direction(line: &Line, directions: usize) -> usize {
    (line.b.atan2(line.a) / TAU * directions as f64).round().rem_euclid(directions as f64) as usize
}

/// Pass: the barcode of a line.
struct BarcodePass<'a> {
    hulls: &'a Hulls,
    reach: &'a Reach,
    line: &'a Line,
    row: &'a mut [u64],
}

impl WithSimd for BarcodePass<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _simd: S) {
        let n = self.hulls.frame.len();
        let Reach { middle, inner, outer } = self.reach;
        let chunks = [&self.hulls.x, &self.hulls.y, middle, inner, outer].map(|v| v.as_chunks::<WORD>());
        for k in 0..n / WORD {
            self.word(k * WORD, chunks.map(|(whole, _)| &whole[k]));
        }
        // What is no number is met by nothing.
        let mut padded = [[f32::NAN; WORD]; 5];
        padded.iter_mut().zip(&chunks).for_each(|(to, (_, rest))| to[..rest.len()].copy_from_slice(rest));
        self.word(n - n % WORD, padded.each_ref());
    }
}

impl BarcodePass<'_> {
    /// The hulls from one on.
    #[inline(always)]
    fn word(&mut self, first: usize, [x, y, middle, inner, outer]: [&[f32; WORD]; 5]) {
        let [a, b, c] = [self.line.a, self.line.b, self.line.c].map(|v| v as f32);
        let (mut near, mut sure) = ([0u8; WORD], [0u8; WORD]);
        for k in 0..WORD {
            let off = (a * x[k] + b * y[k] + c - middle[k]).abs();
            near[k] = u8::from(off <= outer[k]);
            sure[k] = u8::from(off <= inner[k]);
        }
        let sure = word_of(&sure);
        for k in ones_of(word_of(&near)) {
            let met = sure >> k & 1 == 1 || meets(self.hulls, first + k, self.line);
            let frame = self.hulls.frame[first + k] as usize;
            self.row[frame / 64] |= u64::from(met) << (frame % 64);
        }
    }
}

/// Some vertex lies on each side of the line, or near it.
#[inline(always)]
fn meets(hulls: &Hulls, hull: usize, line: &Line) -> bool {
    let (mut below, mut above) = (false, false);
    for (x, y) in hulls.vertices(hull) {
        let distance = line.signed_distance(x, y);
        below |= distance <= HALF_WIDTH;
        above |= distance >= -HALF_WIDTH;
    }
    below & above
}

/// The barcodes of lines over some frames of a recording.
pub(super) fn hull_barcodes(silhouettes: &Silhouettes, frames: &[u32], lines: &[Line]) -> Barcodes {
    let [fewest, most] = DIRECTIONS;
    let directions = (lines.len() / SHARED).clamp(fewest, most);
    barcodes_of(&Hulls::new(silhouettes, frames), frames.len(), lines, directions)
}

/// Hulls with a table for each of some directions, for lines that come a few at a time.
pub(super) struct TabulatedHulls {
    hulls: Hulls,
    frames: usize,
    reach: Vec<Reach>,
}

impl TabulatedHulls {
    /// Hulls of so many frames.
    pub(super) fn new(hulls: Hulls, frames: usize, directions: usize) -> Self {
        let reach = (0..directions).into_par_iter().map(|d| Reach::new(&hulls, d, directions)).collect();
        Self { hulls, frames, reach }
    }

    /// The barcodes of lines, on the thread that asks.
    pub(super) fn barcodes(&self, lines: &[Line]) -> Barcodes {
        let mut barcodes = Barcodes::zeros(lines.len(), self.frames);
        if self.frames == 0 {
            return barcodes;
        }
        let arch = Arch::new();
        for (line, row) in lines.iter().zip(barcodes.bits.chunks_exact_mut(barcodes.words_per)) {
            let reach = &self.reach[direction(line, self.reach.len())];
            arch.dispatch(BarcodePass { hulls: &self.hulls, reach, line, row });
        }
        barcodes
    }
}

/// The barcodes of lines over hulls of so many frames, with a table for each of some directions, which is let go of before the next.
fn barcodes_of(hulls: &Hulls, frames: usize, lines: &[Line], directions: usize) -> Barcodes {
    let mut barcodes = Barcodes::zeros(lines.len(), frames);
    if frames == 0 {
        return barcodes;
    }
    let mut of_direction: Vec<Vec<(&Line, &mut [u64])>> = (0..directions).map(|_| Vec::new()).collect();
    for (line, row) in lines.iter().zip(barcodes.bits.chunks_exact_mut(barcodes.words_per)) {
        of_direction[direction(line, directions)].push((line, row));
    }
    of_direction.into_par_iter().enumerate().filter(|(_, lines)| !lines.is_empty()).for_each(
        |(direction, lines)| {
            let arch = Arch::new();
            let reach = Reach::new(hulls, direction, directions);
            for (line, row) in lines {
                arch.dispatch(BarcodePass { hulls, reach: &reach, line, row });
            }
        },
    );
    barcodes
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::random::generator;

    #[test]
    fn a_line_meets_a_hull_with_vertices_on_both_sides() {
        let mut random = generator(1, 0);
        let frames = 130;
        let mut hulls = Hulls { start: vec![0], ..Hulls::default() };
        for hull in 0..3000 {
            let size = random.random_range(0..60);
            let (x, y) = (random.random_range(0..600), random.random_range(0..400));
            let vertices: Vec<[u16; 2]> = (0..random.random_range(1..9))
                .map(|_| [x + random.random_range(0..=size), y + random.random_range(0..=size)])
                .collect();
            hulls.push(hull * frames as u32 / 3000, &vertices);
        }
        // Every other one along rows, columns and diagonals of pixels, where vertices lie on lines; then as many whose rim passes a vertex by a
        // hair, on either side.
        let lines: Vec<Line> = (0..1600)
            .filter_map(|k| {
                let angle = random.random::<f64>() * TAU;
                let angle = if k % 2 == 0 { angle } else { (angle * 8.0 / TAU).round() * TAU / 8.0 };
                let hull = random.random_range(0..hulls.frame.len());
                let of_hull = hulls.vertices(hull).next().map(|(x, y)| [x, y]);
                let anywhere = [random.random_range(0..600), random.random_range(0..400)].map(f64::from);
                let at = of_hull.filter(|_| k >= 800).unwrap_or(anywhere);
                let rim = [-1.0, 1.0][k / 2 % 2] * HALF_WIDTH + [-1e-6, 1e-6][k / 4 % 2];
                let (b, a) = angle.sin_cos();
                let c = -(a * at[0] + b * at[1]) + if k < 800 { 0.0 } else { rim };
                Line::from_homogeneous(&Homogeneous::new(a, b, c))
            })
            .collect();
        for (directions, most_by_vertices) in [(16, 0.7), (256, 0.1)] {
            let found = barcodes_of(&hulls, frames, &lines, directions);
            let (mut met, mut by_vertices) = (0, 0);
            for (i, line) in lines.iter().enumerate() {
                let mut row = vec![0; frames.div_ceil(64)];
                let reach = Reach::new(&hulls, direction(line, directions), directions);
                for hull in 0..hulls.frame.len() {
                    let distances = || hulls.vertices(hull).map(|(x, y)| line.signed_distance(x, y));
                    let meets = distances().any(|d| d <= HALF_WIDTH) && distances().any(|d| d >= -HALF_WIDTH);
                    let frame = hulls.frame[hull] as usize;
                    row[frame / 64] |= u64::from(meets) << (frame % 64);
                    let centre = line.signed_distance(f64::from(hulls.x[hull]), f64::from(hulls.y[hull]));
                    let off = (centre - f64::from(reach.middle[hull])).abs();
                    let within = |bound: &[f32]| off <= f64::from(bound[hull]);
                    assert!(!within(&reach.inner) || meets, "the inner bound");
                    assert!(within(&reach.outer) || !meets, "the outer bound");
                    met += usize::from(meets);
                    by_vertices += usize::from(within(&reach.outer) && !within(&reach.inner));
                }
                assert_eq!(found.row(i), row);
            }
            let share = by_vertices as f64 / met as f64;
            assert!(met > 40_000 && by_vertices > 400 && share < most_by_vertices, "{met} {share}");
            let kept = TabulatedHulls::new(std::mem::take(&mut hulls), frames, directions);
            assert_eq!(kept.barcodes(&lines).bits, found.bits);
            hulls = kept.hulls;
        }
    }
}
