//! Geometries fitted anew to a few of the tangents that meet, to leave a local optimum.
//!
//! A geometry that is some pixels off has enough true meetings within a wide radius for some small samples of them to be all true;
//! a fit to all of them, false ones among them, stays where it is. Such samples are the local optimisation of Chum, Matas and Kittler
//! (*Locally optimized RANSAC*, DAGM 2003). Moves at random in the seven parameters hardly ever end as near: of one pair the best sample
//! was 2 px from the truth, the best of as many moves 10 px.

use rayon::prelude::*;

use crate::frontier::{TangentMatch, Views, tangent_matches, total_score};
use crate::geometry::Fundamental;
use crate::geometry::seven_parameters::SevenParameters;
use crate::random::{below, generator};
use crate::refine::least_squares::minimise;
use crate::refine::loss_scale;
use crate::refine::sampson::SampsonProblem;

/// Samples, and the best geometries of them by tangents.
const SAMPLES: usize = 160;
const BEST: usize = 5;
/// Tangents of a sample: more than the seven that determine a geometry, as true ones are off by some pixels.
const SIZES: [usize; 3] = [8, 11, 16];
/// Radii within which tangents meet that are sampled, pixels of a 640×480 image.
const RADII: [f64; 2] = [16.0, 8.0];
/// Steps of a fit.
const ITERATIONS: usize = 8;

/// A geometry fitted to random samples of the tangents that meet under it, the best few by tangents.
///
/// `meeting`: the frames whose tangents are sampled; `scoring`: those on which fits are compared, at `radius` pixels.
pub fn resampled(
    meeting: &Views,
    scoring: &Views,
    f: &Fundamental,
    radius: f64,
    seed: u64,
) -> Vec<Fundamental> {
    let Some(start) = SevenParameters::new(f, meeting.sizes()) else { return Vec::new() };
    let radii = RADII.map(|wide| wide * meeting.pixel_scale());
    let met = radii.map(|wide| tangent_matches(meeting, f, wide));
    let mut fitted: Vec<(f64, usize, Fundamental)> = (0..SAMPLES)
        .into_par_iter()
        .filter_map(|k| {
            let (size, which) = (SIZES[k % SIZES.len()], k / SIZES.len() % RADII.len());
            let met = &met[which];
            if met.len() < 2 * size {
                return None;
            }
            let mut random = generator(seed, k as u64);
            let sample: Vec<TangentMatch> = (0..size).map(|_| met[below(&mut random, met.len())]).collect();
            let problem = SampsonProblem::new(&sample, loss_scale(radii[which]));
            let f = minimise(&problem, start.clone(), ITERATIONS).0.fundamental()?;
            let score = total_score(scoring, &f, radius);
            (!score.is_nan()).then_some((score, k, f))
        })
        .collect();
    fitted.sort_by(|p, q| q.0.total_cmp(&p.0).then(p.1.cmp(&q.1)));
    fitted.into_iter().take(BEST).map(|(_, _, f)| f).collect()
}
