//! Refusals before a geometry is tested: there is nothing to work with, or nothing was found.

use super::thresholds::{MIN_CANDIDATES, MIN_FRAMES, MIN_LINES};
use super::verdict::{Kind, Verdict};
use crate::matching::Candidates;

/// Refuses where the cameras have hardly a frame in common.
pub fn too_few_frames(common: usize) -> Option<Verdict> {
    (common < MIN_FRAMES).then(|| {
        Verdict::new(
            Kind::TooLittleMotion,
            format!("Only {common} frames are common to both cameras; at least {MIN_FRAMES} are needed."),
        )
    })
}

/// Refuses where there are too few lines, pairs of lines, or frames (`busy`) with silhouettes in both cameras.
pub fn too_little_motion(candidates: &Candidates, busy: usize) -> Option<Verdict> {
    uninformative(candidates).or_else(|| no_candidates(candidates)).or_else(|| too_few_silhouettes(busy))
}

/// Refuses where a camera has hardly any informative line.
fn uninformative(candidates: &Candidates) -> Option<Verdict> {
    let (a, b) = (candidates.informative_a, candidates.informative_b);
    let which = match (a < MIN_LINES, b < MIN_LINES) {
        (false, false) => return None,
        (true, true) => "either camera",
        (true, false) => "camera A",
        (false, true) => "camera B",
    };
    Some(Verdict::new(
        Kind::TooLittleMotion,
        format!(
            "Too little changes in {which}: {a} lines of A and {b} of B are crossed by motion in some frames and \
             free of it in others, and at least {MIN_LINES} are needed in each."
        ),
    ))
}

fn no_candidates(candidates: &Candidates) -> Option<Verdict> {
    (candidates.pairs.len() < MIN_CANDIDATES).then(|| {
        Verdict::new(
            Kind::NoCommonScene,
            "No lines of the two cameras are crossed by motion at the same moments, so nothing suggests that they see \
             the same moving things at the same time.",
        )
    })
}

fn too_few_silhouettes(busy: usize) -> Option<Verdict> {
    (busy < MIN_FRAMES).then(|| {
        Verdict::new(
            Kind::TooLittleMotion,
            format!(
                "Only {busy} frames show something larger than specks moving in both cameras; at least {MIN_FRAMES} \
                 are needed."
            ),
        )
    })
}

/// Refuses where the search found nothing.
pub fn no_hypothesis() -> Verdict {
    Verdict::new(
        Kind::NoCommonScene,
        "No epipolar geometry explains what moves in both cameras, so nothing suggests that they see the same \
         moving things at the same time.",
    )
}
