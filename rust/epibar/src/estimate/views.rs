//! Silhouettes of two cameras on one time line, ready for epipolar tangents.

use crate::line::ImageSize;
use crate::recording::{Recording, visible};
use std::sync::Arc;

/// Hulls of one camera, frame by frame, vertices as floating point.
#[derive(Debug, Clone)]
pub struct View {
    /// Size of the image.
    pub size: ImageSize,
    /// For each frame its first hull, and the number of hulls as the last entry.
    frame_start: Vec<u32>,
    /// For each hull its first vertex, and the number of vertices as the last entry.
    hull_start: Vec<u32>,
    /// Vertices, pixels.
    vertices: Vec<[f64; 2]>,
    /// For each pixel 0 where nothing is seen to move; `None` where all is visible.
    visible: Option<Arc<[u8]>>,
}

impl View {
    fn empty(recording: &Recording) -> Self {
        Self {
            size: recording.size,
            frame_start: vec![0],
            hull_start: vec![0],
            vertices: Vec::new(),
            visible: recording.visible.clone(),
        }
    }

    fn new(recording: &Recording, frames: impl Iterator<Item = u32>) -> Self {
        let silhouettes = &recording.silhouettes;
        let mut view = Self::empty(recording);
        for frame in frames {
            for hull in silhouettes.hulls(frame as usize) {
                let points = silhouettes.hull(hull);
                if points.len() >= 3 {
                    view.vertices.extend(points.iter().map(|p| p.map(f64::from)));
                    view.hull_start.push(view.vertices.len() as u32);
                }
            }
            view.frame_start.push((view.hull_start.len() - 1) as u32);
        }
        view
    }

    /// From hulls of a recording drawn elsewhere, frame by frame, each of at least three vertices.
    fn of_hulls(recording: &Recording, frames: impl Iterator<Item = Vec<Vec<[f64; 2]>>>) -> Self {
        let mut view = Self::empty(recording);
        for hulls in frames {
            for hull in hulls {
                view.vertices.extend(hull);
                view.hull_start.push(view.vertices.len() as u32);
            }
            view.frame_start.push((view.hull_start.len() - 1) as u32);
        }
        view
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.frame_start.len() - 1
    }

    /// Number of hulls in all frames.
    pub fn hulls(&self) -> usize {
        self.hull_start.len() - 1
    }

    /// Hulls of a frame, each a polygon of at least three vertices.
    pub fn hulls_of(&self, frame: usize) -> impl Iterator<Item = &[[f64; 2]]> {
        (self.frame_start[frame]..self.frame_start[frame + 1]).map(|h| {
            &self.vertices[self.hull_start[h as usize] as usize..self.hull_start[h as usize + 1] as usize]
        })
    }

    /// Whether a vertex lies where a silhouette ends because the view does: on the image border, or at the edge of
    /// what is visible.
    pub fn on_border(&self, p: [f64; 2]) -> bool {
        visible::on_border(self.size, self.visible.as_deref(), p)
    }
}

/// Two views whose frame `i` is one moment.
#[derive(Debug, Clone)]
pub struct Views {
    /// Camera A.
    pub a: View,
    /// Camera B.
    pub b: View,
    /// Frame of recording A and of recording B of each common frame.
    pub frame_pairs: Vec<(u32, u32)>,
}

impl Views {
    /// Both recordings at the given pairs of frames (frame of A, frame of B).
    ///
    /// # Panics
    /// If a frame is beyond its recording.
    pub fn new(a: &Recording, b: &Recording, frame_pairs: &[(u32, u32)]) -> Self {
        Self {
            a: View::new(a, frame_pairs.iter().map(|p| p.0)),
            b: View::new(b, frame_pairs.iter().map(|p| p.1)),
            frame_pairs: frame_pairs.to_vec(),
        }
    }

    /// As [`Views::new`], with the hulls of B at the moment of each frame of A drawn by `hulls_of_b`.
    pub(crate) fn with_hulls_of_b(
        a: &Recording,
        b: &Recording,
        frame_pairs: &[(u32, u32)],
        hulls_of_b: impl Fn(u32) -> Vec<Vec<[f64; 2]>>,
    ) -> Self {
        Self {
            a: View::new(a, frame_pairs.iter().map(|p| p.0)),
            b: View::of_hulls(b, frame_pairs.iter().map(|p| hulls_of_b(p.0))),
            frame_pairs: frame_pairs.to_vec(),
        }
    }

    /// Number of common frames.
    pub fn frames(&self) -> usize {
        self.frame_pairs.len()
    }

    /// Sizes of both images.
    pub fn sizes(&self) -> [ImageSize; 2] {
        [self.a.size, self.b.size]
    }
}

/// Those pairs of frames in which both cameras see something move, thinned evenly to at most `limit`.
pub fn busy_frames(
    a: &Recording,
    b: &Recording,
    frame_pairs: &[(u32, u32)],
    limit: usize,
) -> Vec<(u32, u32)> {
    let busy: Vec<_> = frame_pairs
        .iter()
        .copied()
        .filter(|&(i, j)| {
            !a.silhouettes.hulls(i as usize).is_empty() && !b.silhouettes.hulls(j as usize).is_empty()
        })
        .collect();
    if busy.len() <= limit {
        return busy;
    }
    (0..limit).map(|k| busy[k * busy.len() / limit]).collect()
}
