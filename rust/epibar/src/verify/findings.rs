//! What the tests of a geometry look at.

use super::evidence::Evidence;
use super::gains::Gain;
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
    /// How far it is from any two cameras that have the principal points and the shape of pixels of those that were given, or else square pixels and principal
    /// points in the middle.
    pub from_cameras: f64,
    /// What is explained without the camera matrices that were given; `None` where none were, or nothing stands out.
    pub without_given_cameras: Option<Gain>,
    /// A larger expected error is refused, pixels.
    pub max_expected_error: f64,
}
