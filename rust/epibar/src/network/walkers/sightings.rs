//! One silhouette in two cameras at one moment: its top and its bottom meet in both, and it stands on the floor.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::triangulate::{Ray, covariance};
use crate::network::model::camera::Camera;
use crate::network::observations::ends::{CameraView, Ends, ends, wrapped};
use crate::network::observations::figures::triangulated;
use crate::network::observations::observed::Observed;
use crate::recording::at_moment::Between;
use crate::recording::visible::on_border;

/// Below this share of up in a tangent's normal, top and bottom mean nothing.
const STEEP: f64 = 0.6;
/// A bottom is on the floor within this share of the median height.
const ON_FLOOR: f64 = 0.15;
/// Heights over their median.
const HEIGHTS: std::ops::Range<f64> = 0.55..1.4;
/// A walker's top is above its bottom within this share of the median height: a stride, and some more.
const LEAN: f64 = 0.45;

/// A silhouette of one camera and one of another that may be one walker's.
#[derive(Debug, Clone, PartialEq)]
pub struct Sighting {
    /// The cameras.
    pub cameras: [usize; 2],
    /// Which silhouette of each, in the order of [`Eye::moments`].
    pub silhouettes: [usize; 2],
    /// Pixels of the top.
    pub top: [[f64; 2]; 2],
    /// Pixels of the bottom.
    pub foot: [[f64; 2]; 2],
    /// Top and bottom in space.
    pub segment: [Vector3<f64>; 2],
    /// Covariance of either by the scatter of tangents.
    pub covariance: [Matrix3<f64>; 2],
    /// Distance of the ends over the radius, root mean square.
    pub distance: f64,
}

/// Standard deviations of what meets that a radius is.
pub const DEVIATIONS: f64 = 4.0;

/// Whether a top and a bottom can be those of somebody who stands on the floor, where half are taller than `height`.
pub fn stands([top, foot]: [&Vector3<f64>; 2], height: f64) -> bool {
    let body = (top - foot) / height;
    foot.z.abs() < ON_FLOOR * height && HEIGHTS.contains(&body.z) && body.x.hypot(body.y) < LEAN
}

/// What one camera sees at each of some moments.
pub struct Eye<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Its silhouettes.
    pub observed: &'a Observed,
    /// The silhouettes at each moment; none where it saw nothing.
    pub moments: Vec<Vec<Between<u32>>>,
    /// Whether it was filming at each moment.
    filming: Vec<bool>,
    visible: Option<&'a [u8]>,
    rays: Vec<Vector3<f64>>,
    wanted: Vec<bool>,
}

impl<'a> Eye<'a> {
    /// At moments of the network's time; `visible` is as that of [`on_border`].
    pub fn new(camera: &'a Camera, observed: &'a Observed, visible: Option<&'a [u8]>, times: &[f64]) -> Self {
        let at: Vec<_> = times.iter().map(|&t| observed.moment(camera.clock_at(t))).collect();
        let moments = at
            .iter()
            .map(|moment| {
                let mut seen = Vec::new();
                if let Some(moment) = moment {
                    observed.between(*moment, &mut seen);
                }
                seen
            })
            .collect();
        let wanted = observed.wanted(at.iter().flatten().map(|m| m.frame));
        let filming = at.iter().map(Option::is_some).collect();
        Self { camera, observed, moments, filming, visible, rays: observed.rays(camera, &wanted), wanted }
    }

    /// The pixel of a point that the camera sees if nothing is in the way; `None` where it does not look, or nothing tells.
    pub fn looks_at(&self, moment: usize, point: &Vector3<f64>) -> Option<[f64; 2]> {
        if !self.filming[moment] {
            return None;
        }
        self.camera.project(point).filter(|&pixel| !on_border(self.observed.size, self.visible, pixel))
    }

    /// Whether a silhouette reaches a pixel to within a margin.
    pub fn covers(&self, moment: usize, pixel: [f64; 2], margin: f64) -> bool {
        self.moments[moment].iter().any(|between| {
            let points = || self.observed.range(between.first).map(|i| self.observed.point(i as u32));
            (0..2).all(|k| {
                points().any(|p| p[k] > pixel[k] - margin) && points().any(|p| p[k] < pixel[k] + margin)
            })
        })
    }

    fn view(&self) -> CameraView<'_> {
        CameraView { observed: self.observed, camera: self.camera, rays: &self.rays }
    }

    fn ends(&self, axis: &Vector3<f64>) -> Ends {
        ends(&self.view(), axis, &self.wanted)
    }

    /// Where one side of a silhouette is touched; `None` where it has no tangent.
    fn touch(&self, ends: &Ends, between: &Between<u32>, side: usize) -> Option<Touch> {
        let (p, q) = (&ends[between.first as usize][side], &ends[between.last as usize][side]);
        let mean = |a: f64, b: f64| a + between.share * (b - a);
        let angle = p.angle + between.share * wrapped(q.angle - p.angle);
        if angle.is_nan() {
            return None;
        }
        let (at_p, at_q) = (self.observed.point(p.point), self.observed.point(q.point));
        let outward = [0, 1].map(|k| mean(p.outward[k], q.outward[k]));
        let inset = self.view().inset(between.first, outward);
        Some(Touch {
            angle,
            per_pixel: mean(p.per_pixel, q.per_pixel),
            below: -outward[1],
            pixel: [0, 1].map(|k| mean(at_p[k], at_q[k]) + inset * outward[k]),
        })
    }

    fn touches(&self, ends: &Ends, moment: usize) -> Vec<[Option<Touch>; 2]> {
        let both = |between| [0, 1].map(|side| self.touch(ends, between, side));
        self.moments[moment].iter().map(both).collect()
    }
}

/// A tangent of a silhouette at a moment.
#[derive(Debug, Clone, Copy)]
struct Touch {
    angle: f64,
    per_pixel: f64,
    /// Where the object lies from it along the image's `y` axis: 1 below, −1 above.
    below: f64,
    pixel: [f64; 2],
}

impl Touch {
    /// Pixels to that of another camera.
    fn distance(&self, other: &Self) -> f64 {
        wrapped(self.angle - other.angle).abs() / self.per_pixel.hypot(other.per_pixel)
    }
}

/// What two cameras see alike within a radius, pixels, at each moment.
pub fn sightings(eyes: &[Eye], pair: [usize; 2], radius: f64, height: f64) -> Vec<Vec<Sighting>> {
    let [a, b] = pair.map(|k| &eyes[k]);
    let axis = b.camera.position - a.camera.position;
    let (ends_a, ends_b) = rayon::join(|| a.ends(&axis), || b.ends(&axis));
    (0..a.moments.len())
        .into_par_iter()
        .with_min_len(32)
        .map(|moment| {
            let (in_a, in_b) = (a.touches(&ends_a, moment), b.touches(&ends_b, moment));
            let mut found = Vec::new();
            for (i, p) in in_a.iter().enumerate() {
                for (j, q) in in_b.iter().enumerate() {
                    let Some(whole) = Whole::of(p, q, radius) else { continue };
                    let at = |pixels| triangulated(a.camera, b.camera, pixels);
                    let (Some(top), Some(foot)) = (at(whole.top), at(whole.foot)) else { continue };
                    let within = |pixels: [[f64; 2]; 2], at: &Vector3<f64>| {
                        let rays = [Ray::new(0, a.camera, pixels[0])?, Ray::new(1, b.camera, pixels[1])?];
                        covariance(&rays, at, radius / DEVIATIONS)
                    };
                    if !stands([&top, &foot], height) {
                        continue;
                    }
                    if let (Some(of_top), Some(of_foot)) =
                        (within(whole.top, &top), within(whole.foot, &foot))
                    {
                        found.push(Sighting {
                            cameras: pair,
                            silhouettes: [i, j],
                            top: whole.top,
                            foot: whole.foot,
                            segment: [top, foot],
                            covariance: [of_top, of_foot],
                            distance: whole.distance,
                        });
                    }
                }
            }
            found
        })
        .collect()
}

/// Both ends of a silhouette that meet both of another.
struct Whole {
    top: [[f64; 2]; 2],
    foot: [[f64; 2]; 2],
    distance: f64,
}

impl Whole {
    fn of(a: &[Option<Touch>; 2], b: &[Option<Touch>; 2], radius: f64) -> Option<Self> {
        let [low, high] = [(a[0]?, b[0]?), (a[1]?, b[1]?)];
        let far = [&low, &high].map(|(p, q)| p.distance(q) / radius);
        if far[0] >= 1.0 || far[1] >= 1.0 {
            return None;
        }
        let is_top = |(p, q): &(Touch, Touch)| p.below > STEEP && q.below > STEEP;
        let is_foot = |(p, q): &(Touch, Touch)| p.below < -STEEP && q.below < -STEEP;
        let (top, foot) = match (low, high) {
            (low, high) if is_top(&low) && is_foot(&high) => (low, high),
            (low, high) if is_top(&high) && is_foot(&low) => (high, low),
            _ => return None,
        };
        let pixels = |(p, q): (Touch, Touch)| [p.pixel, q.pixel];
        let distance = (0.5 * (far[0] * far[0] + far[1] * far[1])).sqrt();
        Some(Self { top: pixels(top), foot: pixels(foot), distance })
    }
}
