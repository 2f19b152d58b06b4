//! A camera of a network: what is solved for.
//!
//! `X_c = R (X − C)`, x right, y down, z forward; a direction `(x, y, 1)` is bent by the [`Lens`] and seen at
//! `u = f_x x + c_x`, `v = f_y y + c_y`. Its clock runs `rate` seconds for each of the network's, and shows `offset` at the
//! network's nought.

use nalgebra::{Matrix3, Rotation3, SVector, Vector3};

use super::insets::{Insets, SIDES};
pub use super::optics::INTRINSIC;
use super::optics::Optics;
use crate::geometry::lens::Lens;
use crate::image::ImageSize;

/// What is solved for in a camera: log of the focal length, log of `f_y / f_x`, principal point (2), `k₁ k₂ k₃`, rotation
/// (3, in the camera's frame), position (3), clock's offset (seconds) and drift (ppm), insets of its silhouettes (pixels): all around, of
/// small ones, and on each side (4).
pub const PARAMETERS: usize = 21;
/// Where the logarithm of the focal length is among the parameters.
pub const FOCAL: usize = 0;
/// Where the rotation starts among the parameters.
pub const ROTATION: usize = 7;
/// Where the position starts.
pub const POSITION: usize = 10;
/// Where the clock starts.
pub const CLOCK: usize = 13;
/// Where the inset all around is.
pub const INSET: usize = 15;
/// Where that of small silhouettes is.
pub const INSET_OF_SMALL: usize = 16;
/// Where those of the sides start.
pub const INSET_OF_SIDES: usize = 17;

/// A step in the parameters of a camera.
pub type CameraStep = SVector<f64, PARAMETERS>;

/// A camera with its lens, its place and its clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Size of the image.
    pub size: ImageSize,
    /// Log of `f_x`, pixels.
    pub log_focal: f64,
    /// Log of `f_y / f_x`.
    pub log_aspect: f64,
    /// Principal point, pixels.
    pub principal: [f64; 2],
    /// The lens.
    pub lens: Lens,
    /// World to camera.
    pub rotation: Rotation3<f64>,
    /// Where it stands in the world.
    pub position: Vector3<f64>,
    /// Seconds of this clock at the network's time 0.
    pub offset: f64,
    /// By how much this clock runs faster than the network's, ppm.
    pub drift: f64,
    /// How far the hulls of its silhouettes lie inside of the true outlines, pixels.
    pub insets: Insets,
}

impl Camera {
    /// A camera with square pixels and no distortion, whose axis meets the middle of the image.
    pub fn new(size: ImageSize, focal: f64) -> Self {
        Self {
            size,
            log_focal: focal.ln(),
            log_aspect: 0.0,
            principal: [0.5 * size.x_max(), 0.5 * size.y_max()],
            lens: Lens::NONE,
            rotation: Rotation3::identity(),
            position: Vector3::zeros(),
            offset: 0.0,
            drift: 0.0,
            insets: Insets::default(),
        }
    }

    /// Whether the pixels of another show the same directions.
    pub fn has_lens_of(&self, other: &Self) -> bool {
        let of = |c: &Self| (c.log_focal, c.log_aspect, c.principal, c.lens);
        of(self) == of(other)
    }

    /// The parameters of the camera by itself, in their order.
    pub fn intrinsic(&self) -> [f64; INTRINSIC] {
        let ([cx, cy], [k1, k2, k3]) = (self.principal, self.lens.k);
        [self.log_focal, self.log_aspect, cx, cy, k1, k2, k3]
    }

    /// `f_x` and `f_y`, pixels.
    pub fn focal(&self) -> [f64; 2] {
        [self.log_focal.exp(), (self.log_focal + self.log_aspect).exp()]
    }

    /// The camera matrix.
    pub fn matrix(&self) -> Matrix3<f64> {
        let ([fx, fy], [cx, cy]) = (self.focal(), self.principal);
        Matrix3::new(fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0)
    }

    /// `t` of `X_c = R X + t`.
    pub fn translation(&self) -> Vector3<f64> {
        -(self.rotation * self.position)
    }

    /// What its pixels show, made ready for many of them.
    pub fn optics(&self) -> Optics {
        Optics { focal: self.focal(), principal: self.principal, lens: self.lens }
    }

    /// The direction `(x, y)` of the ray `(x, y, 1)` that is seen at a pixel, in the camera's frame; `None` where the lens
    /// shows nothing.
    pub fn direction(&self, pixel: [f64; 2]) -> Option<[f64; 2]> {
        self.optics().direction(pixel)
    }

    /// The ray of a pixel in the world, not of unit length.
    pub fn ray(&self, pixel: [f64; 2]) -> Option<Vector3<f64>> {
        self.direction(pixel).map(|[x, y]| self.rotation.inverse() * Vector3::new(x, y, 1.0))
    }

    /// The pixel at which a point of the world is seen, in the image or beside it; `None` behind the camera, and where the
    /// lens shows nothing.
    pub fn project(&self, point: &Vector3<f64>) -> Option<[f64; 2]> {
        let seen = self.rotation * (point - self.position);
        if seen.z <= 0.0 {
            return None;
        }
        let direction = [seen.x / seen.z, seen.y / seen.z];
        let ([fx, fy], [cx, cy]) = (self.focal(), self.principal);
        let [x, y] = self.lens.distort(direction);
        let pixel = [fx * x + cx, fy * y + cy];
        // Beyond where the polynomial turns back other directions have the same pixel.
        let back = self.direction(pixel)?;
        ((back[0] - direction[0]).hypot(back[1] - direction[1]) < 1e-6).then_some(pixel)
    }

    /// The camera after a step in its parameters.
    #[must_use]
    pub fn stepped(&self, step: &CameraStep) -> Self {
        let turn = Rotation3::new(Vector3::new(step[ROTATION], step[ROTATION + 1], step[ROTATION + 2]));
        Self {
            size: self.size,
            log_focal: self.log_focal + step[0],
            log_aspect: self.log_aspect + step[1],
            principal: [self.principal[0] + step[2], self.principal[1] + step[3]],
            lens: Lens { k: std::array::from_fn(|i| self.lens.k[i] + step[4 + i]) },
            rotation: turn * self.rotation,
            position: self.position + step.fixed_rows::<3>(POSITION),
            offset: self.offset + step[CLOCK],
            drift: self.drift + step[CLOCK + 1],
            insets: Insets {
                all: self.insets.all + step[INSET],
                sides: std::array::from_fn(|k| self.insets.sides[k] + step[INSET_OF_SIDES + k]),
                small: self.insets.small + step[INSET_OF_SMALL],
            },
        }
    }

    /// The step that leads here from another camera.
    pub fn step_from(&self, before: &Self) -> CameraStep {
        let turn = (self.rotation * before.rotation.inverse()).scaled_axis();
        let moved = self.position - before.position;
        let mut step = CameraStep::zeros();
        step[0] = self.log_focal - before.log_focal;
        step[1] = self.log_aspect - before.log_aspect;
        for i in 0..2 {
            step[2 + i] = self.principal[i] - before.principal[i];
        }
        for i in 0..3 {
            step[4 + i] = self.lens.k[i] - before.lens.k[i];
            step[ROTATION + i] = turn[i];
            step[POSITION + i] = moved[i];
        }
        step[CLOCK] = self.offset - before.offset;
        step[CLOCK + 1] = self.drift - before.drift;
        step[INSET] = self.insets.all - before.insets.all;
        step[INSET_OF_SMALL] = self.insets.small - before.insets.small;
        for k in 0..SIDES {
            step[INSET_OF_SIDES + k] = self.insets.sides[k] - before.insets.sides[k];
        }
        step
    }

    /// Seconds of this clock when the network's shows `time`.
    pub fn clock_at(&self, time: f64) -> f64 {
        time * (1.0 + 1e-6 * self.drift) + self.offset
    }

    /// The network's time when this clock shows `seconds`.
    pub fn time_of(&self, seconds: f64) -> f64 {
        (seconds - self.offset) / (1.0 + 1e-6 * self.drift)
    }
}

#[cfg(test)]
pub(in crate::network) mod tests {
    use super::*;

    /// A camera in which everything differs from what is usual.
    pub fn odd(seed: f64) -> Camera {
        Camera {
            log_aspect: 0.02,
            principal: [330.0, 228.0 + seed],
            lens: Lens { k: [-0.25 - 0.01 * seed, 0.08, -0.01] },
            rotation: Rotation3::from_euler_angles(1.7, 0.2 * seed, -0.3 + seed),
            position: Vector3::new(3.0 * seed.cos(), 3.0 * seed.sin(), 2.0 + 0.1 * seed),
            offset: 0.3 * seed,
            drift: 20.0 * seed,
            insets: Insets { all: 0.2 + 0.1 * seed, sides: [0.1, 0.3, -0.1, 0.2 * seed], small: 0.2 * seed },
            ..Camera::new(ImageSize::new(640, 480).unwrap(), 500.0)
        }
    }

    #[test]
    fn derivatives_equal_differences() {
        let camera = odd(1.0);
        for pixel in [[30.0, 40.0], [331.0, 229.0], [600.0, 300.0]] {
            let sight = camera.optics().sight(pixel).unwrap();
            assert_eq!(camera.optics().look(pixel), Some(sight.look));
            let of = |camera: &Camera, pixel| camera.optics().sight(pixel).unwrap();
            for k in 0..2 {
                let at = |h: f64| {
                    let mut p = pixel;
                    p[k] += h;
                    of(&camera, p).look.direction
                };
                let difference = (at(1e-3) - at(-1e-3)) / 2e-3;
                assert!((difference - sight.look.jacobian.column(k)).norm() < 1e-9);
            }
            for k in 0..INTRINSIC {
                let h = if (2..4).contains(&k) { 1e-3 } else { 1e-6 };
                let at = |h: f64| {
                    let mut step = CameraStep::zeros();
                    step[k] = h;
                    of(&camera.stepped(&step), pixel)
                };
                let (plus, minus) = (at(h), at(-h));
                let along = (plus.look.direction - minus.look.direction) / (2.0 * h);
                assert!((along - sight.along[k]).norm() < 1e-7 * (1.0 + along.norm()), "{k}");
                let along = (plus.look.jacobian - minus.look.jacobian) / (2.0 * h);
                assert!(
                    (along - sight.jacobian_along[k]).norm() < 1e-7,
                    "{k} {along} {}",
                    sight.jacobian_along[k]
                );
            }
        }
    }

    #[test]
    fn a_step_leads_from_one_camera_to_another() {
        let (before, after) = (odd(1.0), odd(1.3));
        let there = before.stepped(&after.step_from(&before));
        assert!(after.step_from(&there).norm() < 1e-12, "{there:?} {after:?}");
        let step = CameraStep::from_fn(|k, _| 0.01 * (k as f64 + 1.0));
        assert!((before.stepped(&step).step_from(&before) - step).norm() < 1e-10);
    }

    #[test]
    fn a_pixel_and_its_ray() {
        let camera = odd(2.0);
        let pixel = [123.0, 345.0];
        let point = camera.position + camera.ray(pixel).unwrap() * 4.0;
        let back = camera.project(&point).unwrap();
        assert!((back[0] - pixel[0]).hypot(back[1] - pixel[1]) < 1e-9);
        let t = camera.rotation * point + camera.translation();
        assert!((t.x / t.z - camera.direction(pixel).unwrap()[0]).abs() < 1e-12);
        assert!(camera.project(&(camera.position - camera.ray(pixel).unwrap())).is_none());
        assert!(
            camera
                .project(&(camera.position + camera.rotation.inverse() * Vector3::new(3.0, 0.0, 1.0)))
                .is_none()
        );
        assert!((camera.time_of(camera.clock_at(17.0)) - 17.0).abs() < 1e-12);
    }
}
