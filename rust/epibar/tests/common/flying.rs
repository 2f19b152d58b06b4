//! Tumbling boxes that fly through a volume, as two very different cameras see them.
//!
//! A silhouette is the hull of the eight projected corners; a pixel moves where its centre lies inside. So masks
//! are exact up to rasterisation, and what remains of an error is the library's.

use std::ops::Range;

use epibar::{Recorder, RecorderOptions, Recording};
use nalgebra::{Rotation3, Vector3};

use super::cameras::Camera;
use super::masks::{Mask, Random};

/// A box on a smooth closed path.
#[derive(Debug, Clone)]
struct Body {
    half: Vector3<f64>,
    centre: Vector3<f64>,
    reach: Vector3<f64>,
    /// Radians per frame, and at frame 0, for each axis.
    speed: Vector3<f64>,
    phase: Vector3<f64>,
    /// Rotation per frame.
    spin: Vector3<f64>,
}

impl Body {
    fn random(random: &mut Random) -> Self {
        let mut vector = |low: f64, high: f64| Vector3::from_fn(|_, _| random.between(low, high));
        let centre = vector(-0.6, 0.6) + Vector3::new(0.0, 0.0, 1.2);
        Self {
            half: vector(0.12, 0.4),
            centre,
            reach: vector(0.7, 1.7).component_mul(&Vector3::new(1.0, 1.0, 0.6)),
            speed: vector(0.03, 0.11),
            phase: vector(0.0, std::f64::consts::TAU),
            spin: vector(-0.05, 0.05),
        }
    }

    fn corners(&self, time: f64) -> [Vector3<f64>; 8] {
        let path = (self.speed * time + self.phase).map(f64::sin).component_mul(&self.reach);
        let rotation = Rotation3::new(self.spin * time + self.phase);
        std::array::from_fn(|i| {
            let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let corner = Vector3::new(sign(0), sign(1), sign(2)).component_mul(&self.half);
            self.centre + path + rotation * corner
        })
    }
}

/// Cameras and what flies before them.
#[derive(Debug, Clone)]
pub struct Scene {
    pub cameras: [Camera; 2],
    pub frames: usize,
    bodies: Vec<Body>,
}

impl Scene {
    /// Boxes before two cameras of different size, focal length, height and roll, some 100° apart.
    pub fn new(bodies: usize, frames: usize, seed: u64) -> Self {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        let cameras = [
            Camera::new([5.4, -3.0, 2.6], [0.0, 0.0, 1.2], (320, 240), 300.0, 0.10),
            Camera::new([-2.6, -6.0, 1.5], [0.1, 0.0, 1.1], (368, 208), 340.0, -0.14),
        ];
        Self { cameras, frames, bodies: (0..bodies).map(|_| Body::random(&mut random)).collect() }
    }

    /// What moves in one frame of one camera.
    pub fn mask(&self, camera: usize, frame: usize) -> Mask {
        self.mask_at(camera, frame as f64)
    }

    /// What moves at a moment, which may lie between frames.
    pub fn mask_at(&self, camera: usize, frame: f64) -> Mask {
        self.seen_by(&self.cameras[camera], frame)
    }

    /// What any camera would see move at a moment.
    pub fn seen_by(&self, camera: &Camera, frame: f64) -> Mask {
        let mut mask = vec![0; camera.size.pixels()];
        for body in &self.bodies {
            let corners: Option<Vec<[f64; 2]>> =
                body.corners(frame).iter().map(|corner| camera.project(corner)).collect();
            if let Some(corners) = corners {
                fill(&mut mask, camera.size.width(), &hull(corners));
            }
        }
        mask
    }

    /// The recording of one camera.
    pub fn record(&self, camera: usize, lines: usize) -> Recording {
        self.record_frames(camera, lines, 0..self.frames)
    }

    /// The recording of a part of the frames.
    pub fn record_frames(&self, camera: usize, lines: usize, frames: Range<usize>) -> Recording {
        let options = RecorderOptions::new().lines(lines).seed(camera as u64);
        let mut recorder = Recorder::new(self.cameras[camera].size, options).unwrap();
        for frame in frames {
            recorder.push(&self.mask(camera, frame), frame as f64 / 25.0).unwrap();
        }
        recorder.finish().unwrap()
    }

    /// The recording of a camera that films at a rate of its own: its frame `k` shows the moment `moments(k)`, in
    /// frames of the scene.
    pub fn record_moments(&self, camera: usize, lines: usize, fps: f64, moments: &[f64]) -> Recording {
        let options = RecorderOptions::new().lines(lines).seed(camera as u64);
        let mut recorder = Recorder::new(self.cameras[camera].size, options).unwrap();
        for (k, &moment) in moments.iter().enumerate() {
            recorder.push(&self.mask_at(camera, moment), k as f64 / fps).unwrap();
        }
        recorder.finish().unwrap()
    }

    /// The recordings of both cameras.
    pub fn recordings(&self, lines: usize) -> [Recording; 2] {
        [self.record(0, lines), self.record(1, lines)]
    }
}

/// Positive where a → b → c turns right on the screen.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
}

/// Clockwise hull of a few points (gift wrapping).
pub fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])));
    points.dedup();
    let mut hull = vec![points[0]];
    while hull.len() <= points.len() {
        let last = hull[hull.len() - 1];
        let mut next = if last == points[0] { points[1] } else { points[0] };
        for &candidate in &points {
            if candidate != last && turn(last, next, candidate) < 0.0 {
                next = candidate;
            }
        }
        if next == points[0] {
            break;
        }
        hull.push(next);
    }
    hull
}

/// Sets the pixels whose centres lie inside a clockwise polygon.
pub fn fill(mask: &mut [u8], width: usize, hull: &[[f64; 2]]) {
    let height = mask.len() / width;
    let (low, high) = hull
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[1]), high.max(p[1])));
    let (first, last) = (low.ceil().max(0.0), high.floor().min(height as f64 - 1.0));
    let mut y = first;
    while y <= last {
        // The row inside every edge: x between the greatest lower and the least upper bound.
        let (mut left, mut right) = (0.0f64, width as f64 - 1.0);
        for (i, p) in hull.iter().enumerate() {
            let q = hull[(i + 1) % hull.len()];
            let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
            // dx (y − p.y) − dy (x − p.x) ≥ 0.
            let bound = p[0] + dx * (y - p[1]) / dy;
            if dy > 0.0 {
                right = right.min(bound.floor());
            } else if dy < 0.0 {
                left = left.max(bound.ceil());
            }
        }
        if left <= right {
            mask[y as usize * width + left as usize..=y as usize * width + right as usize].fill(1);
        }
        y += 1.0;
    }
}
