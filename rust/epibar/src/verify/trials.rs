//! What is left of evidence that is the best of many trials.

use super::evidence::Evidence;
use super::prose;
use super::thresholds::{MIN_Z, reaches};
use super::verdict::{Kind, Verdict};

/// An offset chosen among many fits by chance as well as the best of so many: the normal deviate is what is left
/// of it when the chance is multiplied by their number, `exp(−z²/2) · trials`. An accepted geometry may fall by that.
pub fn account_for_trials(trials: usize, evidence: &mut Evidence, verdict: &mut Verdict) {
    let falls = falls_for(trials, evidence);
    evidence.z = left(evidence.z, trials);
    if verdict.accepted() && falls {
        *verdict = Verdict::new(Kind::NoCommonScene, prose::faint_for_trials(evidence.z, trials));
    }
}

/// Whether the evidence is too little for the best of so many.
pub fn falls_for(trials: usize, evidence: &Evidence) -> bool {
    !reaches(left(evidence.z, trials), MIN_Z)
}

/// The normal deviate that is left of the best of so many trials.
pub fn left(z: f64, trials: usize) -> f64 {
    (z.max(0.0).powi(2) - 2.0 * (trials as f64).ln()).max(0.0).sqrt()
}
