//! What stands on the floor: silhouettes whose tops and bottoms meet in two cameras, as segments in space.
//!
//! Where both ends of a silhouette meet both ends of one silhouette of another camera, and are its top and its bottom in
//! both images, two frontier points of one object are known: points on its surface, true correspondences, and so points
//! in space. Walkers have their bottoms on one plane, are upright, and about equally tall wherever they are. Epipolar
//! constraints know nothing of this: they tell the vertical, the floor and the
//! scale.

use nalgebra::Vector3;

use super::tangents::{MatchedEnds, PairTangents, other_end};
use crate::network::model::camera::Camera;

/// A silhouette of two cameras with its top and its bottom, raw pixels in A and in B.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figure {
    /// Top in A, in B.
    pub top: [[f64; 2]; 2],
    /// Bottom in A, in B.
    pub bottom: [[f64; 2]; 2],
    /// Its breadth in A and in B, across the line from bottom to top, over the length of that line.
    pub breadth: [f64; 2],
}

/// Figures of a pair of cameras.
#[derive(Debug, Clone)]
pub struct PairFigures {
    /// Index of camera A.
    pub a: usize,
    /// Index of camera B.
    pub b: usize,
    /// The figures.
    pub figures: Vec<Figure>,
}

/// Below this share of up in a tangent's normal, top and bottom mean nothing.
const STEEP: f64 = 0.6;
/// Rays of a point that differ by less, radians, do not tell how far away it is.
const NARROW: f64 = 0.05;
/// Sine of the least angle between what is upright and the ray to it at which its height is seen.
const UPRIGHT_SEEN: f64 = 0.3;

/// The silhouettes of which both ends meet those of one silhouette of the other camera, top to top.
pub fn figures(tangents: &PairTangents, met: &[MatchedEnds]) -> Vec<Figure> {
    let mut found = Vec::new();
    for (k, low) in met.iter().enumerate() {
        let Some(high) = other_end(met, k) else { continue };
        let below = |m: &MatchedEnds| tangents.below(m);
        let top_first =
            |[a, b]: [f64; 2], [c, d]: [f64; 2]| a > STEEP && b > STEEP && c < -STEEP && d < -STEEP;
        let (of_low, of_high) = (below(low), below(high));
        let (top, bottom) = if top_first(of_low, of_high) {
            (low, high)
        } else if top_first(of_high, of_low) {
            (high, low)
        } else {
            continue;
        };
        let breadth = tangents.breadths(top, bottom);
        let [top, bottom] = [top, bottom].map(|m| tangents.pixels(m));
        found.push(Figure { top, bottom, breadth });
    }
    found
}

/// The point nearest to the rays of a pixel of A and a pixel of B; `None` behind a camera, or where the rays are
/// nearly parallel.
pub fn triangulated(a: &Camera, b: &Camera, pixels: [[f64; 2]; 2]) -> Option<Vector3<f64>> {
    let (point, [s, t]) = crossing(a, b, pixels)?;
    (s > 0.0 && t > 0.0).then_some(point)
}

/// The point nearest to the rays of a pixel of A and a pixel of B, and how far along each it is, less than nothing behind its camera; `None` where
/// the rays are nearly parallel.
pub fn crossing(a: &Camera, b: &Camera, pixels: [[f64; 2]; 2]) -> Option<(Vector3<f64>, [f64; 2])> {
    let (p, q) = (a.ray(pixels[0])?.normalize(), b.ray(pixels[1])?.normalize());
    let cosine = p.dot(&q);
    let sine2 = 1.0 - cosine * cosine;
    if sine2 < NARROW * NARROW {
        return None;
    }
    let between = b.position - a.position;
    let (along_p, along_q) = (between.dot(&p), between.dot(&q));
    let s = (along_p - cosine * along_q) / sine2;
    let t = (cosine * along_p - along_q) / sine2;
    Some((0.5 * (a.position + p * s + b.position + q * t), [s, t]))
}

/// A figure in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Upright {
    /// Its top.
    pub top: Vector3<f64>,
    /// Its bottom.
    pub bottom: Vector3<f64>,
    /// How broad it is over its height, the mean of what both cameras see; `None` where one of them sees it from straight above.
    pub breadth: Option<f64>,
}

/// A figure of two cameras in space; `None` where its top or its bottom is nowhere.
pub fn upright(a: &Camera, b: &Camera, figure: &Figure) -> Option<Upright> {
    let (top, bottom) = (triangulated(a, b, figure.top)?, triangulated(a, b, figure.bottom)?);
    let (along, middle) = ((top - bottom).try_normalize(0.0)?, 0.5 * (top + bottom));
    // What is upright looks shorter to a camera that looks down on it.
    let seen = [a, b].map(|camera| along.cross(&(middle - camera.position).normalize()).norm());
    let breadth = 0.5 * (figure.breadth[0] * seen[0] + figure.breadth[1] * seen[1]);
    let is_seen = seen[0].min(seen[1]) > UPRIGHT_SEEN && breadth.is_finite();
    Some(Upright { top, bottom, breadth: is_seen.then_some(breadth) })
}
