//! How well the cameras are known: the covariance of the joint problem, robust to tangents of one moment sharing their
//! errors.
//!
//! With the normal matrix `H` at the solution and the gradients `g` of blocks of time the covariance of the unknowns is
//! `H⁻¹ (Σ g gᵀ + P) H⁻¹`, the sandwich estimator clustered in time (White 1982; Liang and Zeger 1986), with weights and loss
//! those of the fit; blocks in space, and errors that outlines of one part of an image share, are added to it; `P` is what the
//! beliefs scatter by themselves. Where the whole stands in the world nothing says: that is
//! taken out by the similarity that fits best, so that a camera's error is what is left after the networks have been laid
//! over one another.

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};

use crate::network::model::camera::{CLOCK, Camera, INSET, INTRINSIC, PARAMETERS, POSITION, ROTATION};
use crate::network::model::joint::{PairMeetings, Problem, weight};
use crate::network::model::residual::{Meeting, Pair, Row};
use crate::verify::thresholds::larger;

/// Blocks of time whose tangents share errors, seconds.
const BLOCK: f64 = 2.0;
/// Cells along each side of an image.
const CELLS: usize = 4;

/// Which cell of an image a pixel is in.
fn cell(camera: &Camera, [x, y]: [f64; 2]) -> usize {
    let along = |v: f64, of: usize| ((v / of as f64 * CELLS as f64) as usize).min(CELLS - 1);
    along(x, camera.size.width) * CELLS + along(y, camera.size.height)
}

/// Gradients of groups of tangents, a row for each group: `groups` tells of a tangent, its pair, its residual and its
/// derivatives, in which groups it is and what by its derivatives are multiplied.
fn gathered<const N: usize>(
    problem: &Problem,
    cameras: &[Camera],
    active: &[(usize, usize)],
    count: usize,
    groups: impl Fn(usize, &Meeting, f64, &Row) -> [(usize, f64); N],
) -> DMatrix<f64> {
    let mut column = vec![usize::MAX; cameras.len() * PARAMETERS];
    for (i, (camera, k)) in active.iter().enumerate() {
        column[camera * PARAMETERS + k] = i;
    }
    let mut sums = DMatrix::zeros(count, active.len());
    for (number, pair) in problem.pairs.iter().enumerate() {
        let geometry = Pair::new(&cameras[pair.a], &cameras[pair.b]);
        for m in &pair.meetings {
            let Some((r, row)) = geometry.row(m) else { continue };
            let weight = m.weight * weight(r, problem.scale, pair.coarseness);
            for (group, factor) in groups(number, m, r, &row) {
                for k in 0..2 * PARAMETERS {
                    let camera = if k < PARAMETERS { pair.a } else { pair.b };
                    let at = column[camera * PARAMETERS + k % PARAMETERS];
                    if at != usize::MAX {
                        sums[(group, at)] += weight * row[k] * factor;
                    }
                }
            }
        }
    }
    sums
}

/// What it does that all outlines of one camera, of one direction and in one part of the image, are wrong by so many pixels.
fn shared_errors(
    problem: &Problem,
    cameras: &[Camera],
    active: &[(usize, usize)],
    outline_errors: &[f64],
) -> DMatrix<f64> {
    let place = |camera: usize, pixel: [f64; 2], [x, y]: [f64; 2]| {
        let direction = if y.abs() > x.abs() { usize::from(y < 0.0) } else { 2 + usize::from(x < 0.0) };
        (camera * 4 + direction) * CELLS * CELLS + cell(&cameras[camera], pixel)
    };
    gathered(problem, cameras, active, cameras.len() * 4 * CELLS * CELLS, |number, m, _, row| {
        let PairMeetings { a, b, .. } = problem.pairs[number];
        [
            (place(a, m.a, m.outward_a), outline_errors[a] * row[INSET]),
            (place(b, m.b, m.outward_b), outline_errors[b] * row[PARAMETERS + INSET]),
        ]
    })
}

/// Gradients of tangents that may share what outlines are wrong by: those of one pair, of tops or of bottoms, in one part of
/// the image of A.
fn places(problem: &Problem, cameras: &[Camera], active: &[(usize, usize)]) -> DMatrix<f64> {
    let each = 2 * CELLS * CELLS;
    gathered(problem, cameras, active, problem.pairs.len() * each, |number, m, r, _| {
        let class = usize::from(m.outward_a[1] < 0.0);
        let a = &cameras[problem.pairs[number].a];
        [(number * each + class * CELLS * CELLS + cell(a, m.a), r)]
    })
}

/// Gradients of blocks of the network's time.
fn blocks(problem: &Problem, cameras: &[Camera], active: &[(usize, usize)]) -> DMatrix<f64> {
    let time = |number: usize, m: &Meeting| cameras[problem.pairs[number].a].time_of(m.time_a);
    let times = problem
        .pairs
        .iter()
        .enumerate()
        .flat_map(|(number, p)| p.meetings.iter().map(move |m| time(number, m)));
    let (first, last) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
    let count = if last > first { ((last - first) / BLOCK).ceil() as usize + 1 } else { 1 };
    gathered(problem, cameras, active, count, |number, m, r, _| {
        [((((time(number, m) - first) / BLOCK) as usize).min(count - 1), r)]
    })
}

/// A covariance, and of which parameters.
pub struct Covariance {
    /// Camera and parameter of each row.
    pub active: Vec<(usize, usize)>,
    /// The covariance.
    pub matrix: DMatrix<f64>,
}

impl Covariance {
    /// The block of three parameters of a camera from one on; `None` where they were not solved for.
    pub fn block(&self, camera: usize, from: usize) -> Option<Matrix3<f64>> {
        let place = |k: usize| self.active.iter().position(|p| *p == (camera, k));
        let at = [place(from)?, place(from + 1)?, place(from + 2)?];
        Some(Matrix3::from_fn(|i, j| self.matrix[(at[i], at[j])]))
    }

    /// The standard deviation of a parameter of a camera; 0 where it was not solved for.
    pub fn deviation(&self, camera: usize, parameter: usize) -> f64 {
        let at = self.active.iter().position(|p| *p == (camera, parameter));
        at.map_or(0.0, |p| self.matrix[(p, p)].max(0.0).sqrt())
    }
}

/// Covariance of the active parameters, with outlines of each camera that may all be wrong alike by so many pixels; `None` where the
/// normal matrix is not usable.
pub fn covariance(problem: &Problem, cameras: &[Camera], outline_errors: &[f64]) -> Option<Covariance> {
    let active = problem.active();
    let linear = problem.linear(cameras, &active);
    let n = active.len();
    let all = linear.normal.nrows();
    let found = blocks(problem, cameras, &active);
    // What nothing determines is held by next to nothing, in proportion to the diagonal.
    let scale = DVector::from_fn(all, |k, _| 1.0 / linear.normal[(k, k)].max(1e-300).sqrt());
    let scaled = DMatrix::from_fn(all, all, |i, j| linear.normal[(i, j)] * scale[i] * scale[j]);
    let held = scaled + DMatrix::identity(all, all) * 1e-9;
    let inverse = held.cholesky()?.inverse();
    let inverse = DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] * scale[i] * scale[j]);
    let used = found.row_iter().filter(|r| r.norm_squared() > 0.0).count() as f64;
    let correction = used / (used - 1.0).max(1.0);
    let mut meat = found.tr_mul(&found) * correction;
    let places = places(problem, cameras, &active);
    meat += places.tr_mul(&places);
    let shared = shared_errors(problem, cameras, &active, outline_errors);
    meat += shared.tr_mul(&shared);
    for (i, (camera, k)) in active.iter().enumerate() {
        let beliefs = &problem.beliefs[*camera];
        let deviation = match *k {
            k if k < INTRINSIC => beliefs.intrinsic[k].deviation,
            CLOCK => beliefs.clock[0].deviation,
            k if k == CLOCK + 1 => beliefs.clock[1].deviation,
            INSET => beliefs.inset.deviation,
            _ => 0.0,
        };
        if deviation > 0.0 && deviation.is_finite() {
            // A belief is an observation of its own: its gradient scatters by its weight over its deviation.
            meat[(i, i)] += (problem.prior_weight / deviation).powi(2);
        }
    }
    let result = &inverse * meat * &inverse;
    result.iter().all(|v| v.is_finite()).then_some(Covariance { active, matrix: result })
}

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
        position_covariance: Matrix3::new(
            f64::NAN,
            f64::NAN,
            f64::NAN,
            f64::NAN,
            f64::NAN,
            f64::NAN,
            f64::NAN,
            f64::NAN,
            f64::NAN,
        ),
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

    /// The same in a world that is turned and has another unit.
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
/// And nine in ten normal vectors in space, alike in every direction, are shorter than so many.
pub const NINE_IN_TEN_IN_SPACE: f64 = 2.5;

/// Errors of every camera after the best similarity, from a covariance of the active parameters.
pub fn expected(
    cameras: &[Camera],
    placed: &[bool],
    active: &[(usize, usize)],
    covariance: &DMatrix<f64>,
) -> Vec<Expected> {
    let n = cameras.len();
    let ways = BY_POSITIONS.map(|share| aligned(cameras, placed, active, covariance, share));
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
    (0..n).map(|camera| of_camera(camera, &ways[0]).or_larger(of_camera(camera, &ways[1]))).collect()
}

/// Nine in ten of normal vectors of this covariance are shorter (the square of the length as a gamma variable of the same
/// mean and variance, Satterthwaite 1946, by the cube-root approximation of Wilson and Hilferty 1931).
pub fn length_quantile(covariance: &Matrix3<f64>) -> f64 {
    let mean = covariance.trace().max(0.0);
    if mean == 0.0 {
        return 0.0;
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
