//! Other geometries that may be the truth as well.

use rayon::prelude::*;

use super::thresholds::{MIN_COMPARED, MOST_OF_CAMERAS, RIVAL_SHARE, RIVAL_Z, reaches, within};
use crate::frontier::Views;
use crate::frontier::symmetric::{SymmetricScore, symmetric_score, symmetric_score_by_frame};
use crate::frontier::volume::{Correspondence, disagreement};
use crate::geometry::Fundamental;
use crate::hypotheses::Source;
use crate::refine::essential::DEVIATION;
use crate::search::Solution;

/// Another geometry that the search found.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Rival {
    /// The matrix.
    pub fundamental: Fundamental,
    /// Its score as a share of the winner's.
    pub share: f64,
    /// Normal deviate of the difference in score, over blocks of frames, and in how well known camera matrices agree.
    pub z: f64,
    /// Mean symmetric epipolar distance from the winner over the volume where things moved, pixels.
    pub distance: f64,
    /// What its hypotheses came from.
    pub source: Source,
}

impl Rival {
    /// Whether the evidence does not tell it from the winner; what is not known tells nothing. Little evidence says nothing for the winner where
    /// camera matrices prefer the rival.
    pub fn is_undecided(&self) -> bool {
        let hardly_any = reaches(self.z, 0.0) && within(self.share, RIVAL_SHARE);
        !(reaches(self.z, RIVAL_Z) || hardly_any)
    }
}

/// The geometry that others are compared with.
pub struct Winner<'v> {
    views: &'v Views,
    /// The matrix.
    pub fundamental: Fundamental,
    /// The radius at which its score is highest, pixels.
    pub radius: f64,
    score: f64,
    by_frame: Vec<f64>,
    block: usize,
}

/// What another geometry has of the winner's evidence.
struct Beside {
    /// Its score as a share of the winner's.
    share: f64,
    /// Normal deviate of the difference in score, and in how well known camera matrices agree.
    z: f64,
}

impl<'v> Winner<'v> {
    /// `block`: frames that share their error.
    pub fn new(views: &'v Views, fundamental: &Fundamental, block: usize) -> Self {
        let (SymmetricScore { total: score, radius }, by_frame) =
            symmetric_score_by_frame(views, fundamental);
        Self { views, fundamental: *fundamental, radius, score, by_frame, block }
    }

    /// The score of another geometry as a share of its own.
    pub fn share(&self, other: &Fundamental) -> f64 {
        self.share_of(symmetric_score(self.views, other))
    }

    fn share_of(&self, theirs: SymmetricScore) -> f64 {
        theirs.total / self.score.max(1e-9)
    }

    /// Another geometry beside it.
    fn beside(&self, other: &Fundamental) -> Beside {
        let (theirs, by_frame) = symmetric_score_by_frame(self.views, other);
        let contradiction = self
            .views
            .cameras
            .as_ref()
            .map_or(0.0, |k| (k.deviation(other) - k.deviation(&self.fundamental)) / DEVIATION);
        Beside {
            share: self.share_of(theirs),
            z: with_cameras(paired_z(&self.by_frame, &by_frame, self.block), contradiction),
        }
    }
}

/// The other solutions beside the winner, highest score first. `volume`: of the winner.
pub fn rivals(winner: &Winner, others: &[Solution], volume: &[Correspondence]) -> Vec<Rival> {
    let mut rivals: Vec<Rival> = others
        .par_iter()
        .map(|solution| {
            let Beside { share, z } = winner.beside(&solution.fundamental);
            Rival {
                fundamental: solution.fundamental,
                share,
                z,
                distance: disagreement(volume, &solution.fundamental),
                source: solution.source,
            }
        })
        .collect();
    rivals.sort_by(|p, q| q.share.total_cmp(&p.share));
    rivals
}

/// Two independent deviates as one, with squares that add up as logarithms of likelihoods do: that of the evidence, and by how
/// much worse than the winner the rival agrees with the camera matrices.
fn with_cameras(z: f64, contradiction: f64) -> f64 {
    let cameras = contradiction.clamp(-MOST_OF_CAMERAS, MOST_OF_CAMERAS);
    let sum = z * z.abs() + cameras * cameras.abs();
    sum.signum() * sum.abs().sqrt()
}

/// Normal deviate of the difference in score between two geometries, from sums over blocks of frames.
///
/// What one frame says its neighbours repeat, so blocks, not frames, are the independent pieces; those in which nothing speaks for either
/// geometry, as nobody is there, are none.
pub fn paired_z(winner: &[f64], rival: &[f64], block: usize) -> f64 {
    let differences: Vec<f64> = winner
        .chunks(block.max(1))
        .zip(rival.chunks(block.max(1)))
        .filter(|(p, q)| p.iter().chain(*q).any(|score| *score != 0.0))
        .map(|(p, q)| p.iter().sum::<f64>() - q.iter().sum::<f64>())
        .collect();
    let n = differences.len() as f64;
    if differences.len() < MIN_COMPARED {
        return 0.0;
    }
    let mean = differences.iter().sum::<f64>() / n;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
    mean / (variance / n).sqrt().max(1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn little_evidence_is_no_rival_however_few_blocks_there_are() {
        let matrix = nalgebra::Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0);
        let fundamental = Fundamental::from_rank_two(&matrix).unwrap();
        let undecided =
            |share, z| Rival { fundamental, share, z, distance: 90.0, source: Source::Tracks }.is_undecided();
        assert!(undecided(0.6, 1.0) && !undecided(0.37, 1.0) && !undecided(0.9, 3.0));
        assert!(undecided(0.51, 0.0) && !undecided(0.5, 0.0) && undecided(0.4, -2.6));
        assert!(undecided(f64::NAN, 1.0) && undecided(0.6, f64::NAN));
    }

    #[test]
    fn cameras_tell_rivals_apart_that_the_evidence_does_not() {
        assert_eq!(with_cameras(1.7, 0.0), 1.7);
        assert_eq!(with_cameras(-1.7, 0.0), -1.7);
        assert!((with_cameras(0.5, 9.0) - 9.25f64.sqrt()).abs() < 1e-12);
        // Matrices that the evidence contradicts do not overrule it; those that speak for the rival take from the winner.
        assert!(with_cameras(-4.0, 9.0) < 0.0 && with_cameras(3.0, -2.9) < 1.0);
        assert!(with_cameras(f64::NAN, 1.0).is_nan());
    }
}
