//! What a network is made of, and what is known of each camera before.

use nalgebra::Matrix3;

use crate::error::{Error, Result};
use crate::geometry::lens::Lens;
use crate::network::model::beliefs::{Belief, Beliefs, InsetBeliefs};
use crate::network::model::camera::Camera;
use crate::network::model::insets::Insets;
use crate::network::thresholds as limits;
use crate::recording::Recording;

/// What is known of a camera before, each part by itself. The default is nothing.
///
/// A recording whose masks had the lens taken out is undistorted: `matrix` is its camera matrix, and there is no distortion. Of a
/// raw recording matrix and distortions may be known too; it is then seen through that lens.
///
/// ```
/// use epibar::network::{Aspect, Knowledge};
///
/// let known = Knowledge::new().focal(1420.0, 0.02).aspect(Aspect::Unknown);
/// assert_eq!(known.focal, Some((1420.0, 0.02)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Knowledge {
    /// The camera matrix, `[[f_x, 0, c_x], [0, f_y, c_y], [0, 0, 1]]`, pixels.
    pub matrix: Option<Matrix3<f64>>,
    /// `k₁ k₂ p₁ p₂ k₃` of `OpenCV`; the tangential ones must be 0.
    pub distortions: Option<[f64; 5]>,
    /// The focal length alone, pixels, and its relative standard deviation.
    pub focal: Option<(f64, f64)>,
    /// The principal point alone, pixels.
    pub principal: Option<[f64; 2]>,
    /// `f_y / f_x`, or how far it may be from 1.
    pub aspect: Aspect,
}

/// What is known of `f_y / f_x`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum Aspect {
    /// Pixels are square.
    #[default]
    Square,
    /// `f_y / f_x` is this number.
    Known(f64),
    /// `f_y / f_x` is solved for, and within a percent or so of 1.
    Unknown,
}

/// A camera of a network: its name, its recording, and what is known of it.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct CameraInput<'r> {
    /// Name, for messages and results.
    pub name: &'r str,
    /// What it saw move.
    pub recording: &'r Recording,
    /// What is known of it before.
    pub known: Knowledge,
}

impl<'r> CameraInput<'r> {
    /// A camera of which nothing is known.
    pub fn new(name: &'r str, recording: &'r Recording) -> Self {
        Self { name, recording, known: Knowledge::default() }
    }

    /// With what is known of it before.
    #[must_use]
    pub fn known(self, known: Knowledge) -> Self {
        Self { known, ..self }
    }
}

/// Focal length that a camera is believed to have before, in widths of its image, and the standard deviation of its log:
/// webcams, phones, action cameras and surveillance cameras are 0.5 to 1.6.
const FOCAL: (f64, f64) = (0.9, 0.7);
/// Standard deviation of `k₁` about 0, and those of `k₂` and `k₃` about what goes with it.
const LENS: [f64; 3] = [0.7, 0.1, 0.05];
/// Standard deviations of a principal point about the middle, in widths of the image: of images that were made or cut about it, of
/// cameras as they are sold, and of images that were cropped or stabilised, more and more.
pub const PRINCIPAL_LEVELS: [f64; 5] = [0.001, 0.004, 0.012, 0.04, 0.12];
/// Index of the level of cameras as they are sold, from which a network starts.
pub const AS_SOLD: usize = 1;
/// How likely each is before anything is seen.
pub const PRINCIPAL_SHARES: [f64; 5] = [0.2, 0.4, 0.25, 0.12, 0.03];
/// Relative standard deviation of a focal length that is given: calibrations are good to a few tenths of a percent.
const GIVEN_FOCAL: f64 = 0.001;
/// Standard deviation of `log (f_y / f_x)` where it is solved for.
const ASPECT: f64 = 0.01;
/// Tangential distortions that are given must be below this: they are taken for 0.
pub const TANGENTIAL: f64 = 1e-2;
/// How far hulls lie inside of outlines, pixels: a part of the grid, and what masks leave out or add.
pub const INSET: Belief = Belief { mean: 0.2, deviation: 1.0 };

/// Standard deviation of `log (f_y / f_x)` where it may be that of any pixels, such as those of television.
const ASPECT_OF_ANY: f64 = 0.1;

/// What is given of a camera, by the kinds that are given together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum IntrinsicKind {
    /// The focal length.
    Focal,
    /// `f_y / f_x`.
    Aspect,
    /// The principal point.
    PrincipalPoint,
    /// `k₁ k₂ k₃`.
    Lens,
}

impl IntrinsicKind {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Focal, Self::Aspect, Self::PrincipalPoint, Self::Lens];

    /// Which of the parameters of a camera are of this kind.
    pub fn parameters(self) -> &'static [usize] {
        match self {
            Self::Focal => &[0],
            Self::Aspect => &[1],
            Self::PrincipalPoint => &[2, 3],
            Self::Lens => &[4, 5, 6],
        }
    }

    /// Whether it is given, so that it is held or nearly so.
    pub fn is_given(self, beliefs: &Beliefs) -> bool {
        let least = if self == Self::Focal { limits::KNOWN_FOCAL } else { 0.0 };
        self.parameters().iter().all(|&k| beliefs.intrinsic[k].deviation <= least)
    }

    /// Takes back that it is given: of a camera as it stands, any number may be the right one.
    pub fn free(self, beliefs: &mut Beliefs, camera: &Camera) {
        let wide = limits::PRINCIPAL_STRAINED * camera.size.width as f64;
        let about = [
            Belief::about(camera.log_focal, FOCAL.1),
            Belief::about(camera.log_aspect, ASPECT_OF_ANY),
            Belief::about(camera.principal[0], wide),
            Belief::about(camera.principal[1], wide),
            Belief::about(0.0, LENS[0]),
            Belief::about(0.0, LENS[1]),
            Belief::about(0.0, LENS[2]),
        ];
        for &k in self.parameters() {
            beliefs.intrinsic[k] = about[k];
        }
    }
}

impl Knowledge {
    /// Nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// With the camera matrix, pixels.
    #[must_use]
    pub fn matrix(self, matrix: Matrix3<f64>) -> Self {
        Self { matrix: Some(matrix), ..self }
    }

    /// With `k₁ k₂ p₁ p₂ k₃` of `OpenCV`.
    #[must_use]
    pub fn distortions(self, distortions: [f64; 5]) -> Self {
        Self { distortions: Some(distortions), ..self }
    }

    /// With the focal length alone, pixels, and its relative standard deviation.
    #[must_use]
    pub fn focal(self, pixels: f64, deviation: f64) -> Self {
        Self { focal: Some((pixels, deviation)), ..self }
    }

    /// With the principal point alone, pixels.
    #[must_use]
    pub fn principal(self, point: [f64; 2]) -> Self {
        Self { principal: Some(point), ..self }
    }

    /// With what is known of `f_y / f_x`.
    #[must_use]
    pub fn aspect(self, aspect: Aspect) -> Self {
        Self { aspect, ..self }
    }

    /// Whether the focal length is known.
    pub fn has_focal(&self) -> bool {
        self.matrix.is_some() || self.focal.is_some_and(|(_, deviation)| deviation < limits::KNOWN_FOCAL)
    }

    /// Whether what was recorded has no distortion.
    pub fn is_undistorted(&self) -> bool {
        self.distortions.is_none_or(|d| d.iter().all(|k| *k == 0.0))
    }

    /// A camera to start from, and what is believed of it.
    pub(in crate::network) fn beliefs(&self, recording: &Recording) -> (Camera, Beliefs) {
        let size = recording.size();
        let width = size.width() as f64;
        let middle = [0.5 * size.x_max(), 0.5 * size.y_max()];
        let unknown = |k: usize| Belief::about(middle[k], PRINCIPAL_LEVELS[AS_SOLD] * width);
        let mut focal = Belief::about((FOCAL.0 * width).ln(), FOCAL.1);
        let mut aspect = match self.aspect {
            Aspect::Square => Belief::fixed(0.0),
            Aspect::Known(ratio) => Belief::fixed(ratio.ln()),
            Aspect::Unknown => Belief::about(0.0, ASPECT),
        };
        let mut principal = [unknown(0), unknown(1)];
        let mut lens = LENS.map(|deviation| Belief::about(0.0, deviation));
        if let Some((pixels, deviation)) = self.focal {
            focal = Belief::about(pixels.ln(), deviation.max(GIVEN_FOCAL));
        }
        if let Some(point) = self.principal {
            principal = point.map(Belief::fixed);
        }
        if let Some(matrix) = self.matrix {
            focal = Belief::fixed(matrix.m11.ln());
            aspect = Belief::fixed((matrix.m22 / matrix.m11).ln());
            principal = [Belief::fixed(matrix.m13), Belief::fixed(matrix.m23)];
            // Pixels by a matrix have been through the lens already, unless it is told otherwise.
            lens = [Belief::fixed(0.0); 3];
        }
        if let Some([k1, k2, _, _, k3]) = self.distortions {
            lens = [k1, k2, k3].map(Belief::fixed);
        }
        let camera = Camera {
            log_focal: focal.mean,
            log_aspect: aspect.mean,
            principal: principal.map(|p| p.mean),
            lens: Lens { k: lens.map(|k| k.mean) },
            insets: Insets::all_around(INSET.mean),
            ..Camera::new(size, 1.0)
        };
        let [k1, k2, k3] = lens;
        let beliefs = Beliefs {
            intrinsic: [focal, aspect, principal[0], principal[1], k1, k2, k3],
            clock: [Belief::fixed(0.0); 2],
            centred: self.matrix.is_none() && self.principal.is_none(),
            insets: InsetBeliefs::all_around(INSET),
            posed: false,
        };
        (camera, beliefs)
    }

    /// Whether every number can be one of a camera.
    ///
    /// # Errors
    /// [`Error::Argument`] otherwise.
    pub(in crate::network) fn check(&self) -> Result<()> {
        let refuse = |name, value: String, expected| Err(Error::Argument { name, value, expected });
        if let Some(m) = self.matrix {
            let last = m.m31 == 0.0 && m.m32 == 0.0 && (m.m33 - 1.0).abs() < 1e-9 && m.m21 == 0.0;
            let usable = m.iter().all(|v| v.is_finite()) && m.m11 > 0.0 && m.m22 > 0.0 && last;
            if !usable {
                return refuse(
                    "matrix",
                    format!("{m:?}"),
                    "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]], finite, without skew",
                );
            }
        }
        if let Some(d) = self.distortions
            && !(d.iter().all(|v| v.is_finite()) && d[2].abs() < TANGENTIAL && d[3].abs() < TANGENTIAL)
        {
            return refuse(
                "distortions",
                format!("{d:?}"),
                "k1 k2 p1 p2 k3, finite, the tangential p1 and p2 near 0",
            );
        }
        if let Some((pixels, deviation)) = self.focal
            && !(pixels > 0.0 && pixels.is_finite() && deviation > 0.0 && deviation.is_finite())
        {
            return refuse(
                "focal",
                format!("{pixels} +- {deviation}"),
                "positive pixels, and a positive deviation",
            );
        }
        if let Some(point) = self.principal
            && !point.iter().all(|v| v.is_finite())
        {
            return refuse("principal", format!("{point:?}"), "two finite pixels");
        }
        if let Aspect::Known(ratio) = self.aspect
            && !(ratio > 0.5 && ratio < 2.0)
        {
            return refuse("aspect", ratio.to_string(), "fy / fx between 0.5 and 2");
        }
        Ok(())
    }
}
