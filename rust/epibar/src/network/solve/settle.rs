//! Tangents found anew under the network, and the joint problem over them, until nothing changes.
//!
//! Under a network every pair has a geometry, those that failed by themselves too, and what meets under it is better
//! than what any pair found alone. While the epipoles move a tangent slides along its silhouette, but along the tangent
//! itself, so that fixed points have the right derivative (envelope theorem).

use crate::geometry::median::deviation;
use crate::network::model::beliefs::Beliefs;
use crate::network::model::camera::Camera;
use crate::network::model::joint::{JointProblem, PairMeetings, standing, weight};
use crate::network::model::residual::CameraPair;
use crate::network::observations::survey::Survey;
use crate::network::thresholds as limits;

/// Radii, pixels of a 640×480 image, within which tangents meet: the first, and the least.
const WIDEST: f64 = 12.0;
const NARROWEST: f64 = 1.5;
/// A radius may be so much smaller than the one before.
const NARROWER: f64 = 0.7;
/// Radius in robust standard deviations of what meets.
const DEVIATIONS: f64 = 4.0;
/// Steps of the solver between two searches for tangents.
const STEPS: usize = 8;
/// A pair counts as so many times coarser than the network at the most: one that shows nothing in common scatters by three
/// quarters of any radius.
const COARSEST: f64 = 3.0;
/// Rounds at the most.
const ROUNDS: usize = 40;
/// Nothing changes where no pixel moves by more than this, pixels, and the radius by less than to this share.
const STILL: (f64, f64) = (0.002, 0.97);
/// Steps go on in one direction from this cosine of what they do to the residuals on, and shrink to no more than this share.
const ONWARD: f64 = 0.5;
const MOST_OF_STEP: f64 = 0.85;
/// Tangents of neighbouring frames and of one outline say the same: so many count as one measurement.
const DEPENDENT: f64 = 30.0;
/// Scatter that is not believed to be smaller, pixels.
const LEAST_SCATTER: f64 = 0.1;

/// From which radius to begin once more, the wider the more may change: so many times the one within which tangents met, and at the most
/// so many pixels of a 640×480 image.
#[derive(Debug, Clone, Copy)]
pub struct Again(f64, f64);

impl Again {
    /// Without some of the moments.
    pub const FEWER_MOMENTS: Self = Self(2.0, 8.0);
    /// With other principal points.
    pub const PRINCIPAL_POINTS: Self = Self(3.0, 8.0);
    /// Without a camera that was wrong.
    pub const FEWER_CAMERAS: Self = Self(4.0, 12.0);
    /// On more frames.
    pub const MORE_FRAMES: Self = Self(1.2, f64::INFINITY);

    /// The radius, after the one of a network that was settled.
    pub fn after(self, settled: &Settled) -> f64 {
        (self.0 * settled.radius).min(self.1)
    }
}

/// A network after its tangents were found anew.
#[derive(Debug, Clone)]
pub struct Settled {
    /// The cameras.
    pub cameras: Vec<Camera>,
    /// What met in the last round.
    pub pairs: Vec<PairMeetings>,
    /// Within what radius, pixels of a 640×480 image.
    pub radius: f64,
    /// Scale of the Cauchy loss: the robust standard deviation of what meets, pixels.
    pub scale: f64,
    /// What a standard deviation of a prior was worth.
    pub prior_weight: f64,
}

impl Settled {
    /// What met in confirmed pairs of cameras that stand.
    pub fn of_confirmed<'s>(
        &'s self,
        placed: &'s [bool],
        confirmed: &'s [(usize, usize)],
    ) -> impl Iterator<Item = &'s PairMeetings> {
        self.pairs.iter().filter(|p| placed[p.a] && placed[p.b] && confirmed.contains(&(p.a, p.b)))
    }

    /// These tangents under other cameras, and what they scatter there.
    pub fn under(&self, cameras: &[Camera]) -> Self {
        let scale = scatter(cameras, &self.pairs).max(LEAST_SCATTER);
        Self { cameras: cameras.to_vec(), pairs: self.pairs.clone(), scale, ..*self }
    }
}

/// Finds tangents anew and solves for the cameras that move, from a radius down to the one that suits the masks.
pub fn settle(
    survey: &Survey,
    cameras: &[Camera],
    beliefs: &[Beliefs],
    pairs: &[(usize, usize)],
    moving: &[bool],
    from: Option<f64>,
) -> Settled {
    let mut radius = from.unwrap_or(WIDEST);
    let mut at = cameras.to_vec();
    // All that is compared moves, so that size and place of the whole are free.
    let free = |c: usize| moving[c] && !beliefs[c].posed;
    let whole = pairs.iter().all(|&(a, b)| free(a) && free(b));
    let mut found = Vec::new();
    let mut coarseness = vec![1.0; pairs.len()];
    let (mut scale, mut prior_weight) = (radius, 1.0);
    let mut before: Option<Vec<Camera>> = None;
    for _ in 0..ROUNDS {
        found = survey.meetings(&at, pairs, &coarseness, radius, limits::LEAST_MEETINGS);
        let scatter = scatter(&at, &found);
        if scatter.is_nan() {
            break;
        }
        let suits =
            (DEVIATIONS * scatter_of(&at, &found, |p| survey.scale(p.a, p.b))).clamp(NARROWEST, radius);
        scale = scatter.max(LEAST_SCATTER);
        for p in &mut found {
            p.coarseness = coarseness_of(&at, p, scale);
        }
        // Those of a pair that is missing begin anew; what is there stands in the order of `pairs`.
        let mut there = found.iter().peekable();
        for (pair, coarseness) in pairs.iter().zip(&mut coarseness) {
            *coarseness = there.next_if(|p| (p.a, p.b) == *pair).map_or(1.0, |p| p.coarseness);
        }
        prior_weight = weight_of_prior(&at, &found, scale);
        let problem = JointProblem { pairs: &found, beliefs, scale, prior_weight, moving: moving.to_vec() };
        let solved = problem.solve(&at, STEPS).0;
        let solved = if whole { standing(&solved, moving) } else { solved };
        let moved = shift(&at, &solved, &found);
        let next = suits.max(NARROWER * radius);
        let prolonged = before.take().and_then(|before| prolonged(&before, &at, &solved, &found));
        if prolonged.is_none() && next > STILL.1 * radius {
            before = Some(at);
        }
        at = prolonged.unwrap_or(solved);
        if moved < STILL.0 && next > STILL.1 * radius {
            break;
        }
        radius = next;
    }
    Settled { cameras: at, pairs: found, radius, scale, prior_weight }
}

/// By how many times what met in a pair scatters more than `scale`.
fn coarseness_of(cameras: &[Camera], p: &PairMeetings, scale: f64) -> f64 {
    let pair = CameraPair::new(&cameras[p.a], &cameras[p.b]);
    let own = deviation(p.meetings.iter().filter_map(|m| pair.residual(m)));
    own.map_or(1.0, |own| (own / scale).clamp(1.0, COARSEST))
}

/// What a standard deviation of a prior is worth, in the unit of the cost of the tangents: so much as [`DEPENDENT`] of
/// them, by the variance of a robust estimate, `E ψ² / E w` with `ψ` the influence and `w` the weight of a residual.
fn weight_of_prior(cameras: &[Camera], pairs: &[PairMeetings], scale: f64) -> f64 {
    let (mut influence, mut sum, mut surprise, mut count) = (0.0, 0.0, 0.0, 0.0);
    for p in pairs {
        let pair = CameraPair::new(&cameras[p.a], &cameras[p.b]);
        for m in &p.meetings {
            let Some(r) = pair.residual(m) else { continue };
            let w = weight(r, scale, p.coarseness);
            influence += (w * r).powi(2);
            sum += w;
            surprise += m.weight;
            count += 1.0;
        }
    }
    DEPENDENT * surprise / f64::max(count, 1.0) * (influence / f64::max(sum, 1e-9)).max(LEAST_SCATTER.powi(2))
}

/// Robust standard deviation of all residuals, pixels; NaN of none.
fn scatter(cameras: &[Camera], pairs: &[PairMeetings]) -> f64 {
    scatter_of(cameras, pairs, |_| 1.0)
}

/// Robust standard deviation of all residuals, those of each pair in so many pixels as a unit; NaN of none.
fn scatter_of(cameras: &[Camera], pairs: &[PairMeetings], unit: impl Fn(&PairMeetings) -> f64) -> f64 {
    let residuals = pairs.iter().flat_map(|p| {
        let (pair, unit) = (CameraPair::new(&cameras[p.a], &cameras[p.b]), unit(p));
        p.meetings.iter().filter_map(move |m| Some(pair.residual(m)? / unit))
    });
    deviation(residuals).unwrap_or(f64::NAN)
}

/// Where steps lead that go on in one direction, each by a share of the one before: what meets is found by where the cameras
/// stand, and holds them there, so that what the tangents hardly know comes slowly. `None` where they do not go on.
fn prolonged(
    before: &[Camera],
    at: &[Camera],
    after: &[Camera],
    pairs: &[PairMeetings],
) -> Option<Vec<Camera>> {
    let (mut first, mut second, mut both) = (0.0, 0.0, 0.0);
    for p in pairs {
        let [r, s, t] = [before, at, after].map(|of| CameraPair::new(&of[p.a], &of[p.b]));
        let step = p.meetings.len().div_ceil(200).max(1);
        for m in p.meetings.iter().step_by(step) {
            if let (Some(r), Some(s), Some(t)) = (r.residual(m), s.residual(m), t.residual(m)) {
                first += (s - r).powi(2);
                second += (t - s).powi(2);
                both += (s - r) * (t - s);
            }
        }
    }
    if both.is_nan() || both <= ONWARD * (first * second).sqrt() {
        return None;
    }
    let share = (both / first).min(MOST_OF_STEP);
    let on = share / (1.0 - share);
    Some(at.iter().zip(after).map(|(at, after)| after.stepped(&(after.step_from(at) * on))).collect())
}

/// By how much residuals change between two networks, root mean square, pixels.
fn shift(before: &[Camera], after: &[Camera], pairs: &[PairMeetings]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for p in pairs {
        let (one, other) =
            (CameraPair::new(&before[p.a], &before[p.b]), CameraPair::new(&after[p.a], &after[p.b]));
        let step = p.meetings.len().div_ceil(200).max(1);
        for m in p.meetings.iter().step_by(step) {
            if let (Some(r), Some(s)) = (one.residual(m), other.residual(m)) {
                sum += (r - s).powi(2);
                count += 1.0;
            }
        }
    }
    (sum / f64::max(count, 1.0)).sqrt()
}

#[cfg(test)]
pub(in crate::network) mod tests {
    use nalgebra::{Matrix3, Rotation3, Vector3};
    use rand::RngExt;

    use super::*;
    use crate::image::ImageSize;
    use crate::network::model::residual::Meeting;
    use crate::random::generator;

    /// On a circle about the origin, looking at it.
    pub fn around(angle: f64, focal: f64) -> Camera {
        let position = Vector3::new(6.0 * angle.cos(), 6.0 * angle.sin(), 2.5);
        let forward = -position.normalize();
        let right = forward.cross(&Vector3::z()).normalize();
        let rows =
            Matrix3::from_rows(&[right.transpose(), forward.cross(&right).transpose(), forward.transpose()]);
        Camera {
            rotation: Rotation3::from_matrix_unchecked(rows),
            position,
            ..Camera::new(ImageSize::new(640, 480).unwrap(), focal)
        }
    }

    /// Points seen by every two of four cameras, with outlines of each camera wrong by so many pixels.
    pub fn seen(scatter: [f64; 4]) -> Settled {
        let cameras: Vec<Camera> =
            [(0.3, 500.0), (1.6, 480.0), (2.9, 300.0), (4.4, 520.0)].map(|(a, f)| around(a, f)).into();
        let mut random = generator(7, 0);
        let mut uniform = move || random.random::<f64>() - 0.5;
        let mut pairs = Vec::new();
        for (a, b) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            let meetings = (0..400).filter_map(|_| {
                let point = Vector3::from_fn(|_, _| 2.0 * uniform());
                // A sum of uniform numbers is as good as normal: its variance is 1.
                let mut wrong = |c: usize| {
                    let [x, y] = cameras[c].project(&point)?;
                    let mut by = || scatter[c] * (0..12).map(|_| uniform()).sum::<f64>();
                    Some([x + by(), y + by()])
                };
                let (in_a, in_b) = (wrong(a)?, wrong(b)?);
                Some(Meeting {
                    a: in_a,
                    b: in_b,
                    outward_a: [0.0, -1.0],
                    outward_b: [0.0, -1.0],
                    smallness: [0.0; 2],
                    velocity_b: [0.0; 2],
                    time_a: 0.0,
                    time_b: 0.0,
                    weight: 1.0,
                })
            });
            pairs.push(PairMeetings { a, b, meetings: meetings.collect(), coarseness: 1.0 });
        }
        Settled { cameras, pairs, radius: 4.0, scale: 0.5, prior_weight: 1.0 }
    }

    #[test]
    fn pairs_of_a_ragged_camera_are_coarse() {
        let even = seen([0.4; 4]);
        let ragged = seen([0.4, 0.4, 1.0, 0.4]);
        for (network, of_camera) in [(&even, 1.0..1.3), (&ragged, 1.5..2.6)] {
            for p in &network.pairs {
                let found = coarseness_of(&network.cameras, p, 0.4);
                let expected = if p.a == 2 || p.b == 2 { &of_camera } else { &(1.0..1.3) };
                assert!(expected.contains(&found), "{} {}: {found}", p.a, p.b);
            }
        }
        let hopeless = seen([30.0; 4]);
        let of = |p| coarseness_of(&hopeless.cameras, p, 0.4);
        assert!(hopeless.pairs.iter().all(|p| of(p) == COARSEST));
    }

    #[test]
    fn steps_that_go_on_are_prolonged_to_where_they_lead() {
        let network = seen([0.4; 4]);
        // All focal lengths together, each step a share of the one before.
        let at = |share: f64| -> Vec<Camera> {
            let camera = |c: &Camera| Camera { log_focal: c.log_focal + 1e-3 * share, ..*c };
            network.cameras.iter().map(camera).collect()
        };
        let led = prolonged(&at(0.0), &at(0.5), &at(0.75), &network.pairs).unwrap();
        for (led, end) in led.iter().zip(at(1.0)) {
            assert!((led.log_focal - end.log_focal).abs() < 1e-5, "{led:?} {end:?}");
        }
        // Steps that grow go no farther than a bound, and steps back and forth not at all.
        let led = prolonged(&at(0.0), &at(0.1), &at(0.3), &network.pairs).unwrap();
        let most = 0.3 + 0.2 * MOST_OF_STEP / (1.0 - MOST_OF_STEP);
        assert!((led[0].log_focal - at(most)[0].log_focal).abs() < 1e-9);
        assert_eq!(prolonged(&at(0.0), &at(0.5), &at(0.1), &network.pairs), None);
        assert_eq!(prolonged(&at(0.0), &at(0.0), &at(0.0), &network.pairs), None);
    }

    #[test]
    fn a_coarse_pair_pulls_less() {
        let problem =
            JointProblem { pairs: &[], beliefs: &[], scale: 0.5, prior_weight: 1.0, moving: vec![] };
        let of = |residual, coarseness| problem.loss(Some(residual), coarseness);
        for (residual, coarseness) in [(0.2, 1.0), (0.2, 1.7), (2.0, 3.0), (-1.0, 1.2)] {
            let slope = (of(residual + 1e-6, coarseness).0 - of(residual - 1e-6, coarseness).0) / 2e-6;
            assert!((of(residual, coarseness).1 * residual - slope).abs() < 1e-6, "{residual} {coarseness}");
        }
        // As a measurement of that variance: a small residual counts by its inverse.
        assert!((of(1e-4, 1.0).1 / of(1e-4, 3.0).1 - 9.0).abs() < 1e-3);
    }
}
