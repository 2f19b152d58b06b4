//! Points, segments and lines of an image.
//!
//! Convention: points are `(x, y)` in pixels, pixel **centres** at integers, so an image of
//! `width` × `height` pixels covers `-0.5 ≤ x ≤ width − 0.5`. A [`Line`] is `a·x + b·y + c = 0`
//! with `a² + b² = 1`; its sign is that of the vector it was made from, so `a·x + b·y + c` is a signed
//! distance in pixels.

use crate::{Error, Result};
use nalgebra::Vector3;

/// A homogeneous point or line: `(x, y, w)` or `(a, b, c)`.
pub type Homogeneous = Vector3<f64>;

/// Size of an image in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageSize {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
}

impl ImageSize {
    /// A checked size.
    ///
    /// # Errors
    /// [`Error::ImageSize`] unless both sides are between 2 and 16384 pixels.
    pub fn new(width: usize, height: usize) -> Result<Self> {
        if (2..=16384).contains(&width) && (2..=16384).contains(&height) {
            Ok(Self { width, height })
        } else {
            Err(Error::ImageSize { width, height })
        }
    }

    /// Number of pixels.
    pub fn pixels(self) -> usize {
        self.width * self.height
    }

    /// Length of the diagonal, pixels.
    pub fn diagonal(self) -> f64 {
        (self.width as f64).hypot(self.height as f64)
    }

    /// Right-most pixel centre.
    pub fn x_max(self) -> f64 {
        (self.width - 1) as f64
    }

    /// Lowest pixel centre.
    pub fn y_max(self) -> f64 {
        (self.height - 1) as f64
    }
}

/// A segment between two image points, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// x of the first end.
    pub x0: f64,
    /// y of the first end.
    pub y0: f64,
    /// x of the second end.
    pub x1: f64,
    /// y of the second end.
    pub y1: f64,
}

impl Segment {
    /// The point half way.
    pub fn midpoint(&self) -> [f64; 2] {
        [0.5 * (self.x0 + self.x1), 0.5 * (self.y0 + self.y1)]
    }

    /// Length in pixels.
    pub fn length(&self) -> f64 {
        let (dx, dy) = (self.x1 - self.x0, self.y1 - self.y0);
        (dx * dx + dy * dy).sqrt()
    }

    /// The line through both ends; `None` where they coincide.
    pub fn line(&self) -> Option<Line> {
        Line::from_homogeneous(
            &Vector3::new(self.x0, self.y0, 1.0).cross(&Vector3::new(self.x1, self.y1, 1.0)),
        )
    }
}

/// A line `a·x + b·y + c = 0` with `a² + b² = 1`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// x component of the unit normal.
    pub a: f64,
    /// y component of the unit normal.
    pub b: f64,
    /// Signed distance of the origin, pixels.
    pub c: f64,
}

impl Line {
    /// Normalises `(a, b, c)`, keeping its sign; `None` for the line at infinity or non-finite input.
    pub fn from_homogeneous(line: &Homogeneous) -> Option<Self> {
        // Not `hypot`, which took half the time of a line score; image coordinates do not overflow.
        let norm = (line.x * line.x + line.y * line.y).sqrt();
        let scaled = line / norm;
        (norm > 0.0 && scaled.iter().all(|v| v.is_finite())).then_some(Self {
            a: scaled.x,
            b: scaled.y,
            c: scaled.z,
        })
    }

    /// The line as a homogeneous vector.
    pub fn homogeneous(&self) -> Homogeneous {
        Vector3::new(self.a, self.b, self.c)
    }

    /// Signed distance of a point, pixels.
    pub fn signed_distance(&self, x: f64, y: f64) -> f64 {
        self.a * x + self.b * y + self.c
    }

    /// The part of the line inside the rectangle of pixel centres, `None` where it misses it.
    pub fn clip(&self, size: ImageSize) -> Option<Segment> {
        // The point nearest the origin plus t times the direction, clipped against two slabs.
        let (px, py) = (-self.a * self.c, -self.b * self.c);
        let (dx, dy) = (-self.b, self.a);
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for (p, d, max) in [(px, dx, size.x_max()), (py, dy, size.y_max())] {
            if d.abs() < 1e-12 {
                if p < 0.0 || p > max {
                    return None;
                }
            } else {
                let (t0, t1) = ((0.0 - p) / d, (max - p) / d);
                low = low.max(t0.min(t1));
                high = high.min(t0.max(t1));
            }
        }
        (low < high).then_some(Segment {
            x0: px + low * dx,
            y0: py + low * dy,
            x1: px + high * dx,
            y1: py + high * dy,
        })
    }
}

/// Image area enclosed between two lines, pixels² (paper §3.2, Fig. 5).
///
/// The image rectangle is cut by both lines; the area is that of the points on different sides of
/// the two, with sides chosen so that equal lines enclose nothing: of the two double wedges that the lines
/// form, the smaller one inside the image. A line that misses the image counts as the whole image.
pub fn area_between(first: &Line, second: &Line, size: ImageSize) -> f64 {
    CutImage::new(first, size).area_to(second)
}

/// An image cut by a line, whose areas to many others are asked for.
pub(crate) struct CutImage {
    size: ImageSize,
    /// The positive side, and its area; `None` where the line misses the image.
    side: Option<(Polygon, f64)>,
}

impl CutImage {
    pub(crate) fn new(line: &Line, size: ImageSize) -> Self {
        let side = line.clip(size).map(|_| {
            let mut side = Polygon::rectangle(size);
            side.cut(line, 1.0);
            (side, side.area())
        });
        Self { size, side }
    }

    /// As [`area_between`].
    pub(crate) fn area_to(&self, line: &Line) -> f64 {
        let total = self.size.x_max() * self.size.y_max();
        let Some((mut together, area)) = self.side else { return total };
        if line.clip(self.size).is_none() {
            return total;
        }
        together.cut(line, 1.0);
        let mut other = Polygon::rectangle(self.size);
        other.cut(line, 1.0);
        // Symmetric difference of the two half planes; its complement is the other double wedge.
        let wedge = (area + other.area() - 2.0 * together.area()).max(0.0);
        wedge.min(total - wedge)
    }
}

/// A convex polygon of at most eight corners on the stack: a rectangle after a few cuts.
#[derive(Clone, Copy)]
struct Polygon {
    points: [[f64; 2]; 8],
    len: usize,
}

impl Polygon {
    fn rectangle(size: ImageSize) -> Self {
        let (x, y) = (size.x_max(), size.y_max());
        let mut points = [[0.0; 2]; 8];
        points[1] = [x, 0.0];
        points[2] = [x, y];
        points[3] = [0.0, y];
        Self { points, len: 4 }
    }

    /// Keeps the side where `sign · (a·x + b·y + c) ≥ 0` (Sutherland and Hodgman).
    fn cut(&mut self, line: &Line, sign: f64) {
        let before = *self;
        self.len = 0;
        for i in 0..before.len {
            let p = before.points[i];
            let q = before.points[(i + 1) % before.len];
            let dp = sign * line.signed_distance(p[0], p[1]);
            let dq = sign * line.signed_distance(q[0], q[1]);
            if dp >= 0.0 {
                self.push(p);
            }
            if (dp > 0.0 && dq < 0.0) || (dp < 0.0 && dq > 0.0) {
                let t = dp / (dp - dq);
                self.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
            }
        }
    }

    fn push(&mut self, point: [f64; 2]) {
        if self.len < self.points.len() {
            self.points[self.len] = point;
            self.len += 1;
        }
    }

    fn area(&self) -> f64 {
        let mut twice = 0.0;
        for i in 0..self.len {
            let (p, q) = (self.points[i], self.points[(i + 1) % self.len]);
            twice += p[0] * q[1] - q[0] * p[1];
        }
        0.5 * twice.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(a: f64, b: f64, c: f64) -> Line {
        Line::from_homogeneous(&Vector3::new(a, b, c)).unwrap()
    }

    #[test]
    fn clips_to_pixel_centres() {
        let size = ImageSize::new(11, 6).unwrap();
        let s = line(0.0, 1.0, -2.0).clip(size).unwrap();
        assert!((s.length() - 10.0).abs() < 1e-12 && (s.midpoint()[1] - 2.0).abs() < 1e-12);
        assert!(line(0.0, 1.0, -7.0).clip(size).is_none());
    }

    #[test]
    fn area_between_parallel_and_crossing_lines() {
        let size = ImageSize::new(101, 51).unwrap();
        let area = |p: &Line, q: &Line| area_between(p, q, size);
        let (two, five) = (line(0.0, 1.0, -2.0), line(0.0, 1.0, -5.0));
        assert!((area(&two, &five) - 300.0).abs() < 1e-9);
        // The sign of a line does not matter, nor the order.
        assert!((area(&line(0.0, -1.0, 2.0), &five) - 300.0).abs() < 1e-9);
        assert!((area(&five, &two) - 300.0).abs() < 1e-9);
        assert!(area(&two, &two) < 1e-9);
        // Two lines crossing in the middle at ±h over the half width: two triangles.
        let up = line(-0.2, 1.0, -25.0 + 10.0);
        let down = line(0.2, 1.0, -25.0 - 10.0);
        assert!((area(&up, &down) - 2.0 * 0.5 * 50.0 * 20.0).abs() < 1e-6);
    }
}
