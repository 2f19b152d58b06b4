//! Other geometries that may be the truth as well.

use rayon::prelude::*;

use crate::frontier::Views;
use crate::frontier::symmetric::{score_by_frame, symmetric_score};
use crate::frontier::volume::{Correspondence, disagreement};
use crate::geometry::Fundamental;
use crate::hypotheses::Source;
use crate::search::Solution;

/// Another geometry that the search found.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Rival {
    /// The matrix.
    pub fundamental: Fundamental,
    /// Its score as a share of the winner's.
    pub share: f64,
    /// Normal deviate of the difference in score, over blocks of frames.
    pub z: f64,
    /// Mean symmetric epipolar distance from the winner over the volume where things moved, pixels.
    pub distance: f64,
    /// What its hypotheses came from.
    pub source: Source,
}

/// The other solutions beside the winner, highest score first, and the radius at which the winner's score is highest, pixels.
///
/// `volume`: of the winner; `block`: frames that share their error.
pub fn rivals(
    views: &Views,
    winner: &Fundamental,
    others: &[Solution],
    volume: &[Correspondence],
    block: usize,
) -> (Vec<Rival>, f64) {
    let own = symmetric_score(views, winner);
    let own_by_frame = score_by_frame(views, winner, own.radius);
    let mut rivals: Vec<Rival> = others
        .par_iter()
        .map(|solution| {
            let theirs = symmetric_score(views, &solution.fundamental);
            let by_frame = score_by_frame(views, &solution.fundamental, theirs.radius);
            Rival {
                fundamental: solution.fundamental,
                share: theirs.total / own.total.max(1e-9),
                z: paired_z(&own_by_frame, &by_frame, block),
                distance: disagreement(volume, &solution.fundamental),
                source: solution.source,
            }
        })
        .collect();
    rivals.sort_by(|p, q| q.share.total_cmp(&p.share));
    (rivals, own.radius)
}

/// Normal deviate of the difference in score between two geometries, from sums over blocks of frames.
///
/// What one frame says its neighbours repeat, so blocks, not frames, are the independent pieces.
pub fn paired_z(winner: &[f64], rival: &[f64], block: usize) -> f64 {
    let differences: Vec<f64> = winner
        .chunks(block.max(1))
        .zip(rival.chunks(block.max(1)))
        .map(|(p, q)| p.iter().sum::<f64>() - q.iter().sum::<f64>())
        .collect();
    let n = differences.len() as f64;
    if n < 4.0 {
        return 0.0;
    }
    let mean = differences.iter().sum::<f64>() / n;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
    mean / (variance / n).sqrt().max(1e-9)
}
