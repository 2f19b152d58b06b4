//! What the tests of a geometry look at.

use super::evidence::Evidence;
use super::rivals::Rival;
use crate::frontier::TangentMatch;

/// All that a verdict is reached from.
pub struct Findings<'a> {
    /// Against chance.
    pub evidence: &'a Evidence,
    /// Tangents that meet in all frames.
    pub matches: &'a [TangentMatch],
    /// The radius within which they meet, pixels.
    pub radius: f64,
    /// The radius at which the score is highest, pixels.
    pub best_radius: f64,
    /// Expected error over the volume where things moved, pixels; NaN where unknown.
    pub expected_error: f64,
    /// The error that the covariance alone expects in half of an image, pixels.
    pub beyond_motion: f64,
    /// What is possible in half of an image, what outlines are off alike included, pixels.
    pub possible_beyond: f64,
    /// Other geometries.
    pub rivals: &'a [Rival],
    /// Pixels for one of a 640×480 image.
    pub scale: f64,
    /// It is known which end of what moves is up.
    pub upright: bool,
    /// How far it is from any two cameras with square pixels and principal points in the middle; `None` where the cameras are known.
    pub from_cameras: Option<f64>,
    /// A larger expected error is refused, pixels.
    pub max_expected_error: f64,
}
