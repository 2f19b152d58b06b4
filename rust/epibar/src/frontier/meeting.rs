//! Within which radius tangents meet.

use super::matches::robust_deviation;
use super::score::tangent_matches;
use super::views::Views;
use crate::geometry::Fundamental;

/// Tangents meet within so many deviations of what meets at [`GENEROUS_RADIUS`]: nearly all of those that are right.
const RADIUS_DEVIATIONS: f64 = 3.0;
/// Tangents meet within this at first, and no farther apart, pixels of a 640×480 image: four times the radius of clean outlines.
const GENEROUS_RADIUS: f64 = 6.0;
/// Tangents meet within at least this, whatever their deviation, pixels of a 640×480 image: outlines are of whole pixels in both.
const LEAST_RADIUS: f64 = 1.0;
/// Tangents meet within this where too few do to tell a deviation, pixels of a 640×480 image.
const UNKNOWN_RADIUS: f64 = 3.0;

/// Within how many pixels tangents meet under `f`. The radius follows the masks: three times the deviation of what meets at a generous one.
pub fn meeting_radius(views: &Views, f: &Fundamental) -> f64 {
    let scale = views.pixel_scale();
    let generous = tangent_matches(views, f, GENEROUS_RADIUS * scale);
    let radius = RADIUS_DEVIATIONS * robust_deviation(&generous);
    let radius = radius.clamp(LEAST_RADIUS * scale, GENEROUS_RADIUS * scale);
    if radius.is_nan() { UNKNOWN_RADIUS * scale } else { radius }
}
