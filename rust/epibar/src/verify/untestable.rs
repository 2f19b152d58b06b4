//! Refusals before a geometry is tested: there is nothing to work with, or nothing was found.

use super::prose;
use super::thresholds::{MIN_CANDIDATES, MIN_FRAMES, MIN_LINES};
use super::verdict::{Kind, Verdict};
use crate::matching::Candidates;

/// Refuses where the cameras have hardly a frame in common.
pub fn too_few_frames(common: usize) -> Option<Verdict> {
    (common < MIN_FRAMES).then(|| Verdict::new(Kind::TooLittleMotion, prose::few_common_frames(common)))
}

/// Refuses where there are too few lines, pairs of lines, or frames (`busy`) with silhouettes in both cameras.
pub fn too_little_motion(candidates: &Candidates, busy: usize) -> Option<Verdict> {
    uninformative(candidates).or_else(|| no_candidates(candidates)).or_else(|| too_few_silhouettes(busy))
}

/// Refuses where a camera has hardly any informative line.
fn uninformative(candidates: &Candidates) -> Option<Verdict> {
    let (a, b) = (candidates.informative_a, candidates.informative_b);
    let few = a < MIN_LINES || b < MIN_LINES;
    few.then(|| Verdict::new(Kind::TooLittleMotion, prose::uninformative(a, b)))
}

fn no_candidates(candidates: &Candidates) -> Option<Verdict> {
    let few = candidates.pairs.len() < MIN_CANDIDATES;
    few.then(|| Verdict::new(Kind::NoCommonScene, prose::NO_CANDIDATES))
}

fn too_few_silhouettes(busy: usize) -> Option<Verdict> {
    (busy < MIN_FRAMES).then(|| Verdict::new(Kind::TooLittleMotion, prose::few_silhouettes(busy)))
}

/// Refuses where the search found nothing.
pub fn no_hypothesis() -> Verdict {
    Verdict::new(Kind::NoCommonScene, prose::NO_HYPOTHESIS)
}
