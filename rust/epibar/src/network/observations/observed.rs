//! What one camera of a network saw: outlines of silhouettes in raw pixels, and which is which from frame to frame.

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::geometry::hull::diagonal;
use crate::geometry::median::median;
use crate::image::ImageSize;
use crate::network::model::camera::Camera;
use crate::recording::at_moment::{Between, at_moment};
use crate::recording::fill::fill;
use crate::recording::tracker::Links;
use crate::recording::visible::on_border;
use crate::recording::{LONG_STEP, RecordedFrame, Recording};

/// Silhouettes of one camera.
#[derive(Debug, Clone)]
pub struct Observed {
    /// Size of the image.
    pub size: ImageSize,
    /// Seconds of this camera's clock of each frame, since its first.
    pub times: Vec<f64>,
    /// Seconds from one frame to the next.
    pub interval: f64,
    /// For each frame its first silhouette, and the number of silhouettes as the last entry.
    frame_start: Vec<u32>,
    /// For each silhouette its first point, and the number of points as the last entry.
    start: Vec<u32>,
    /// Points of the outlines, pixels: corners of the hull and what may be one through a lens.
    points: Vec<[f64; 2]>,
    /// Whether the view ends at a point.
    cut: Vec<bool>,
    /// Which silhouette of one frame is which of the next.
    links: Links,
    /// Directions of the points before a camera, of which the lens is known; NaN where it shows nothing.
    through: Option<(Camera, Vec<Vector3<f64>>)>,
    /// For each silhouette by how much the usual extent is more than its own, as a share of its own.
    smallness: Vec<f32>,
    /// Median share of a hull that its silhouette fills: 0.5 to 0.9 of people and animals, 1 of boxes, ellipses and balls.
    pub fill: f64,
}

/// No silhouette is smaller than this, which is one of a quarter of the usual extent: what is smaller is no whole figure.
const SMALLEST: f64 = 3.0;

/// Smallness of each silhouette, by the diagonals of their bounding boxes.
fn smallness(start: &[u32], points: &[[f64; 2]]) -> Vec<f32> {
    let of_one = |ends: &[u32]| diagonal(&points[ends[0] as usize..ends[1] as usize]);
    let extents: Vec<f64> = start.windows(2).map(of_one).collect();
    let usual = median(extents.iter().copied().filter(|e| e.is_finite())).unwrap_or(1.0);
    extents.iter().map(|e| (usual / e - 1.0).clamp(-1.0, SMALLEST) as f32).collect()
}

/// A moment among the frames of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// The frame before it, or at it.
    pub frame: RecordedFrame,
    /// How far it is to the next one, 0 to 1.
    pub share: f64,
}

impl Observed {
    /// The silhouettes of a recording.
    pub fn new(recording: &Recording) -> Self {
        let silhouettes = &recording.silhouettes;
        let (mut start, mut points, mut cut) = (vec![0], Vec::new(), Vec::new());
        for hull in 0..silhouettes.len() {
            // Specks and lines have no two sides.
            if silhouettes.hull(hull).len() >= 3 {
                for p in silhouettes.hull(hull).iter().chain(silhouettes.outline(hull)) {
                    let p = p.map(f64::from);
                    points.push(p);
                    cut.push(on_border(recording.size, recording.visible.as_deref(), p));
                }
            }
            start.push(points.len() as u32);
        }
        let smallness = smallness(&start, &points);
        let first = recording.times.first().copied().unwrap_or(0.0);
        Self {
            size: recording.size,
            times: recording.times.iter().map(|t| t - first).collect(),
            interval: recording.frame_interval(),
            frame_start: silhouettes.frame_start.clone(),
            start,
            points,
            cut,
            smallness,
            links: Links::new(recording),
            through: None,
            fill: fill(&recording.silhouettes),
        }
    }

    /// What was seen, made ready for cameras of one lens, of which rays then take next to nothing.
    #[must_use]
    pub fn through(self, camera: &Camera) -> Self {
        let optics = camera.optics();
        let direction = |p: &[f64; 2]| {
            optics.direction(*p).map_or(Vector3::repeat(f64::NAN), |[x, y]| Vector3::new(x, y, 1.0))
        };
        let directions = self.points.par_iter().map(direction).collect();
        Self { through: Some((*camera, directions)), ..self }
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.times.len()
    }

    /// Number of silhouettes.
    pub fn silhouettes(&self) -> usize {
        self.start.len() - 1
    }

    /// The silhouettes of a frame.
    pub fn of_frame(&self, frame: RecordedFrame) -> std::ops::Range<u32> {
        self.frame_start[frame.index()]..self.frame_start[frame.index() + 1]
    }

    /// The points of a silhouette; none of one without two sides.
    pub fn range(&self, silhouette: u32) -> std::ops::Range<usize> {
        self.start[silhouette as usize] as usize..self.start[silhouette as usize + 1] as usize
    }

    /// 0 of a silhouette of the camera's usual extent, 1 of one half as large, up to [`SMALLEST`].
    pub fn smallness(&self, silhouette: u32) -> f64 {
        f64::from(self.smallness[silhouette as usize])
    }

    /// A point, pixels.
    pub fn point(&self, i: u32) -> [f64; 2] {
        self.points[i as usize]
    }

    /// Whether the view ends at a point.
    pub fn is_cut(&self, i: u32) -> bool {
        self.cut[i as usize]
    }

    /// Whether a silhouette has two sides.
    pub fn usable(&self, silhouette: u32) -> bool {
        !self.range(silhouette).is_empty()
    }

    /// A silhouette's object one frame later.
    pub fn next(&self, silhouette: u32) -> Option<u32> {
        self.links.next(silhouette as usize).map(|h| h as u32).filter(|&h| self.usable(h))
    }

    /// A silhouette's object one frame earlier.
    pub fn previous(&self, silhouette: u32) -> Option<u32> {
        self.links.previous(silhouette as usize).map(|h| h as u32).filter(|&h| self.usable(h))
    }

    /// Rays in the world of the points of some silhouettes, NaN of the others and where the lens shows nothing.
    pub fn rays(&self, camera: &Camera, wanted: &[bool]) -> Vec<Vector3<f64>> {
        let mut rays = vec![Vector3::repeat(f64::NAN); self.points.len()];
        let mut parts = Vec::with_capacity(wanted.len());
        let mut rest = rays.as_mut_slice();
        for (silhouette, wanted) in wanted.iter().enumerate() {
            let range = self.range(silhouette as u32);
            let (part, after) = rest.split_at_mut(range.len());
            if *wanted {
                parts.push((part, range.start));
            }
            rest = after;
        }
        if let Some((_, directions)) = self.through.as_ref().filter(|(known, _)| known.has_lens_of(camera)) {
            let back = camera.rotation.inverse();
            parts.into_par_iter().with_min_len(256).for_each(|(part, first)| {
                for (ray, direction) in part.iter_mut().zip(&directions[first..]) {
                    *ray = back * direction;
                }
            });
            return rays;
        }
        parts.into_par_iter().with_min_len(64).for_each(|(part, first)| {
            for (ray, p) in part.iter_mut().zip(&self.points[first..]) {
                if let Some(found) = camera.ray(*p) {
                    *ray = found;
                }
            }
        });
        rays
    }

    /// For each silhouette whether it is seen in one of some frames, or in the one after.
    pub fn wanted(&self, frames: impl Iterator<Item = RecordedFrame>) -> Vec<bool> {
        let mut wanted = vec![false; self.silhouettes()];
        for frame in frames {
            let last = (frame.index() + 1).min(self.frames() - 1);
            let range = self.frame_start[frame.index()] as usize..self.frame_start[last + 1] as usize;
            wanted[range].fill(true);
        }
        wanted
    }

    /// The moment at `seconds` of this camera's clock; `None` where it saw nothing then.
    pub fn moment(&self, seconds: f64) -> Option<Moment> {
        let after = self.times.partition_point(|t| *t <= seconds);
        let whole = |frame: usize| Some(Moment { frame: RecordedFrame(frame as u32), share: 0.0 });
        if after == 0 {
            return if self.times.first()? - seconds <= 0.5 * self.interval { whole(0) } else { None };
        }
        let before = after - 1;
        if after == self.times.len() {
            return if seconds - self.times[before] <= 0.5 * self.interval { whole(before) } else { None };
        }
        let gap = self.times[after] - self.times[before];
        let share = (seconds - self.times[before]) / gap;
        if gap > LONG_STEP * self.interval {
            // Frames are missing, so only what is near one of those that are there is known.
            let near = 0.5 * self.interval / gap;
            return match share {
                s if s <= near => whole(before),
                s if s >= 1.0 - near => whole(after),
                _ => None,
            };
        }
        match share {
            s if s < 1e-6 => whole(before),
            s if s > 1.0 - 1e-6 => whole(after),
            share => Some(Moment { frame: RecordedFrame(before as u32), share }),
        }
    }

    /// Seconds of this camera's clock at a moment.
    pub fn seconds(&self, moment: Moment) -> f64 {
        let at = self.times[moment.frame.index()];
        if moment.share == 0.0 {
            return at;
        }
        at + moment.share * (self.times[moment.frame.index() + 1] - at)
    }

    /// The silhouettes at a moment; those that are not followed to the other frame stand still in the nearer.
    pub fn between(&self, moment: Moment, found: &mut Vec<Between<u32>>) {
        let Moment { frame, share } = moment;
        let usable = |h: &u32| self.usable(*h);
        let there = if share == 0.0 { 0..0 } else { self.of_frame(RecordedFrame(frame.0 + 1)) };
        found.clear();
        found.extend(at_moment(
            self.of_frame(frame).filter(usable),
            there.filter(usable),
            |h| self.next(h),
            |h| self.previous(h),
            share,
        ));
    }
}
