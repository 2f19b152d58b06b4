//! How far two tangents are from meeting, and how that changes with both cameras.
//!
//! With `Q = R_b [C_a − C_b]× R_aᵀ` the rays `x_a`, `x_b` of two pixels lie in one plane through both cameras where
//! `e = x_bᵀ Q x_a = 0`. The residual is the Sampson distance in the *raw* pixels of both images, `e / g` with `g` the norm of
//! the gradient of `e` to the four coordinates of the pixels, lens included: so no lens can make residuals small by making
//! the image small, and no length of the baseline enters. The derivatives are exact, those of `g` among them.

use nalgebra::{Matrix3, SVector, Vector2, Vector3};

use super::camera::{
    CLOCK, Camera, INSET, INSET_OF_SIDES, INSET_OF_SMALL, INTRINSIC, PARAMETERS, POSITION, ROTATION,
};
use super::changes::{Change, Changes, Parts};
use super::insets::shares;
use super::optics::Optics;

/// A tangent of A that meets one of B.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meeting {
    /// Pixel of A.
    pub a: [f64; 2],
    /// Pixel of B at `time_b`.
    pub b: [f64; 2],
    /// Away from the silhouette, across the tangent, in A; unit length.
    pub outward_a: [f64; 2],
    /// Away from the silhouette, across the tangent, in B; unit length.
    pub outward_b: [f64; 2],
    /// Smallness of the silhouettes of A and B, as of [`Insets`](super::insets::Insets).
    pub smallness: [f64; 2],
    /// How fast the pixel of B moves, pixels a second.
    pub velocity_b: [f64; 2],
    /// Seconds of A's clock.
    pub time_a: f64,
    /// Seconds of B's clock.
    pub time_b: f64,
    /// How much it counts.
    pub weight: f64,
}

/// Derivatives of a residual to the parameters of A and then those of B.
pub type PairGradient = SVector<f64, { 2 * PARAMETERS }>;

/// What two cameras have in common.
#[derive(Debug, Clone, Copy)]
pub struct CameraPair<'c> {
    a: &'c Camera,
    b: &'c Camera,
    optics_a: Optics,
    optics_b: Optics,
    q: Matrix3<f64>,
}

/// The pixels of a meeting with the clocks and the insets as they are, and the network's time.
struct MeetingPixels {
    a: [f64; 2],
    b: [f64; 2],
    time: f64,
}

impl<'c> CameraPair<'c> {
    /// Of two cameras at different places.
    pub fn new(a: &'c Camera, b: &'c Camera) -> Self {
        let baseline = a.position - b.position;
        let baseline = baseline / baseline.norm().max(1e-12);
        let q = b.rotation.matrix() * baseline.cross_matrix() * a.rotation.matrix().transpose();
        Self { a, b, optics_a: a.optics(), optics_b: b.optics(), q }
    }

    fn pixels(&self, m: &Meeting) -> MeetingPixels {
        let time = self.a.time_of(m.time_a);
        let late = self.b.clock_at(time) - m.time_b;
        let [inset_a, inset_b] =
            [self.a.insets.at(m.outward_a, m.smallness[0]), self.b.insets.at(m.outward_b, m.smallness[1])];
        MeetingPixels {
            a: [0, 1].map(|k| m.a[k] + inset_a * m.outward_a[k]),
            b: [0, 1].map(|k| m.b[k] + late * m.velocity_b[k] + inset_b * m.outward_b[k]),
            time,
        }
    }

    fn parts(&self, meeting: &Meeting) -> Option<Parts> {
        let pixels = self.pixels(meeting);
        Some(Parts::new(&self.q, &self.optics_a.look(pixels.a)?, &self.optics_b.look(pixels.b)?))
    }

    /// Pixels; `None` where a lens shows nothing.
    pub fn residual(&self, meeting: &Meeting) -> Option<f64> {
        self.parts(meeting).map(|p| p.residual)
    }

    /// The residual, and the share of A's pixels in the square of the gradient, and so in what it scatters by: of two cameras whose
    /// outlines are as good as each other's the one that sees less in a pixel has more of it.
    pub fn shared(&self, meeting: &Meeting) -> Option<(f64, f64)> {
        let share = |p: &Parts| p.gradient.fixed_rows::<2>(0).norm_squared() / p.norm.powi(2);
        self.parts(meeting).map(|p| (p.residual, share(&p)))
    }

    /// Residuals of those of some meetings that agree within so many pixels.
    fn near(&self, meetings: &[Meeting], within: f64) -> impl Iterator<Item = f64> {
        meetings.iter().filter_map(move |m| self.residual(m)).filter(move |r| r.abs() < within)
    }

    /// How well meetings agree within `ρ` pixels: the sum of `1 − r²/ρ²` of those that do.
    pub fn agreement(&self, meetings: &[Meeting], within: f64) -> f64 {
        self.near(meetings, within).fold(0.0, |sum, r| sum + 1.0 - (r / within).powi(2))
    }

    /// How many meetings agree within so many pixels.
    pub fn agreeing(&self, meetings: &[Meeting], within: f64) -> usize {
        self.near(meetings, within).count()
    }

    /// The residual with its derivatives.
    pub fn row(&self, meeting: &Meeting) -> Option<(f64, PairGradient)> {
        let pixels = self.pixels(meeting);
        let (sight_a, sight_b) = (self.optics_a.sight(pixels.a)?, self.optics_b.sight(pixels.b)?);
        let parts = Parts::new(&self.q, &sight_a.look, &sight_b.look);
        let changes = Changes::new([self.a, self.b], &self.q, &parts, [&sight_a, &sight_b]);
        let mut row = PairGradient::zeros();
        let mut put = |k: usize, change: Change| {
            row[k] =
                (change.e - parts.residual * parts.gradient.dot(&change.gradient) / parts.norm) / parts.norm;
        };
        for k in 0..INTRINSIC {
            put(k, changes.of_lens_a(k));
            put(PARAMETERS + k, changes.of_lens_b(k));
        }
        for k in 0..3 {
            let axis = Vector3::ith(k, 1.0);
            put(ROTATION + k, changes.of_turn_a(&axis));
            put(PARAMETERS + ROTATION + k, changes.of_turn_b(&axis));
            let of_position = changes.of_position_a(&axis);
            put(POSITION + k, of_position);
            put(PARAMETERS + POSITION + k, of_position.times(-1.0));
        }
        let outward = [meeting.outward_a, meeting.outward_b];
        let of_outward = [
            changes.of_pixel_a(&Vector2::from(meeting.outward_a)),
            changes.of_pixel_b(&Vector2::from(meeting.outward_b)),
        ];
        for (camera, of_outward) in of_outward.into_iter().enumerate() {
            let first = camera * PARAMETERS;
            put(first + INSET, of_outward);
            put(first + INSET_OF_SMALL, of_outward.times(meeting.smallness[camera]));
            for (k, share) in shares(outward[camera]).into_iter().enumerate() {
                put(first + INSET_OF_SIDES + k, of_outward.times(share));
            }
        }
        let velocity = Vector2::from(meeting.velocity_b);
        if velocity != Vector2::zeros() {
            let of_second = changes.of_pixel_b(&velocity);
            let (rate_a, rate_b) = (1.0 + 1e-6 * self.a.drift, 1.0 + 1e-6 * self.b.drift);
            put(CLOCK, of_second.times(-rate_b / rate_a));
            put(CLOCK + 1, of_second.times(-1e-6 * rate_b / rate_a * pixels.time));
            put(PARAMETERS + CLOCK, of_second);
            put(PARAMETERS + CLOCK + 1, of_second.times(1e-6 * pixels.time));
        }
        Some((parts.residual, row))
    }
}

#[cfg(test)]
mod tests {
    use super::super::camera::{CameraStep, tests::odd};
    use super::*;

    #[test]
    fn derivatives_equal_differences() {
        let (a, b) = (odd(0.4), odd(1.9));
        let meeting = Meeting {
            a: [500.0, 120.0],
            b: [100.0, 300.0],
            outward_a: [0.6, -0.8],
            outward_b: [0.28, 0.96],
            smallness: [0.4, -0.2],
            velocity_b: [40.0, -25.0],
            time_a: 3.0,
            time_b: 3.4,
            weight: 1.0,
        };
        let (_, row) = CameraPair::new(&a, &b).row(&meeting).unwrap();
        for k in 0..2 * PARAMETERS {
            let h = match k % PARAMETERS {
                2 | 3 | 14 | 15 => 1e-2,
                _ => 1e-6,
            };
            let at = |h: f64| {
                let mut step = CameraStep::zeros();
                step[k % PARAMETERS] = h;
                let moved = if k < PARAMETERS { (a.stepped(&step), b) } else { (a, b.stepped(&step)) };
                CameraPair::new(&moved.0, &moved.1).residual(&meeting).unwrap()
            };
            let difference = (at(h) - at(-h)) / (2.0 * h);
            assert!(
                (row[k] - difference).abs() < 1e-5 * (1.0 + difference.abs()),
                "{k}: {} {difference}",
                row[k]
            );
        }
        assert!(row.iter().filter(|v| **v != 0.0).count() >= 30);
    }

    #[test]
    fn the_pixels_of_one_point_meet() {
        let (a, b) = (odd(0.4), odd(1.0));
        let point =
            nalgebra::Vector3::new(0.1, -0.2, 0.3) + (a.ray([320.0, 240.0]).unwrap() * 3.0 + a.position);
        let (Some(in_a), Some(in_b)) = (a.project(&point), b.project(&point)) else { return };
        let meeting = Meeting {
            a: in_a,
            b: in_b,
            outward_a: [0.0; 2],
            outward_b: [0.0; 2],
            smallness: [0.0; 2],
            velocity_b: [0.0; 2],
            time_a: 0.0,
            time_b: 0.0,
            weight: 1.0,
        };
        assert!(CameraPair::new(&a, &b).residual(&meeting).unwrap().abs() < 1e-9);
    }
}
