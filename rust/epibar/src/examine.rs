//! A matrix that the caller already has, against what moved.

use crate::calibration::FrontierPoint;
use crate::clock::{Aligned, Clock};
use crate::error::{Error, Result};
use crate::frontier::up::up_in;
use crate::frontier::{ClassScore, compare, symmetric_score};
use crate::geometry::{CameraMatrices, Fundamental};
use crate::recording::Recording;
use crate::recording::tracker::Links;
use crate::refine::polish;

/// Options of [`examine`](fn@crate::examine).
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ExamineOptions {
    /// Two tangents meet below this Sampson distance, pixels.
    pub radius: f64,
    /// Where A's first frame falls in B, frames of B after B's first.
    pub time_offset: f64,
    /// Both cameras are the right way up.
    pub upright: bool,
    /// Refine the matrix on the tangents first.
    pub refine: bool,
    /// The camera matrices, where both are known: refinement takes them into account.
    pub cameras: Option<CameraMatrices>,
}

impl Default for ExamineOptions {
    fn default() -> Self {
        Self { radius: 3.0, time_offset: 0.0, upright: true, refine: false, cameras: None }
    }
}

impl ExamineOptions {
    /// The defaults.
    pub fn new() -> Self {
        Self::default()
    }

    /// With a [radius](Self::radius), pixels.
    #[must_use]
    pub fn radius(self, radius: f64) -> Self {
        Self { radius, ..self }
    }

    /// With a [time offset](Self::time_offset), frames of B.
    #[must_use]
    pub fn time_offset(self, time_offset: f64) -> Self {
        Self { time_offset, ..self }
    }

    /// With cameras that are [upright](Self::upright), or are not.
    #[must_use]
    pub fn upright(self, upright: bool) -> Self {
        Self { upright, ..self }
    }

    /// With or without [refinement](Self::refine).
    #[must_use]
    pub fn refine(self, refine: bool) -> Self {
        Self { refine, ..self }
    }

    /// With known [camera matrices](Self::cameras).
    #[must_use]
    pub fn cameras(self, cameras: CameraMatrices) -> Self {
        Self { cameras: Some(cameras), ..self }
    }
}

/// Tangents of one kind, tops or bottoms, under a matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct TangentCounts {
    /// Tangents of A.
    pub tangents: usize,
    /// Tangents of A that meet one of B.
    pub matches: usize,
    /// How many would by chance.
    pub expected: f64,
    /// Excess over chance, each match weighed by how unlikely it was.
    pub excess: f64,
}

impl TangentCounts {
    fn of(score: ClassScore) -> Self {
        let ClassScore { tangents, matches, expected, excess } = score;
        Self { tangents, matches, expected, excess }
    }
}

/// What speaks for a matrix.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Examined {
    /// The matrix, refined where that was asked for.
    pub fundamental: Fundamental,
    /// Evidence of the silhouettes against chance, both cameras in turn, at the radius that gives most.
    pub score: f64,
    /// Tangents whose objects lie below them, at the radius asked for.
    pub tops: TangentCounts,
    /// Tangents whose objects lie above them.
    pub bottoms: TangentCounts,
    /// Tangents that meet within the radius.
    pub frontier_points: Vec<FrontierPoint>,
    /// Sampson distance of each, pixels.
    pub distances: Vec<f64>,
}

/// Compares the epipolar tangents of two recordings under a matrix that is given.
///
/// Silhouettes of B are drawn at the very moments of A's frames, as [`calibrate`](fn@crate::calibrate) draws them. Nothing is tested: a
/// [`Verdict`](crate::Verdict) is [`calibrate`](fn@crate::calibrate)'s.
///
/// # Errors
/// [`Error::Argument`] for a radius that is not positive, or an offset that is not finite.
pub fn examine(a: &Recording, b: &Recording, f: &Fundamental, options: &ExamineOptions) -> Result<Examined> {
    let ExamineOptions { radius, time_offset, upright, refine, cameras } = *options;
    let refuse =
        |name, value: f64, expected| Err(Error::Argument { name, value: value.to_string(), expected });
    if radius.is_nan() || radius <= 0.0 {
        return refuse("radius", radius, "a positive number of pixels");
    }
    if !time_offset.is_finite() {
        return refuse("time_offset", time_offset, "a finite number of frames");
    }
    let links = Links::new(b);
    let aligned = Aligned::new(a, b, &links, Clock::at(time_offset), up_in([a, b], upright));
    let common = aligned.frame_pairs();
    let views = aligned.views(&common).with_cameras(cameras);
    let f = if refine { polish(&views, f) } else { *f };
    let comparison = compare(&views, &f, radius);
    let point =
        |p: &crate::frontier::TangentMatch| FrontierPoint::new(common[p.frame.index()].a, p.a, p.b, &f);
    Ok(Examined {
        fundamental: f,
        score: symmetric_score(&views, &f).total,
        tops: TangentCounts::of(comparison.score.tops),
        bottoms: TangentCounts::of(comparison.score.bottoms),
        frontier_points: comparison.matches.iter().map(point).collect(),
        distances: comparison.matches.iter().map(|p| p.distance).collect(),
    })
}
