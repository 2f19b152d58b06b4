//! The image area between two lines (paper §3.2, Fig. 5).

use crate::image::{ImageSize, Line, Segment};

/// Image area enclosed between two lines, pixels².
///
/// Two lines divide the image into the parts on either side of each. Where they cross inside the image there are four, and
/// the area is that of the smaller double wedge. Where they do not there are three, and the area is that of the one between
/// them. Equal lines enclose nothing. A line that misses the image counts as the whole image.
pub fn area_between(first: &Line, second: &Line, size: ImageSize) -> f64 {
    CutImage::new(first, size).area_to(second)
}

/// Pixels by which the end of a line must lie beside another one: nearer ones meet.
const MEETS: f64 = 1e-9;

/// On which side of a line a segment lies; `None` where it crosses the line or touches it.
fn side_of(segment: &Segment, line: &Line) -> Option<f64> {
    let (from, to) =
        (line.signed_distance(segment.x0, segment.y0), line.signed_distance(segment.x1, segment.y1));
    if from.min(to) > MEETS {
        Some(1.0)
    } else if from.max(to) < -MEETS {
        Some(-1.0)
    } else {
        None
    }
}

/// An image cut by a line, whose areas to many others are asked for.
pub(crate) struct CutImage {
    size: ImageSize,
    line: Line,
    /// The line inside the image, and the positive side with its area; `None` where the line misses the image.
    inside: Option<(Segment, Polygon, f64)>,
}

impl CutImage {
    pub(crate) fn new(line: &Line, size: ImageSize) -> Self {
        let inside = line.clip(size).map(|segment| {
            let mut side = Polygon::rectangle(size);
            side.cut(line, 1.0);
            (segment, side, side.area())
        });
        Self { size, line: *line, inside }
    }

    /// Image area between the line that cuts the image and another, pixels²: [`area_between`].
    pub(crate) fn area_to(&self, line: &Line) -> f64 {
        let total = self.size.x_max() * self.size.y_max();
        let (Some((own, positive, area)), Some(segment)) = (self.inside, line.clip(self.size)) else {
            return total;
        };
        if let (Some(theirs), Some(ours)) = (side_of(&segment, &self.line), side_of(&own, line)) {
            let mut between = if theirs > 0.0 { positive } else { Polygon::rectangle(self.size) };
            if theirs < 0.0 {
                between.cut(&self.line, -1.0);
            }
            between.cut(line, ours);
            return between.area();
        }
        let (mut together, mut other) = (positive, Polygon::rectangle(self.size));
        together.cut(line, 1.0);
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

    #[test]
    fn lines_that_do_not_cross_inside_enclose_what_lies_between() {
        let size = ImageSize::new(640, 480).unwrap();
        // Along top and bottom of the image: nearly all of it, not what is left of it.
        let (top, bottom) = (line(0.0, 1.0, -1.0), line(0.0, 1.0, -478.0));
        assert!((area_between(&top, &bottom, size) - 639.0 * 477.0).abs() < 1e-6);
        assert!((area_between(&bottom, &line(0.0, -1.0, 1.0), size) - 639.0 * 477.0).abs() < 1e-6);
        // Over opposite corners: all but two triangles.
        let (first, second) = (line(1.0, 1.0, -40.0), line(1.0, 1.0, -639.0 - 479.0 + 40.0));
        let (there, back) = (area_between(&first, &second, size), area_between(&second, &first, size));
        assert!((there - (639.0 * 479.0 - 1600.0)).abs() < 1e-6 && (there - back).abs() < 1e-6, "{there}");
        // One about the corner that another goes about as well.
        assert!((area_between(&first, &line(-1.0, -1.0, 30.0), size) - (800.0 - 450.0)).abs() < 1e-6);
    }
}
