//! Highest and lowest points of silhouettes that are followed through time.
//!
//! A hull continues that of the frame before which it overlaps most, if each is the other's and they are about as
//! large ([`tracker`](crate::recording::tracker)).

use crate::frontier::View;
use crate::geometry::hull::extent;
use crate::recording::tracker::{Outline, predecessors};

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

/// Highest and lowest vertex of a hull, the middle of them where several are level; `None` where the view ends at
/// one of them.
pub fn extremes(view: &View, hull: &[[f64; 2]]) -> Option<Extremes> {
    let extreme = |sign: f64| {
        let height = |p: &[f64; 2]| sign * (view.up[0] * p[0] + view.up[1] * p[1]);
        let most = hull.iter().map(height).fold(f64::NEG_INFINITY, f64::max);
        let level = || hull.iter().filter(|p| height(p) == most);
        let (sum, count) = level().fold(([0.0; 2], 0.0), |(s, n), p| ([s[0] + p[0], s[1] + p[1]], n + 1.0));
        level().all(|&p| !view.on_border(p)).then_some(sum.map(|s| s / count))
    };
    Some([extreme(1.0)?, extreme(-1.0)?])
}

/// All tracks of a view of at least `shortest` frames; `continues(t)` says whether frame `t + 1` of the view follows
/// frame `t` in time.
pub fn tracks(view: &View, continues: impl Fn(usize) -> bool, shortest: usize) -> Vec<Track> {
    let within = |p: f64, q: f64, ratio: f64| p.max(q) <= ratio * p.min(q);
    let alike = |p: &TrackedOutline, q: &TrackedOutline, overlap: f64| {
        overlap >= OVERLAP
            && within(p.height, q.height, HEIGHT_RATIO)
            && within(p.outline.area(), q.outline.area(), AREA_RATIO)
    };
    let mut found: Vec<Track> = Vec::new();
    // The silhouettes of the previous frame, and the track that each ends.
    let (mut before, mut ended): (Vec<TrackedOutline>, Vec<usize>) = (Vec::new(), Vec::new());
    for frame in 0..view.frames() {
        if frame > 0 && !continues(frame - 1) {
            before.clear();
        }
        let now: Vec<TrackedOutline> =
            view.hulls_of(frame).map(|hull| TrackedOutline::new(hull, view.up)).collect();
        let links = predecessors(&before, &now, |p, q| p.outline.overlap(&q.outline), alike);
        let tracks = links.into_iter().map(|link| {
            link.map_or_else(
                || {
                    found.push(Track { start: frame, extremes: Vec::new() });
                    found.len() - 1
                },
                |previous| ended[previous],
            )
        });
        let tracks: Vec<usize> = tracks.collect();
        for (&track, hull) in tracks.iter().zip(view.hulls_of(frame)) {
            found[track].extremes.push(extremes(view, hull));
        }
        (before, ended) = (now, tracks);
    }
    found.retain(|t| t.extremes.len() >= shortest);
    found
}

/// What of a silhouette tells its next one.
struct TrackedOutline {
    outline: Outline,
    /// From top to bottom, pixels.
    height: f64,
}

impl TrackedOutline {
    fn new(hull: &[[f64; 2]], up: [f64; 2]) -> Self {
        let [bottom, top] = extent(hull, up);
        Self { outline: Outline::of(hull.iter().copied()), height: top - bottom + 1.0 }
    }
}
