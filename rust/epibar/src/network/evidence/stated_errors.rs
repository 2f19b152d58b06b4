//! What errors are to be expected of a camera, by the covariance of the joint problem.
//!
//! Where the whole stands in the world nothing says: that is taken out by the similarity that fits best, so that a camera's
//! error is what is left after the networks have been laid over one another.

use nalgebra::{ArrayStorage, DMatrix, DVector, Matrix3, Rotation3, Vector3};

use crate::network::model::camera::{Camera, POSITION, ROTATION};
use crate::verify::thresholds::larger;

/// Errors to expect of one camera, each below what it says nine times in ten.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Expected {
    /// Of the focal length, relative.
    pub focal: f64,
    /// Of the rotation, radians.
    pub rotation: f64,
    /// Of the position, unit of the network.
    pub position: f64,
    /// Covariance of the position along the axes of the world, square of the unit: the position is off by more in one direction than in another.
    pub position_covariance: Matrix3<f64>,
}

impl Expected {
    /// Of a focal length, relative, of a rotation, radians, and of a position, unit of the network, which is off alike in all directions.
    pub fn new(focal: f64, rotation: f64, position: f64) -> Self {
        Self { focal, rotation, position, position_covariance: alike(position) }
    }

    /// Nothing is known.
    pub const UNKNOWN: Self = Self {
        focal: f64::NAN,
        rotation: f64::NAN,
        position: f64::NAN,
        position_covariance: Matrix3::from_array_storage(ArrayStorage([[f64::NAN; 3]; 3])),
    };

    /// Of a covariance of the position.
    pub(in crate::network) fn of_position(focal: f64, rotation: f64, covariance: Matrix3<f64>) -> Self {
        // That of a weakly determined network is symmetric but for what rounding leaves, a hundred thousandth.
        let symmetric = 0.5 * (covariance + covariance.transpose());
        Self { focal, rotation, position: length_quantile(&covariance), position_covariance: symmetric }
    }

    /// The larger of each that depends on how networks are laid over one another; a focal length does not.
    fn or_larger(self, other: Self) -> Self {
        let position = larger(self.position, other.position);
        let of_other = self.position < position || other.position.is_nan();
        Self {
            rotation: larger(self.rotation, other.rotation),
            position,
            position_covariance: if of_other { other } else { self }.position_covariance,
            ..self
        }
    }

    /// Besides errors that are independent of these, those of the position alike in all directions.
    pub(in crate::network) fn besides(self, other: &Self) -> Self {
        Self {
            focal: self.focal.hypot(other.focal),
            rotation: self.rotation.hypot(other.rotation),
            position: self.position.hypot(other.position),
            position_covariance: self.position_covariance + alike(other.position),
        }
    }

    /// These errors in a world that is turned and has another unit.
    pub(in crate::network) fn in_world(self, turn: &Rotation3<f64>, unit: f64) -> Self {
        Self {
            position: self.position / unit,
            position_covariance: turn * self.position_covariance * turn.inverse() / (unit * unit),
            ..self
        }
    }
}

/// A covariance alike in all directions, of vectors of which nine in ten are shorter than this.
fn alike(length: f64) -> Matrix3<f64> {
    Matrix3::from_diagonal_element((length / NINE_IN_TEN_IN_SPACE).powi(2))
}

/// How much positions count, beside rotations, for the turn that lays one network over another. Who compares two networks lays them over
/// one another by both, or by where the cameras look and then shifts and scales; what is stated is the larger of the two.
const BY_POSITIONS: [f64; 2] = [1.0, 1e-6];

/// Quantile of a normal deviate's absolute value below which nine in ten lie.
pub const NINE_IN_TEN: f64 = 1.645;
/// Nine in ten normal vectors in space, alike in every direction, are shorter than so many.
pub const NINE_IN_TEN_IN_SPACE: f64 = 2.5;

/// Covariances of what is left after the similarity that fits best, by either way of comparing networks.
pub(in crate::network) fn ways_to_align(
    cameras: &[Camera],
    placed: &[bool],
    active: &[(usize, usize)],
    covariance: &DMatrix<f64>,
) -> [DMatrix<f64>; 2] {
    BY_POSITIONS.map(|share| aligned(cameras, placed, active, covariance, share))
}

/// Errors of so many cameras, from covariances of the active parameters after the best similarity as of [`ways_to_align`].
pub fn expected(count: usize, active: &[(usize, usize)], ways: &[DMatrix<f64>; 2]) -> Vec<Expected> {
    let of_camera = |camera: usize, aligned: &DMatrix<f64>| {
        let block = |from: usize| {
            let places: Vec<Option<usize>> =
                (0..3).map(|k| active.iter().position(|p| *p == (camera, from + k))).collect();
            Matrix3::from_fn(|i, j| match (places[i], places[j]) {
                (Some(p), Some(q)) => aligned[(p, q)],
                _ => 0.0,
            })
        };
        let focal = active
            .iter()
            .position(|p| *p == (camera, 0))
            .map_or(0.0, |p| NINE_IN_TEN * aligned[(p, p)].max(0.0).sqrt());
        Expected::of_position(focal, length_quantile(&block(ROTATION)), block(POSITION))
    };
    (0..count).map(|camera| of_camera(camera, &ways[0]).or_larger(of_camera(camera, &ways[1]))).collect()
}

/// Nine in ten of normal vectors of this covariance are shorter (the square of the length as a gamma variable of the same
/// mean and variance, Satterthwaite 1946, by the cube-root approximation of Wilson and Hilferty 1931); infinite where it is none.
pub fn length_quantile(covariance: &Matrix3<f64>) -> f64 {
    let mean = covariance.trace();
    if mean == 0.0 {
        return 0.0;
    }
    if mean.is_nan() || mean < 0.0 {
        return f64::INFINITY;
    }
    let freedom = mean * mean / (covariance * covariance).trace().max(1e-300);
    let variance = 2.0 / (9.0 * freedom);
    let ratio = (1.0 - variance + 1.2816 * variance.sqrt()).powi(3);
    (mean * ratio).sqrt()
}

/// The covariance of what is left after the similarity that lays one network best over another: a rotation by a radian counts like
/// a move by the size of the network, or by a share of that.
fn aligned(
    cameras: &[Camera],
    placed: &[bool],
    active: &[(usize, usize)],
    covariance: &DMatrix<f64>,
    by_positions: f64,
) -> DMatrix<f64> {
    let stand = || cameras.iter().zip(placed).filter(|(_, p)| **p).map(|(c, _)| c.position);
    let count = stand().count().max(1) as f64;
    let mean = stand().sum::<Vector3<f64>>() / count;
    let size2 = stand().map(|p| (p - mean).norm_squared()).sum::<f64>() / count;
    // Moves of the whole: three shifts, three turns, one scale.
    let mut moves = DMatrix::zeros(active.len(), 7);
    let mut weight = DVector::zeros(active.len());
    for (i, (camera, k)) in active.iter().enumerate() {
        let c = &cameras[*camera];
        match *k {
            k if (POSITION..POSITION + 3).contains(&k) => {
                let axis = k - POSITION;
                weight[i] = by_positions / size2.max(1e-12);
                moves[(i, axis)] = 1.0;
                for turn in 0..3 {
                    let omega = Vector3::ith(turn, 1.0);
                    moves[(i, 3 + turn)] = omega.cross(&(c.position - mean))[axis];
                }
                moves[(i, 6)] = (c.position - mean)[axis];
            }
            k if (ROTATION..ROTATION + 3).contains(&k) => {
                weight[i] = 1.0;
                for turn in 0..3 {
                    // The world turned by ω turns the camera by −R ω in its own frame.
                    moves[(i, 3 + turn)] = -(c.rotation * Vector3::ith(turn, 1.0))[k - ROTATION];
                }
            }
            _ => (),
        }
    }
    let weighed = DMatrix::from_fn(active.len(), 7, |i, j| weight[i] * moves[(i, j)]);
    let Some(inverse) = weighed.tr_mul(&moves).try_inverse() else { return covariance.clone() };
    let projector = DMatrix::identity(active.len(), active.len()) - &moves * inverse * weighed.transpose();
    &projector * covariance * projector.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_turn_with_the_world() {
        let along_x = Matrix3::from_diagonal(&Vector3::new(4.0, 1.0, 1.0));
        let stated = Expected::of_position(0.01, 0.02, along_x);
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
        let there = stated.in_world(&turn, 2.0);
        let along_y = Matrix3::from_diagonal(&Vector3::new(0.25, 1.0, 0.25));
        assert!((there.position_covariance - along_y).norm() < 1e-12, "{there:?}");
        assert!((there.position - length_quantile(&along_y)).abs() < 1e-12);
        assert_eq!((there.focal, there.rotation), (0.01, 0.02));
    }

    #[test]
    fn a_covariance_is_symmetric() {
        let mut rounded = Matrix3::from_diagonal(&Vector3::new(4.0, 1.0, 1.0));
        (rounded[(0, 1)], rounded[(1, 0)]) = (0.5, 0.5001);
        let stated = Expected::of_position(0.01, 0.02, rounded).position_covariance;
        assert_eq!(stated, stated.transpose());
        let turn = Rotation3::from_euler_angles(0.3, 0.2, 0.1);
        let there = Expected::of_position(0.01, 0.02, rounded).in_world(&turn, 2.0).position_covariance;
        assert!((there - there.transpose()).norm() < 1e-12);
    }

    #[test]
    fn what_is_alike_in_all_directions_is_added() {
        let (own, other) = (Expected::new(0.03, 0.0, 0.3), Expected::new(0.04, 0.1, 0.4));
        let both = own.besides(&other);
        assert!(
            (both.focal - 0.05).abs() < 1e-12 && both.rotation == 0.1 && (both.position - 0.5).abs() < 1e-12
        );
        assert!((both.position_covariance - alike(0.5)).norm() < 1e-12);
        assert!((length_quantile(&alike(0.5)) - 0.5).abs() < 0.002, "nine in ten are shorter");
        assert_eq!(length_quantile(&Matrix3::zeros()), 0.0);
        for none in [-1e-9, f64::NAN] {
            assert_eq!(length_quantile(&Matrix3::from_diagonal_element(none)), f64::INFINITY);
        }
        assert!(own.besides(&Expected::UNKNOWN).position_covariance.diagonal().iter().all(|v| v.is_nan()));
    }

    #[test]
    fn the_covariance_is_that_of_the_larger_error() {
        let (small, large) = (Expected::new(0.01, 0.2, 0.1), Expected::new(0.01, 0.1, 0.3));
        for found in [small.or_larger(large), large.or_larger(small)] {
            assert_eq!((found.rotation, found.position_covariance), (0.2, large.position_covariance));
        }
        let unknown = large.or_larger(Expected::UNKNOWN);
        assert!(unknown.position.is_nan() && unknown.position_covariance.iter().all(|v| v.is_nan()));
        let unknown = Expected::UNKNOWN.or_larger(large);
        assert!(unknown.position.is_nan() && unknown.position_covariance.iter().all(|v| v.is_nan()));
    }
}
