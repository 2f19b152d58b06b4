//! Where the pixels of a camera look, in its own frame, and how that changes with the pixel and with the camera.

use nalgebra::{Matrix2, Vector2};

use crate::geometry::lens::Lens;
use crate::image::ImageSize;

/// Parameters of a camera by itself: `f, f_y / f_x, c_x, c_y, k₁, k₂, k₃`.
pub const INTRINSIC: usize = 7;

/// What the pixels of a camera show, wherever it stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optics {
    /// `f_x` and `f_y`, pixels.
    pub focal: [f64; 2],
    /// Principal point, pixels.
    pub principal: [f64; 2],
    /// The lens.
    pub lens: Lens,
}

/// Where a pixel looks, and how that changes with the pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// `(x, y)` of the ray `(x, y, 1)` in the camera's frame.
    pub direction: Vector2<f64>,
    /// Derivative of the direction to the pixel.
    pub jacobian: Matrix2<f64>,
}

/// Where a pixel looks, and how that changes with the camera too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Where, and how that changes with the pixel.
    pub look: Look,
    /// Derivative of the direction to each intrinsic parameter.
    pub along: [Vector2<f64>; INTRINSIC],
    /// Derivative of the jacobian to each intrinsic parameter.
    pub jacobian_along: [Matrix2<f64>; INTRINSIC],
}

impl Optics {
    /// Where a pixel is on the plane `z = 1` before the lens is taken out.
    fn distorted(&self, [u, v]: [f64; 2]) -> Vector2<f64> {
        let ([fx, fy], [cx, cy]) = (self.focal, self.principal);
        Vector2::new((u - cx) / fx, (v - cy) / fy)
    }

    /// Pixels from the principal point up to which the lens shows anything, along the shorter focal length; `None` where that is all
    /// of an image.
    pub fn reach(&self, size: ImageSize) -> Option<f64> {
        let [left, top, right, bottom] = [-0.5, -0.5, size.x_max() + 0.5, size.y_max() + 0.5];
        let corners = [[left, top], [right, top], [left, bottom], [right, bottom]];
        let farthest = corners.map(|c| self.distorted(c).norm()).into_iter().fold(0.0, f64::max);
        let reach = self.lens.reach(farthest);
        (reach < farthest).then(|| reach * self.focal[0].min(self.focal[1]))
    }

    /// The direction `(x, y)` of the ray `(x, y, 1)` that is seen at a pixel; `None` where the lens shows nothing.
    pub fn direction(&self, pixel: [f64; 2]) -> Option<[f64; 2]> {
        let d = self.distorted(pixel);
        self.lens.undistort([d.x, d.y])
    }

    /// The direction of a pixel with its derivative to it; `None` where the lens shows nothing.
    pub fn look(&self, pixel: [f64; 2]) -> Option<Look> {
        let d = self.distorted(pixel);
        let [s, s_q] = self.lens.stretch_only(d.norm_squared())?;
        Some(self.look_by(&d, s, &bend(&d, s, s_q)))
    }

    fn look_by(&self, d: &Vector2<f64>, s: f64, bend: &Matrix2<f64>) -> Look {
        Look { direction: d * s, jacobian: bend * self.scale() }
    }

    fn scale(&self) -> Matrix2<f64> {
        Matrix2::new(1.0 / self.focal[0], 0.0, 0.0, 1.0 / self.focal[1])
    }

    /// The direction of a pixel with all its derivatives; `None` where the lens shows nothing.
    pub fn sight(&self, pixel: [f64; 2]) -> Option<Sight> {
        let (d, [fx, fy]) = (self.distorted(pixel), self.focal);
        let stretch = self.lens.stretch(d.norm_squared())?;
        let outer = d * d.transpose();
        let bend = bend(&d, stretch.s, stretch.s_q);
        let scale = self.scale();
        let look = self.look_by(&d, stretch.s, &bend);
        let mut along = [Vector2::zeros(); INTRINSIC];
        let mut jacobian_along = [Matrix2::zeros(); INTRINSIC];
        // Through the place on the plane z = 1: log f, log aspect, principal point.
        let moved = [-d, Vector2::new(0.0, -d.y), Vector2::new(-1.0 / fx, 0.0), Vector2::new(0.0, -1.0 / fy)];
        for (i, step) in moved.into_iter().enumerate() {
            let inner = d.dot(&step);
            let crossed = step * d.transpose();
            let bend_along = Matrix2::identity() * (2.0 * stretch.s_q * inner)
                + outer * (4.0 * stretch.s_qq * inner)
                + (crossed + crossed.transpose()) * (2.0 * stretch.s_q);
            along[i] = bend * step;
            jacobian_along[i] = bend_along * scale;
        }
        jacobian_along[0] -= look.jacobian;
        jacobian_along[1] -= bend * Matrix2::new(0.0, 0.0, 0.0, 1.0 / fy);
        for i in 0..3 {
            along[4 + i] = d * stretch.s_k[i];
            let bend_along = Matrix2::identity() * stretch.s_k[i] + outer * (2.0 * stretch.s_qk[i]);
            jacobian_along[4 + i] = bend_along * scale;
        }
        Some(Sight { look, along, jacobian_along })
    }
}

/// Derivative of the direction to the place on the plane `z = 1`.
fn bend(d: &Vector2<f64>, s: f64, s_q: f64) -> Matrix2<f64> {
    Matrix2::identity() * s + d * d.transpose() * (2.0 * s_q)
}
