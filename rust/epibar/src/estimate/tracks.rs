//! Silhouettes followed through time.
//!
//! A hull continues that of the frame before which it overlaps most, if both agree that they do and are about as
//! large. Where silhouettes merge or part a track ends: what is followed is one object, or one group.

use super::views::View;

/// Least overlap (intersection over union of the bounding boxes) of a silhouette with its successor.
const OVERLAP: f64 = 0.35;
/// Largest ratio of their heights.
const HEIGHT_RATIO: f64 = 1.25;
/// Largest ratio of their areas.
const AREA_RATIO: f64 = 1.5;

/// Highest and lowest point of a silhouette, pixels.
pub type Extremes = [[f64; 2]; 2];

/// One silhouette through consecutive frames.
#[derive(Debug, Clone)]
pub struct Track {
    /// Index of its first frame.
    pub start: usize,
    /// For each frame from there on its top and bottom; `None` where the view ends at one.
    pub extremes: Vec<Option<Extremes>>,
}

impl Track {
    /// One past its last frame.
    pub fn end(&self) -> usize {
        self.start + self.extremes.len()
    }
}

/// How far up a point lies.
fn along(up: [f64; 2], p: &[f64; 2]) -> f64 {
    up[0] * p[0] + up[1] * p[1]
}

/// Pixels of a box, none where it is empty.
fn area(low: [f64; 2], high: [f64; 2]) -> f64 {
    (0..2).map(|k| (high[k] - low[k] + 1.0).max(0.0)).product()
}

#[derive(Clone, Copy)]
struct Bounds {
    low: [f64; 2],
    high: [f64; 2],
    /// From top to bottom.
    height: f64,
}

impl Bounds {
    fn of(hull: &[[f64; 2]], up: [f64; 2]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let (mut bottom, mut top) = (f64::INFINITY, f64::NEG_INFINITY);
        for p in hull {
            let height = along(up, p);
            (bottom, top) = (bottom.min(height), top.max(height));
            for k in 0..2 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        Self { low, high, height: top - bottom + 1.0 }
    }

    fn area(&self) -> f64 {
        area(self.low, self.high)
    }

    fn overlap(&self, other: &Self) -> f64 {
        let shared = area(
            [self.low[0].max(other.low[0]), self.low[1].max(other.low[1])],
            [self.high[0].min(other.high[0]), self.high[1].min(other.high[1])],
        );
        shared / (self.area() + other.area() - shared)
    }

    fn as_large(&self, other: &Self) -> bool {
        let within = |p: f64, q: f64, ratio: f64| p.max(q) <= ratio * p.min(q);
        within(self.height, other.height, HEIGHT_RATIO) && within(self.area(), other.area(), AREA_RATIO)
    }
}

/// Highest and lowest vertex of a hull, the middle of them where several are level; `None` where the view ends at
/// one of them.
pub fn extremes(view: &View, hull: &[[f64; 2]]) -> Option<Extremes> {
    let extreme = |sign: f64| {
        let height = |p: &[f64; 2]| sign * along(view.up, p);
        let most = hull.iter().map(height).fold(f64::NEG_INFINITY, f64::max);
        let level = || hull.iter().filter(|p| height(p) == most);
        let (sum, count) = level().fold(([0.0; 2], 0.0), |(s, n), p| ([s[0] + p[0], s[1] + p[1]], n + 1.0));
        level().all(|&p| !view.on_border(p)).then_some(sum.map(|s| s / count))
    };
    Some([extreme(1.0)?, extreme(-1.0)?])
}

/// All tracks of a view of at least `shortest` frames; `continues(t)` tells whether frame `t + 1` of the view follows
/// frame `t` in time.
pub fn tracks(view: &View, continues: impl Fn(usize) -> bool, shortest: usize) -> Vec<Track> {
    let mut found: Vec<Track> = Vec::new();
    // Of the previous frame: bounds of each hull and the track that it ends.
    let mut before: Vec<(Bounds, usize)> = Vec::new();
    for frame in 0..view.frames() {
        if frame > 0 && !continues(frame - 1) {
            before.clear();
        }
        let hulls: Vec<_> = view.hulls_of(frame).collect();
        let bounds: Vec<Bounds> = hulls.iter().map(|h| Bounds::of(h, view.up)).collect();
        let nearest = |of: &Bounds, among: &mut dyn Iterator<Item = Bounds>| {
            among
                .map(|b| of.overlap(&b))
                .enumerate()
                .max_by(|p, q| p.1.total_cmp(&q.1).then(q.0.cmp(&p.0)))
                .filter(|(_, overlap)| *overlap >= OVERLAP)
                .map(|(k, _)| k)
        };
        let mut now = Vec::with_capacity(hulls.len());
        for (k, (hull, b)) in hulls.iter().zip(&bounds).enumerate() {
            let previous = nearest(b, &mut before.iter().map(|(b, _)| *b)).filter(|&p| {
                let (theirs, _) = &before[p];
                theirs.as_large(b) && nearest(theirs, &mut bounds.iter().copied()) == Some(k)
            });
            let track = previous.map_or_else(
                || {
                    found.push(Track { start: frame, extremes: Vec::new() });
                    found.len() - 1
                },
                |p| before[p].1,
            );
            found[track].extremes.push(extremes(view, hull));
            now.push((*b, track));
        }
        before = now;
    }
    found.retain(|t| t.extremes.len() >= shortest);
    found
}
