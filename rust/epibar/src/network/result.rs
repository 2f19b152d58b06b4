//! What comes out: cameras, pairs and clocks of a network, with a verdict on each.

use nalgebra::{Matrix3, Vector3};

use super::evidence::stated_errors::Expected;
use super::evidence::support::Deviates;
use super::model::camera::Camera;
use super::solve::world::Ground;
use crate::image::ImageSize;

/// Many cameras, calibrated together.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Network {
    /// The cameras, in the order given.
    pub cameras: Vec<NetworkCamera>,
    /// All pairs of cameras `a < b`, in that order.
    pub pairs: Vec<NetworkPair>,
    /// Every camera is accepted.
    pub accepted: bool,
    /// What was found, or what is wrong, in words.
    pub reason: String,
    /// Where the vertical comes from, and the floor.
    pub ground: Ground,
    /// Radius within which tangents met in the end, pixels of a 640×480 image: 4 standard deviations.
    pub radius: f64,
}

/// Why a camera is accepted or not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum CameraStatus {
    /// It can be relied on.
    Accepted,
    /// Nothing tells where it stands: what it sees moves unlike what the others see.
    NothingInCommon,
    /// It agrees with some others, which have nothing in common with the rest.
    Apart,
    /// It sees what the others see only before or only after some moment.
    Knocked,
    /// Its focal length could as well be another.
    FocalLength,
    /// Which way it looks could as well be another.
    Rotation,
    /// Where it stands could as well be elsewhere.
    Position,
    /// Its pairs cannot be told from other geometries.
    Ambiguous,
    /// What moves does not tell its clock, and with that where it stands.
    Clock,
    /// What was given of it is contradicted by what moves.
    Contradicted,
    /// All cameras that it has something in common with stand where it does.
    NoBaseline,
    /// What moves keeps to one plane, which leaves focal lengths open of which nothing is known.
    OnePlane,
    /// Two cameras stand, and the verdict on their pair by itself was no.
    PairRefused,
    /// There are too few cameras, or too little is known of two.
    TooFew,
}

impl CameraStatus {
    /// A word for programs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Accepted => "accepted",
            Self::NothingInCommon => "nothing_in_common",
            Self::Apart => "apart",
            Self::Knocked => "knocked",
            Self::FocalLength => "focal_length",
            Self::Rotation => "rotation",
            Self::Position => "position",
            Self::Ambiguous => "ambiguous",
            Self::Clock => "clock",
            Self::Contradicted => "contradicted",
            Self::NoBaseline => "no_baseline",
            Self::OnePlane => "one_plane",
            Self::PairRefused => "pair_refused",
            Self::TooFew => "too_few",
        }
    }
}

/// A camera of a [`Network`].
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct NetworkCamera {
    /// Its name.
    pub name: String,
    /// Why it is accepted or not.
    pub status: CameraStatus,
    /// What the status says, as a sentence, with the numbers behind it.
    pub reason: String,
    /// Where it stands, with its lens; `None` where that was not found.
    pub(super) camera: Option<Camera>,
    /// Errors to expect; below these nine times in ten.
    pub expected: Option<Expected>,
    /// What speaks for it.
    pub deviates: Deviates,
    /// Size of its image.
    pub size: ImageSize,
    /// Expected error of its clock's offset, seconds, one standard deviation.
    pub offset_error: f64,
}

impl NetworkCamera {
    /// Whether it can be relied on.
    pub fn accepted(&self) -> bool {
        self.status == CameraStatus::Accepted
    }

    /// Whether it stands anywhere, accepted or not.
    pub fn stands(&self) -> bool {
        self.camera.is_some()
    }

    /// The camera matrix, pixels.
    pub fn matrix(&self) -> Option<Matrix3<f64>> {
        self.camera.map(|c| c.matrix())
    }

    /// `k₁ k₂ p₁ p₂ k₃` of `OpenCV`.
    pub fn distortions(&self) -> Option<[f64; 5]> {
        self.camera.map(|c| [c.lens.k[0], c.lens.k[1], 0.0, 0.0, c.lens.k[2]])
    }

    /// How far from the principal point its lens shows anything, pixels of its images; `None` where that is all of them, or it has
    /// no place. The polynomial that fits where things moved may turn back before the corners: no direction is seen beyond, and
    /// what undoes a lens makes nonsense of it.
    pub fn lens_reach(&self) -> Option<f64> {
        self.camera.and_then(|c| c.optics().reach(self.size))
    }

    /// `R` of `X_c = R X + t`, world z up.
    pub fn rotation(&self) -> Option<Matrix3<f64>> {
        self.camera.map(|c| *c.rotation.matrix())
    }

    /// `t` of `X_c = R X + t`, in the network's unit.
    pub fn translation(&self) -> Option<Vector3<f64>> {
        self.camera.map(|c| c.translation())
    }

    /// Where it stands, in the network's unit.
    pub fn position(&self) -> Option<Vector3<f64>> {
        self.camera.map(|c| c.position)
    }

    /// Its clock against that of the first camera: what is at `t` there is at `t + offset + 1e-6 drift t` here; seconds since the
    /// first frame of each, and ppm.
    pub fn clock(&self) -> Option<(f64, f64)> {
        self.camera.map(|c| (c.offset, c.drift))
    }
}

/// What became of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PairStatus {
    /// What moves in both agrees with the network.
    Confirmed,
    /// Too little moves in both to say; its geometry is that of the network.
    Predicted,
    /// By itself it would have another geometry, and was accepted so.
    Contradicts,
    /// Its cameras stand no farther from each other than is known of where they stand: any epipole fits.
    NoBaseline,
    /// One of its cameras is not part of the network.
    Outside,
}

impl PairStatus {
    /// A word for programs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Confirmed => "confirmed",
            Self::Predicted => "predicted",
            Self::Contradicts => "contradicts",
            Self::NoBaseline => "no_baseline",
            Self::Outside => "outside",
        }
    }
}

/// A pair of a [`Network`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct NetworkPair {
    /// Index of camera A.
    pub a: usize,
    /// Index of camera B.
    pub b: usize,
    /// What became of it.
    pub status: PairStatus,
    /// Whether both cameras are accepted, they stand apart, and nothing contradicts.
    pub accepted: bool,
    /// `x_bᵀ F x_a = 0` in undistorted pixels of the cameras' matrices, of norm 1; `None` where one does not stand.
    pub fundamental: Option<Matrix3<f64>>,
    /// What speaks for it.
    pub deviates: Deviates,
}

/// What new footage says of a camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum CheckStatus {
    /// The camera stands and looks as stored.
    Unmoved,
    /// The camera stands or looks otherwise.
    Moved,
    /// This camera or another one stands or looks otherwise, and which is not known.
    Suspect,
    /// Too little moved before it and the others to say.
    Unsure,
}

impl CheckStatus {
    /// A word for programs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unmoved => "unmoved",
            Self::Moved => "moved",
            Self::Suspect => "suspect",
            Self::Unsure => "unsure",
        }
    }
}

/// What new footage says of a camera, in numbers.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct CameraCheck {
    /// Its name.
    pub name: String,
    /// Whether it moved.
    pub status: CheckStatus,
    /// What the status says, as a sentence, with the numbers behind it.
    pub reason: String,
    /// By how much it looks another way, radians; NaN where it is not known.
    pub turned: f64,
    /// Below this, nine times in ten, is the error of that, radians.
    pub turned_error: f64,
    /// How far it stands from where it stood, unit of the network.
    pub shifted: f64,
    /// Below this, nine times in ten, is the error of that.
    pub shifted_error: f64,
    /// Relative change of the focal length.
    pub focal: f64,
    /// Below this, nine times in ten, is the error of that.
    pub focal_error: f64,
    /// What it has in common with the others on this footage, as a normal deviate.
    pub deviate: f64,
    /// When it moved, seconds since its first frame; `None` where it did not, or before.
    pub since: Option<f64>,
    /// Where it stands now; `None` where it did not move, or where two cameras that stand do not confirm it.
    pub place: Option<Place>,
    /// Of a suspect the others, by index: one of them moved, or this one.
    pub rivals: Vec<usize>,
}

/// Where a camera that moved stands now.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Place {
    /// The camera matrix, pixels.
    pub matrix: Matrix3<f64>,
    /// `R` of `X_c = R X + t`.
    pub rotation: Matrix3<f64>,
    /// `t` of `X_c = R X + t`, unit of the network.
    pub translation: Vector3<f64>,
    /// Whether the focal length is another one.
    pub zoomed: bool,
    /// Whether rotation and position were solved for.
    pub reposed: bool,
    /// Errors to expect, with the cameras that did not move where they are stored; 0 of what was not solved for.
    pub expected: Expected,
    /// The other cameras that were looked at, by index, and what speaks for the pair.
    pub pairs: Vec<(usize, Deviates)>,
}

/// `F` of two cameras in undistorted pixels, of norm 1.
pub(super) fn fundamental(a: &Camera, b: &Camera) -> Option<Matrix3<f64>> {
    let baseline = b.rotation * (a.position - b.position);
    let essential = baseline.cross_matrix() * (b.rotation * a.rotation.inverse()).matrix();
    let f = b.matrix().try_inverse()?.transpose() * essential * a.matrix().try_inverse()?;
    let norm = f.norm();
    (norm > 0.0 && norm.is_finite()).then(|| f / norm)
}
