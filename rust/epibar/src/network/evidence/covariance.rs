//! How well the cameras are known: the covariance of the joint problem, robust to tangents of one moment sharing their
//! errors.
//!
//! With the normal matrix `H` at the solution and the gradients `g` of blocks of time the covariance of the unknowns is
//! `H⁻¹ (Σ g gᵀ + P) H⁻¹`, the sandwich estimator clustered in time (White 1982; Liang and Zeger 1986), with weights and loss
//! those of the fit; blocks in space, and errors that outlines of one part of an image share, are added to it; `P` is what the
//! beliefs scatter by themselves. Where several beliefs are possible it is that of all of them together.

use nalgebra::{DMatrix, DVector, Matrix3};

use crate::network::model::camera::{
    CLOCK, Camera, INSET, INSET_OF_SIDES, INSET_OF_SMALL, INTRINSIC, PARAMETERS,
};
use crate::network::model::invertible::{HELD, Invertible};
use crate::network::model::joint::{JointProblem, PairMeetings, columns, columns_of_pair, weight};
use crate::network::model::residual::{CameraPair, Meeting, PairGradient};
use crate::network::solve::networks::Solved;
use crate::network::solve::principal::{self, Likely};

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
    problem: &JointProblem,
    cameras: &[Camera],
    active: &[(usize, usize)],
    count: usize,
    groups: impl Fn(usize, &Meeting, f64, &PairGradient) -> [(usize, f64); N],
) -> DMatrix<f64> {
    let column = columns(cameras.len(), active);
    let mut sums = DMatrix::zeros(count, active.len());
    for (number, pair) in problem.pairs.iter().enumerate() {
        let geometry = CameraPair::new(&cameras[pair.a], &cameras[pair.b]);
        let columns_of_pair = columns_of_pair(pair, &column);
        for m in &pair.meetings {
            let Some((r, row)) = geometry.row(m) else { continue };
            let weight = m.weight * weight(r, problem.scale, pair.coarseness);
            for (group, factor) in groups(number, m, r, &row) {
                for (k, at) in columns_of_pair.iter().enumerate() {
                    if let Some(at) = *at {
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
    problem: &JointProblem,
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
fn places(problem: &JointProblem, cameras: &[Camera], active: &[(usize, usize)]) -> DMatrix<f64> {
    let each = 2 * CELLS * CELLS;
    gathered(problem, cameras, active, problem.pairs.len() * each, |number, m, r, _| {
        let class = usize::from(m.outward_a[1] < 0.0);
        let a = &cameras[problem.pairs[number].a];
        [(number * each + class * CELLS * CELLS + cell(a, m.a), r)]
    })
}

/// Gradients of blocks of the network's time.
fn blocks(problem: &JointProblem, cameras: &[Camera], active: &[(usize, usize)]) -> DMatrix<f64> {
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

/// The covariance of what was solved for, with principal points as far from the middle as they may be.
pub fn covariance_with_principal_points(
    solved: &Solved,
    likely: &Likely,
    outline_errors: &[f64],
) -> Option<Covariance> {
    let cameras = &solved.network.cameras;
    let of_level = |(level, share)| {
        let beliefs = principal::at_level(&solved.beliefs, cameras, level);
        Some((covariance(&solved.problem(&beliefs), cameras, outline_errors)?, share))
    };
    Covariance::of_several(likely.levels().map(of_level).collect::<Option<_>>()?)
}

/// A covariance, and of which parameters.
#[derive(Debug, Clone)]
pub struct Covariance {
    /// Camera and parameter of each row.
    pub active: Vec<(usize, usize)>,
    /// The covariance.
    pub matrix: DMatrix<f64>,
    /// How far the optimum is from the cameras that it was asked of, to first order.
    pub off: DVector<f64>,
}

impl Covariance {
    /// Mean square of errors under one of several problems, each as likely as its share of the sum: within each, and by how much its
    /// optimum is off. What is solved for in some is known in the others. `None` of none.
    pub fn of_several(problems: Vec<(Self, f64)>) -> Option<Self> {
        let sum: f64 = problems.iter().map(|(_, share)| share).sum();
        let mut active = problems.first()?.0.active.clone();
        for at in problems.iter().flat_map(|(one, _)| &one.active) {
            if !active.contains(at) {
                active.push(*at);
            }
        }
        let by_share = |(one, share): (Self, f64)| {
            let one = if one.active == active { one } else { one.among(&active) };
            let matrix = (one.matrix + &one.off * one.off.transpose()) * (share / sum);
            Self { off: one.off * (share / sum), matrix, active: one.active }
        };
        problems.into_iter().map(by_share).reduce(|all, one| Self {
            matrix: all.matrix + one.matrix,
            off: all.off + one.off,
            active: all.active,
        })
    }

    /// This information among other parameters, which are known.
    #[must_use]
    pub fn among(&self, active: &[(usize, usize)]) -> Self {
        let place: Vec<Option<usize>> = active.iter().map(|&(c, k)| self.row(c, k)).collect();
        let n = active.len();
        let matrix = DMatrix::from_fn(n, n, |i, j| match (place[i], place[j]) {
            (Some(p), Some(q)) => self.matrix[(p, q)],
            _ => 0.0,
        });
        let off = DVector::from_fn(n, |i, _| place[i].map_or(0.0, |p| self.off[p]));
        Self { active: active.to_vec(), matrix, off }
    }

    /// This information with an optimum that is off by so much of each parameter of a camera.
    #[must_use]
    pub fn off_by(self, step: impl Fn(usize, usize) -> f64) -> Self {
        let off = self.active.iter().map(|&(camera, k)| step(camera, k));
        Self { off: DVector::from_iterator(self.active.len(), off), ..self }
    }

    /// This information with the offset of each camera's clock that was solved for wrong by more than scatters, and with it what was solved for
    /// beside it, as the normal matrix says; `None` where that is not usable.
    ///
    /// `wrong` gives seconds of a camera and of how much still tells of its offset where all else follows it, as a share of what does where
    /// all else is known. Drifts are held: an offset is that at the network's time 0, and beside a drift would say nothing of the time of the
    /// footage.
    pub fn with_offsets_wrong(
        mut self,
        normal: &DMatrix<f64>,
        wrong: impl Fn(usize, f64) -> f64,
    ) -> Option<Self> {
        let rows = |of: &dyn Fn(usize) -> bool| -> Vec<usize> {
            (0..self.active.len()).filter(|&i| of(self.active[i].1)).collect()
        };
        let (offsets, others) = (rows(&|k| k == CLOCK), rows(&|k| k != CLOCK && k != CLOCK + 1));
        let between = |one: &[usize], other: &[usize]| {
            DMatrix::from_fn(one.len(), other.len(), |i, j| normal[(one[i], other[j])])
        };
        let follow = -(Invertible::of(&between(&others, &others))?.inverse() * between(&others, &offsets));
        let mut along = DMatrix::zeros(self.active.len(), offsets.len());
        for (j, &offset) in offsets.iter().enumerate() {
            let left = normal[(offset, offset)] + (between(&[offset], &others) * follow.column(j))[0];
            let seconds = wrong(self.active[offset].0, left / normal[(offset, offset)]);
            along[(offset, j)] = seconds;
            for (i, &other) in others.iter().enumerate() {
                along[(other, j)] = seconds * follow[(i, j)];
            }
        }
        self.matrix += &along * along.transpose();
        self.matrix.iter().all(|v| v.is_finite()).then_some(self)
    }

    /// The block of some parameters, each of a camera; `None` where one was not solved for.
    pub fn of(&self, parameters: &[(usize, usize)]) -> Option<DMatrix<f64>> {
        let at: Vec<usize> = parameters.iter().map(|&(c, k)| self.row(c, k)).collect::<Option<_>>()?;
        Some(DMatrix::from_fn(at.len(), at.len(), |i, j| self.matrix[(at[i], at[j])]))
    }

    /// The block of three parameters of a camera from one on; `None` where they were not solved for.
    pub fn block(&self, camera: usize, from: usize) -> Option<Matrix3<f64>> {
        let found = self.of(&[from, from + 1, from + 2].map(|k| (camera, k)))?;
        Some(Matrix3::from_fn(|i, j| found[(i, j)]))
    }

    /// The standard deviation of a parameter of a camera; 0 where it was not solved for.
    pub fn deviation(&self, camera: usize, parameter: usize) -> f64 {
        self.row(camera, parameter).map_or(0.0, |p| self.matrix[(p, p)].max(0.0).sqrt())
    }

    /// The row of a parameter of a camera; `None` where it was not solved for.
    pub fn row(&self, camera: usize, parameter: usize) -> Option<usize> {
        self.active.iter().position(|p| *p == (camera, parameter))
    }
}

/// Covariance of the active parameters, with outlines of each camera that may all be wrong alike by so many pixels; `None` where the
/// normal matrix is not usable.
pub fn covariance(problem: &JointProblem, cameras: &[Camera], outline_errors: &[f64]) -> Option<Covariance> {
    let active = problem.active();
    let linear = problem.linear(cameras, &active);
    let found = blocks(problem, cameras, &active);
    let inverse = Invertible::of(&linear.normal)?.inverse();
    let used = found.row_iter().filter(|r| r.norm_squared() > 0.0).count() as f64;
    let correction = used / (used - 1.0).max(1.0);
    let mut meat = found.tr_mul(&found) * correction;
    let places = places(problem, cameras, &active);
    meat += places.tr_mul(&places);
    let shared = shared_errors(problem, cameras, &active, outline_errors);
    meat += shared.tr_mul(&shared);
    for (i, (camera, k)) in active.iter().enumerate() {
        // What holds a direction that nothing determines scatters as a belief does: it is not known there.
        meat[(i, i)] += problem.prior_weight * HELD * linear.normal[(i, i)];
        let beliefs = &problem.beliefs[*camera];
        let deviation = match *k {
            k if k < INTRINSIC => beliefs.intrinsic[k].deviation,
            CLOCK => beliefs.clock[0].deviation,
            k if k == CLOCK + 1 => beliefs.clock[1].deviation,
            INSET => beliefs.insets.all.deviation,
            INSET_OF_SMALL => beliefs.insets.small.deviation,
            INSET_OF_SIDES.. => beliefs.insets.sides.deviation,
            _ => 0.0,
        };
        if deviation > 0.0 && deviation.is_finite() {
            // A belief is an observation of its own: its gradient scatters by its weight over its deviation.
            meat[(i, i)] += (problem.prior_weight / deviation).powi(2);
        }
    }
    let result = &inverse * meat * &inverse;
    let off = -(&inverse * linear.gradient);
    result.iter().chain(&off).all(|v| v.is_finite()).then_some(Covariance { active, matrix: result, off })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_problems_are_as_uncertain_as_each_and_as_they_are_apart() {
        let of = |variance: f64, off: f64| Covariance {
            active: vec![(0, 0)],
            matrix: DMatrix::from_element(1, 1, variance),
            off: DVector::from_element(1, off),
        };
        let both = Covariance::of_several(vec![(of(1.0, 0.0), 3.0), (of(4.0, 2.0), 1.0)]).unwrap();
        assert!((both.matrix[(0, 0)] - (0.75 + 0.25 * (4.0 + 4.0))).abs() < 1e-12, "{}", both.matrix);
        assert!((both.off[0] - 0.5).abs() < 1e-12);
        assert!(Covariance::of_several(vec![]).is_none());
    }

    #[test]
    fn what_follows_offsets_is_wrong_along_with_them() {
        let active = vec![(0, 7), (1, 7), (0, CLOCK), (1, CLOCK), (1, CLOCK + 1)];
        let scatter = Covariance { active, matrix: DMatrix::from_element(5, 5, 0.5), off: DVector::zeros(5) };
        // Each of the two follows its own offset, one twice as far and the other half as far the other way, whatever drifts say.
        let mut normal = DMatrix::from_diagonal(&DVector::from_column_slice(&[1.0, 2.0, 9.0, 9.0, 9.0]));
        for (i, j, value) in [(0, 2, -2.0), (1, 3, 1.0), (1, 4, 3.0), (3, 4, 8.0)] {
            (normal[(i, j)], normal[(j, i)]) = (value, value);
        }
        let left = [(9.0 - 4.0) / 9.0, (9.0 - 0.5) / 9.0];
        let wrong = |camera: usize, share: f64| {
            assert!((share - left[camera]).abs() < 1e-6, "{camera}: {share}");
            [3.0, 2.0][camera]
        };
        let more = scatter.clone().with_offsets_wrong(&normal, wrong).unwrap().matrix - &scatter.matrix;
        for (found, expected) in more.diagonal().iter().zip([36.0, 1.0, 9.0, 4.0, 0.0]) {
            assert!((found - expected).abs() < 1e-6, "{more}");
        }
        assert!((more[(0, 2)] - 18.0).abs() < 1e-6 && more[(0, 3)] == 0.0, "{more}");
        assert!(scatter.clone().with_offsets_wrong(&normal, |_, _| f64::NAN).is_none());
    }
}
