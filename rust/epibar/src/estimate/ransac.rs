//! The hypothesise-and-score loop, which knows nothing of geometry.
//!
//! Every hypothesis has an index, and whatever is random in it is drawn from a generator of (seed, index): the
//! outcome does not depend on the number of threads. The best are kept by (score, lower index). Work is done in
//! batches, between which the caller may stop the loop.

use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::{Error, Result};

/// Hypotheses scored between two looks at [`Watch::keep_going`].
const BATCH: usize = 512;

/// Share of the worst kept score below which a glance is enough.
const GLANCED: f64 = 0.5;

/// Something that proposes models and tells how good they are.
pub trait Estimator: Sync {
    /// What is estimated.
    type Model: Clone + Send;

    /// A model from hypothesis `index`, `None` where the sample is degenerate.
    fn generate(&self, index: usize, random: &mut Pcg64Mcg) -> Option<Self::Model>;

    /// How good a model is: larger is better, NaN never wins.
    fn score(&self, model: &Self::Model) -> f64;

    /// About the score, from part of what tells it; infinite where that would save nothing.
    ///
    /// A model with less than half of what the worst that is kept scored is not looked at more closely.
    fn glance(&self, _model: &Self::Model) -> f64 {
        f64::INFINITY
    }
}

/// Lets a caller watch a long computation and stop it.
pub trait Watch {
    /// Called between batches, on the calling thread: a stage, and how much of it is done (0 to 1). `false` stops.
    fn keep_going(&mut self, stage: &'static str, done: f64) -> bool;
}

/// Watches nothing and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unwatched;

impl Watch for Unwatched {
    fn keep_going(&mut self, _stage: &'static str, _done: f64) -> bool {
        true
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

/// A generator that depends only on the seed and the index.
pub fn generator(seed: u64, index: u64) -> Pcg64Mcg {
    // SplitMix64 of both words: neighbouring indices give unrelated states.
    let mix = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    };
    let low = mix(seed.wrapping_add(0x9E37_79B9_7F4A_7C15).wrapping_add(mix(index)));
    let high = mix(low ^ index.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    Pcg64Mcg::new((u128::from(high) << 64) | u128::from(low) | 1)
}

/// Draws `draws` hypotheses and returns the `keep` best, best first.
///
/// # Errors
/// [`Error::Interrupted`] where `watch` says so.
pub fn ransac<E: Estimator>(
    estimator: &E,
    draws: usize,
    keep: usize,
    seed: u64,
    stage: &'static str,
    watch: &mut dyn Watch,
) -> Result<Vec<Scored<E::Model>>> {
    let mut best: Vec<Scored<E::Model>> = Vec::new();
    for start in (0..draws).step_by(BATCH) {
        if !watch.keep_going(stage, start as f64 / draws as f64) {
            return Err(Error::Interrupted);
        }
        let enough = if best.len() < keep { f64::NEG_INFINITY } else { GLANCED * best[keep - 1].score };
        let scored: Vec<_> = (start..(start + BATCH).min(draws))
            .into_par_iter()
            .filter_map(|index| {
                let model = estimator.generate(index, &mut generator(seed, index as u64))?;
                if estimator.glance(&model) < enough {
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
    use rand::RngExt;

    /// Finds the number nearest 0.5 among random ones.
    struct Nearest;

    impl Estimator for Nearest {
        type Model = f64;

        fn generate(&self, index: usize, random: &mut Pcg64Mcg) -> Option<f64> {
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
            pool.install(|| ransac(&Nearest, 3000, 5, 7, "test", &mut Unwatched).unwrap())
        };
        let (one, four) = (run(1), run(4));
        assert_eq!(one.len(), 5);
        assert!((one[0].model - 0.5).abs() < 2e-3);
        for (p, q) in one.iter().zip(&four) {
            assert_eq!((p.model.to_bits(), p.index), (q.model.to_bits(), q.index));
        }
    }

    /// As [`Nearest`], with a glance that tells half the score, or nothing.
    struct Glancing(f64, std::sync::atomic::AtomicUsize);

    impl Estimator for Glancing {
        type Model = f64;

        fn generate(&self, index: usize, random: &mut Pcg64Mcg) -> Option<f64> {
            Nearest.generate(index, random)
        }

        fn score(&self, model: &f64) -> f64 {
            self.1.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            1.0 - 2.0 * (model - 0.5).abs()
        }

        fn glance(&self, model: &f64) -> f64 {
            self.0 * (1.0 - 2.0 * (model - 0.5).abs())
        }
    }

    #[test]
    fn a_glance_saves_scores_and_loses_nothing_that_it_does_not_halve() {
        let run = |factor| {
            let estimator = Glancing(factor, 0.into());
            let best = ransac(&estimator, 3000, 5, 7, "test", &mut Unwatched).unwrap();
            (best.iter().map(|s| s.index).collect::<Vec<_>>(), estimator.1.into_inner())
        };
        let (all, scored) = run(f64::INFINITY);
        let (glanced, fewer) = run(0.6);
        assert_eq!(all, glanced);
        assert!(scored > 2500 && fewer < scored / 2, "{fewer} of {scored}");
    }

    #[test]
    fn stops_when_told() {
        struct Never;
        impl Watch for Never {
            fn keep_going(&mut self, _: &'static str, _: f64) -> bool {
                false
            }
        }
        assert!(matches!(ransac(&Nearest, 10, 1, 0, "test", &mut Never), Err(Error::Interrupted)));
    }
}
