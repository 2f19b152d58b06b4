//! Tangents of all silhouettes of a view from one epipole, those with the object on one side apart from the others.

use crate::frontier::views::View;
use crate::image::Homogeneous;

/// Below this share of up in a tangent's normal, top and bottom mean nothing (12°).
const STEEP: f64 = 0.2;

/// The tangent may be of a top, of a bottom; a steep one may be of either.
pub(super) const MAY_BE_TOP: u64 = 1;
pub(super) const MAY_BE_BOTTOM: u64 = 2;
pub(super) const EITHER: u64 = MAY_BE_TOP | MAY_BE_BOTTOM;
/// The object lies above the tangent.
pub(super) const BOTTOM: u64 = 4;

/// No tangent of B.
pub(super) const NONE: u32 = u32::MAX;

/// A frame's tangents may be read in vectors of so many, beyond its last.
pub(super) const LANES: usize = 8;

/// Which tangents may meet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sides {
    /// An object on the positive side in A is on the positive side in B.
    pub(super) same: bool,
    /// Tops meet tops only.
    pub(super) upright: bool,
}

/// The side of B that one of A meets.
pub(super) fn partner(side: usize, sides: Sides) -> usize {
    if sides.same { side } else { 1 - side }
}

/// Tangents whose objects lie on one side of the oriented line `e × point`, by frames.
#[derive(Debug, Default)]
pub(super) struct Tangents {
    /// For each frame its first tangent, and the number of tangents as the last entry.
    pub(super) frame_start: Vec<u32>,
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    /// `e × point`.
    pub(super) line: [Vec<f64>; 3],
    /// [`EITHER`] and [`BOTTOM`].
    pub(super) class: Vec<u64>,
    /// Infinite where a tangent of the other view with these bits of [`EITHER`] must not meet it, else 0.
    pub(super) refused: [Vec<f64>; 4],
    /// The silhouette of each tangent.
    pub(super) hull: Vec<u32>,
    /// The tangent of each silhouette of the view, or [`NONE`].
    pub(super) of_hull: Vec<u32>,
    /// For each frame its first silhouette, and the number of silhouettes as the last entry.
    pub(super) first_hull: Vec<u32>,
}

impl Tangents {
    fn clear(&mut self) {
        self.frame_start.clear();
        self.frame_start.push(0);
        self.x.clear();
        self.y.clear();
        self.hull.clear();
        self.of_hull.clear();
        self.first_hull.clear();
        self.first_hull.push(0);
    }

    /// How many tangents there are; behind them stand [`LANES`] of no meaning.
    pub(super) fn len(&self) -> usize {
        self.frame_start.last().map_or(0, |&n| n as usize)
    }

    pub(super) fn frames(&self) -> usize {
        self.frame_start.len() - 1
    }

    pub(super) fn of(&self, frame: usize) -> std::ops::Range<usize> {
        self.frame_start[frame] as usize..self.frame_start[frame + 1] as usize
    }

    /// The silhouettes of a frame.
    pub(super) fn hulls(&self, frame: usize) -> std::ops::Range<usize> {
        self.first_hull[frame] as usize..self.first_hull[frame + 1] as usize
    }

    #[inline(always)]
    fn classify(&mut self, epipole: &Homogeneous, positive: bool, up: [f64; 2]) {
        let n = self.len() + LANES;
        for part in [&mut self.x, &mut self.y].into_iter().chain(&mut self.line).chain(&mut self.refused) {
            part.resize(n, 0.0);
        }
        self.class.resize(n, 0);
        let [line_x, line_y, line_z] = &mut self.line;
        let (line_x, line_y, line_z) = (&mut line_x[..n], &mut line_y[..n], &mut line_z[..n]);
        let (x, y, class) = (&self.x[..n], &self.y[..n], &mut self.class[..n]);
        let (ex, ey, ew) = (epipole.x, epipole.y, epipole.z);
        let [_, refuses_top, refuses_bottom, _] = &mut self.refused;
        let (refuses_top, refuses_bottom) = (&mut refuses_top[..n], &mut refuses_bottom[..n]);
        let towards = if positive { 1.0 } else { -1.0 };
        for i in 0..n {
            let (lx, ly) = (ey - ew * y[i], ew * x[i] - ex);
            (line_x[i], line_y[i], line_z[i]) = (lx, ly, ex * y[i] - ey * x[i]);
            let level = -(lx * up[0] + ly * up[1]);
            let top = level * towards > 0.0;
            let steep = level * level < STEEP * STEEP * (lx * lx + ly * ly);
            let may = if top { MAY_BE_TOP } else { MAY_BE_BOTTOM };
            class[i] = if steep { EITHER } else { may } | if top { 0 } else { BOTTOM };
            refuses_top[i] = if steep || top { 0.0 } else { f64::INFINITY };
            refuses_bottom[i] = if steep || !top { 0.0 } else { f64::INFINITY };
        }
    }
}

/// Both tangents of every silhouette: `[object on the negative side, on the positive side]`.
///
/// Tangents at which the view ends, not the object, are left out.
#[inline(always)]
pub(super) fn fill(tangents: &mut [Tangents; 2], view: &View, epipole: &Homogeneous, sides: &mut Vec<u8>) {
    let [negative, positive] = tangents;
    negative.clear();
    positive.clear();
    view.edges_facing(epipole, sides);
    for frame in 0..view.frames() {
        for hull in view.hull_indices(frame) {
            let Some([rising, falling]) = view.turns(hull, sides, epipole) else {
                positive.of_hull.push(NONE);
                negative.of_hull.push(NONE);
                continue;
            };
            for (vertex, of_side) in [(rising, &mut *positive), (falling, &mut *negative)] {
                let [x, y] = view.touchable(vertex);
                if x.is_nan() {
                    of_side.of_hull.push(NONE);
                } else {
                    of_side.of_hull.push(of_side.hull.len() as u32);
                    of_side.hull.push(hull as u32);
                    of_side.x.push(x);
                    of_side.y.push(y);
                }
            }
        }
        for of_side in [&mut *negative, &mut *positive] {
            of_side.frame_start.push(of_side.x.len() as u32);
            of_side.first_hull.push(of_side.of_hull.len() as u32);
        }
    }
    negative.classify(epipole, false, view.up);
    positive.classify(epipole, true, view.up);
}
