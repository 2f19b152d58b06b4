//! The image area between two lines (paper §3.2, Fig. 5).

use crate::image::{ImageSize, Line};

/// Image area enclosed between two lines, pixels².
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

    /// Image area between the line that cuts the image and another, pixels²: [`area_between`].
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
    use nalgebra::Vector3;

    fn line(a: f64, b: f64, c: f64) -> Line {
        Line::from_homogeneous(&Vector3::new(a, b, c)).unwrap()
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
