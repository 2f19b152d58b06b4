//! By how much a floor is wrong since cameras are: its vertical, and its level where figures stand.
//!
//! A floor is fitted to bottoms that pairs of cameras triangulate. By the rule of error propagation a covariance `C` of the cameras,
//! after the similarity that fits best, gives the plane the covariance `J C Jᵀ`, with `J` the change of its level and of its two slopes with each
//! parameter: what least squares makes of how far each bottom is lifted off the plane.

use nalgebra::{DMatrix, Matrix3, Vector3};

use crate::geometry::across::across;
use crate::network::model::camera::{CameraStep, INTRINSIC, POSITION, ROTATION};
use crate::network::observations::figures::triangulated;
use crate::network::solve::relocate::Placed;
use crate::network::solve::world::{Bottom, FloorFound};
use crate::verify::thresholds::larger;

/// Standard errors of a floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FloorErrors {
    /// Of its vertical, radians.
    pub vertical: f64,
    /// Of its level where the figures stand, in the unit of the network before it has a world.
    pub level: f64,
}

impl FloorErrors {
    /// Nothing is known.
    pub const UNKNOWN: Self = Self { vertical: f64::INFINITY, level: f64::INFINITY };
}

/// Differences of parameters for derivatives: log focal length, pixels of a principal point, and so on to position.
const DIFFERENCE: f64 = 1e-5;

/// Of a variance, which may be less than nothing by rounding; infinite where it is none.
fn deviation(variance: f64) -> f64 {
    match variance {
        v if v >= 0.0 => v.sqrt(),
        v if v > -ROUNDING => 0.0,
        _ => f64::INFINITY,
    }
}

/// Variances, of radians and of the unit, that are nothing but rounding.
const ROUNDING: f64 = 1e-12;

/// Errors of a floor by covariances of the active parameters after the best similarity, as of
/// [`ways_to_align`](super::stated_errors::ways_to_align); `None` where the bottoms tell no plane.
pub fn floor_errors(
    network: &Placed,
    found: &FloorFound,
    active: &[(usize, usize)],
    ways: &[DMatrix<f64>; 2],
) -> Option<FloorErrors> {
    let (up, middle) = (found.floor.up, found.floor.middle);
    let [along, aside] = across(&up);
    let row = |bottom: &Bottom| {
        let from = bottom.place - middle;
        Vector3::new(1.0, along.dot(&from), aside.dot(&from))
    };
    let normal_matrix: Matrix3<f64> = found.bottoms.iter().map(|b| row(b) * row(b).transpose()).sum();
    let inverse = normal_matrix.try_inverse()?;
    let change = |&(camera, k): &(usize, usize)| -> Vector3<f64> {
        if k >= INTRINSIC && !(ROTATION..POSITION + 3).contains(&k) {
            return Vector3::zeros();
        }
        let mut step = CameraStep::zeros();
        step[k] = DIFFERENCE;
        let stepped = network.cameras[camera].stepped(&step);
        let lifted = |b: &Bottom| {
            let of = |c: usize| if c == camera { &stepped } else { &network.cameras[c] };
            let place = triangulated(of(b.a), of(b.b), b.pixels)?;
            Some(row(b) * up.dot(&(place - b.place)))
        };
        let seen = found.bottoms.iter().filter(|b| b.a == camera || b.b == camera);
        inverse * seen.filter_map(lifted).sum::<Vector3<f64>>() / DIFFERENCE
    };
    let columns: Vec<Vector3<f64>> = active.iter().map(change).collect();
    let changes = DMatrix::from_fn(3, columns.len(), |i, j| columns[j][i]);
    let of_way = |aligned: &DMatrix<f64>| {
        let plane = &changes * aligned * changes.transpose();
        let plane = Matrix3::from_fn(|i, j| plane[(i, j)]);
        let level = (plane * normal_matrix).trace() / found.bottoms.len() as f64;
        let [vertical, level] = [plane[(1, 1)] + plane[(2, 2)], level].map(deviation);
        FloorErrors { vertical, level }
    };
    let [one, other] = ways.each_ref().map(of_way);
    Some(FloorErrors {
        vertical: larger(one.vertical, other.vertical),
        level: larger(one.level, other.level),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::evidence::stated_errors::ways_to_align;
    use crate::network::model::camera::Camera;
    use crate::network::observations::figures::Upright;
    use crate::network::observations::floor::Floor;
    use crate::network::solve::settle::tests::around;

    /// Three cameras, and bottoms of figures on `z = 0` as they see them.
    fn seen() -> (Placed, Vec<Bottom>) {
        let cameras: Vec<Camera> = (0..3).map(|k| around(f64::from(k) * 1.3, 600.0)).collect();
        let mut bottoms = Vec::new();
        for k in 0..60 {
            let place = Vector3::new(f64::from(k % 8) * 0.2 - 0.7, f64::from(k / 8) * 0.2 - 0.7, 0.0);
            let (a, b) = [(0, 1), (0, 2), (1, 2)][k as usize % 3];
            let Some(pixels) = cameras[a].project(&place).zip(cameras[b].project(&place)) else { continue };
            bottoms.push(Bottom { a, b, pixels: pixels.into(), place });
        }
        (Placed { cameras, placed: vec![true; 3] }, bottoms)
    }

    fn floor_of(bottoms: &[Bottom]) -> Floor {
        let upright = |b: &Bottom| Upright { top: b.place + Vector3::z(), bottom: b.place, breadth: None };
        Floor::of(&bottoms.iter().map(upright).collect::<Vec<_>>()).unwrap()
    }

    /// What is stated by a covariance of one step alone, up to its sign.
    fn stated(network: &Placed, found: &FloorFound, step: impl Fn(usize) -> CameraStep) -> FloorErrors {
        let active: Vec<(usize, usize)> =
            (0..3).flat_map(|c| (0..INTRINSIC).chain(ROTATION..POSITION + 3).map(move |k| (c, k))).collect();
        let off = nalgebra::DVector::from_iterator(active.len(), active.iter().map(|&(c, k)| step(c)[k]));
        let ways = ways_to_align(&network.cameras, &network.placed, &active, &(&off * off.transpose()));
        floor_errors(network, found, &active, &ways).unwrap()
    }

    #[test]
    fn a_focal_length_that_is_wrong_moves_the_floor_as_it_says() {
        let (network, bottoms) = seen();
        assert!(bottoms.len() > 40);
        let of_focal = |c: usize| {
            let mut step = CameraStep::zeros();
            step[0] = if c == 0 { 0.01 } else { 0.0 };
            step
        };
        let found = FloorFound { floor: floor_of(&bottoms), bottoms: bottoms.clone() };
        let stated = stated(&network, &found, of_focal);
        let wrong = [0, 1, 2].map(|c| network.cameras[c].stepped(&of_focal(c)));
        let place = |b: &Bottom| triangulated(&wrong[b.a], &wrong[b.b], b.pixels).unwrap();
        let moved: Vec<Bottom> = bottoms.iter().map(|b| Bottom { place: place(b), ..*b }).collect();
        // By least squares of all, as the floor is to first order.
        let rows = |b: &Bottom| Vector3::new(1.0, b.place.x, b.place.y);
        let normal: Matrix3<f64> = bottoms.iter().map(|b| rows(b) * rows(b).transpose()).sum();
        let lifted: Vector3<f64> =
            bottoms.iter().zip(&moved).map(|(b, m)| rows(b) * (m.place.z - b.place.z)).sum();
        let plane = normal.try_inverse().unwrap() * lifted;
        let tilt = plane.y.hypot(plane.z);
        assert!(tilt > 1e-4 && (stated.vertical / tilt - 1.0).abs() < 0.05, "{tilt} {stated:?}");
        let level = bottoms.iter().map(|b| rows(b).dot(&plane).powi(2)).sum::<f64>() / bottoms.len() as f64;
        assert!((stated.level / level.sqrt() - 1.0).abs() < 0.05, "{level} {stated:?}");
    }

    #[test]
    fn a_turn_of_the_whole_network_is_no_error() {
        let (network, bottoms) = seen();
        let turn = Vector3::new(0.003, -0.01, 0.005);
        let of_whole = |c: usize| {
            let camera = &network.cameras[c];
            let mut step = CameraStep::zeros();
            let own: Vector3<f64> = camera.rotation * turn;
            step.fixed_rows_mut::<3>(ROTATION).copy_from(&-own);
            step.fixed_rows_mut::<3>(POSITION).copy_from(&turn.cross(&camera.position));
            step
        };
        let found = FloorFound { floor: floor_of(&bottoms), bottoms };
        let stated = stated(&network, &found, of_whole);
        assert!(stated.vertical < 1e-6 && stated.level < 1e-6, "{stated:?}");
    }
}
