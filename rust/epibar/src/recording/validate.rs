//! Whether the parts of a recording fit together, asked when it comes from a file.

use super::traversal::is_walkable;
use super::{Barcodes, Recording, Silhouettes};
use crate::line::ImageSize;
use crate::{Error, Result};

/// [`Error::Damaged`] with the message unless the condition holds.
fn ensure(condition: bool, message: impl FnOnce() -> String) -> Result<()> {
    if condition { Ok(()) } else { Err(Error::Damaged(message())) }
}

fn ensure_length(what: &str, actual: usize, expected: usize) -> Result<()> {
    ensure(actual == expected, || format!("{actual} {what} where {expected} belong"))
}

impl Recording {
    /// Checks every length and range, so that the rest of the crate can index without fear.
    ///
    /// # Errors
    /// [`Error::NoFrames`] for an empty recording, [`Error::ImageSize`] for an unusable size,
    /// [`Error::Damaged`] with the reason for anything else.
    pub fn validate(&self) -> Result<()> {
        let (frames, pixels) = (self.frames(), ImageSize::new(self.size.width, self.size.height)?.pixels());
        if frames == 0 {
            return Err(Error::NoFrames);
        }
        let increasing = self.times.is_sorted_by(|a, b| a < b);
        let finite = self.times.iter().all(|time| time.is_finite());
        ensure(increasing && finite, || "times are not finite and increasing".into())?;

        ensure_length("frames of barcodes", self.barcodes.frames, frames)?;
        ensure_length("barcodes", self.barcodes.count, self.segments.len())?;
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
    fn validate(&self) -> Result<()> {
        ensure_length("words per barcode", self.words_per, self.frames.div_ceil(64))?;
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
        ensure(self.points.iter().all(inside), || "a hull leaves the image".into())
    }
}
