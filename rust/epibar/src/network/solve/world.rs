//! The world of a network: z up, the floor at 0 where figures stand on one, and its unit.
//!
//! Epipolar geometry knows neither vertical nor scale. Where things that move stand on one plane, that plane is taken for the
//! floor and its normal for up; otherwise up is the mean of the cameras' own, which are mostly held level. The unit is the
//! distance between the first two cameras that stand.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::relocate::Placed;
use crate::geometry::across::across;
use crate::network::model::camera::Camera;
use crate::network::observations::evenly::evenly;
use crate::network::observations::figures;
use crate::network::observations::floor::Floor;
use crate::network::observations::survey::Survey;
use crate::network::thresholds as limits;

/// Where the vertical of a network comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Ground {
    /// From the floor that figures stand on: z = 0 is that floor.
    #[non_exhaustive]
    Floor {
        /// Median height of the figures, in the unit of the network.
        height: f64,
        /// Standard error of its vertical, radians.
        vertical_error: f64,
        /// Standard error of its level where the figures stand, in the unit of the network.
        level_error: f64,
        /// Figures that it rests on.
        figures: usize,
        /// Robust standard deviation of the figures' heights over their median.
        diversity: f64,
        /// Median breadth of the figures over their height; `None` where all are seen from straight above.
        breadth: Option<f64>,
    },
    /// From how the cameras are held: z = 0 is the mean height of the cameras.
    Cameras,
}

impl Ground {
    /// A word for programs.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Floor { .. } => "floor",
            Self::Cameras => "cameras",
        }
    }
}

/// Figures looked at of all pairs.
const FIGURES: usize = 4000;

/// Where a figure stands, as two cameras see it.
#[derive(Debug, Clone, Copy)]
pub struct Bottom {
    /// Index of camera A.
    pub a: usize,
    /// Index of camera B.
    pub b: usize,
    /// Raw pixels in A and in B.
    pub pixels: [[f64; 2]; 2],
    /// In the network.
    pub place: Vector3<f64>,
}

/// A floor, and the bottoms of figures on it.
#[derive(Debug, Clone)]
pub struct FloorFound {
    /// The floor.
    pub floor: Floor,
    /// The bottoms of those that stand on it.
    pub bottoms: Vec<Bottom>,
}

/// The floor under a network's figures; `None` where they stand on none.
pub fn floor(survey: &Survey, network: &Placed, radius: f64) -> Option<FloorFound> {
    let pairs = network.pairs();
    let most = (FIGURES / pairs.len().max(1)).max(20);
    let (mut upright, mut bottoms) = (Vec::new(), Vec::new());
    for found in survey.figures(&network.cameras, &pairs, radius) {
        let (a, b) = (&network.cameras[found.a], &network.cameras[found.b]);
        for figure in evenly(found.figures.len(), most).map(|k| &found.figures[k]) {
            let Some(seen) = figures::upright(a, b, figure) else { continue };
            bottoms.push(Bottom { a: found.a, b: found.b, pixels: figure.bottom, place: seen.bottom });
            upright.push(seen);
        }
    }
    let floor = Floor::of(&upright)?;
    bottoms.retain(|b| (floor.up.dot(&b.place) - floor.level).abs() < limits::ON_FLOOR * floor.height);
    (floor.unevenness < limits::FLOOR_UNEVEN && floor.lean < limits::FLOOR_LEANING)
        .then_some(FloorFound { floor, bottoms })
}

/// Cameras in a world of their own.
pub struct World {
    /// The cameras.
    pub cameras: Vec<Camera>,
    /// Where its vertical comes from.
    pub ground: Ground,
    /// From the axes of the network before to its own.
    pub turn: Rotation3<f64>,
    /// Its unit in that of the network before.
    pub unit: f64,
}

/// Cameras in a world with z up, the first that stands over the origin and the second towards x, one unit from it.
///
/// `[vertical, level]` are standard errors of the floor since cameras are wrong, radians and the unit of the network.
pub fn placed(network: &Placed, floor: Option<&Floor>, [vertical, level_by_cameras]: [f64; 2]) -> World {
    let stand: Vec<usize> = (0..network.cameras.len()).filter(|&c| network.placed[c]).collect();
    let of = |c: usize| &network.cameras[stand[c]];
    let up = floor.map_or_else(
        || {
            let own = |&c: &usize| network.cameras[c].rotation.inverse() * -Vector3::y();
            stand.iter().map(own).sum::<Vector3<f64>>().try_normalize(1e-9).unwrap_or_else(Vector3::z)
        },
        |floor| floor.up,
    );
    let first = of(0).position;
    let between = if stand.len() > 1 { of(1).position - first } else { Vector3::x() };
    let unit = between.norm();
    // Horizontally towards the second camera; anywhere, if that is straight above.
    let ahead = between - up * up.dot(&between);
    let ahead = ahead.try_normalize(1e-6 * unit).unwrap_or_else(|| across(&up)[0]);
    let side = up.cross(&ahead);
    let turn = Rotation3::from_matrix_unchecked(Matrix3::from_rows(&[
        ahead.transpose(),
        side.transpose(),
        up.transpose(),
    ]));
    let level = match floor {
        Some(floor) => floor.level,
        None => stand.iter().map(|&c| up.dot(&network.cameras[c].position)).sum::<f64>() / stand.len() as f64,
    };
    let origin = first - up * (up.dot(&first) - level);
    let cameras = network
        .cameras
        .iter()
        .map(|c| Camera {
            rotation: c.rotation * turn.inverse(),
            position: turn * (c.position - origin) / unit,
            ..*c
        })
        .collect();
    let ground = floor.map_or(Ground::Cameras, |floor| Ground::Floor {
        height: floor.height / unit,
        vertical_error: floor.vertical_error.hypot(vertical),
        level_error: floor.level_error.hypot(level_by_cameras) / unit,
        figures: floor.figures,
        diversity: floor.diversity,
        breadth: floor.breadth,
    });
    World { cameras, ground, turn, unit }
}
