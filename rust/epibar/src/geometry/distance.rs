//! Distances of point correspondences from an epipolar geometry, in pixels.

use nalgebra::Vector3;

use super::fundamental::Fundamental;

/// Symmetric epipolar distance `½ (d(x_b, F x_a) + d(x_a, Fᵀ x_b))`, pixels (paper §4.3).
///
/// Infinite where a point is an epipole and so has no epipolar line.
pub fn symmetric_epipolar_distance(f: &Fundamental, a: [f64; 2], b: [f64; 2]) -> f64 {
    let (xa, xb) = (Vector3::new(a[0], a[1], 1.0), Vector3::new(b[0], b[1], 1.0));
    let (line_b, line_a) = (f.line_in_b(&xa), f.line_in_a(&xb));
    let algebraic = xb.dot(&line_b).abs();
    // Not `hypot`: image coordinates do not overflow, and everything is measured with this.
    let length = |line: &Vector3<f64>| (line.x * line.x + line.y * line.y).sqrt();
    let distance = 0.5 * algebraic * (1.0 / length(&line_b) + 1.0 / length(&line_a));
    if distance.is_nan() { f64::INFINITY } else { distance }
}

/// Signed first-order geometric distance of Sampson, pixels: `x_bᵀFx_a / √(|Fx_a|² + |Fᵀx_b|²)` over
/// the first two components (Hartley and Zisserman, §11.4.3).
pub fn sampson_distance(f: &Fundamental, a: [f64; 2], b: [f64; 2]) -> f64 {
    let (xa, xb) = (Vector3::new(a[0], a[1], 1.0), Vector3::new(b[0], b[1], 1.0));
    let (line_b, line_a) = (f.line_in_b(&xa), f.line_in_a(&xb));
    let norm = (line_b.x.powi(2) + line_b.y.powi(2) + line_a.x.powi(2) + line_a.y.powi(2)).sqrt();
    xb.dot(&line_b) / norm.max(f64::MIN_POSITIVE)
}
