//! Where one camera stands beside another by the geometry of their pair, once both focal lengths are guessed.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::camera::Camera;
use super::residual::Meeting;

/// Tangents by which it is told which side of the cameras is before them.
const RAYS: usize = 160;

/// The relative pose that a guess of both cameras makes of a geometry: rotation from A to B and unit translation
/// `x_b ~ R x_a + t`, and the share of the meetings that lie before both.
pub fn relative_pose(
    fundamental: &Matrix3<f64>,
    a: &Camera,
    b: &Camera,
    meetings: &[Meeting],
) -> Option<(Rotation3<f64>, Vector3<f64>, f64)> {
    let essential = b.matrix().tr_mul(&(fundamental * a.matrix()));
    let svd = (essential / essential.norm()).try_svd(true, true, 1e-15, 200)?;
    let (mut u, mut vt) = (svd.u?, svd.v_t?);
    // The null direction last.
    let least = svd.singular_values.imin();
    u.swap_columns(least, 2);
    vt.swap_rows(least, 2);
    if u.determinant() < 0.0 {
        u.neg_mut();
    }
    if vt.determinant() < 0.0 {
        vt.neg_mut();
    }
    let quarter = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let step = meetings.len().div_ceil(RAYS).max(1);
    let (optics_a, optics_b) = (a.optics(), b.optics());
    let rays: Vec<_> = meetings
        .iter()
        .step_by(step)
        .filter_map(|m| {
            let ([xa, ya], [xb, yb]) = (optics_a.direction(m.a)?, optics_b.direction(m.b)?);
            Some((Vector3::new(xa, ya, 1.0), Vector3::new(xb, yb, 1.0)))
        })
        .collect();
    let mut best: Option<(Rotation3<f64>, Vector3<f64>, f64)> = None;
    for turn in [quarter, quarter.transpose()] {
        let rotation = Rotation3::from_matrix_unchecked(u * turn * vt);
        for sign in [1.0, -1.0] {
            let t = u.column(2) * sign;
            let before = rays.iter().filter(|(p, q)| are_before(&(rotation * p), q, &t)).count();
            let share = before as f64 / rays.len().max(1) as f64;
            if best.is_none_or(|b| share > b.2) {
                best = Some((rotation, t, share));
            }
        }
    }
    best
}

/// Whether the point nearest to both rays, `z_a p + t` and `z_b q`, lies before both cameras.
fn are_before(p: &Vector3<f64>, q: &Vector3<f64>, t: &Vector3<f64>) -> bool {
    let across = q.cross(p);
    let depth_a = -across.dot(&q.cross(t));
    // z_a from q × (z_a p + t) = 0; the sign of z_b from that of the point along q.
    let z_a = depth_a / across.norm_squared().max(1e-300);
    z_a > 0.0 && (p * z_a + t).dot(q) > 0.0
}

/// A camera at the place that a relative pose and a length of the baseline give it beside another.
pub fn placed_beside(
    from: &Camera,
    to: &Camera,
    rotation: &Rotation3<f64>,
    t: &Vector3<f64>,
    length: f64,
) -> Camera {
    let turned = rotation * from.rotation;
    // X_b = R X_a + t, so B's centre is at −Rᵀ t in A's frame.
    Camera { rotation: turned, position: from.position - turned.inverse() * t * length, ..*to }
}
