//! Pinhole cameras, and the fundamental matrix that they have by definition.
//!
//! World: x to the right, y forwards, z up, metres. Camera: x right, y down, z along the view.

use epibar::{Fundamental, ImageSize};
use nalgebra::{Matrix3, Vector3};

use super::masks::Random;

/// A pinhole camera: `x ~ K (R X + t)`.
#[derive(Debug, Clone)]
pub struct Camera {
    pub size: ImageSize,
    k: Matrix3<f64>,
    r: Matrix3<f64>,
    t: Vector3<f64>,
}

impl Camera {
    /// A camera at `position` that looks at `target`, turned about its axis by `roll` radians. The principal point
    /// is a little off the centre of the image, so that nothing may take it to be there.
    pub fn new(position: [f64; 3], target: [f64; 3], size: (usize, usize), focal: f64, roll: f64) -> Self {
        let (position, target) = (Vector3::from(position), Vector3::from(target));
        let forward = (target - position).normalize();
        let right = forward.cross(&Vector3::z()).normalize();
        let down = forward.cross(&right);
        let (sin, cos) = roll.sin_cos();
        let (x, y) = (right * cos + down * sin, down * cos - right * sin);
        let r = Matrix3::from_rows(&[x.transpose(), y.transpose(), forward.transpose()]);
        let size = ImageSize::new(size.0, size.1).unwrap();
        let (cx, cy) = (0.52 * size.x_max(), 0.47 * size.y_max());
        Self { size, k: Matrix3::new(focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0), r, t: -(r * position) }
    }

    /// This camera with the principal point in the middle of the image, as a network takes it to be unless told otherwise.
    pub fn centred(self) -> Self {
        let mut k = self.k;
        (k[(0, 2)], k[(1, 2)]) = (0.5 * self.size.x_max(), 0.5 * self.size.y_max());
        Self { k, ..self }
    }

    /// This camera, knocked: turned about its centre.
    pub fn turned(self, turn: &nalgebra::Rotation3<f64>) -> Self {
        let (r, centre) = (turn * self.r, self.centre());
        Self { t: -(r * centre), r, ..self }
    }

    /// This camera with its focal length so many times as long.
    pub fn zoomed(mut self, by: f64) -> Self {
        self.k.m11 *= by;
        self.k.m22 *= by;
        self
    }

    /// The camera matrix.
    pub fn matrix(&self) -> Matrix3<f64> {
        self.k
    }

    /// World to camera.
    pub fn rotation(&self) -> Matrix3<f64> {
        self.r
    }

    /// The centre of projection.
    pub fn centre(&self) -> Vector3<f64> {
        -self.r.tr_mul(&self.t)
    }

    /// Homogeneous image of a point, pixels; its third entry is the depth, metres.
    pub fn homogeneous(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.k * (self.r * point + self.t)
    }

    /// Image of a point in front of the camera, whether inside the image or not.
    pub fn project(&self, point: &Vector3<f64>) -> Option<[f64; 2]> {
        let x = self.homogeneous(point);
        (x.z > 0.05).then(|| [x.x / x.z, x.y / x.z])
    }

    /// Image of a point that falls inside the image.
    pub fn see(&self, point: &Vector3<f64>) -> Option<[f64; 2]> {
        let [x, y] = self.project(point)?;
        let inside = (0.0..=self.size.x_max()).contains(&x) && (0.0..=self.size.y_max()).contains(&y);
        inside.then_some([x, y])
    }
}

/// `K_b^{-T} [t]× R K_a^{-1}` (Hartley and Zisserman, eq. 9.10 with A as the first camera): the matrix itself, without
/// anything of the crate in it.
pub fn fundamental_matrix(a: &Camera, b: &Camera) -> Matrix3<f64> {
    let r = b.r * a.r.transpose();
    let t = b.t - r * a.t;
    let matrix = b.k.try_inverse().unwrap().transpose() * t.cross_matrix() * r * a.k.try_inverse().unwrap();
    matrix / matrix.norm()
}

/// [`fundamental_matrix`] as a [`Fundamental`].
pub fn fundamental(a: &Camera, b: &Camera) -> Fundamental {
    Fundamental::from_matrix(&fundamental_matrix(a, b), a.size, b.size).unwrap()
}

/// Two random cameras that differ in everything and look into the volume of [`points`] from different sides.
pub fn random_pair(random: &mut Random) -> [Camera; 2] {
    let turn = random.between(0.0, std::f64::consts::TAU);
    let apart = random.between(0.5, 2.6);
    [(0.0, 400), (apart, 260)].map(|(angle, width)| {
        let (sin, cos) = (turn + angle).sin_cos();
        let distance = random.between(6.0, 10.0);
        let position = [distance * cos, distance * sin, random.between(0.5, 5.0)];
        let target = [random.between(-0.5, 0.5), random.between(-0.5, 0.5), random.between(0.5, 1.5)];
        let size = (width + random.below(300), 200 + random.below(300));
        let focal = random.between(0.8, 1.4) * size.0 as f64;
        Camera::new(position, target, size, focal, random.between(-0.5, 0.5))
    })
}

/// Images of random points of the volume that both cameras see.
pub fn points(cameras: &[Camera; 2], count: usize, random: &mut Random) -> Vec<([f64; 2], [f64; 2])> {
    let mut points = Vec::with_capacity(count);
    while points.len() < count {
        let [x, y, z] = [(-2.5, 2.5), (-2.5, 2.5), (0.0, 2.5)].map(|(low, high)| random.between(low, high));
        let point = Vector3::new(x, y, z);
        if let (Some(a), Some(b)) = (cameras[0].see(&point), cameras[1].see(&point)) {
            points.push((a, b));
        }
    }
    points
}

/// Mean symmetric epipolar distance over the volume, pixels.
pub fn error(f: &Fundamental, cameras: &[Camera; 2]) -> f64 {
    let points = points(cameras, 400, &mut Random(99));
    let distance = |(a, b): &_| epibar::symmetric_epipolar_distance(f, *a, *b);
    points.iter().map(distance).sum::<f64>() / points.len() as f64
}
