//! Lines to watch: two points on the image border, on different sides (paper §2).
//!
//! Both points are pixel centres, so that the traversal of the line is exact in integers. Line `i`
//! draws from its own generator, made of the seed and `i` alone: the first lines of a larger set are
//! the lines of a smaller one, and no thread count changes them.

use crate::image::{ImageSize, Segment};
use crate::random::{below, line_generator};

/// `count` segments from border to border.
///
/// The ends are uniform over the pixels of the border among the pairs that do not share a side; a
/// corner belongs to both of its sides, so no segment runs along the border. An image less than two
/// pixels wide or high (which [`ImageSize::new`] refuses) has no such pair and gives no segments.
pub fn border_segments(size: ImageSize, count: usize, seed: u64) -> Vec<Segment> {
    if size.width < 2 || size.height < 2 {
        return Vec::new();
    }
    (0..count as u64).map(|index| border_segment(size, seed, index)).collect()
}

fn border_segment(size: ImageSize, seed: u64, index: u64) -> Segment {
    let mut random = line_generator(seed, index);
    let perimeter = 2 * (size.width - 1 + size.height - 1);
    loop {
        let [p, q] = [(); 2].map(|()| border_pixel(size, below(&mut random, perimeter)));
        if !share_side(size, p, q) {
            return Segment { x0: p[0] as f64, y0: p[1] as f64, x1: q[0] as f64, y1: q[1] as f64 };
        }
    }
}

/// The border pixel at a position counted around the image from its first pixel, rightwards.
fn border_pixel(size: ImageSize, position: usize) -> [usize; 2] {
    let (right, bottom) = (size.width - 1, size.height - 1);
    if position < right {
        [position, 0]
    } else if position < right + bottom {
        [right, position - right]
    } else if position < 2 * right + bottom {
        [2 * right + bottom - position, bottom]
    } else {
        [0, 2 * (right + bottom) - position]
    }
}

fn share_side(size: ImageSize, p: [usize; 2], q: [usize; 2]) -> bool {
    let ends = [size.width - 1, size.height - 1];
    (0..2).any(|axis| p[axis] == q[axis] && (p[axis] == 0 || p[axis] == ends[axis]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ends as integers, which they must be.
    fn ends(s: &Segment) -> [i64; 4] {
        let ends = [s.x0, s.y0, s.x1, s.y1];
        assert!(ends.iter().all(|v| v.fract().abs() < f64::EPSILON));
        ends.map(|v| v as i64)
    }

    #[test]
    fn ends_lie_on_two_sides_and_a_prefix_is_a_prefix() {
        let size = ImageSize::new(37, 20).unwrap();
        let many = border_segments(size, 5000, 7);
        assert_eq!(many[..300], border_segments(size, 300, 7));
        assert_ne!(many[..300], border_segments(size, 300, 8));
        for [x0, y0, x1, y1] in many.iter().map(ends) {
            for (x, y) in [(x0, y0), (x1, y1)] {
                assert!((0..=36).contains(&x) && (0..=19).contains(&y));
                assert!(x == 0 || x == 36 || y == 0 || y == 19);
            }
            assert!(x0 != x1 || (x0 != 0 && x0 != 36), "along the border");
            assert!(y0 != y1 || (y0 != 0 && y0 != 19), "along the border");
        }
        assert_eq!(border_segments(ImageSize::new(2, 2).unwrap(), 50, 0).len(), 50);
    }

    #[test]
    fn every_border_pixel_is_one_position() {
        let size = ImageSize::new(5, 4).unwrap();
        let mut all: Vec<_> = (0..14).map(|p| border_pixel(size, p)).collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 14);
        assert!(all.iter().all(|&[x, y]| x == 0 || x == 4 || y == 0 || y == 3));
    }

    #[test]
    fn the_lines_of_a_seed_never_change() {
        let first = &border_segments(ImageSize::new(640, 480).unwrap(), 1, 0)[0];
        assert_eq!(ends(first), [639, 447, 0, 374]);
    }
}
