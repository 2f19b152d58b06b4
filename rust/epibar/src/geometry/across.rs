//! Two directions across a third.

use nalgebra::Vector3;

/// Two directions across an axis, with which it is a right-handed frame.
pub fn across(axis: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let u = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
    [u, axis.normalize().cross(&u)]
}
