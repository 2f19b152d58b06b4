//! An image: its size, and points, segments and lines in it.
//!
//! Convention: points are `(x, y)` in pixels, pixel **centres** at integers, so an image of
//! `width` × `height` pixels covers `-0.5 ≤ x ≤ width − 0.5`. A [`Line`] is `a·x + b·y + c = 0`
//! with `a² + b² = 1`; its sign is that of the vector it was made from, so `a·x + b·y + c` is a signed
//! distance in pixels.

use crate::error::{Error, Result};
use nalgebra::Vector3;

/// A homogeneous point or line: `(x, y, w)` or `(a, b, c)`.
pub type Homogeneous = Vector3<f64>;

/// Size of an image in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageSize {
    pub(crate) width: usize,
    pub(crate) height: usize,
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

    /// Width in pixels.
    pub fn width(self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(self) -> usize {
        self.height
    }

    /// Number of pixels.
    pub fn pixels(self) -> usize {
        self.width * self.height
    }

    /// Length of the diagonal, pixels.
    pub fn diagonal(self) -> f64 {
        (self.width as f64).hypot(self.height as f64)
    }

    /// Pixels of two images for one of a 640×480 image, whose diagonal is 800: their mean diagonal over that, not below ¼.
    pub(crate) fn pixel_scale([a, b]: [Self; 2]) -> f64 {
        (0.5 * (a.diagonal() + b.diagonal()) / 800.0).max(0.25)
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
    pub(crate) a: f64,
    pub(crate) b: f64,
    pub(crate) c: f64,
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

    /// x component of the unit normal.
    pub fn a(&self) -> f64 {
        self.a
    }

    /// y component of the unit normal.
    pub fn b(&self) -> f64 {
        self.b
    }

    /// Signed distance of the origin, pixels.
    pub fn c(&self) -> f64 {
        self.c
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
}
