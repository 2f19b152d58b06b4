//! A point from the rays of many cameras, some of which may be wrong.

use nalgebra::{Matrix3, Vector3};

use crate::network::model::camera::Camera;

/// Steps of reweighting.
const STEPS: usize = 8;

/// A ray that is said to go through a point.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Whose it is.
    pub camera: usize,
    origin: Vector3<f64>,
    direction: Vector3<f64>,
    /// Pixels of a radian.
    focal: f64,
}

impl Ray {
    /// The ray of a pixel; `None` where the lens shows nothing.
    pub fn new(camera: usize, of: &Camera, pixel: [f64; 2]) -> Option<Self> {
        let [fx, fy] = of.focal();
        let direction = of.ray(pixel)?.normalize();
        Some(Self { camera, origin: of.position, direction, focal: (fx * fy).sqrt() })
    }

    /// Pixels by which it misses a point, and pixels that a unit of length is there; infinite behind the camera.
    pub fn miss(&self, point: &Vector3<f64>) -> (f64, f64) {
        let from = point - self.origin;
        let depth = from.dot(&self.direction);
        if depth <= 0.0 {
            return (f64::INFINITY, 0.0);
        }
        let per_unit = self.focal / depth;
        ((from - self.direction * depth).norm() * per_unit, per_unit)
    }
}

/// Covariance of a point from rays that are each off by some pixels, standard deviation; `None` where they do not
/// determine one.
pub fn covariance(rays: &[Ray], at: &Vector3<f64>, pixels: f64) -> Option<Matrix3<f64>> {
    let mut information = Matrix3::zeros();
    for ray in rays {
        let per_unit = ray.miss(at).1 / pixels;
        information += (Matrix3::identity() - ray.direction * ray.direction.transpose()) * per_unit.powi(2);
    }
    information.try_inverse()
}

/// The point that minimises the robust sum of squared pixels to some rays, from one near it; `None` where they do not
/// determine one. The loss is Cauchy's with the given scale, pixels.
pub fn point(rays: &[Ray], from: Vector3<f64>, scale: f64) -> Option<Vector3<f64>> {
    let mut at = from;
    for _ in 0..STEPS {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for ray in rays {
            let (pixels, per_unit) = ray.miss(&at);
            if !pixels.is_finite() {
                continue;
            }
            let weight = per_unit * per_unit / (1.0 + (pixels / scale).powi(2));
            let across = (Matrix3::identity() - ray.direction * ray.direction.transpose()) * weight;
            normal += across;
            right += across * ray.origin;
        }
        at = normal.cholesky()?.solve(&right);
    }
    at.iter().all(|v| v.is_finite()).then_some(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::model::camera::tests::odd;

    #[test]
    fn one_wrong_ray_of_five_moves_nothing() {
        let truth = Vector3::new(0.2, -0.1, 0.9);
        let cameras: Vec<Camera> = (0..5)
            .map(|k| {
                let mut camera = odd(0.1 * f64::from(k));
                let angle = 1.2 * f64::from(k);
                camera.position = Vector3::new(6.0 * angle.cos(), 6.0 * angle.sin(), 2.0);
                let ahead = (truth - camera.position).normalize();
                let right = ahead.cross(&Vector3::z()).normalize();
                let rows = [right.transpose(), ahead.cross(&right).transpose(), ahead.transpose()];
                camera.rotation = nalgebra::Rotation3::from_matrix_unchecked(Matrix3::from_rows(&rows));
                camera
            })
            .collect();
        let rays = |wrong: f64| -> Vec<Ray> {
            let pixel = |k: usize| {
                let [x, y] = cameras[k].project(&truth).unwrap();
                [x + if k == 2 { wrong } else { 0.0 }, y]
            };
            (0..5).map(|k| Ray::new(k, &cameras[k], pixel(k)).unwrap()).collect()
        };
        let near = truth + Vector3::new(0.05, 0.05, -0.05);
        let exact = point(&rays(0.0), near, 1.0).unwrap();
        assert!((exact - truth).norm() < 1e-9);
        let robust = point(&rays(40.0), near, 1.0).unwrap();
        assert!((robust - truth).norm() < 0.002, "{}", (robust - truth).norm());
        assert!(rays(40.0)[2].miss(&robust).0 > 30.0 && rays(40.0)[0].miss(&robust).0 < 0.2);
        assert!(point(&rays(0.0)[..1], near, 1.0).is_none_or(|p| (p - truth).norm() > 1e-6));
    }
}
