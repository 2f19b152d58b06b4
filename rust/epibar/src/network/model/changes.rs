//! How `e = x_bᵀ Q x_a` and its gradient to the pixels change with each parameter of two cameras.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3, Vector4};

use super::camera::Camera;
use super::optics::{Look, Sight};

/// What a residual is made of.
pub(super) struct Parts {
    pub ray_a: Vector3<f64>,
    pub ray_b: Vector3<f64>,
    /// `Qᵀ x_b`.
    pub normal_a: Vector3<f64>,
    /// `Q x_a`.
    pub normal_b: Vector3<f64>,
    /// Of `e` to the pixels of A and of B.
    pub gradient: Vector4<f64>,
    /// Of the gradient.
    pub norm: f64,
    /// `e` over the norm, pixels.
    pub residual: f64,
}

impl Parts {
    /// Of `Q` between two cameras, and where a pixel of either looks.
    pub fn new(q: &Matrix3<f64>, look_a: &Look, look_b: &Look) -> Self {
        let (ray_a, ray_b) = (look_a.direction.push(1.0), look_b.direction.push(1.0));
        let (normal_b, normal_a) = (q * ray_a, q.tr_mul(&ray_b));
        let gradient =
            both(look_a.jacobian.tr_mul(&head(&normal_a)), look_b.jacobian.tr_mul(&head(&normal_b)));
        let norm = gradient.norm().max(1e-150);
        let residual = ray_b.dot(&normal_b) / norm;
        Self { ray_a, ray_b, normal_a, normal_b, gradient, norm, residual }
    }
}

/// A derivative to one parameter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Change {
    /// Of `e`.
    pub e: f64,
    /// Of its gradient to the pixels of A and of B.
    pub gradient: Vector4<f64>,
}

impl Change {
    /// To what the parameter is a function of, at so much of it for one.
    pub fn times(self, rate: f64) -> Self {
        Self { e: self.e * rate, gradient: self.gradient * rate }
    }
}

/// Derivatives at the pixels of one meeting.
pub(super) struct Changes<'c> {
    cameras: [&'c Camera; 2],
    q: &'c Matrix3<f64>,
    parts: &'c Parts,
    sights: [&'c Sight; 2],
    /// Both rays in the axes of the world, and their cross product.
    world: [Vector3<f64>; 2],
    across: Vector3<f64>,
    /// From B to A: direction and length.
    unit: Vector3<f64>,
    length: f64,
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

impl<'c> Changes<'c> {
    /// Of two cameras, `Q` between them, and what each sees.
    pub fn new(
        cameras: [&'c Camera; 2],
        q: &'c Matrix3<f64>,
        parts: &'c Parts,
        sights: [&'c Sight; 2],
    ) -> Self {
        let [a, b] = cameras;
        let world = [a.rotation.inverse() * parts.ray_a, b.rotation.inverse() * parts.ray_b];
        let across = world[0].cross(&world[1]);
        let baseline = a.position - b.position;
        let length = baseline.norm().max(1e-12);
        Self { cameras, q, parts, sights, world, across, unit: baseline / length, length }
    }

    /// A vector of A's image plane and one of B's, in the pixels of both.
    fn in_pixels(&self, of_a: &Vector3<f64>, of_b: &Vector3<f64>) -> Vector4<f64> {
        let [a, b] = self.sights.map(|sight| sight.look.jacobian);
        both(a.tr_mul(&head(of_a)), b.tr_mul(&head(of_b)))
    }

    /// To what moves the ray of A in the plane one before it, and bends the Jacobian.
    fn of_ray_a(&self, moved: &Vector2<f64>, bent: &Matrix2<f64>) -> Change {
        let normal = head(&self.parts.normal_a);
        let of_b = self.sights[1].look.jacobian.tr_mul(&head(&(self.q * flat(moved))));
        Change { e: normal.dot(moved), gradient: both(bent.tr_mul(&normal), of_b) }
    }

    /// To what moves the ray of B in the plane one before it, and bends the Jacobian.
    fn of_ray_b(&self, moved: &Vector2<f64>, bent: &Matrix2<f64>) -> Change {
        let normal = head(&self.parts.normal_b);
        let of_a = self.sights[0].look.jacobian.tr_mul(&head(&self.q.tr_mul(&flat(moved))));
        Change { e: normal.dot(moved), gradient: both(of_a, bent.tr_mul(&normal)) }
    }

    /// To the `k`-th intrinsic parameter of A.
    pub fn of_lens_a(&self, k: usize) -> Change {
        self.of_ray_a(&self.sights[0].along[k], &self.sights[0].jacobian_along[k])
    }

    /// To the `k`-th intrinsic parameter of B.
    pub fn of_lens_b(&self, k: usize) -> Change {
        self.of_ray_b(&self.sights[1].along[k], &self.sights[1].jacobian_along[k])
    }

    /// To a turn of A about an axis of its own.
    pub fn of_turn_a(&self, axis: &Vector3<f64>) -> Change {
        let normal = &self.parts.normal_a;
        let moved = self.parts.ray_a.cross(axis);
        Change { e: normal.dot(&moved), gradient: self.in_pixels(&axis.cross(normal), &(self.q * moved)) }
    }

    /// To a turn of B about an axis of its own.
    pub fn of_turn_b(&self, axis: &Vector3<f64>) -> Change {
        let normal = &self.parts.normal_b;
        let moved = self.parts.ray_b.cross(axis);
        Change {
            e: normal.dot(&moved),
            gradient: self.in_pixels(&self.q.tr_mul(&moved), &axis.cross(normal)),
        }
    }

    /// To A's place along an axis of the world; B's changes as much the other way. The baseline is taken with unit length: a change of its length
    /// says nothing.
    pub fn of_position_a(&self, axis: &Vector3<f64>) -> Change {
        let step = (axis - self.unit * self.unit.dot(axis)) / self.length;
        let ([a, b], [world_a, world_b]) = (self.cameras, self.world);
        let of_a = a.rotation * world_b.cross(&step);
        let of_b = b.rotation * step.cross(&world_a);
        Change { e: step.dot(&self.across), gradient: self.in_pixels(&of_a, &of_b) }
    }

    /// To a step of A's pixel, in pixels.
    pub fn of_pixel_a(&self, step: &Vector2<f64>) -> Change {
        self.of_ray_a(&(self.sights[0].look.jacobian * step), &bent(self.sights[0], step))
    }

    /// To a step of B's pixel, in pixels.
    pub fn of_pixel_b(&self, step: &Vector2<f64>) -> Change {
        self.of_ray_b(&(self.sights[1].look.jacobian * step), &bent(self.sights[1], step))
    }
}

/// How a step of the pixel changes the Jacobian: a pixel further right is a principal point further left.
fn bent(sight: &Sight, step: &Vector2<f64>) -> Matrix2<f64> {
    -(sight.jacobian_along[2] * step.x + sight.jacobian_along[3] * step.y)
}
