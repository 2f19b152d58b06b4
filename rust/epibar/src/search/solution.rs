//! What a search finds.

use crate::frontier::Views;
use crate::frontier::symmetric::{SymmetricScore, chance_level, symmetric_score};
use crate::geometry::Fundamental;
use crate::hypotheses::Source;
use crate::hypotheses::floor::FloorHomography;

/// A refined geometry with its score.
#[derive(Debug, Clone, Copy)]
pub struct Solution {
    /// The matrix.
    pub fundamental: Fundamental,
    /// Evidence of its silhouettes, at the radius that gives most, less `chance`.
    pub score: f64,
    /// That evidence with the clocks shifted, where above nought: what the model of chance missed.
    pub chance: f64,
    /// The hypotheses it grew from.
    pub source: Source,
}

/// Different geometries, as the fitted frames have them.
#[derive(Debug, Clone, Default)]
pub struct Searched {
    /// Highest score first.
    pub solutions: Vec<Solution>,
    /// The plane that many candidates fit, if there is one.
    pub floor: Option<FloorHomography>,
}

/// What was found: the answer, what is tested, and rivals.
#[derive(Debug, Clone, Default)]
pub struct Found {
    /// Different geometries, highest score on all frames first.
    pub solutions: Vec<Solution>,
    /// The winner of the fitted frames alone, in which those kept aside had no part.
    pub fitted: Option<Fundamental>,
    /// The plane that many candidates fit, if there is one.
    pub floor: Option<FloorHomography>,
}

/// What is worth a share of a score, which may be below nought: then it is below that.
pub(super) fn share_of(score: f64, share: f64) -> f64 {
    score - (1.0 - share) * score.abs()
}

impl Solution {
    /// `f` with its score on `views`; `None` where that is not finite.
    pub(super) fn new(views: &Views, f: Fundamental, source: Source) -> Option<Self> {
        Self::scored(views, symmetric_score(views, &f), f, source)
    }

    /// `f` with a score that is known.
    pub(super) fn scored(
        views: &Views,
        found: SymmetricScore,
        f: Fundamental,
        source: Source,
    ) -> Option<Self> {
        let chance = chance_level(views, &f, found.radius);
        let score = found.total - chance;
        score.is_finite().then_some(Self { fundamental: f, score, chance, source })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_of_a_score_is_never_above_it() {
        assert_eq!([8.0, 0.0, -8.0].map(|score| share_of(score, 0.75)), [6.0, 0.0, -10.0]);
    }
}
