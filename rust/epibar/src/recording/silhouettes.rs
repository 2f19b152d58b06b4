//! Silhouettes: the convex hulls of what moves, frame by frame.
//!
//! Stored flat: frame → hulls → points through two tables of offsets. They give the barcode of any
//! line without the pixels, and epipolar tangents.

use super::components::Components;
use super::convex_hull::convex_hull;
use super::lens_corners::OutlineFinder;
use super::visible::on_border;
use crate::error::{Error, Result};
use crate::image::ImageSize;
use std::ops::Range;

/// The convex hulls of the moving components of all frames.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Silhouettes {
    /// For each frame its first hull, and the number of hulls as the last entry.
    pub(crate) frame_start: Vec<u32>,
    /// For each hull its first point, and the number of points as the last entry.
    pub(crate) hull_start: Vec<u32>,
    /// Vertices `[x, y]` in the order of [`convex_hull`].
    pub(crate) points: Vec<[u16; 2]>,
    /// Pixels of the component of each hull.
    pub(crate) area: Vec<u32>,
    /// Whether a vertex of each hull is where the view ends: its tangents there are the view's, not the
    /// object's.
    pub(crate) border: Vec<bool>,
    /// For each hull its first further point, and the number of those as the last entry; 0 alone where a recording was made
    /// without them.
    pub(crate) outline_start: Vec<u32>,
    /// Further points `[x, y]`: corners of the hull only when the silhouette is seen through a lens ([`super::outline`]).
    pub(crate) outline_points: Vec<[u16; 2]>,
}

impl Default for Silhouettes {
    fn default() -> Self {
        Self {
            frame_start: vec![0],
            hull_start: vec![0],
            points: Vec::new(),
            area: Vec::new(),
            border: Vec::new(),
            outline_start: vec![0],
            outline_points: Vec::new(),
        }
    }
}

impl Silhouettes {
    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.frame_start.len().saturating_sub(1)
    }

    /// Number of hulls in all frames.
    pub fn len(&self) -> usize {
        self.area.len()
    }

    /// Whether there is no hull in any frame.
    pub fn is_empty(&self) -> bool {
        self.area.is_empty()
    }

    /// The hulls of a frame.
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn hulls(&self, frame: usize) -> Range<usize> {
        self.frame_start[frame] as usize..self.frame_start[frame + 1] as usize
    }

    /// The vertices of a hull, at least one.
    ///
    /// # Panics
    /// If there is no such hull.
    pub fn hull(&self, i: usize) -> &[[u16; 2]] {
        &self.points[self.hull_start[i] as usize..self.hull_start[i + 1] as usize]
    }

    /// Points of a silhouette that are corners of its hull through some lens but not without one; none where the
    /// recording was made without them.
    ///
    /// # Panics
    /// If there is no such hull.
    pub fn outline(&self, i: usize) -> &[[u16; 2]] {
        if self.outline_start.len() <= 1 {
            return &[];
        }
        &self.outline_points[self.outline_start[i] as usize..self.outline_start[i + 1] as usize]
    }

    /// Pixels of the connected component of a hull.
    ///
    /// # Panics
    /// If there is no such hull.
    pub fn area(&self, i: usize) -> u32 {
        self.area[i]
    }

    /// Whether a vertex of a hull lies where the view ends: its tangents there are the view's, not the object's.
    ///
    /// # Panics
    /// If there is no such hull.
    pub fn is_cut(&self, i: usize) -> bool {
        self.border[i]
    }

    /// Adds a frame with those components that have `min_area` pixels.
    pub(super) fn push(
        &mut self,
        found: &Components,
        outlines: &mut OutlineFinder,
        size: ImageSize,
        visible: Option<&[u8]>,
        min_area: usize,
    ) -> Result<()> {
        for component in found.components() {
            if component.area as usize >= min_area {
                let first = self.points.len();
                let runs = found.runs_of(component);
                convex_hull(runs, &mut self.points);
                outlines.find(runs, &self.points[first..], size, &mut self.outline_points);
                self.outline_start.push(offset(self.outline_points.len())?);
                let cut = |p: &[u16; 2]| on_border(size, visible, p.map(f64::from));
                self.border.push(self.points[first..].iter().any(cut));
                self.hull_start.push(offset(self.points.len())?);
                self.area.push(component.area);
            }
        }
        self.frame_start.push(offset(self.area.len())?);
        Ok(())
    }
}

fn offset(value: usize) -> Result<u32> {
    u32::try_from(value).map_err(|_| Error::Argument {
        name: "silhouette points",
        value: value.to_string(),
        expected: "a recording holds fewer than 2^32; split it, or raise min_component_area",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_have_the_hulls_of_their_components() {
        let size = ImageSize::new(20, 10).unwrap();
        let mut silhouettes = Silhouettes::default();
        let mut found = Components::new();
        let mut square = vec![0; 200];
        for y in 3..6 {
            square[y * 20 + 8..y * 20 + 12].fill(1);
        }
        square[0] = 1;
        for mask in [&square[..], &[0; 200], &square] {
            found.find(mask, size);
            silhouettes.push(&found, &mut OutlineFinder::default(), size, None, 2).unwrap();
        }
        assert_eq!((silhouettes.frames(), silhouettes.len()), (3, 2));
        assert_eq!(silhouettes.hulls(1), 1..1);
        assert_eq!(silhouettes.hull(1), [[8, 3], [11, 3], [11, 5], [8, 5]]);
        assert_eq!((silhouettes.area(1), silhouettes.is_cut(1)), (12, false));
    }
}
