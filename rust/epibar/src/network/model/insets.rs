//! How far the hulls of one camera's silhouettes lie inside of the true outlines.
//!
//! Vertices are pixel centres, a part of a pixel inside; masks leave out, or add, some more all around, and not the same on every side:
//! shadows lie below, and feet are thinner than heads. What is thin is taken off by whoever cleans a mask, and more of small figures than of
//! large ones: where a tip is half as thick a filter takes twice as much of it. A camera sees small figures far away and in one part of its image, so that
//! this looks like another focal length, or another lens, if it is not solved for.

/// Sides of a silhouette: right, below, left, above.
pub const SIDES: usize = 4;

/// Insets, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Insets {
    /// All around a silhouette of the camera's usual size.
    pub all: f64,
    /// Beyond that of one half as large.
    pub small: f64,
    /// Beyond that on each side.
    pub sides: [f64; SIDES],
}

impl Insets {
    /// The same everywhere.
    pub fn all_around(all: f64) -> Self {
        Self { all, ..Self::default() }
    }

    /// Across a tangent, `outward` being of unit length and away from a silhouette of some smallness: 0 of the usual size, 1 of half of it.
    pub fn at(&self, outward: [f64; 2], smallness: f64) -> f64 {
        let of_sides: f64 = shares(outward).iter().zip(&self.sides).map(|(share, side)| share * side).sum();
        self.all + smallness * self.small + of_sides
    }
}

/// How much of a tangent is on each side: 1 in all where `outward` is of unit length.
pub fn shares([x, y]: [f64; 2]) -> [f64; SIDES] {
    [x, y, -x, -y].map(|along| along.max(0.0).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_share_a_tangent() {
        assert_eq!(shares([0.0, 1.0]), [0.0, 1.0, 0.0, 0.0]);
        for angle in [0.3_f64, 1.9, 3.3, 5.5] {
            let found = shares([angle.cos(), angle.sin()]);
            assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-12 && found.iter().all(|s| *s >= 0.0));
        }
    }

    #[test]
    fn feet_and_small_figures_lose_more() {
        let insets = Insets { all: 0.2, small: 0.4, sides: [0.0, 0.3, 0.0, -0.1] };
        let of = |outward, smallness| (insets.at(outward, smallness) * 1e9).round() / 1e9;
        assert_eq!([of([0.0, 1.0], 0.0), of([0.0, 1.0], 1.0), of([0.0, -1.0], -0.5)], [0.5, 0.9, -0.1]);
        assert_eq!(of([0.6, 0.8], 0.0), 0.392);
        assert_eq!(Insets::all_around(0.4).at([0.6, -0.8], 2.0), 0.4);
    }
}
