//! Evidence against chance: the score of `F` with the clocks shifted.
//!
//! A true `F` scores high at the true time offset and at chance level elsewhere. [`shift_curve`] scores `F` with B's
//! frames moved against A's, on frames that `F` was not fitted to; [`ShiftCurve::evidence`] sums it up. The same pairs of
//! frames are compared from A to B and from B to A, so that it does not matter which camera comes first.

use std::ops::Range;

use rayon::prelude::*;

use super::evidence::Evidence;
use super::independence::independent;
use super::thresholds::{MIN_DEVIATION, MIN_SHIFTS, reaches};
use crate::frontier::{ClassScore, Comparer, FrontierScore, Views};
use crate::geometry::Fundamental;
use crate::refine::polish;

/// Score of `F` at one shift of B's frames, class by class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AtShift {
    /// Frames of shift, cyclic.
    pub shift: usize,
    /// The sum of the score from A to B and from B to A.
    pub score: FrontierScore,
}

/// What a geometry is tested on.
#[derive(Debug, Clone)]
pub struct HeldOut<'a> {
    /// All common frames in which both cameras see something.
    pub views: &'a Views,
    /// The frames that the geometry was fitted to.
    pub fitted: &'a Views,
    /// Stretches of `views` that it was not fitted to, nor anything near them.
    pub tested: &'a [Range<usize>],
    /// For how many of `views` motion stays where it is; shifts by less say the same as none.
    pub stay: usize,
    /// Two tangents meet below this Sampson distance, pixels.
    pub radius: f64,
}

/// Scores over time shifts.
#[derive(Debug, Clone, Default)]
pub struct ShiftCurve {
    /// The frames tested, at no shift and then at others.
    pub scores: Vec<AtShift>,
    /// As many frames of A elsewhere, at the same shifts but the first.
    pub elsewhere: Vec<Vec<FrontierScore>>,
    /// How many of the shifts are farther from one another than motion stays.
    pub apart: f64,
    /// How many looks at the recording are summed.
    pub looks: usize,
}

/// Of so many sets of frames, each of two looks that overlap, as many as two thirds are independent: by simulation 3.3 of five sets that
/// cover every frame twice.
const OF_TWO_LOOKS: f64 = 2.0 / 3.0;

/// Scores `f` on the frames tested at no shift and at about `count` others, none within `stay` frames of it.
///
/// B's frames move cyclically through the whole recording, not among the tested ones alone: the deviation over shifts is
/// known no better than there are moments that differ. A frame of B that `f` was fitted to is no more in its favour
/// beside another frame of A than any other is.
pub fn shift_curve(held_out: &HeldOut, f: &Fundamental, count: usize) -> ShiftCurve {
    let HeldOut { views, fitted, tested, stay, radius } = *held_out;
    let (frames, stay) = (views.frames(), stay.max(1));
    let span = frames.saturating_sub(2 * stay);
    let count = count.min(span);
    let shifts: Vec<usize> = std::iter::once(0).chain((0..count).map(|k| stay + k * span / count)).collect();
    let length = tested.iter().map(Range::len).max().unwrap_or(0).max(1);
    let total: usize = tested.iter().map(Range::len).sum();
    let moved = |by: usize| -> Vec<usize> {
        tested.iter().flat_map(Clone::clone).map(|i| (i + by) % frames.max(1)).collect()
    };
    let sets: Vec<Vec<usize>> = (0..(frames / total.max(1)).max(1)).map(|k| moved(k * length)).collect();
    // Which of the two maps of rays holds is no choice that the frames tested have.
    let signs = (Comparer::new(fitted, f).sign(0, radius), Comparer::reversed(fitted, f).sign(0, radius));
    let scores: Vec<Vec<FrontierScore>> = shifts
        .par_iter()
        .map_init(
            || (Comparer::new(views, f), Comparer::reversed(views, f)),
            |(there, back), &shift| {
                let (mut there, mut back) =
                    (there.pair_by(signs.0, shift), back.pair_by(signs.1, (frames - shift) % frames));
                let (there, back) = (there.weigh(radius), back.weigh(radius));
                let of = |set: &Vec<usize>| {
                    let in_b: Vec<usize> = set.iter().map(|i| (i + shift) % frames).collect();
                    let mut score = there.score_of(set);
                    score += back.score_of(&in_b);
                    score
                };
                sets.iter().map(of).collect()
            },
        )
        .collect();
    ShiftCurve {
        scores: shifts.iter().zip(&scores).map(|(&shift, of)| AtShift { shift, score: of[0] }).collect(),
        elsewhere: (1..sets.len()).map(|k| scores[1..].iter().map(|of| of[k]).collect()).collect(),
        apart: span as f64 / (2 * stay) as f64,
        looks: 1,
    }
}

/// Parts into which [`cross_validated`] divides the frames.
const FOLDS: usize = 5;

/// The curve of all frames: each fifth is tested with what `f` becomes when it is refined on the others.
///
/// Five times the frames of a test apart, for what is too faint there. `f` itself was chosen on all frames, so this is less
/// strict than [`shift_curve`]: it is for parts of the evidence of a geometry that passed the test.
pub fn cross_validated(views: &Views, f: &Fundamental, held_out: &HeldOut, count: usize) -> ShiftCurve {
    let n = views.frames();
    let mut whole = ShiftCurve::default();
    for fold in 0..FOLDS {
        let tested = fold * n / FOLDS..(fold + 1) * n / FOLDS;
        let apart = |i: &usize| i + held_out.stay < tested.start || *i >= tested.end + held_out.stay;
        let fitted = views.chosen(&(0..n).filter(apart).collect::<Vec<_>>());
        let refined = polish(&fitted, f);
        let of = HeldOut { views, fitted: &fitted, tested: std::slice::from_ref(&tested), ..*held_out };
        let curve = shift_curve(&of, &refined, count);
        whole = if whole.scores.is_empty() { curve } else { whole.with(&curve) };
    }
    // Nothing is elsewhere.
    ShiftCurve { elsewhere: Vec::new(), ..whole }
}

fn mean_and_variance(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0))
}

/// The normal deviate that is as unlikely as Student's `t` with `freedom` degrees of freedom (Wallace 1959).
pub fn normal_deviate(t: f64, freedom: f64) -> f64 {
    let (nu, sign) = (freedom, t.signum());
    sign * (8.0 * nu + 1.0) / (8.0 * nu + 3.0) * (nu * (t * t / nu).ln_1p()).sqrt()
}

impl ShiftCurve {
    /// The curve of these frames and of others of the same recording, tested at the same shifts.
    pub fn with(mut self, other: &Self) -> Self {
        // Which shifts there are is of the recording's frames and of how long motion stays, so no input makes them differ.
        assert!(self.scores.iter().map(|s| s.shift).eq(other.scores.iter().map(|s| s.shift)));
        self.scores.iter_mut().zip(&other.scores).for_each(|(sum, part)| sum.score += part.score);
        self.elsewhere.truncate(other.elsewhere.len());
        for (sums, parts) in self.elsewhere.iter_mut().zip(&other.elsewhere) {
            sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += *part);
        }
        self.looks += other.looks;
        self
    }

    /// Each shift with the mean score of both ways.
    pub fn totals(&self) -> impl Iterator<Item = (usize, f64)> {
        self.scores.iter().map(|s| (s.shift, 0.5 * s.score.total()))
    }

    /// Whether there are enough shifts that differ to say anything by those of the frames tested alone: two degrees of freedom, as with one
    /// even nine deviations are no more than two of a normal one.
    pub fn can_say(&self) -> bool {
        let rest = self.scores.len().saturating_sub(1);
        rest >= MIN_SHIFTS && reaches(self.apart.min(rest as f64) - 1.0, 2.0)
    }

    /// How unlikely it is by chance that `of` is as large as at no shift, as a normal deviate; 0 where there are too few
    /// shifts to say.
    ///
    /// The mean is that of the frames tested. Their deviation is that of few independent shifts, so that of as many
    /// frames elsewhere is taken with it, and the larger of the two counts.
    fn deviate(&self, of: &dyn Fn(&FrontierScore) -> f64) -> f64 {
        // The mean of both ways.
        let of = &|score: &FrontierScore| 0.5 * of(score);
        let Some((first, rest)) = self.scores.split_first() else { return 0.0 };
        let here = rest.iter().map(|s| of(&s.score)).collect();
        let elsewhere = self.elsewhere.iter().map(|scores| scores.iter().map(of).collect());
        let sets: Vec<Vec<f64>> = std::iter::once(here).chain(elsewhere).collect();
        // Motion that stays says the same of neighbouring shifts, but what meets under a geometry may be gone long before.
        // One part by itself is too short to tell.
        let shown = if sets.len() > 1 { independent(&sets) } else { None };
        let independent = shown.map_or(self.apart, |shown| shown.max(self.apart)).min(rest.len() as f64);
        let of_sets = if sets.len() > 1 && self.looks > 1 { OF_TWO_LOOKS } else { 1.0 };
        let freedom = (independent - 1.0) * of_sets * sets.len() as f64;
        if rest.len() < MIN_SHIFTS || !reaches(freedom, 1.0) {
            return 0.0;
        }
        let (mean, own) = mean_and_variance(&sets[0]);
        let pooled = sets.iter().map(|set| mean_and_variance(set).1).sum::<f64>() / sets.len() as f64;
        let deviation = own.max(pooled).sqrt().max(MIN_DEVIATION);
        // The mean itself is uncertain.
        let t = (of(&first.score) - mean) / (deviation * (1.0 + 1.0 / independent).sqrt());
        normal_deviate(t, freedom)
    }

    /// Standard scores of what is found at no shift.
    pub fn evidence(&self) -> Evidence {
        let Some((first, rest)) = self.scores.split_first() else { return Evidence::default() };
        let share = |s: &FrontierScore| s.matches() as f64 / (s.tangents().max(1)) as f64;
        let of_class = |c: &ClassScore| c.matches as f64 / c.tangents.max(1) as f64;
        let objects = &first.score.objects;
        Evidence {
            z: self.deviate(&FrontierScore::total),
            z_tops: self.deviate(&|s| s.tops.excess),
            z_bottoms: self.deviate(&|s| s.bottoms.excess),
            z_whole: self.deviate(&|s| s.objects.whole as f64),
            both_ends: (objects.whole + objects.torn) as f64 / objects.silhouettes.max(1) as f64,
            explained: share(&first.score),
            explained_tops: of_class(&first.score.tops),
            explained_bottoms: of_class(&first.score.bottoms),
            explained_by_chance: rest.iter().map(|s| share(&s.score)).sum::<f64>() / rest.len().max(1) as f64,
            ..Evidence::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_looks_that_overlap_are_not_worth_two() {
        let of = |excess: f64| {
            let mut score = FrontierScore::default();
            score.tops.excess = excess;
            score
        };
        let noise = |k: usize| ((k * 7919) % 101) as f64 - 50.0;
        let scores =
            (0..40).map(|k| AtShift { shift: 10 * k, score: of(if k == 0 { 250.0 } else { noise(k) }) });
        let sets = (1..5).map(|set| (1..40).map(|k| of(noise(100 * set + k))).collect());
        let one = ShiftCurve { scores: scores.collect(), elsewhere: sets.collect(), apart: 3.0, looks: 1 };
        let two = ShiftCurve { looks: 2, ..one.clone() };
        let (z, less) = (one.evidence().z_tops, two.evidence().z_tops);
        assert!(less > 2.0 && less < z - 0.05, "{less} {z}");
        assert_eq!(one.clone().with(&one).looks, 2);
    }
}
