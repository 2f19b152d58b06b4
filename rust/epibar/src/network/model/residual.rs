//! How far two tangents are from meeting, and how that changes with both cameras.
//!
//! With `Q = R_b [C_a − C_b]× R_aᵀ` the rays `x_a`, `x_b` of two pixels lie in one plane through both cameras where
//! `e = x_bᵀ Q x_a = 0`. The residual is the Sampson distance in the *raw* pixels of both images, `e / g` with `g` the norm of
//! the gradient of `e` to the four coordinates of the pixels, lens included: so no lens can make residuals small by making
//! the image small, and no length of the baseline enters. The derivatives are exact, those of `g` among them.

use nalgebra::{Matrix3, SVector, Vector2, Vector3, Vector4};

use super::camera::{CLOCK, Camera, INSET, INTRINSIC, PARAMETERS, POSITION, ROTATION};
use super::optics::{Look, Optics, Sight};

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
pub type Row = SVector<f64, { 2 * PARAMETERS }>;

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
struct Pixels {
    a: [f64; 2],
    b: [f64; 2],
    time: f64,
}

struct Parts {
    ray_a: Vector3<f64>,
    ray_b: Vector3<f64>,
    /// `Qᵀ x_b` and `Q x_a`.
    normal_a: Vector3<f64>,
    normal_b: Vector3<f64>,
    gradient: Vector4<f64>,
    norm: f64,
    residual: f64,
}

fn head(v: &Vector3<f64>) -> Vector2<f64> {
    Vector2::new(v.x, v.y)
}

fn flat(v: &Vector2<f64>) -> Vector3<f64> {
    Vector3::new(v.x, v.y, 0.0)
}

fn both(a: Vector2<f64>, b: Vector2<f64>) -> Vector4<f64> {
    Vector4::new(a.x, a.y, b.x, b.y)
}

impl<'c> CameraPair<'c> {
    /// Of two cameras at different places.
    pub fn new(a: &'c Camera, b: &'c Camera) -> Self {
        let baseline = a.position - b.position;
        let baseline = baseline / baseline.norm().max(1e-12);
        let q = b.rotation.matrix() * baseline.cross_matrix() * a.rotation.matrix().transpose();
        Self { a, b, optics_a: a.optics(), optics_b: b.optics(), q }
    }

    fn pixels(&self, m: &Meeting) -> Pixels {
        let time = self.a.time_of(m.time_a);
        let late = self.b.clock_at(time) - m.time_b;
        Pixels {
            a: [0, 1].map(|k| m.a[k] + self.a.inset * m.outward_a[k]),
            b: [0, 1].map(|k| m.b[k] + late * m.velocity_b[k] + self.b.inset * m.outward_b[k]),
            time,
        }
    }

    fn parts(&self, meeting: &Meeting) -> Option<Parts> {
        let pixels = self.pixels(meeting);
        Some(self.parts_of(&self.optics_a.look(pixels.a)?, &self.optics_b.look(pixels.b)?))
    }

    fn parts_of(&self, look_a: &Look, look_b: &Look) -> Parts {
        let (ray_a, ray_b) = (look_a.direction.push(1.0), look_b.direction.push(1.0));
        let (normal_b, normal_a) = (self.q * ray_a, self.q.tr_mul(&ray_b));
        let gradient =
            both(look_a.jacobian.tr_mul(&head(&normal_a)), look_b.jacobian.tr_mul(&head(&normal_b)));
        let norm = gradient.norm().max(1e-150);
        let residual = ray_b.dot(&normal_b) / norm;
        Parts { ray_a, ray_b, normal_a, normal_b, gradient, norm, residual }
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
    pub fn row(&self, meeting: &Meeting) -> Option<(f64, Row)> {
        let pixels = self.pixels(meeting);
        let (sight_a, sight_b) = (self.optics_a.sight(pixels.a)?, self.optics_b.sight(pixels.b)?);
        let p = self.parts_of(&sight_a.look, &sight_b.look);
        let (q, jacobian_a, jacobian_b) = (&self.q, sight_a.look.jacobian, sight_b.look.jacobian);
        let mut row = Row::zeros();
        let mut put = |k: usize, de: f64, dg: Vector4<f64>| {
            row[k] = (de - p.residual * p.gradient.dot(&dg) / p.norm) / p.norm;
        };
        for k in 0..INTRINSIC {
            let (dx, dj) = (sight_a.along[k], sight_a.jacobian_along[k]);
            let of_b = jacobian_b.tr_mul(&head(&(q * flat(&dx))));
            put(k, head(&p.normal_a).dot(&dx), both(dj.tr_mul(&head(&p.normal_a)), of_b));
            let (dx, dj) = (sight_b.along[k], sight_b.jacobian_along[k]);
            let of_a = jacobian_a.tr_mul(&head(&q.tr_mul(&flat(&dx))));
            put(PARAMETERS + k, head(&p.normal_b).dot(&dx), both(of_a, dj.tr_mul(&head(&p.normal_b))));
        }
        let world_a = self.a.rotation.inverse() * p.ray_a;
        let world_b = self.b.rotation.inverse() * p.ray_b;
        let across = world_a.cross(&world_b);
        // The baseline is taken with unit length: a change of its length says nothing.
        let baseline = self.a.position - self.b.position;
        let length = baseline.norm().max(1e-12);
        let unit = baseline / length;
        for k in 0..3 {
            let turn = Vector3::ith(k, 1.0);
            let (moved_a, moved_b) = (p.ray_a.cross(&turn), p.ray_b.cross(&turn));
            put(
                ROTATION + k,
                p.normal_a.dot(&moved_a),
                both(
                    jacobian_a.tr_mul(&head(&turn.cross(&p.normal_a))),
                    jacobian_b.tr_mul(&head(&(q * moved_a))),
                ),
            );
            put(
                PARAMETERS + ROTATION + k,
                p.normal_b.dot(&moved_b),
                both(
                    jacobian_a.tr_mul(&head(&q.tr_mul(&moved_b))),
                    jacobian_b.tr_mul(&head(&turn.cross(&p.normal_b))),
                ),
            );
            let step = (turn - unit * unit.dot(&turn)) / length;
            let de = step.dot(&across);
            let dg = both(
                jacobian_a.tr_mul(&head(&(self.a.rotation * world_b.cross(&step)))),
                jacobian_b.tr_mul(&head(&(self.b.rotation * step.cross(&world_a)))),
            );
            put(POSITION + k, de, dg);
            put(PARAMETERS + POSITION + k, -de, -dg);
        }
        // A pixel further right is a principal point further left.
        let bent = |sight: &Sight, step: &Vector2<f64>| {
            -(sight.jacobian_along[2] * step.x + sight.jacobian_along[3] * step.y)
        };
        let moved_a = |step: Vector2<f64>| {
            let dx = jacobian_a * step;
            let of_b = jacobian_b.tr_mul(&head(&(q * flat(&dx))));
            (head(&p.normal_a).dot(&dx), both(bent(&sight_a, &step).tr_mul(&head(&p.normal_a)), of_b))
        };
        let moved_b = |step: Vector2<f64>| {
            let dx = jacobian_b * step;
            let of_a = jacobian_a.tr_mul(&head(&q.tr_mul(&flat(&dx))));
            (head(&p.normal_b).dot(&dx), both(of_a, bent(&sight_b, &step).tr_mul(&head(&p.normal_b))))
        };
        let (de, dg) = moved_a(Vector2::from(meeting.outward_a));
        put(INSET, de, dg);
        let (de, dg) = moved_b(Vector2::from(meeting.outward_b));
        put(PARAMETERS + INSET, de, dg);
        let velocity = Vector2::from(meeting.velocity_b);
        if velocity != Vector2::zeros() {
            let (de, dg) = moved_b(velocity);
            let (rate_a, rate_b) = (1.0 + 1e-6 * self.a.drift, 1.0 + 1e-6 * self.b.drift);
            for (k, along) in [
                (CLOCK, -rate_b / rate_a),
                (CLOCK + 1, -1e-6 * rate_b / rate_a * pixels.time),
                (PARAMETERS + CLOCK, 1.0),
                (PARAMETERS + CLOCK + 1, 1e-6 * pixels.time),
            ] {
                put(k, de * along, dg * along);
            }
        }
        Some((p.residual, row))
    }
}

#[cfg(test)]
mod tests {
    use super::super::camera::{Step, tests::odd};
    use super::*;

    #[test]
    fn derivatives_equal_differences() {
        let (a, b) = (odd(0.4), odd(1.9));
        let meeting = Meeting {
            a: [500.0, 120.0],
            b: [100.0, 300.0],
            outward_a: [0.6, -0.8],
            outward_b: [0.28, 0.96],
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
                let mut step = Step::zeros();
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
            velocity_b: [0.0; 2],
            time_a: 0.0,
            time_b: 0.0,
            weight: 1.0,
        };
        assert!(CameraPair::new(&a, &b).residual(&meeting).unwrap().abs() < 1e-9);
    }
}
