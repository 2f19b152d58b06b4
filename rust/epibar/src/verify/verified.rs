//! What comes out of the tests.

use super::error_map::Uncertainty;
use super::evidence::Evidence;
use super::rivals::Rival;
use super::shift_curve::ShiftCurve;
use super::verdict::Verdict;
use crate::frontier::TangentMatch;
use crate::frontier::volume::Correspondence;

/// What the tests gave.
pub struct Verified {
    /// Accepted, or why not.
    pub verdict: Verdict,
    /// Pixels; NaN where unknown.
    pub expected_error: f64,
    /// The numbers behind the verdict.
    pub evidence: Evidence,
    /// Scores with the clocks shifted, on frames kept aside.
    pub curve: ShiftCurve,
    /// Other geometries.
    pub rivals: Vec<Rival>,
    /// Within which tangents meet, pixels.
    pub radius: f64,
    /// Tangents that meet in all frames.
    pub matches: Vec<TangentMatch>,
    /// Correspondences of the volume where things moved.
    pub volume: Vec<Correspondence>,
    /// `None` where the matches do not determine it.
    pub uncertainty: Option<Uncertainty>,
}
