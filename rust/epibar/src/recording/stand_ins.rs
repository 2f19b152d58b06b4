//! Silhouettes that stand for something else: upright boxes, and ellipses in such boxes, as detectors and hand-drawn data have them.
//!
//! What is convex by itself, as balls, cars and thrown things are, fills its hull as they do, and is no stand-in: its outlines are those of a thing. It is
//! hardly ever an upright box or ellipse, but for balls, and a disc is taken for one: what stands on a floor is not as wide as it is high.

use std::f64::consts::FRAC_PI_4;

use super::fill::{filled, pixels_of, shapely};
use super::silhouettes::Silhouettes;

/// A shape fills its hull by more than this share: outlines of whole pixels leave some of it.
const FILLED: f64 = 0.96;
/// A shape is a box or an ellipse if it has this share of the pixels of the box fewer or more, at most, and so many for each of half its outline: pixels
/// are whole, and a filter takes corners off.
const OFF: (f64, f64) = (0.03, 0.5);
/// Corners are on an ellipse within this share of the shorter half axis, and so many pixels.
const CORNER_OFF: (f64, f64) = (0.05, 1.5);
/// An ellipse whose axes differ by no more than this share of the longer one, and so many pixels, is a disc.
const ROUND: (f64, f64) = (0.15, 1.0);

/// The share of silhouettes that are upright boxes or ellipses, of those that are large enough to tell and that no border cuts, evenly over time; NaN
/// of none.
pub fn stand_ins(silhouettes: &Silhouettes) -> f64 {
    let whole = shapely(silhouettes, |i| !silhouettes.is_cut(i));
    let is_one = |&&i: &&usize| filled(silhouettes, i) >= FILLED && is_upright(silhouettes.hull(i));
    whole.iter().filter(is_one).count() as f64 / whole.len() as f64
}

/// Whether a hull is an upright box, or the ellipse in one.
fn is_upright(hull: &[[u16; 2]]) -> bool {
    let pixels = pixels_of(hull);
    let ends = |axis: usize| {
        let along = || hull.iter().map(|p| f64::from(p[axis]));
        (along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max))
    };
    let ((left, right), (top, bottom)) = (ends(0), ends(1));
    let (width, height) = (right - left + 1.0, bottom - top + 1.0);
    let off = |expected: f64| (pixels - expected).abs() <= OFF.0 * width * height + OFF.1 * (width + height);
    let shorter = 0.5 * width.min(height);
    let on_ellipse = |p: &[u16; 2]| {
        let [x, y] = p.map(f64::from);
        let along = (2.0 * x - left - right) / width;
        let radius = along.hypot((2.0 * y - top - bottom) / height);
        (radius - 1.0).abs() * shorter <= CORNER_OFF.0 * shorter + CORNER_OFF.1
    };
    let is_round = (width - height).abs() <= ROUND.0 * width.max(height) + ROUND.1;
    off(width * height) || !is_round && off(FRAC_PI_4 * width * height) && hull.iter().all(on_ellipse)
}

#[cfg(test)]
mod tests {
    use super::super::components::Components;
    use super::super::lens_corners::OutlineFinder;
    use super::*;
    use crate::image::ImageSize;

    /// Of one frame with pixels at some places from the middle.
    fn of(inside: impl Fn(f64, f64) -> bool) -> f64 {
        let size = ImageSize::new(200, 160).unwrap();
        let at = |k: usize| inside((k % 200) as f64 - 100.0, (k / 200) as f64 - 80.0);
        let mask: Vec<u8> = (0..size.pixels()).map(|k| u8::from(at(k))).collect();
        let (mut found, mut silhouettes) = (Components::new(), Silhouettes::default());
        found.find(&mask, size);
        silhouettes.push(&found, &mut OutlineFinder::default(), size, None, 2).unwrap();
        stand_ins(&silhouettes)
    }

    #[test]
    fn upright_boxes_and_ellipses_are_stand_ins() {
        for (a, b) in [(8.0, 20.0), (30.0, 12.0), (40.0, 70.0)] {
            assert_eq!(of(|x, y| x.abs() <= a && y.abs() <= b), 1.0, "{a} {b}");
            assert_eq!(of(|x, y| (x / (a + 0.5)).hypot(y / (b + 0.5)) <= 1.0), 1.0, "{a} {b}");
            // A filter takes the corners off.
            assert_eq!(of(|x, y| x.abs() <= a && y.abs() <= b && x.abs() + y.abs() <= a + b - 2.0), 1.0);
        }
    }

    #[test]
    fn what_is_convex_by_itself_is_none() {
        let of_turned =
            |inside: fn(f64, f64) -> bool| of(|x, y| inside(0.8 * x + 0.6 * y, 0.8 * y - 0.6 * x));
        assert_eq!(of_turned(|x, y| x.abs() <= 15.0 && y.abs() <= 40.0), 0.0);
        assert_eq!(of_turned(|x, y| (x / 15.0).hypot(y / 40.0) <= 1.0), 0.0);
        // A cube from aside, of three faces, and a diamond, whose corners are on the ellipse of its box.
        assert_eq!(of(|x, y| x.abs() <= 30.0 && (y - 0.5 * x).abs() <= 30.0), 0.0);
        assert_eq!(of(|x, y| x.abs() / 30.0 + y.abs() / 50.0 <= 1.0), 0.0);
        // A ball, and one that is moving a little in its frame.
        for (a, b) in [(20.0, 20.0), (8.0, 8.0), (22.0, 20.0)] {
            assert_eq!(of(|x, y| (x / (a + 0.5)).hypot(y / (b + 0.5)) <= 1.0), 0.0, "{a} {b}");
        }
        // Somebody with a gap between the legs.
        assert_eq!(of(|x, y| x.abs() <= 15.0 && y.abs() <= 40.0 && (x.abs() >= 5.0 || y <= 5.0)), 0.0);
    }

    #[test]
    fn what_is_small_or_cut_does_not_tell() {
        assert!(of(|x, y| x.abs() <= 3.0 && y.abs() <= 3.0).is_nan());
        assert!(of(|x, y| x <= -50.0 && y.abs() <= 20.0).is_nan());
    }
}
