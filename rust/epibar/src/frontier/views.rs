//! Silhouettes of two cameras on one time line, ready for epipolar tangents.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::edges::Edges;
use super::up::Up;
use crate::geometry::hull::moved_outward;
use crate::geometry::{CameraMatrices, TangentPoint, epipolar_tangents};
use crate::image::{Homogeneous, ImageSize};
use crate::recording::{FramePair, RecordedFrame, Recording, visible};

/// Hulls of one camera, frame by frame, vertices as floating point.
#[derive(Debug, Clone)]
pub struct View {
    /// Size of the image.
    pub size: ImageSize,
    /// Where up is in the image, unit length: what tops and bottoms refer to.
    pub up: [f64; 2],
    /// For each frame its first hull, and the number of hulls as the last entry.
    frame_start: Vec<u32>,
    /// For each hull its first vertex, and the number of vertices as the last entry.
    hull_start: Vec<u32>,
    /// Vertices, pixels.
    vertices: Vec<[f64; 2]>,
    /// Vertices again, NaN where the view ends.
    touchable: Vec<[f64; 2]>,
    /// Vertices as they were before they were moved; empty where they were not.
    unmoved: Vec<[f64; 2]>,
    edges: Edges,
    /// For each pixel 0 where nothing is seen to move; `None` where all is visible.
    visible: Option<Arc<[u8]>>,
}

impl View {
    /// From the hulls of each frame, each of at least three vertices.
    fn new<'h>(
        size: ImageSize,
        visible: Option<&Arc<[u8]>>,
        frames: impl Iterator<Item = Vec<Cow<'h, [[f64; 2]]>>>,
    ) -> Self {
        let mut view = Self::empty(size, visible.cloned());
        for hulls in frames {
            for hull in hulls {
                view.push(&hull, &hull);
            }
            view.end_frame();
        }
        view
    }

    /// Of no frame.
    fn empty(size: ImageSize, visible: Option<Arc<[u8]>>) -> Self {
        Self {
            size,
            up: Up::IMAGE.direction,
            frame_start: vec![0],
            hull_start: vec![0],
            vertices: Vec::new(),
            touchable: Vec::new(),
            unmoved: Vec::new(),
            edges: Edges::default(),
            visible,
        }
    }

    /// A hull; where the view ends is told by its vertices before they were moved.
    fn push(&mut self, hull: &[[f64; 2]], unmoved: &[[f64; 2]]) {
        let cut = |p: [f64; 2]| visible::on_border(self.size, self.visible.as_deref(), p);
        self.touchable
            .extend(hull.iter().zip(unmoved).map(|(p, was)| if cut(*was) { [f64::NAN; 2] } else { *p }));
        self.edges.push(hull);
        self.vertices.extend_from_slice(hull);
        self.hull_start.push(self.vertices.len() as u32);
    }

    fn end_frame(&mut self) {
        self.frame_start.push(self.hulls() as u32);
    }

    /// The frames of a recording.
    fn of_frames(recording: &Recording, frames: impl Iterator<Item = RecordedFrame>) -> Self {
        let silhouettes = &recording.silhouettes;
        let hulls = |frame: RecordedFrame| {
            let all = silhouettes.hulls(frame.index()).map(|hull| silhouettes.hull(hull));
            let areas = all.filter(|points| points.len() >= 3);
            areas.map(|points| points.iter().map(|p| p.map(f64::from)).collect()).collect()
        };
        Self::new(recording.size, recording.visible.as_ref(), frames.map(hulls))
    }

    /// This view with every silhouette moved outward by so many pixels, but for where the view ends.
    fn moved_outward(&self, pixels: f64) -> Self {
        let mut view = Self { up: self.up, ..Self::empty(self.size, self.visible.clone()) };
        for frame in 0..self.frames() {
            for hull in self.hulls_of(frame) {
                let (moved, was): (Vec<_>, Vec<_>) =
                    moved_outward(hull, pixels, |p| self.on_border(p)).into_iter().unzip();
                view.push(&moved, &was);
                view.unmoved.extend(was);
            }
            view.end_frame();
        }
        view
    }

    /// A vertex of a frame as it was before silhouettes were moved.
    pub fn unmoved(&self, frame: usize, vertex: [f64; 2]) -> [f64; 2] {
        let first = self.hull_start[self.frame_start[frame] as usize] as usize;
        let last = self.hull_start[self.frame_start[frame + 1] as usize] as usize;
        let found = self.vertices[first..last].iter().position(|v| *v == vertex);
        found.and_then(|i| self.unmoved.get(first + i)).copied().unwrap_or(vertex)
    }

    /// Some of the frames.
    fn chosen(&self, frames: &[usize]) -> Self {
        let mut view = Self { up: self.up, ..Self::empty(self.size, self.visible.clone()) };
        for &frame in frames {
            for hull in self.hull_indices(frame) {
                let vertices = self.hull_start[hull] as usize..self.hull_start[hull + 1] as usize;
                view.edges.push_of(&self.edges, hull, vertices.len());
                view.touchable.extend_from_slice(&self.touchable[vertices.clone()]);
                view.unmoved.extend_from_slice(self.unmoved.get(vertices.clone()).unwrap_or_default());
                view.vertices.extend_from_slice(&self.vertices[vertices]);
                view.hull_start.push(view.vertices.len() as u32);
            }
            view.end_frame();
        }
        view
    }

    /// Hulls made up by a test.
    #[cfg(test)]
    pub(crate) fn made_up(size: ImageSize, frames: &[Vec<Vec<[f64; 2]>>]) -> Self {
        let hulls = |hulls: &Vec<Vec<[f64; 2]>>| hulls.iter().map(|h| Cow::Owned(h.clone())).collect();
        Self::new(size, None, frames.iter().map(hulls))
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

    /// Indices of the hulls of a frame.
    pub(super) fn hull_indices(&self, frame: usize) -> Range<usize> {
        self.frame_start[frame] as usize..self.frame_start[frame + 1] as usize
    }

    /// For each edge of all hulls 1 where it turns its positive side to the epipole.
    #[inline(always)]
    pub(super) fn edges_facing(&self, epipole: &Homogeneous, sides: &mut Vec<u8>) {
        self.edges.facing(epipole, sides);
    }

    /// The vertices of a hull where lines from the epipole touch it, as [`epipolar_tangents`] finds them: with the hull
    /// on the positive side, and on the negative. `sides` are those of [`View::edges_facing`] the same epipole.
    #[inline(always)]
    pub(super) fn turns(&self, hull: usize, sides: &[u8], epipole: &Homogeneous) -> Option<[usize; 2]> {
        let first = self.hull_start[hull] as usize;
        let count = self.hull_start[hull + 1] as usize - first;
        if count <= Edges::MOST {
            return self.edges.turns(hull, count, sides).map(|turns| turns.map(|i| first + i));
        }
        let vertices = &self.vertices[first..first + count];
        let tangents = epipolar_tangents(vertices, epipole)?;
        let index = |t: TangentPoint| vertices.iter().position(|v| *v == t.point);
        Some([first + index(tangents[0])?, first + index(tangents[1])?])
    }

    /// A vertex, NaN where the view ends ([`View::on_border`]).
    pub(super) fn touchable(&self, i: usize) -> [f64; 2] {
        self.touchable[i]
    }
}

/// Two views whose frame `i` is one moment.
#[derive(Debug, Clone)]
pub struct Views {
    /// Camera A.
    pub a: View,
    /// Camera B.
    pub b: View,
    /// Frames of both recordings for each common frame.
    pub frame_pairs: Vec<FramePair>,
    /// It is known which end of what moves is up in both images, so that a top of A is a top of B.
    pub upright: bool,
    /// The camera matrices, where both are known.
    pub cameras: Option<CameraMatrices>,
    /// Silhouettes were moved outward by so many pixels in A and in B, onto their outlines; `None` where they are as they were seen.
    pub insets: Option<[f64; 2]>,
}

impl Views {
    /// Two views of as many frames, of cameras that are the right way up and whose matrices are not known.
    pub(crate) fn of(a: View, b: View, frame_pairs: Vec<FramePair>) -> Self {
        Self { a, b, frame_pairs, upright: true, cameras: None, insets: None }
    }

    /// Both recordings at the given pairs of frames.
    ///
    /// # Panics
    /// If a frame is beyond its recording.
    pub fn new(a: &Recording, b: &Recording, frame_pairs: &[FramePair]) -> Self {
        let (a, b) = rayon::join(
            || View::of_frames(a, frame_pairs.iter().map(|p| p.a)),
            || View::of_frames(b, frame_pairs.iter().map(|p| p.b)),
        );
        Self::of(a, b, frame_pairs.to_vec())
    }

    /// [`Views::new`] with the hulls of B at the moment of each frame of A drawn by `hulls_of_b`.
    pub(crate) fn with_hulls_of_b(
        a: &Recording,
        b: &Recording,
        frame_pairs: &[FramePair],
        hulls_of_b: impl Fn(RecordedFrame) -> Vec<Vec<[f64; 2]>> + Sync,
    ) -> Self {
        let (a, drawn) = rayon::join(
            || View::of_frames(a, frame_pairs.iter().map(|p| p.a)),
            || frame_pairs.par_iter().map(|p| hulls_of_b(p.a)).collect::<Vec<_>>(),
        );
        let drawn = drawn.into_iter().map(|hulls| hulls.into_iter().map(Cow::Owned).collect());
        let b = View::new(b.size, b.visible.as_ref(), drawn);
        Self::of(a, b, frame_pairs.to_vec())
    }

    /// These views with up as it was found in A and in B.
    #[must_use]
    pub fn with_up(mut self, [a, b]: [Up; 2]) -> Self {
        (self.a.up, self.b.up) = (a.direction, b.direction);
        self.with_upright(a.known && b.known)
    }

    /// These views of cameras that are, or are not known to be, the right way up.
    #[must_use]
    pub fn with_upright(self, upright: bool) -> Self {
        Self { upright, ..self }
    }

    /// These views with known camera matrices.
    #[must_use]
    pub fn with_cameras(self, cameras: Option<CameraMatrices>) -> Self {
        Self { cameras, ..self }
    }

    /// These views with B for A: `F` becomes [`Fundamental::transposed`](crate::Fundamental::transposed).
    #[must_use]
    pub fn swapped(&self) -> Self {
        Self {
            a: self.b.clone(),
            b: self.a.clone(),
            frame_pairs: self.frame_pairs.iter().map(|p| p.swapped()).collect(),
            cameras: self.cameras.map(CameraMatrices::swapped),
            insets: self.insets.map(|[a, b]| [b, a]),
            ..*self
        }
    }

    /// Some of the frames, by index.
    ///
    /// # Panics
    /// If a frame is not there.
    #[must_use]
    pub fn chosen(&self, frames: &[usize]) -> Self {
        Self {
            a: self.a.chosen(frames),
            b: self.b.chosen(frames),
            frame_pairs: frames.iter().map(|&frame| self.frame_pairs[frame]).collect(),
            ..*self
        }
    }

    /// These views with the silhouettes of A and of B, as they were seen, moved outward by so many pixels.
    #[must_use]
    pub fn moved_outward(&self, insets: [f64; 2]) -> Self {
        let (a, b) = rayon::join(|| self.a.moved_outward(insets[0]), || self.b.moved_outward(insets[1]));
        Self { a, b, frame_pairs: self.frame_pairs.clone(), insets: Some(insets), ..*self }
    }

    /// Number of common frames.
    pub fn frames(&self) -> usize {
        self.frame_pairs.len()
    }

    /// Sizes of both images.
    pub fn sizes(&self) -> [ImageSize; 2] {
        [self.a.size, self.b.size]
    }

    /// [`ImageSize::pixel_scale`] of these images.
    pub fn pixel_scale(&self) -> f64 {
        ImageSize::pixel_scale(self.sizes())
    }
}

/// Those pairs of frames in which both cameras see something move, thinned evenly to at most `limit`, where there is one.
pub fn busy_frames(
    a: &Recording,
    b: &Recording,
    frame_pairs: &[FramePair],
    limit: Option<usize>,
) -> Vec<FramePair> {
    let busy: Vec<_> = frame_pairs.iter().copied().filter(|p| a.shows(p.a) && b.shows(p.b)).collect();
    match limit {
        Some(limit) if busy.len() > limit => (0..limit).map(|k| busy[k * busy.len() / limit]).collect(),
        _ => busy,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moved_silhouettes_know_where_they_were() {
        let size = ImageSize::new(100, 80).unwrap();
        let whole = vec![[30.0, 20.0], [50.0, 20.0], [50.0, 60.0], [30.0, 60.0]];
        let cut = vec![[0.0, 10.0], [20.0, 10.0], [20.0, 70.0], [0.0, 70.0]];
        // The second corner is nearer to the border than it is moved.
        let near = vec![[60.0, 1.0], [98.0, 1.0], [90.0, 40.0]];
        let seen = View::made_up(size, &[vec![cut.clone()], vec![whole.clone(), near.clone()]]);
        let moved = seen.moved_outward(2.0);
        assert_eq!((moved.frames(), moved.hulls()), (2, 3));
        let on_frame = |view: &View, frame| view.hulls_of(frame).flatten().copied().collect::<Vec<_>>();
        let was: Vec<_> = on_frame(&moved, 1).into_iter().map(|p| moved.unmoved(1, p)).collect();
        assert_eq!(was, on_frame(&seen, 1));
        assert!(
            on_frame(&moved, 1).iter().zip(&was).all(|(p, was)| (p[0] - was[0]).hypot(p[1] - was[1]) > 1.9)
        );
        // Where the view ends nothing is moved, or touched; what is moved beyond it can be touched all the same.
        assert_eq!(moved.hulls_of(0).next().unwrap()[0], [0.0, 10.0]);
        let touchable: Vec<bool> = (0..11).map(|i| !moved.touchable(i)[0].is_nan()).collect();
        assert_eq!(touchable, [false, true, true, false, true, true, true, true, true, true, true]);
        // Some of the frames know it as well, and of silhouettes as they were seen each vertex is where it was.
        let some = moved.chosen(&[1]);
        assert_eq!(on_frame(&some, 0), on_frame(&moved, 1));
        assert_eq!(some.unmoved(0, on_frame(&some, 0)[5]), was[5]);
        assert!((0..7).all(|i| some.touchable(i) == moved.touchable(4 + i)));
        assert_eq!(seen.unmoved(1, whole[2]), whole[2]);
    }
}
