//! A second look, where the frames kept aside show too little to decide.
//!
//! A fifth of a short recording may show next to nothing: one walker who stands still, or nobody whom both cameras see. What is found by
//! some frames and tested on others is then found and tested anew, with other frames kept aside ([`Fold::Second`](super::split::Fold)).
//! Both searches start from nothing, and neither tests on a frame that it was fitted to. Where they give the same geometry the two tests are
//! one of twice as many frames (cross-fitting); where they do not, each stands for itself, as one of two trials. `calibrate_at` of
//! [`calibrate`](mod@crate::calibrate) looks twice.

use super::shift_curve::ShiftCurve;
use super::thresholds::{FAINT_Z, MIN_Z, reaches};
use super::verified::Verified;
use crate::geometry::Fundamental;

/// How many there are at most.
pub const LOOKS: usize = 2;

/// What the first look tested, and what it gave.
#[derive(Debug, Clone)]
pub struct Earlier {
    /// Fitted to the frames that were not kept aside then.
    pub fitted: Fundamental,
    /// The scores on those that were.
    pub curve: ShiftCurve,
}

impl Earlier {
    /// What is worth another look: nothing decided, but more than nothing was seen.
    pub fn new(verified: &Verified, fitted: Option<Fundamental>) -> Option<Self> {
        let z = verified.evidence.z;
        let faint = reaches(z, FAINT_Z) && !reaches(z, MIN_Z);
        fitted.filter(|_| faint).map(|fitted| Self { fitted, curve: verified.curve.clone() })
    }
}
