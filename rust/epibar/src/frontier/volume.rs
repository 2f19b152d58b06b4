//! The volume where things moved, as correspondences under a proposed `F`.
//!
//! Without a metric frame a volume is what both images show of it: a spot inside some silhouette of A and, on its
//! epipolar line, a spot inside some silhouette of B, at whatever moments. The pairs reach a little beyond the true
//! volume, where the two spots lie at depths that nothing had together, and so err on the side of caution.

use nalgebra::Vector3;
use rand::RngExt;

use super::views::{View, Views};
use crate::geometry::hull::on_chord;
use crate::geometry::{Fundamental, symmetric_epipolar_distance};
use crate::random::{Generator, generator};

/// A spot in A and a spot in B on its epipolar line, pixels.
pub type Correspondence = ([f64; 2], [f64; 2]);

/// Silhouettes of B tried for each spot of A.
const TRIES: usize = 12;

fn random_hull<'v>(view: &'v View, random: &mut Generator) -> Option<&'v [[f64; 2]]> {
    if view.frames() == 0 {
        return None;
    }
    let frame = random.random_range(0..view.frames());
    let count = view.hulls_of(frame).count();
    if count == 0 {
        return None;
    }
    view.hulls_of(frame).nth(random.random_range(0..count))
}

/// About `count` correspondences under `f`, drawn by a seed; fewer where its epipolar lines miss what moved in B.
pub fn moving_correspondences(
    views: &Views,
    f: &Fundamental,
    count: usize,
    seed: u64,
) -> Vec<Correspondence> {
    const SALT: u64 = 0x70_6F69_6E74;
    (0..count)
        .filter_map(|k| {
            let mut random = generator(seed.wrapping_add(SALT), k as u64);
            let hull = random_hull(&views.a, &mut random)?;
            // A random mixture of three vertices lies inside a convex hull.
            let mut pick = || hull[random.random_range(0..hull.len())];
            let (p, q, r) = (pick(), pick(), pick());
            let a = [(p[0] + q[0] + r[0]) / 3.0, (p[1] + q[1] + r[1]) / 3.0];
            let line = f.line_in_b(&Vector3::new(a[0], a[1], 1.0));
            (0..TRIES).find_map(|_| {
                let at = random.random::<f64>();
                on_chord(random_hull(&views.b, &mut random)?, &line, at).map(|b| (a, b))
            })
        })
        .collect()
}

/// Mean symmetric epipolar distance of correspondences under another geometry, pixels.
pub fn disagreement(correspondences: &[Correspondence], other: &Fundamental) -> f64 {
    if correspondences.is_empty() {
        return f64::INFINITY;
    }
    // Capped, so that one spot near an epipole does not decide.
    let sum: f64 =
        correspondences.iter().map(|(a, b)| symmetric_epipolar_distance(other, *a, *b).min(100.0)).sum();
    sum / correspondences.len() as f64
}
