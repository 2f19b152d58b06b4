//! The verdict: accepted, or refused with a reason in plain English.

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
    /// A different geometry scores about as high.
    Ambiguous,
    /// It holds in one part of the recording only: a camera moved.
    Knocked,
    /// The expected error is above the limit.
    Inaccurate,
}

impl Kind {
    /// Every kind.
    #[cfg(feature = "files")]
    pub(crate) const ALL: [Self; 7] = [
        Self::Accepted,
        Self::TooLittleMotion,
        Self::NoCommonScene,
        Self::Undetermined,
        Self::Ambiguous,
        Self::Knocked,
        Self::Inaccurate,
    ];

    /// The word in reports and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Accepted => "accepted",
            Self::TooLittleMotion => "too_little_motion",
            Self::NoCommonScene => "no_common_scene",
            Self::Undetermined => "undetermined",
            Self::Ambiguous => "ambiguous",
            Self::Knocked => "knocked",
            Self::Inaccurate => "inaccurate",
        }
    }
}

/// Whether a calibration can be relied on, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Verdict {
    /// For programs.
    pub kind: Kind,
    /// In plain English: a sentence, and another one where there is something to know beside it.
    pub reason: String,
}

impl Verdict {
    pub(crate) fn new(kind: Kind, reason: impl Into<String>) -> Self {
        Self { kind, reason: reason.into() }
    }

    /// This verdict, with something to know beside it.
    pub(crate) fn with_remark(self, remark: &str) -> Self {
        Self { reason: self.reason + remark, ..self }
    }

    /// Whether the matrix can be relied on.
    pub fn accepted(&self) -> bool {
        self.kind == Kind::Accepted
    }
}
