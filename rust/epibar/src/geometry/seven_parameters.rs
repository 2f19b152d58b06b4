//! Seven parameters of a fundamental matrix.
//!
//! In normalised coordinates `F = U diag(cos θ, sin θ, 0) Vᵀ` with rotations `U` and `V` (the orthonormal
//! representation of Bartoli and Sturm 2004): rank 2 and unit norm by construction, seven parameters, no
//! singularity. A step multiplies `U` and `V` from the right by small rotations and adds to `θ`.

use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, Vector3};

use super::fundamental::{Fundamental, denormaliser, normaliser};
use crate::image::ImageSize;

/// A step in the seven parameters: rotation of U (3), rotation of V (3), angle of the singular values.
pub type Step = SVector<f64, 7>;
/// A 7×7 matrix over the parameters: normal equations, covariance.
pub type Information = SMatrix<f64, 7, 7>;

/// A fundamental matrix on its seven-dimensional manifold.
#[derive(Debug, Clone)]
pub struct SevenParameters {
    u: Matrix3<f64>,
    v: Matrix3<f64>,
    theta: f64,
    sizes: [ImageSize; 2],
}

impl SevenParameters {
    /// The parameters of `f`; `None` where the decomposition fails.
    pub fn new(f: &Fundamental, sizes: [ImageSize; 2]) -> Option<Self> {
        let normalised = denormaliser(sizes[1]).transpose() * f.matrix() * denormaliser(sizes[0]);
        let svd = (normalised / normalised.norm()).try_svd(true, true, 1e-15, 200)?;
        let (u, vt) = (svd.u?, svd.v_t?);
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| svd.singular_values[j].total_cmp(&svd.singular_values[i]));
        let pick = |m: &Matrix3<f64>| Matrix3::from_columns(&order.map(|i| m.column(i).into_owned()));
        let (mut u, mut v) = (pick(&u), pick(&vt.transpose()));
        // The third columns are free in sign, so both can be made rotations.
        if u.determinant() < 0.0 {
            u.column_mut(2).neg_mut();
        }
        if v.determinant() < 0.0 {
            v.column_mut(2).neg_mut();
        }
        let theta = svd.singular_values[order[1]].atan2(svd.singular_values[order[0]]);
        Some(Self { u, v, theta, sizes })
    }

    /// Sizes of both images.
    pub fn sizes(&self) -> [ImageSize; 2] {
        self.sizes
    }

    /// Back to a matrix in pixels; `None` where it is not finite.
    pub fn fundamental(&self) -> Option<Fundamental> {
        let sigma = Matrix3::from_diagonal(&Vector3::new(self.theta.cos(), self.theta.sin(), 0.0));
        let normalised = self.u * sigma * self.v.transpose();
        Fundamental::from_parts(
            self.to_pixels(&normalised),
            denormaliser(self.sizes[0]) * self.v.column(2),
            denormaliser(self.sizes[1]) * self.u.column(2),
        )
    }

    /// The parameters moved by a step.
    #[must_use]
    pub fn stepped(&self, step: &Step) -> Self {
        let du = Rotation3::new(Vector3::new(step[0], step[1], step[2]));
        let dv = Rotation3::new(Vector3::new(step[3], step[4], step[5]));
        Self {
            u: self.u * du.matrix(),
            v: self.v * dv.matrix(),
            theta: self.theta + step[6],
            sizes: self.sizes,
        }
    }

    /// `∂F/∂parameter`, in pixels and in the scale of [`SevenParameters::unscaled`].
    pub fn derivatives(&self) -> [Matrix3<f64>; 7] {
        let (sin, cos) = self.theta.sin_cos();
        let sigma = Matrix3::from_diagonal(&Vector3::new(cos, sin, 0.0));
        let turned = Matrix3::from_diagonal(&Vector3::new(-sin, cos, 0.0));
        std::array::from_fn(|k| {
            let normalised = match k {
                0..=2 => self.u * Vector3::ith(k, 1.0).cross_matrix() * sigma * self.v.transpose(),
                3..=5 => {
                    self.u * sigma * Vector3::ith(k - 3, 1.0).cross_matrix().transpose() * self.v.transpose()
                }
                _ => self.u * turned * self.v.transpose(),
            };
            self.to_pixels(&normalised)
        })
    }

    /// Normal equations over the nine entries of the matrix, column by column, carried to the seven parameters.
    pub fn carried(&self, normal: &SMatrix<f64, 9, 9>, gradient: &SVector<f64, 9>) -> (Information, Step) {
        let chain = as_columns(&self.derivatives());
        (chain.tr_mul(&(normal * chain)), chain.tr_mul(gradient))
    }

    /// `F` in pixels with unit norm in *normalised* coordinates, the scale in which steps act.
    pub fn unscaled(&self) -> Matrix3<f64> {
        let sigma = Matrix3::from_diagonal(&Vector3::new(self.theta.cos(), self.theta.sin(), 0.0));
        self.to_pixels(&(self.u * sigma * self.v.transpose()))
    }

    fn to_pixels(&self, normalised: &Matrix3<f64>) -> Matrix3<f64> {
        normaliser(self.sizes[1]).transpose() * normalised * normaliser(self.sizes[0])
    }
}

/// Derivatives of a matrix as those of its nine entries, column by column.
pub fn as_columns(derivatives: &[Matrix3<f64>; 7]) -> SMatrix<f64, 9, 7> {
    SMatrix::from_fn(|i, k| derivatives[k].as_slice()[i])
}
