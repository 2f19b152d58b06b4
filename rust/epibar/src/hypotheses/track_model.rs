//! Hypotheses from silhouettes followed through time.
//!
//! Upright walkers seen from the side: the highest point of a silhouette is about where a near-horizontal epipolar line
//! touches it, and so is the lowest. Which silhouette of B is the same walker is unknown, but it stays the same for
//! as long as both are followed: two or three tracks of A, each paired with one of B that lives at the same time,
//! are a sample. A wrong pairing seldom fits any geometry, so most samples are refused by their own residual before
//! anything else is computed.

use rand::RngExt;

use super::ransac::Estimator;
use super::tracks::{Extremes, tracks};
use crate::frontier::{Scorer, Views};
use crate::geometry::median::median;
use crate::geometry::{
    CameraMatrices, Fundamental, SevenParameters, eight_point, symmetric_epipolar_distance,
};
use crate::image::ImageSize;
use crate::random::Generator;
use crate::recording::{FramePair, RecordedFrame};
use crate::refine::essential::{EssentialPrior, WithPrior};
use crate::refine::least_squares::minimise;
use crate::refine::sampson::SampsonProblem;

/// Frames for which two tracks must live together.
const SHORTEST: usize = 12;
/// Frames of a pair of tracks that enter a sample.
const SAMPLED: usize = 10;
/// Largest mean epipolar distance of a sample under its own geometry, pixels of a 640×480 image.
const TOLERANCE: f64 = 4.0;

/// Top and bottom of one silhouette in A and of one in B at the same moments.
struct TrackPair {
    moments: Vec<(Extremes, Extremes)>,
}

/// Draws pairs of tracks, scores with tangents.
pub struct TrackModel<'a> {
    pairs: Vec<TrackPair>,
    /// Running sum of the pairs' lengths.
    cumulative: Vec<usize>,
    tolerance: f64,
    /// Tops of A may be bottoms of B.
    mirrored: bool,
    scorer: &'a Scorer<'a>,
}

impl<'a> TrackModel<'a> {
    /// Follows the silhouettes of `followed`, whose frames must be consecutive for the most part; hypotheses are
    /// scored by `scorer`.
    pub fn new(followed: &Views, scorer: &'a Scorer<'a>) -> Self {
        let frames = &followed.frame_pairs;
        // Where one camera films faster than the other not all of its frames are common.
        let followed_on = |frame: fn(&FramePair) -> RecordedFrame| {
            let step =
                move |p: &[FramePair]| frame(&p[1]).index().saturating_sub(frame(&p[0]).index()) as f64;
            let longest = 2.0 * median(frames.windows(2).map(step)).unwrap_or(1.0).max(1.0);
            move |t: usize| step(&frames[t..t + 2]) <= longest
        };
        let in_a = tracks(&followed.a, followed_on(|p| p.a), SHORTEST);
        let in_b = tracks(&followed.b, followed_on(|p| p.b), SHORTEST);
        let mut pairs = Vec::new();
        for p in &in_a {
            for q in &in_b {
                let (from, to) = (p.start.max(q.start), p.end().min(q.end()));
                let moments: Vec<_> = (from..to)
                    .filter_map(|t| Some((p.extremes[t - p.start]?, q.extremes[t - q.start]?)))
                    .collect();
                if moments.len() >= SHORTEST {
                    pairs.push(TrackPair { moments });
                }
            }
        }
        let mut sum = 0;
        let cumulative = pairs
            .iter()
            .map(|p| {
                sum += p.moments.len();
                sum
            })
            .collect();
        let tolerance = TOLERANCE * followed.pixel_scale();
        Self { pairs, cumulative, tolerance, mirrored: !followed.upright, scorer }
    }

    /// How many pairs of tracks there are to draw from.
    pub fn pairs(&self) -> usize {
        self.pairs.len()
    }

    /// One pair, with probability proportional to its length.
    fn draw(&self, random: &mut Generator) -> Option<usize> {
        let at = random.random_range(0..*self.cumulative.last()?);
        Some(self.cumulative.partition_point(|&c| c <= at))
    }
}

/// The geometry near `f` that fits the matches about as well and the camera matrices too; `tolerance` in pixels.
fn fit_with_cameras(
    matches: &[([f64; 2], [f64; 2])],
    f: &Fundamental,
    cameras: &CameraMatrices,
    tolerance: f64,
    sizes: [ImageSize; 2],
) -> Option<Fundamental> {
    const ITERATIONS: usize = 8;
    let points = SampsonProblem::of_matches(matches, tolerance);
    let problem =
        WithPrior { points: &points, prior: Some((EssentialPrior(cameras), tolerance * tolerance)) };
    minimise(&problem, SevenParameters::new(f, sizes)?, ITERATIONS).0.fundamental()
}

impl Estimator for TrackModel<'_> {
    type Model = Fundamental;

    fn generate(&self, index: usize, random: &mut Generator) -> Option<Fundamental> {
        let count = 2 + index % 2;
        let mirror = self.mirrored && index / 2 % 2 == 1;
        let mut matches = Vec::with_capacity(2 * SAMPLED * count);
        for _ in 0..count {
            let moments = &self.pairs[self.draw(random)?].moments;
            for k in 0..SAMPLED.min(moments.len()) {
                let (a, b) = moments[k * moments.len() / SAMPLED.min(moments.len())];
                let b = if mirror { [b[1], b[0]] } else { b };
                matches.extend([(a[0], b[0]), (a[1], b[1])]);
            }
        }
        let f = eight_point(&matches, self.scorer.views().sizes())?;
        let fits = |f: &Fundamental| {
            let sum: f64 = matches.iter().map(|(a, b)| symmetric_epipolar_distance(f, *a, *b)).sum();
            sum <= self.tolerance * matches.len() as f64
        };
        if !fits(&f) {
            return None;
        }
        // Extremes are only about frontier points, so that the true sample may miss the geometry that the cameras allow:
        // half of the draws go on without them.
        let Some(cameras) = self.scorer.views().cameras.as_ref().filter(|_| (index / 4).is_multiple_of(2))
        else {
            return Some(f);
        };
        let f = fit_with_cameras(&matches, &f, cameras, self.tolerance, self.scorer.views().sizes())?;
        fits(&f).then_some(f)
    }

    fn score(&self, model: &Fundamental) -> f64 {
        self.scorer.score(model)
    }

    fn preview(&self, model: &Fundamental) -> f64 {
        self.scorer.preview(model)
    }
}
