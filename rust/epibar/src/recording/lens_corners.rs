//! What a lens needs of a silhouette beyond its hull.
//!
//! The hull of an undistorted silhouette is not the undistorted hull: a side that is straight in the image is bent by the
//! lens, and pixels inside of the hull of the image come to lie outside of the chord. So of each component those pixels are
//! kept too that are corners of its hull seen through one of some lenses, which lie so close that what falls between two
//! of them is below a tenth of a pixel.
//!
//! The lenses are the division model `r_u = r_d / (1 + λ r_d²)` (Fitzgibbon, CVPR 2001) about the middle of the image,
//! with half its diagonal as the unit: what is asked for is which points *can* be corners, and for that any one-parameter
//! family of lenses does that reaches from pincushion to a strong barrel.

use super::components::Run;
use crate::image::ImageSize;

/// From a pincushion to a barrel that doubles distances in the corner of the image.
const LENSES: [f64; 7] = [0.08, -0.07, -0.14, -0.22, -0.3, -0.4, -0.5];
/// Pixels by which the strongest of them may lift the middle of a chord, times image diagonal over square of its length.
const BULGE: f64 = 0.75;
/// A bulge below this, pixels, is not worth a point.
const LEAST_BULGE: f64 = 0.05;
/// Corners that stand out by less, pixels, are left out.
const TOLERANCE: f64 = 0.04;
/// Columns between two pixels that are looked at along a level side.
const STEP: usize = 4;

/// Pixels of one component that may be corners through a lens; memory is kept from component to component.
#[derive(Debug, Clone, Default)]
pub struct OutlineFinder {
    rim: Vec<[u16; 2]>,
    columns: Vec<[u16; 2]>,
    near: Vec<[u16; 2]>,
    warped: Vec<([f64; 2], u32)>,
    chain: Vec<u32>,
    corner: Vec<bool>,
}

impl OutlineFinder {
    /// Appends to `points` the pixels of a component, given by its runs, that are no corners of `hull` but may be through
    /// a lens, in the order of rows.
    pub fn find(&mut self, runs: &[Run], hull: &[[u16; 2]], size: ImageSize, points: &mut Vec<[u16; 2]>) {
        if hull.len() < 3 || bulge(hull, size) < LEAST_BULGE {
            return;
        }
        self.find_rim(runs);
        self.find_near(hull, size);
        if self.near.len() == hull.len() {
            return;
        }
        self.corner.clear();
        self.corner.resize(self.near.len(), false);
        let (middle, unit) = ([0.5 * size.x_max(), 0.5 * size.y_max()], 0.5 * size.diagonal());
        for lens in LENSES {
            self.warped.clear();
            self.warped.extend(self.near.iter().enumerate().map(|(i, p)| {
                let q = [(f64::from(p[0]) - middle[0]) / unit, (f64::from(p[1]) - middle[1]) / unit];
                let scale = 1.0 / (1.0 + lens * (q[0] * q[0] + q[1] * q[1]));
                ([q[0] * scale, q[1] * scale], i as u32)
            }));
            self.mark_corners(TOLERANCE / unit);
        }
        let fresh = self.near.iter().zip(&self.corner).filter(|(p, corner)| **corner && !hull.contains(p));
        points.extend(fresh.map(|(p, _)| *p));
    }

    /// Ends of rows, and ends of some columns.
    fn find_rim(&mut self, runs: &[Run]) {
        self.rim.clear();
        for row in runs.chunk_by(|a, b| a.y == b.y) {
            self.rim.push([row[0].x_first, row[0].y]);
            self.rim.push([row[row.len() - 1].x_last, row[0].y]);
        }
        let first = runs.iter().map(|r| r.x_first).min().unwrap_or(0) as usize;
        let last = runs.iter().map(|r| r.x_last).max().unwrap_or(0) as usize;
        self.columns.clear();
        self.columns.resize((last - first) / STEP + 1, [u16::MAX, 0]);
        for run in runs {
            let from = (usize::from(run.x_first) - first).div_ceil(STEP);
            let to = (usize::from(run.x_last) - first) / STEP;
            for column in self.columns.iter_mut().take(to + 1).skip(from) {
                *column = [column[0].min(run.y), column[1].max(run.y)];
            }
        }
        for (k, [top, bottom]) in self.columns.iter().enumerate() {
            if top <= bottom {
                let x = (first + k * STEP) as u16;
                self.rim.push([x, *top]);
                self.rim.push([x, *bottom]);
            }
        }
        self.rim.sort_unstable_by_key(|p| (p[1], p[0]));
        self.rim.dedup();
    }

    /// Finds the points of the rim that lie no deeper inside the hull than a lens may lift them.
    fn find_near(&mut self, hull: &[[u16; 2]], size: ImageSize) {
        self.near.clear();
        let sides: Vec<_> = (0..hull.len())
            .map(|i| {
                let ([x, y], [u, v]) = (hull[i].map(f64::from), hull[(i + 1) % hull.len()].map(f64::from));
                let (dx, dy) = (u - x, v - y);
                let length = dx.hypot(dy);
                ([x, y], [dx / length, dy / length], length, lift(length, size))
            })
            .collect();
        let near = |p: &[u16; 2]| {
            let [x, y] = p.map(f64::from);
            sides.iter().any(|([x0, y0], [dx, dy], length, lift)| {
                let (ax, ay) = (x - x0, y - y0);
                let along = ax * dx + ay * dy;
                (ax * dy - ay * dx).abs() <= *lift && along >= 0.0 && along <= *length
            })
        };
        self.near.extend(self.rim.iter().copied().filter(near));
    }

    /// Marks the corners of the hull of the warped points (Andrew's monotone chain) but for those that stand out little.
    fn mark_corners(&mut self, tolerance: f64) {
        self.warped.sort_unstable_by(|p, q| p.0[0].total_cmp(&q.0[0]).then(p.0[1].total_cmp(&q.0[1])));
        for reversed in [false, true] {
            self.chain.clear();
            for k in 0..self.warped.len() {
                let k = if reversed { self.warped.len() - 1 - k } else { k };
                while let [.., o, p] = self.chain.as_slice() {
                    let at = |i: &u32| self.warped[*i as usize].0;
                    if turn(at(o), at(p), self.warped[k].0) > 0.0 {
                        break;
                    }
                    self.chain.pop();
                }
                self.chain.push(k as u32);
            }
            self.mark_chain(tolerance);
        }
    }

    /// Marks so many of the chain that none of the others is farther than the tolerance outside of them.
    fn mark_chain(&mut self, tolerance: f64) {
        let at = |i: usize| self.warped[self.chain[i] as usize].0;
        let mut mark = |i: usize| self.corner[self.warped[self.chain[i] as usize].1 as usize] = true;
        let mut last = 0;
        mark(0);
        for next in 2..self.chain.len() {
            let (from, to) = (at(last), at(next));
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            let stands_out = |i: usize| turn(from, to, at(i)).abs() > tolerance * length;
            if (last + 1..next).any(stands_out) {
                last = next - 1;
                mark(last);
            }
        }
        mark(self.chain.len() - 1);
    }
}

/// Twice the area of the triangle, positive where it turns left.
fn turn(o: [f64; 2], p: [f64; 2], q: [f64; 2]) -> f64 {
    (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0])
}

/// How far a lens may lift the middle of a chord, pixels, with a pixel for the grid.
fn lift(length: f64, size: ImageSize) -> f64 {
    BULGE * length * length / size.diagonal() + 1.0
}

/// The most that a lens may lift a side of a hull, pixels.
fn bulge(hull: &[[u16; 2]], size: ImageSize) -> f64 {
    let side = |i: usize| {
        let ([x, y], [u, v]) = (hull[i].map(f64::from), hull[(i + 1) % hull.len()].map(f64::from));
        (u - x).powi(2) + (v - y).powi(2)
    };
    BULGE * (0..hull.len()).map(side).fold(0.0, f64::max) / size.diagonal()
}

#[cfg(test)]
mod tests {
    use super::super::components::Components;
    use super::super::convex_hull::convex_hull;
    use super::*;

    /// The farthest place of a component in a direction, through a lens, pixels; over all of its pixels, or over some.
    fn reach(points: &[[u16; 2]], lens: f64, size: ImageSize, direction: f64) -> f64 {
        let (middle, unit) = ([0.5 * size.x_max(), 0.5 * size.y_max()], 0.5 * size.diagonal());
        let at = |p: &[u16; 2]| {
            let q = [(f64::from(p[0]) - middle[0]) / unit, (f64::from(p[1]) - middle[1]) / unit];
            let scale = unit / (1.0 + lens * (q[0] * q[0] + q[1] * q[1]));
            scale * (q[0] * direction.cos() + q[1] * direction.sin())
        };
        points.iter().map(at).fold(f64::NEG_INFINITY, f64::max)
    }

    #[test]
    fn nothing_sticks_out_through_any_lens() {
        let size = ImageSize::new(640, 480).unwrap();
        let shapes: [fn(f64, f64) -> bool; 4] = [
            |x, y| (400.0..620.0).contains(&x) && (20.0..200.0).contains(&y),
            |x, y| ((x - 150.0) / 90.0).powi(2) + ((y - 330.0) / 120.0).powi(2) < 1.0,
            |x, y| (y - 0.7 * x - 10.0).abs() < 12.0 && (20.0..560.0).contains(&x),
            |x, y| (300.0..340.0).contains(&x) && (10.0..470.0).contains(&y),
        ];
        let mut finder = OutlineFinder::default();
        for (number, shape) in shapes.iter().enumerate() {
            let mask: Vec<u8> =
                (0..size.pixels()).map(|i| u8::from(shape((i % 640) as f64, (i / 640) as f64))).collect();
            let mut found = Components::new();
            found.find(&mask, size);
            let runs = found.runs_of(&found.components()[0]);
            let (mut hull, mut more) = (Vec::new(), Vec::new());
            convex_hull(runs, &mut hull);
            finder.find(runs, &hull, size, &mut more);
            assert!(more.iter().all(|p| !hull.contains(p)));
            let kept: Vec<_> = hull.iter().chain(&more).copied().collect();
            assert!(kept.len() < 140, "{number}: {}", kept.len());
            let all: Vec<_> = runs.iter().flat_map(|r| (r.x_first..=r.x_last).map(|x| [x, r.y])).collect();
            // Also between the lenses that were tried.
            for lens in [0.05, -0.04, -0.1, -0.18, -0.26, -0.35, -0.45] {
                for k in 0..48 {
                    let direction = f64::from(k) * std::f64::consts::TAU / 48.0;
                    let missed = reach(&all, lens, size, direction) - reach(&kept, lens, size, direction);
                    assert!((0.0..0.1).contains(&missed), "{number} {lens} {k}: {missed}");
                }
            }
            let hull_alone = reach(&all, -0.4, size, 0.6) - reach(&hull, -0.4, size, 0.6);
            assert!(number != 0 || hull_alone >= 0.0);
        }
    }

    #[test]
    fn small_silhouettes_need_no_more_than_their_hulls() {
        let size = ImageSize::new(640, 480).unwrap();
        let mut mask = vec![0; size.pixels()];
        for y in 100..106 {
            mask[y * 640 + 500..y * 640 + 505].fill(1);
        }
        let mut found = Components::new();
        found.find(&mask, size);
        let runs = found.runs_of(&found.components()[0]);
        let (mut hull, mut more) = (Vec::new(), Vec::new());
        convex_hull(runs, &mut hull);
        OutlineFinder::default().find(runs, &hull, size, &mut more);
        assert!(more.is_empty(), "{more:?}");
    }
}
