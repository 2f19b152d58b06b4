//! The verdict: accepted, or refused with a reason in plain English (DESIGN §7).

use crate::matching::Candidates;

/// What a verdict says, for programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
    /// The matrix can be relied on.
    Accepted,
    /// A camera saw too little motion.
    TooLittleMotion,
    /// Nothing suggests that the two cameras see the same moving things.
    NoCommonScene,
    /// The motion leaves the matrix undetermined: one line, one plane, or no baseline.
    Undetermined,
    /// A different geometry has about the same evidence.
    Ambiguous,
    /// The expected error is above the limit.
    Inaccurate,
}

impl Kind {
    /// The word in reports and files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Accepted => "accepted",
            Self::TooLittleMotion => "too_little_motion",
            Self::NoCommonScene => "no_common_scene",
            Self::Undetermined => "undetermined",
            Self::Ambiguous => "ambiguous",
            Self::Inaccurate => "inaccurate",
        }
    }
}

/// Whether a calibration can be relied on, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verdict {
    /// For programs.
    pub kind: Kind,
    /// One sentence in plain English.
    pub reason: String,
}

impl Verdict {
    pub(super) fn new(kind: Kind, reason: impl Into<String>) -> Self {
        Self { kind, reason: reason.into() }
    }

    /// Whether the matrix can be relied on.
    pub fn accepted(&self) -> bool {
        self.kind == Kind::Accepted
    }

    pub(super) fn too_few_frames(frames: usize, least: usize) -> Self {
        Self::new(
            Kind::TooLittleMotion,
            format!("Only {frames} frames are common to both cameras; at least {least} are needed."),
        )
    }

    pub(super) fn too_few_silhouettes(frames: usize, least: usize) -> Self {
        Self::new(
            Kind::TooLittleMotion,
            format!(
                "Only {frames} frames show something larger than specks moving in both cameras; at least {least} are \
                 needed."
            ),
        )
    }

    /// Refuses where a camera has hardly any informative line.
    pub(super) fn too_little_motion(candidates: &Candidates) -> Option<Self> {
        let (a, b) = (candidates.informative_a, candidates.informative_b);
        let which = match (a < 2, b < 2) {
            (false, false) => return None,
            (true, true) => "either camera",
            (true, false) => "camera A",
            (false, true) => "camera B",
        };
        Some(Self::new(
            Kind::TooLittleMotion,
            format!(
                "Too little changes in {which}: {a} lines of A and {b} of B are crossed by motion in some frames and \
                 free of it in others, and at least 2 are needed in each."
            ),
        ))
    }

    pub(super) fn no_candidates() -> Self {
        Self::new(
            Kind::NoCommonScene,
            "No lines of the two cameras are crossed by motion at the same moments, so nothing suggests that they see \
             the same moving things at the same time.",
        )
    }

    pub(super) fn no_hypothesis() -> Self {
        Self::new(
            Kind::NoCommonScene,
            "No epipolar geometry explains what moves in both cameras, so nothing suggests that they see the same \
             moving things at the same time.",
        )
    }
}
