//! The two planes through both cameras between which a silhouette lies, as angles about the line that joins the cameras.

use nalgebra::Vector3;
use rayon::prelude::*;
use std::f64::consts::TAU;

use super::observed::Observed;
use crate::geometry::across::across;
use crate::network::model::camera::Camera;

/// What two cameras are compared with.
#[derive(Clone, Copy)]
pub struct CameraView<'a> {
    /// Silhouettes.
    pub observed: &'a Observed,
    /// The camera.
    pub camera: &'a Camera,
    /// Rays of the silhouettes' points.
    pub rays: &'a [Vector3<f64>],
}

impl CameraView<'_> {
    /// By how many pixels the true outline of a silhouette lies further outward than its hull, along a tangent's normal.
    pub fn inset(&self, silhouette: u32, outward: [f64; 2]) -> f64 {
        self.camera.insets.at(outward, self.observed.smallness(silhouette))
    }
}

/// One end of a silhouette's interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// Dihedral angle; NaN where there is no tangent.
    pub angle: f64,
    /// Change of the angle by a pixel, across the tangent.
    pub per_pixel: f64,
    /// Away from the object, across the tangent, in the image; unit length.
    pub outward: [f64; 2],
    /// Which point is touched.
    pub point: u32,
}

const NO_END: End = End { angle: f64::NAN, per_pixel: f64::NAN, outward: [0.0; 2], point: 0 };

impl End {
    /// Where the object lies from the tangent, along the image's `y` axis: 1 below, −1 above, 0 beside.
    pub fn below(&self) -> f64 {
        -self.outward[1]
    }
}

/// Wider than this, radians, no silhouette is one object before one camera.
const WIDEST: f64 = 2.5;

/// The lower and the upper end of each silhouette of one camera.
pub type Ends = Vec<[End; 2]>;

/// Ends of the wanted silhouettes about an axis through the camera; `rays` are those of [`Observed::rays`].
pub fn ends(seen: &CameraView, axis: &Vector3<f64>, wanted: &[bool]) -> Ends {
    let [u, v] = across(axis);
    wanted
        .par_iter()
        .enumerate()
        .with_min_len(256)
        .map(|(silhouette, wanted)| {
            let range = seen.observed.range(silhouette as u32);
            let Some([low, high]) = wanted.then(|| extreme_rays(&seen.rays[range.clone()], &u, &v)).flatten()
            else {
                return [NO_END; 2];
            };
            let end = |i: usize, sense: f64| {
                let point = range.start + i;
                if seen.observed.is_cut(point as u32) {
                    return NO_END;
                }
                end_at(seen, silhouette as u32, point, &u, &v, sense)
            };
            let [low, high] = [end(low, 1.0), end(high, -1.0)];
            // The interval may reach across the half turn, where angles jump.
            let high = if high.angle < low.angle { End { angle: high.angle + TAU, ..high } } else { high };
            if high.angle - low.angle > WIDEST { [NO_END; 2] } else { [low, high] }
        })
        .collect()
}

/// Which rays have the least and the greatest angle; `None` where they surround the axis.
fn extreme_rays(rays: &[Vector3<f64>], u: &Vector3<f64>, v: &Vector3<f64>) -> Option<[usize; 2]> {
    let at = |i: usize| [rays[i].dot(u), rays[i].dot(v)];
    let left_of = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
    let (mut low, mut high) = (0, 0);
    if rays.is_empty() {
        return None;
    }
    let (mut at_low, mut at_high) = (at(0), at(0));
    for i in 1..rays.len() {
        let p = at(i);
        if left_of(at_low, p) < 0.0 {
            (low, at_low) = (i, p);
        } else if left_of(at_high, p) > 0.0 {
            (high, at_high) = (i, p);
        }
    }
    let between = (0..rays.len()).map(at).all(|p| left_of(at_low, p) >= 0.0 && left_of(p, at_high) >= 0.0);
    (between && left_of(at_low, at_high) >= 0.0).then_some([low, high])
}

fn end_at(
    seen: &CameraView,
    silhouette: u32,
    point: usize,
    u: &Vector3<f64>,
    v: &Vector3<f64>,
    sense: f64,
) -> End {
    let Some(look) = seen.camera.optics().look(seen.observed.point(point as u32)) else { return NO_END };
    let ray = &seen.rays[point];
    let (p, q) = (ray.dot(u), ray.dot(v));
    let gradient = (v * p - u * q) / (p * p + q * q).max(1e-300);
    let across = seen.camera.rotation * gradient;
    let by_pixel = look.jacobian.tr_mul(&across.xy());
    let per_pixel = by_pixel.norm();
    // At the lower end the object lies towards greater angles.
    let outward: [f64; 2] = (by_pixel * (-sense / per_pixel.max(1e-300))).into();
    let inset = seen.inset(silhouette, outward);
    End { angle: q.atan2(p) - sense * inset * per_pixel, per_pixel, outward, point: point as u32 }
}

/// An angle between −π and π.
pub fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}
