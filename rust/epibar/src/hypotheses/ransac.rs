//! The hypothesise-and-score loop, which knows nothing of geometry.
//!
//! Every hypothesis has an index, and whatever is random in it is drawn from a generator of (seed, index): the
//! outcome does not depend on the number of threads. The best are kept by (score, lower index). Work is done in
//! batches, between which the caller may stop the loop.

use rayon::prelude::*;

use crate::error::Result;
use crate::random::{Generator, generator};
use crate::watch::{Stage, Watch, report};

/// Hypotheses scored between two calls of [`Watch::keep_going`].
const BATCH: usize = 512;

/// A preview refuses a model that is below the worst kept score by more than what this share leaves of it.
const PREVIEWED: f64 = 0.5;

/// Something that proposes models and scores them.
pub trait Estimator: Sync {
    /// What is estimated.
    type Model: Clone + Send;

    /// A model from hypothesis `index`, `None` where the sample is degenerate.
    fn generate(&self, index: usize, random: &mut Generator) -> Option<Self::Model>;

    /// How good a model is: larger is better, NaN never wins.
    fn score(&self, model: &Self::Model) -> f64;

    /// An estimate of the score from a part of the data; infinite where that would save nothing.
    ///
    /// A model whose preview is below the worst score kept so far by half of it is not scored.
    fn preview(&self, _model: &Self::Model) -> f64 {
        f64::INFINITY
    }
}

/// A model with its score and the index of its hypothesis.
#[derive(Debug, Clone)]
pub struct Scored<M> {
    /// The model.
    pub model: M,
    /// Its score.
    pub score: f64,
    /// Index of the hypothesis that gave it.
    pub index: usize,
}

/// Draws `draws` hypotheses and returns the `keep` best, best first.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted) where `watch` says so.
pub fn ransac<E: Estimator>(
    estimator: &E,
    draws: usize,
    keep: usize,
    seed: u64,
    stage: Stage,
    watch: &mut dyn Watch,
) -> Result<Vec<Scored<E::Model>>> {
    let mut best: Vec<Scored<E::Model>> = Vec::new();
    for start in (0..draws).step_by(BATCH) {
        report(watch, stage, start as f64 / draws as f64)?;
        let enough = match best.get(keep - 1) {
            Some(worst) => worst.score - (1.0 - PREVIEWED) * worst.score.abs(),
            None => f64::NEG_INFINITY,
        };
        let scored: Vec<_> = (start..(start + BATCH).min(draws))
            .into_par_iter()
            .filter_map(|index| {
                let model = estimator.generate(index, &mut generator(seed, index as u64))?;
                if estimator.preview(&model) < enough {
                    return None;
                }
                let score = estimator.score(&model);
                (!score.is_nan()).then_some(Scored { model, score, index })
            })
            .collect();
        best.extend(scored);
        best.sort_by(|p, q| q.score.total_cmp(&p.score).then(p.index.cmp(&q.index)));
        best.truncate(keep);
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::watch::Unwatched;
    use rand::RngExt;

    /// Finds the number nearest 0.5 among random ones.
    struct Nearest;

    impl Estimator for Nearest {
        type Model = f64;

        fn generate(&self, index: usize, random: &mut Generator) -> Option<f64> {
            (!index.is_multiple_of(7)).then(|| random.random::<f64>())
        }

        fn score(&self, model: &f64) -> f64 {
            if *model > 0.9 { f64::NAN } else { -(model - 0.5).abs() }
        }
    }

    #[test]
    fn finds_the_best_whatever_the_thread_count() {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| ransac(&Nearest, 3000, 5, 7, Stage::Lines, &mut Unwatched).unwrap())
        };
        let (one, four) = (run(1), run(4));
        assert_eq!(one.len(), 5);
        assert!((one[0].model - 0.5).abs() < 2e-3);
        for (p, q) in one.iter().zip(&four) {
            assert_eq!((p.model.to_bits(), p.index), (q.model.to_bits(), q.index));
        }
    }

    /// [`Nearest`] with a preview that is a multiple of the score.
    struct Previewed(f64, std::sync::atomic::AtomicUsize);

    impl Estimator for Previewed {
        type Model = f64;

        fn generate(&self, index: usize, random: &mut Generator) -> Option<f64> {
            Nearest.generate(index, random)
        }

        fn score(&self, model: &f64) -> f64 {
            self.1.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            1.0 - 2.0 * (model - 0.5).abs()
        }

        fn preview(&self, model: &f64) -> f64 {
            self.0 * (1.0 - 2.0 * (model - 0.5).abs())
        }
    }

    #[test]
    fn a_preview_saves_scores_and_loses_nothing_that_it_does_not_halve() {
        let run = |factor| {
            let estimator = Previewed(factor, 0.into());
            let best = ransac(&estimator, 3000, 5, 7, Stage::Lines, &mut Unwatched).unwrap();
            (best.iter().map(|s| s.index).collect::<Vec<_>>(), estimator.1.into_inner())
        };
        let (all, scored) = run(f64::INFINITY);
        let (previewed, fewer) = run(0.6);
        assert_eq!(all, previewed);
        assert!(scored > 2500 && fewer < scored / 2, "{fewer} of {scored}");
    }

    /// Scores that are all below nought, and exact previews.
    struct Below;

    impl Estimator for Below {
        type Model = f64;

        fn generate(&self, index: usize, random: &mut Generator) -> Option<f64> {
            Nearest.generate(index, random)
        }

        fn score(&self, model: &f64) -> f64 {
            -100.0 - (model - 0.5).abs()
        }

        fn preview(&self, model: &f64) -> f64 {
            self.score(model)
        }
    }

    #[test]
    fn a_preview_loses_nothing_where_scores_are_negative() {
        let best = ransac(&Below, 3000, 5, 7, Stage::Lines, &mut Unwatched).unwrap();
        assert!(best[4].score > -100.01, "{}", best[4].score);
    }

    #[test]
    fn stops_where_the_watch_says_so() {
        let mut never = |_: Stage, _: f64| false;
        assert!(matches!(ransac(&Nearest, 10, 1, 0, Stage::Lines, &mut never), Err(Error::Interrupted)));
    }
}
