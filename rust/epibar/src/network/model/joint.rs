//! The joint problem: all cameras at once, from the tangents of all pairs.
//!
//! A frontier point belongs to one pair, so there are no points to carry along: unknowns are the cameras alone, a dozen
//! numbers each, and residuals those of [`super::residual`]. Levenberg–Marquardt over the dense normal equations, with a
//! Cauchy loss and what is known of each camera before as a prior. Where the whole stands in the world, and how large it
//! is, nothing says; damping holds what nothing determines where it is.

use nalgebra::{DMatrix, DVector, SMatrix, Vector3};
use rayon::prelude::*;

use super::beliefs::Beliefs;
use super::camera::{
    CLOCK, Camera, CameraStep, INSET, INSET_OF_SIDES, INSET_OF_SMALL, INTRINSIC, PARAMETERS,
};
use super::insets::SIDES;
use super::residual::{CameraPair, Meeting, PairGradient};
use crate::geometry::median::median;

/// `k₂ / k₁²` and `k₃ / k₁³` of real wide lenses: 1.4 to 1.7 and 1.4 to 1.8 of three in one recording, 2 and 5 of the
/// division model, 0 of a `k₁` by itself.
const BEND: f64 = 1.2;

/// Tangents of one pair of cameras.
#[derive(Debug, Clone)]
pub struct PairMeetings {
    /// Index of camera A.
    pub a: usize,
    /// Index of camera B.
    pub b: usize,
    /// What met.
    pub meetings: Vec<Meeting>,
    /// By how many times they scatter more than those of the network; 1 where they do not.
    pub coarseness: f64,
}

impl PairMeetings {
    /// The median angle between the rays of what met, radians; `None` of nothing.
    pub fn median_angle(&self, cameras: &[Camera]) -> Option<f64> {
        let (a, b) = (&cameras[self.a], &cameras[self.b]);
        median(self.meetings.iter().filter_map(|m| Some(a.ray(m.a)?.angle(&b.ray(m.b)?))))
    }
}

/// All that is minimised over the cameras.
#[derive(Debug, Clone)]
pub struct JointProblem<'p> {
    /// Tangents, pair by pair.
    pub pairs: &'p [PairMeetings],
    /// What is known before, camera by camera.
    pub beliefs: &'p [Beliefs],
    /// Scale of the Cauchy loss, pixels.
    pub scale: f64,
    /// What a standard deviation of a prior is worth, in the unit of the tangents' cost.
    pub prior_weight: f64,
    /// Cameras that are solved for; the others stay as they are.
    pub moving: Vec<bool>,
}

/// Cost, normal matrix and gradient.
pub struct Linear {
    /// Robust cost.
    pub cost: f64,
    /// `JᵀWJ`.
    pub normal: DMatrix<f64>,
    /// `JᵀWr`.
    pub gradient: DVector<f64>,
}

type Local = SMatrix<f64, { 2 * PARAMETERS }, { 2 * PARAMETERS }>;

/// What a residual costs where a lens shows nothing: as much as one of so many scales.
const LOST: f64 = 10.0;

impl JointProblem<'_> {
    /// Which parameters are solved for, as (camera, parameter).
    pub fn active(&self) -> Vec<(usize, usize)> {
        let mut active = Vec::new();
        for (camera, beliefs) in self.beliefs.iter().enumerate() {
            if !self.moving[camera] {
                continue;
            }
            for (k, belief) in beliefs.intrinsic.iter().enumerate() {
                if belief.deviation > 0.0 {
                    active.push((camera, k));
                }
            }
            if !beliefs.posed {
                active.extend((INTRINSIC..CLOCK).map(|k| (camera, k)));
            }
            if beliefs.insets.all.deviation > 0.0 {
                active.push((camera, INSET));
            }
            if beliefs.insets.small.deviation > 0.0 {
                active.push((camera, INSET_OF_SMALL));
            }
            if beliefs.insets.sides.deviation > 0.0 {
                active.extend((INSET_OF_SIDES..INSET_OF_SIDES + SIDES).map(|k| (camera, k)));
            }
            for (k, belief) in beliefs.clock.iter().enumerate() {
                if belief.deviation > 0.0 {
                    active.push((camera, CLOCK + k));
                }
            }
        }
        active
    }

    /// Robust cost alone.
    pub fn cost(&self, cameras: &[Camera]) -> f64 {
        let of_pairs: Vec<f64> = self
            .pairs
            .par_iter()
            .map(|pair| {
                let geometry = CameraPair::new(&cameras[pair.a], &cameras[pair.b]);
                pair.meetings
                    .iter()
                    .map(|m| m.weight * self.loss(geometry.residual(m), pair.coarseness).0)
                    .sum()
            })
            .collect();
        let prior: f64 = self.prior(cameras).iter().map(|p| 0.5 * p.weight * p.value * p.value).sum();
        of_pairs.iter().sum::<f64>() + prior
    }

    /// Cauchy loss `½ s² ln(1 + r²/(c s)²)` and its [`weight`], with `c` the coarseness of the pair.
    pub fn loss(&self, residual: Option<f64>, coarseness: f64) -> (f64, f64) {
        let scale = coarseness * self.scale;
        let residual = residual.unwrap_or(LOST * scale);
        let q = 1.0 + (residual / scale).powi(2);
        (0.5 * self.scale * self.scale * q.ln(), weight(residual, self.scale, coarseness))
    }

    /// Linearised about some cameras, over the active parameters.
    pub fn linear(&self, cameras: &[Camera], active: &[(usize, usize)]) -> Linear {
        let column = columns(cameras.len(), active);
        let of_pairs: Vec<(f64, Local, PairGradient)> =
            self.pairs.par_iter().map(|pair| self.of_pair(pair, cameras, &column)).collect();
        let n = active.len();
        let mut sum = Linear { cost: 0.0, normal: DMatrix::zeros(n, n), gradient: DVector::zeros(n) };
        for (pair, (cost, normal, gradient)) in self.pairs.iter().zip(&of_pairs) {
            sum.cost += cost;
            let places = columns_of_pair(pair, &column);
            let solved_for = || places.iter().enumerate().filter_map(|(i, p)| Some((i, (*p)?)));
            for (i, p) in solved_for() {
                sum.gradient[p] += gradient[i];
                for (j, q) in solved_for() {
                    sum.normal[(p, q)] += normal[(i.max(j), i.min(j))];
                }
            }
        }
        for prior in self.prior(cameras) {
            sum.cost += 0.5 * prior.weight * prior.value * prior.value;
            for (p, along) in prior.along(&column) {
                sum.gradient[p] += prior.weight * prior.value * along;
                for (q, other) in prior.along(&column) {
                    sum.normal[(p, q)] += prior.weight * along * other;
                }
            }
        }
        sum
    }

    fn of_pair(
        &self,
        pair: &PairMeetings,
        cameras: &[Camera],
        column: &[Option<usize>],
    ) -> (f64, Local, PairGradient) {
        let geometry = CameraPair::new(&cameras[pair.a], &cameras[pair.b]);
        let places = columns_of_pair(pair, column);
        let used: Vec<usize> = (0..2 * PARAMETERS).filter(|&i| places[i].is_some()).collect();
        let (mut cost, mut normal, mut gradient) = (0.0, Local::zeros(), PairGradient::zeros());
        // Of those that are used, one after the other.
        let mut sums = [[0.0; 2 * PARAMETERS]; 2 * PARAMETERS];
        let (mut own, mut weighed) = ([0.0; 2 * PARAMETERS], [0.0; 2 * PARAMETERS]);
        for meeting in &pair.meetings {
            let Some((residual, row)) = geometry.row(meeting) else {
                cost += meeting.weight * self.loss(None, pair.coarseness).0;
                continue;
            };
            let (loss, weight) = self.loss(Some(residual), pair.coarseness);
            cost += meeting.weight * loss;
            let weight = meeting.weight * weight;
            for (k, &i) in used.iter().enumerate() {
                own[k] = row[i];
                weighed[k] = weight * row[i];
                gradient[i] += weighed[k] * residual;
            }
            for (k, by) in own[..used.len()].iter().enumerate() {
                for (sum, weighed) in sums[k][k..used.len()].iter_mut().zip(&weighed[k..]) {
                    *sum += weighed * by;
                }
            }
        }
        for (k, &j) in used.iter().enumerate() {
            for (l, &i) in used.iter().enumerate().skip(k) {
                normal[(i, j)] = sums[k][l];
            }
        }
        (cost, normal, gradient)
    }

    /// Residuals of what is known before of the cameras that are solved for, in standard deviations.
    fn prior(&self, cameras: &[Camera]) -> Vec<Prior> {
        let mut all = Vec::new();
        for (camera, (c, beliefs)) in cameras.iter().zip(self.beliefs).enumerate() {
            if !self.moving[camera] {
                continue;
            }
            let [k1, ..] = c.lens.k;
            for (k, (value, belief)) in c.intrinsic().into_iter().zip(&beliefs.intrinsic).enumerate() {
                if belief.deviation > 0.0 && belief.deviation.is_finite() {
                    // How a lens of one family goes with k₁.
                    let (family, slope) = match k {
                        5 => (BEND * k1 * k1, 2.0 * BEND * k1),
                        6 => (BEND * k1.powi(3), 3.0 * BEND * k1 * k1),
                        _ => (0.0, 0.0),
                    };
                    all.push(Prior {
                        value: (value - belief.mean - family) / belief.deviation,
                        weight: self.prior_weight,
                        at: [
                            (camera * PARAMETERS + k, 1.0 / belief.deviation),
                            (camera * PARAMETERS + 4, -slope / belief.deviation),
                        ],
                    });
                }
            }
            let others = [
                (CLOCK, c.offset, beliefs.clock[0]),
                (CLOCK + 1, c.drift, beliefs.clock[1]),
                (INSET, c.insets.all, beliefs.insets.all),
                (INSET_OF_SMALL, c.insets.small, beliefs.insets.small),
            ];
            let of_sides = c.insets.sides.into_iter().zip(INSET_OF_SIDES..);
            let of_sides = of_sides.map(|(value, k)| (k, value, beliefs.insets.sides));
            for (k, value, belief) in others.into_iter().chain(of_sides) {
                if belief.deviation > 0.0 && belief.deviation.is_finite() {
                    let along = 1.0 / belief.deviation;
                    all.push(Prior {
                        value: (value - belief.mean) * along,
                        weight: self.prior_weight,
                        at: [(camera * PARAMETERS + k, along), (camera * PARAMETERS + k, 0.0)],
                    });
                }
            }
        }
        all
    }

    /// Levenberg–Marquardt; ends after so many steps, or where the cost no longer falls.
    pub fn solve(&self, start: &[Camera], steps: usize) -> (Vec<Camera>, f64) {
        let active = self.active();
        let mut at = start.to_vec();
        let mut now = self.linear(&at, &active);
        let mut damping = 1e-4;
        for _ in 0..steps {
            let Some(step) = damped_step(&now, damping) else {
                damping *= 10.0;
                if damping > 1e10 {
                    break;
                }
                continue;
            };
            let tried = stepped(&at, &active, &step);
            let cost = self.cost(&tried);
            if cost < now.cost {
                let gain = (now.cost - cost) / now.cost.max(f64::MIN_POSITIVE);
                at = tried;
                damping = (damping * 0.3_f64).max(1e-9);
                if gain < 1e-7 {
                    return (at, cost);
                }
                now = self.linear(&at, &active);
            } else {
                damping *= 8.0;
                if damping > 1e8 {
                    break;
                }
            }
        }
        (at, now.cost)
    }
}

/// Weight of a residual under the Cauchy loss, `1 / (c² + r²/s²)`, with `c` the coarseness of its pair.
pub fn weight(residual: f64, scale: f64, coarseness: f64) -> f64 {
    1.0 / (coarseness * coarseness + (residual / scale).powi(2))
}

/// A residual of what is known before: its value, what it counts, and its derivatives.
struct Prior {
    value: f64,
    weight: f64,
    at: [(usize, f64); 2],
}

impl Prior {
    fn along<'c>(&'c self, column: &'c [Option<usize>]) -> impl Iterator<Item = (usize, f64)> + 'c {
        let known = self.at.iter().filter(|(_, along)| *along != 0.0);
        known.filter_map(|(at, along)| Some((column[*at]?, *along)))
    }
}

/// The column of each parameter of so many cameras, one camera after the other; `None` of those that are not solved for.
pub fn columns(cameras: usize, active: &[(usize, usize)]) -> Vec<Option<usize>> {
    let mut column = vec![None; cameras * PARAMETERS];
    for (i, (camera, k)) in active.iter().enumerate() {
        column[camera * PARAMETERS + k] = Some(i);
    }
    column
}

/// Columns of the parameters of both cameras.
pub fn columns_of_pair(pair: &PairMeetings, column: &[Option<usize>]) -> [Option<usize>; 2 * PARAMETERS] {
    std::array::from_fn(|i| {
        let camera = if i < PARAMETERS { pair.a } else { pair.b };
        column[camera * PARAMETERS + i % PARAMETERS]
    })
}

fn damped_step(now: &Linear, damping: f64) -> Option<DVector<f64>> {
    let mut damped = now.normal.clone();
    let least = 1e-9 * (0..damped.nrows()).map(|k| now.normal[(k, k)]).fold(0.0, f64::max) + 1e-12;
    for k in 0..damped.nrows() {
        damped[(k, k)] += damping * (now.normal[(k, k)] + least);
    }
    let step = damped.cholesky()?.solve(&-&now.gradient);
    step.iter().all(|v| v.is_finite()).then_some(step)
}

/// The cameras after a step in the active parameters.
pub fn stepped(cameras: &[Camera], active: &[(usize, usize)], step: &DVector<f64>) -> Vec<Camera> {
    let mut steps = vec![CameraStep::zeros(); cameras.len()];
    for ((camera, k), value) in active.iter().zip(step.iter()) {
        steps[*camera][*k] = *value;
    }
    cameras.iter().zip(&steps).map(|(camera, step)| camera.stepped(step)).collect()
}

/// A network about the mean of those of its cameras that stand, the root of the mean square of their distances from it
/// being 1; the others stay as they are.
pub fn standing(cameras: &[Camera], placed: &[bool]) -> Vec<Camera> {
    let stand =
        || cameras.iter().zip(placed).filter(|(_, placed)| **placed).map(|(camera, _)| camera.position);
    let n = stand().count() as f64;
    let mean = stand().sum::<Vector3<f64>>() / n;
    let size = (stand().map(|p| (p - mean).norm_squared()).sum::<f64>() / n).sqrt();
    let size = if size > 0.0 && size.is_finite() { size } else { 1.0 };
    let normalised = |c: &Camera| Camera { position: (c.position - mean) / size, ..*c };
    cameras.iter().zip(placed).map(|(c, placed)| if *placed { normalised(c) } else { *c }).collect()
}
