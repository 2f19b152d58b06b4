//! A recording taken apart into plain arrays, and put together again: what is kept in a file.

use super::barcode::Barcodes;
use super::recording::Recording;
use super::silhouettes::Silhouettes;
use super::traversal::is_walkable;
use crate::error::{Error, Result};
use crate::image::{ImageSize, Segment};

/// The arrays that a [`Recording`] consists of, which may contradict each other: [`Recording::try_from`] finds out.
///
/// Made of a recording, or by [`new`](Self::new), and then changed field by field.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct RecordingParts {
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// Time of each frame, seconds.
    pub times: Vec<f64>,
    /// Lines, from border to border.
    pub segments: Vec<Segment>,
    /// Motion barcodes, line after line: bit `i % 64` of word `i / 64` of a line is frame `i`.
    pub barcodes: Vec<u64>,
    /// For each frame its first hull, and the number of hulls as the last entry.
    pub frame_start: Vec<u32>,
    /// For each hull its first point, and the number of points as the last entry.
    pub hull_start: Vec<u32>,
    /// Vertices `[x, y]` of the hulls, pixels.
    pub hull_points: Vec<[u16; 2]>,
    /// Pixels of the connected component of each hull.
    pub hull_area: Vec<u32>,
    /// Whether each hull is cut where the view ends.
    pub hull_border: Vec<bool>,
    /// For each hull its first further point, and the number of those as the last entry; 0 alone where the recording
    /// has none.
    pub outline_start: Vec<u32>,
    /// Further points `[x, y]` of silhouettes: corners of the hull only through a lens, pixels.
    pub outline_points: Vec<[u16; 2]>,
    /// For each pixel, row-major, the number of frames in which it moves.
    pub heat: Vec<u32>,
    /// For each frame the number of moving pixels.
    pub moving_pixels: Vec<u32>,
    /// For each pixel, row-major, 0 where the camera does not see what moves; `None` where it sees all.
    pub visible: Option<Vec<u8>>,
    /// Seed of the lines.
    pub seed: u64,
}

impl RecordingParts {
    /// The arrays of a recording without lines in which nothing moves: its size, pixels, and the time of each frame, seconds.
    ///
    /// `heat` is empty; it takes a number for each pixel.
    pub fn new(size: [usize; 2], times: Vec<f64>) -> Self {
        let Silhouettes { hull_start, points, area, border, outline_start, outline_points, .. } =
            Silhouettes::default();
        Self {
            size,
            segments: Vec::new(),
            barcodes: Vec::new(),
            frame_start: vec![0; times.len() + 1],
            hull_start,
            hull_points: points,
            hull_area: area,
            hull_border: border,
            outline_start,
            outline_points,
            heat: Vec::new(),
            moving_pixels: vec![0; times.len()],
            visible: None,
            seed: 0,
            times,
        }
    }
}

impl From<Recording> for RecordingParts {
    fn from(recording: Recording) -> Self {
        let Silhouettes { frame_start, hull_start, points, area, border, outline_start, outline_points } =
            recording.silhouettes;
        Self {
            size: [recording.size.width, recording.size.height],
            times: recording.times,
            segments: recording.segments,
            barcodes: recording.barcodes.bits,
            frame_start,
            hull_start,
            hull_points: points,
            hull_area: area,
            hull_border: border,
            outline_start,
            outline_points,
            heat: recording.heat,
            moving_pixels: recording.moving_pixels,
            visible: recording.visible.map(|visible| visible.to_vec()),
            seed: recording.seed,
        }
    }
}

impl TryFrom<RecordingParts> for Recording {
    type Error = Error;

    /// Checks every length and range, so that the rest of the crate can index without fear.
    ///
    /// # Errors
    /// [`Error::NoFrames`] for an empty recording, [`Error::ImageSize`] for an unusable size, [`Error::Damaged`] with
    /// the reason for anything else.
    fn try_from(parts: RecordingParts) -> Result<Self> {
        let [width, height] = parts.size;
        let (frames, count) = (parts.times.len(), parts.segments.len());
        let recording = Self {
            size: ImageSize::new(width, height)?,
            times: parts.times,
            segments: parts.segments,
            barcodes: Barcodes { count, frames, words_per: frames.div_ceil(64), bits: parts.barcodes },
            silhouettes: Silhouettes {
                frame_start: parts.frame_start,
                hull_start: parts.hull_start,
                points: parts.hull_points,
                area: parts.hull_area,
                border: parts.hull_border,
                // One made without them may say so by an empty array.
                outline_start: if parts.outline_start.is_empty() { vec![0] } else { parts.outline_start },
                outline_points: parts.outline_points,
            },
            heat: parts.heat,
            moving_pixels: parts.moving_pixels,
            visible: parts.visible.map(Into::into),
            seed: parts.seed,
        };
        recording.validate()?;
        Ok(recording)
    }
}

/// [`Error::Damaged`] with the message unless the condition holds.
fn ensure(condition: bool, message: impl FnOnce() -> String) -> Result<()> {
    if condition { Ok(()) } else { Err(Error::Damaged(message())) }
}

fn ensure_length(what: &str, actual: usize, expected: usize) -> Result<()> {
    ensure(actual == expected, || format!("{actual} {what} where {expected} belong"))
}

impl Recording {
    fn validate(&self) -> Result<()> {
        let (frames, pixels) = (self.frames(), self.size.pixels());
        if frames == 0 {
            return Err(Error::NoFrames);
        }
        let increasing = self.times.is_sorted_by(|a, b| a < b);
        let finite = self.times.iter().all(|time| time.is_finite());
        ensure(increasing && finite, || "times are not finite and increasing".into())?;

        self.barcodes.validate()?;
        let walkable = self.segments.iter().position(|segment| !is_walkable(segment));
        ensure(walkable.is_none(), || format!("line {} has no usable ends", walkable.unwrap_or_default()))?;

        ensure_length("frames of silhouettes", self.silhouettes.frames(), frames)?;
        self.silhouettes.validate(self.size)?;

        if let Some(visible) = &self.visible {
            ensure_length("pixels of the visible area", visible.len(), pixels)?;
        }
        ensure_length("pixels of the heat map", self.heat.len(), pixels)?;
        ensure_length("counts of moving pixels", self.moving_pixels.len(), frames)?;
        let heat_fits = self.heat.iter().all(|&heat| heat as usize <= frames);
        ensure(heat_fits, || "the heat map counts more frames than there are".into())?;
        let moving_fits = self.moving_pixels.iter().all(|&moving| moving as usize <= pixels);
        ensure(moving_fits, || "a frame has more moving pixels than pixels".into())?;
        let sum = |counts: &[u32]| counts.iter().map(|&count| u64::from(count)).sum::<u64>();
        ensure(sum(&self.heat) == sum(&self.moving_pixels), || {
            "the heat map and the moving pixels disagree".into()
        })
    }
}

impl Barcodes {
    /// Whether there are as many words as belong, and no bits behind the last frame.
    pub(super) fn validate(&self) -> Result<()> {
        let words = self.count.saturating_mul(self.words_per);
        ensure_length("words of barcodes", self.bits.len(), words)?;
        let used = self.frames % 64;
        let padded =
            used == 0 || (0..self.count).all(|i| self.row(i).last().is_none_or(|word| word >> used == 0));
        ensure(padded, || "barcodes have bits behind the last frame".into())
    }
}

impl Silhouettes {
    fn validate(&self, size: ImageSize) -> Result<()> {
        let hulls = self.area.len();
        ensure_length("border flags", self.border.len(), hulls)?;
        ensure_length("ends of hulls", self.hull_start.len(), hulls + 1)?;
        let offsets = |table: &[u32], end: usize| {
            table.first() == Some(&0)
                && table.last().is_some_and(|&last| last as usize == end)
                && table.is_sorted()
        };
        ensure(offsets(&self.frame_start, hulls), || "frames and hulls do not fit together".into())?;
        let points = offsets(&self.hull_start, self.points.len());
        ensure(points, || "hulls and points do not fit together".into())?;
        let none_empty = self.hull_start.windows(2).all(|pair| pair[0] < pair[1]);
        ensure(none_empty, || "a hull has no points".into())?;
        let areas = self.area.iter().all(|&area| (1..=size.pixels()).contains(&(area as usize)));
        ensure(areas, || "a silhouette has an impossible area".into())?;
        let inside = |&[x, y]: &[u16; 2]| usize::from(x) < size.width && usize::from(y) < size.height;
        ensure(self.points.iter().all(inside), || "a hull leaves the image".into())?;
        if self.outline_start.len() == 1 && hulls > 0 {
            return ensure_length("points of outlines", self.outline_points.len(), 0);
        }
        ensure_length("ends of outlines", self.outline_start.len(), hulls + 1)?;
        let outlines = offsets(&self.outline_start, self.outline_points.len());
        ensure(outlines, || "hulls and outlines do not fit together".into())?;
        ensure(self.outline_points.iter().all(inside), || "an outline leaves the image".into())
    }
}
