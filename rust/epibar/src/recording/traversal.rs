//! The pixels of a segment, in integers.
//!
//! One pixel per step along the major axis (the one along which the segment is longer; x on a tie),
//! the minor coordinate rounded to the nearest pixel, halves towards larger coordinates. The
//! remainder is carried in integers, so nothing drifts, and the ends are ordered first, so the walk
//! visits the same pixels whichever end is given first. Each pixel is at most ½ px from the line,
//! measured along the minor axis.
//!
//! Real-valued ends are rounded to the nearest pixel centre first, which moves the line by up to ½ px
//! at its ends; the segments of [`border_segments`](super::sampling::border_segments) are integer and are not moved.
//!
//! The pixels of a line are 8-connected, not 4-connected. A 4-connected set of pixels that lies on both sides
//! of a line therefore shares a pixel with it; two blobs that touch at a corner only may let a line
//! slip through between them.

use crate::image::{ImageSize, Segment};

/// Coordinates beyond this overflow the integer walk: over 30,000 times the largest image.
const REACH: f64 = (1_i64 << 29) as f64;

/// Whether [`for_each_pixel`] can walk the segment: its ends are finite and below 2²⁹ px in magnitude.
pub fn is_walkable(segment: &Segment) -> bool {
    [segment.x0, segment.y0, segment.x1, segment.y1].iter().all(|v| v.abs() < REACH)
}

/// Calls `visit` with the row-major index of every pixel of the segment inside the image, each once.
///
/// The part outside the image is cut off without bending the rest. A segment that is not
/// [walkable](is_walkable) has no pixels.
#[inline]
pub fn for_each_pixel(segment: &Segment, size: ImageSize, visit: impl FnMut(usize)) {
    if let Some(mut walk) = Walk::new(segment, size) {
        walk.visit_while(|_| true, visit);
    }
}

/// A walk along a segment that can be interrupted. From here on m runs along the major axis and n along the minor one.
#[derive(Debug, Clone)]
pub(super) struct Walk {
    m: i64,
    last: i64,
    n: i64,
    /// Of n over the denominator, from 0.
    remainder: i64,
    denominator: i64,
    /// What n and the remainder grow by in a step.
    whole: i64,
    part: i64,
    /// Length of the image along n.
    length: i64,
    /// Index steps along m and n.
    strides: (i64, i64),
    steep: bool,
}

impl Walk {
    /// At the first pixel; `None` where the segment is not [walkable](is_walkable).
    pub(super) fn new(segment: &Segment, size: ImageSize) -> Option<Self> {
        if !is_walkable(segment) {
            return None;
        }
        let (width, height) = (size.width as i64, size.height as i64);
        let (x0, y0) = (nearest(segment.x0), nearest(segment.y0));
        let (x1, y1) = (nearest(segment.x1), nearest(segment.y1));
        let steep = (y1 - y0).abs() > (x1 - x0).abs();
        let (from, to, lengths, strides) = if steep {
            ((y0, x0), (y1, x1), (height, width), (width, 1))
        } else {
            ((x0, y0), (x1, y1), (width, height), (1, width))
        };
        let (from, to) = if from.0 <= to.0 { (from, to) } else { (to, from) };
        let (dm, dn) = ((to.0 - from.0).max(1), to.1 - from.1);

        // n = floor(from.1 + (m − from.0)·dn/dm + ½) over the denominator 2·dm, remainder kept in 0..2·dm.
        let (first, last) = (from.0.max(0), to.0.min(lengths.0 - 1));
        let denominator = 2 * dm;
        let start = 2 * (first - from.0) * dn + dm;
        Some(Self {
            m: first,
            last,
            n: from.1 + start.div_euclid(denominator),
            remainder: start.rem_euclid(denominator),
            denominator,
            whole: (2 * dn).div_euclid(denominator),
            part: (2 * dn).rem_euclid(denominator),
            length: lengths.1,
            strides,
            steep,
        })
    }

    /// Whether rows only grow along the walk; otherwise they only shrink.
    pub(super) fn is_downwards(&self) -> bool {
        self.steep || self.whole >= 0
    }

    /// Goes on for as long as `inside` holds for the row (which may lie outside the image), and visits the pixels inside
    /// the image.
    #[inline]
    pub(super) fn visit_while(&mut self, inside: impl Fn(i64) -> bool, mut visit: impl FnMut(usize)) {
        let Self { mut m, mut n, mut remainder, .. } = *self;
        while m <= self.last && inside(if self.steep { m } else { n }) {
            if (0..self.length).contains(&n) {
                visit((m * self.strides.0 + n * self.strides.1) as usize);
            }
            remainder += self.part;
            let carry = i64::from(remainder >= self.denominator);
            remainder -= carry * self.denominator;
            n += self.whole + carry;
            m += 1;
        }
        (self.m, self.n, self.remainder) = (m, n, remainder);
    }
}

/// The pixels of the segment inside the image as `(x, y)`, in order along the major axis.
pub fn pixels(segment: &Segment, size: ImageSize) -> Vec<(usize, usize)> {
    let mut pixels = Vec::new();
    for_each_pixel(segment, size, |index| {
        pixels.push((index % size.width, index / size.width));
    });
    pixels
}

fn nearest(value: f64) -> i64 {
    (value + 0.5).floor() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(x0: f64, y0: f64, x1: f64, y1: f64) -> Segment {
        Segment { x0, y0, x1, y1 }
    }

    #[test]
    fn a_known_walk() {
        let size = ImageSize::new(10, 6).unwrap();
        let walk = pixels(&segment(0.0, 0.0, 5.0, 2.0), size);
        assert_eq!(walk, [(0, 0), (1, 0), (2, 1), (3, 1), (4, 2), (5, 2)]);
        assert_eq!(pixels(&segment(3.0, 3.0, 3.0, 3.0), size), [(3, 3)]);
        assert_eq!(pixels(&segment(3.4, 2.6, 2.6, 3.4), size), [(3, 3)]);
    }

    #[test]
    fn outside_is_cut_off_without_bending() {
        let size = ImageSize::new(16, 9).unwrap();
        let large = ImageSize::new(100, 100).unwrap();
        // The same segment in a larger image, shifted so that it all fits.
        for (dx, dy) in [(31.0, 17.0), (-35.0, 23.0), (9.0, -38.0), (40.0, 0.0)] {
            let (x0, y0) = (8.0 - dx, 4.0 - dy);
            let (x1, y1) = (8.0 + dx, 5.0 + dy);
            let cut = pixels(&segment(x0, y0, x1, y1), size);
            let whole = pixels(&segment(x0 + 40.0, y0 + 40.0, x1 + 40.0, y1 + 40.0), large);
            let inside: Vec<_> = whole
                .iter()
                .filter(|(x, y)| (40..56).contains(x) && (40..49).contains(y))
                .map(|(x, y)| (x - 40, y - 40))
                .collect();
            assert!(!cut.is_empty());
            assert_eq!(cut, inside);
        }
        assert!(pixels(&segment(-5.0, 20.0, 30.0, 21.0), size).is_empty());
        assert!(pixels(&segment(-9.0, 2.0, -3.0, 2.0), size).is_empty());
    }

    #[test]
    fn what_cannot_be_walked_has_no_pixels() {
        let size = ImageSize::new(16, 9).unwrap();
        for bad in [f64::NAN, f64::INFINITY, -1e10] {
            assert!(pixels(&segment(0.0, 0.0, bad, 3.0), size).is_empty());
        }
        assert_eq!(pixels(&segment(-5e8, 4.0, 5e8, 4.0), size).len(), 16);
    }
}
