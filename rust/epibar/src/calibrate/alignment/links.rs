//! Which silhouette of one frame is which of the next.
//!
//! Only silhouettes that plainly are the same object count: each other's nearest, overlapping, and of the same widths.
//! Where two walkers merge, or one leaves the image, there is no link.

use super::{LONG_STEP, frame_interval};
use crate::recording::Recording;

/// No hull.
const NONE: u32 = u32::MAX;
/// Widths in each direction may differ by this share, and by [`WIDTH_PIXELS`].
const WIDTH_SHARE: f64 = 0.2;
const WIDTH_PIXELS: f64 = 3.0;

/// For each hull of a recording the hull of the same object one frame later, and one earlier.
#[derive(Debug, Clone)]
pub struct Links {
    next: Vec<u32>,
    previous: Vec<u32>,
}

/// Extent of a hull along x, y and both diagonals, pixels (diagonals times √2).
#[derive(Debug, Clone, Copy)]
struct Extent {
    low: [f64; 4],
    high: [f64; 4],
    border: bool,
}

impl Extent {
    fn of(hull: &[[u16; 2]], border: bool) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4]);
        for p in hull {
            let [x, y] = p.map(f64::from);
            for (k, value) in [x, y, x + y, x - y].into_iter().enumerate() {
                low[k] = low[k].min(value);
                high[k] = high[k].max(value);
            }
        }
        Self { low, high, border }
    }

    /// Squared distance of the centres; `None` where the two cannot be one object a frame apart.
    fn distance(&self, other: &Self) -> Option<f64> {
        if self.border != other.border {
            return None;
        }
        for k in 0..4 {
            let (width, theirs) = (self.high[k] - self.low[k], other.high[k] - other.low[k]);
            let allowed = WIDTH_PIXELS + WIDTH_SHARE * width.max(theirs);
            let overlap = self.high[k].min(other.high[k]) - self.low[k].max(other.low[k]);
            if (width - theirs).abs() > allowed || overlap < -WIDTH_PIXELS {
                return None;
            }
        }
        let middle = |e: &Self, k: usize| 0.5 * (e.low[k] + e.high[k]);
        Some((0..2).map(|k| (middle(self, k) - middle(other, k)).powi(2)).sum())
    }
}

impl Links {
    /// Follows the silhouettes of a recording.
    pub fn new(recording: &Recording) -> Self {
        let silhouettes = &recording.silhouettes;
        let extents: Vec<Extent> =
            (0..silhouettes.len()).map(|h| Extent::of(silhouettes.hull(h), silhouettes.border[h])).collect();
        let mut links = Self { next: vec![NONE; extents.len()], previous: vec![NONE; extents.len()] };
        let long = LONG_STEP * frame_interval(recording);
        for frame in 1..recording.frames() {
            if recording.times[frame] - recording.times[frame - 1] > long {
                continue;
            }
            let (before, now) = (silhouettes.hulls(frame - 1), silhouettes.hulls(frame));
            let nearest = |from: usize, among: std::ops::Range<usize>| {
                let distances = among.filter_map(|to| Some((extents[from].distance(&extents[to])?, to)));
                distances.min_by(|p, q| p.0.total_cmp(&q.0)).map(|(_, to)| to)
            };
            for h in before.clone() {
                if let Some(to) = nearest(h, now.clone())
                    && nearest(to, before.clone()) == Some(h)
                {
                    links.next[h] = to as u32;
                    links.previous[to] = h as u32;
                }
            }
        }
        links
    }

    /// The same object one frame later.
    pub fn next(&self, hull: usize) -> Option<usize> {
        Some(self.next[hull]).filter(|&h| h != NONE).map(|h| h as usize)
    }

    /// The same object one frame earlier.
    pub fn previous(&self, hull: usize) -> Option<usize> {
        Some(self.previous[hull]).filter(|&h| h != NONE).map(|h| h as usize)
    }
}
