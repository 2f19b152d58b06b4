//! Where upright figures of one height stand, told by one camera alone.
//!
//! A silhouette has its lowest point on the floor and its highest one figure's height above it. Many of them, here and there in
//! the image, tell how the camera is held and how high it hangs, in heights of a figure (F. Lv, T. Zhao and R. Nevatia, *Camera
//! Calibration from Video of a Walking Human*, PAMI 28(9), 2006). A focal length that is not known is the one of a few under
//! which they are most alike, or several of those.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::tracks::{Extremes, extremes};
use crate::frontier::View;
use crate::image::ImageSize;

/// Silhouettes that are asked.
const FIGURES: usize = 400;
/// Least height of one, pixels of a 640×480 image, and fewest of them.
const LEAST_HEIGHT: f64 = 12.0;
const LEAST_FIGURES: usize = 30;
/// Focal lengths that are tried, in widths of the image.
const FOCAL_LENGTHS: [f64; 7] = [0.55, 0.7, 0.9, 1.15, 1.5, 2.0, 2.8];
/// Tilts and rolls that are tried first, degrees, and halvings of the steps between them.
const TILTS: [f64; 3] = [-5.0, 75.0, 5.0];
const ROLLS: [f64; 3] = [-12.0, 12.0, 4.0];
const HALVINGS: usize = 5;
/// A silhouette agrees the more the nearer its top is to where it should be, up to this share of its height.
const AGREES: f64 = 0.15;
/// Where fewer agree than this share of them, they are no figures of one height.
const ALIKE: f64 = 0.08;
/// A focal length goes on of which at least this share of the best one's agree, and most that do.
const NEARLY: f64 = 0.85;
const KEPT: usize = 7;
/// Heights that are tried are so many of a hundred of those that silhouettes give: merged ones give others.
const HEIGHTS: [usize; 5] = [20, 35, 50, 65, 80];
/// Seen from above, the top of a figure is so much farther away than its lowest point, in heights of it: it is no line.
const BODY_DEPTH: f64 = 0.15;
/// A silhouette stands where it is told to if its top is off by no more than this share of its height.
const STANDS: f64 = 0.25;
/// Sine of the angle below the horizon from which on a place of the floor is known.
const BELOW_HORIZON: f64 = 0.02;
/// What is nearer to the camera than this, in heights of a figure, is behind it.
const NEAREST: f64 = 1e-6;

/// A camera over a floor, in heights of a figure: its own foot is the origin, x points to where it looks, z up.
#[derive(Debug, Clone, Copy)]
pub struct SingleView {
    matrix: Matrix3<f64>,
    inverse: Matrix3<f64>,
    /// x, y and z of the floor in the camera, as columns.
    axes: Matrix3<f64>,
    /// Height of the camera.
    height: f64,
}

impl SingleView {
    /// The ways the camera may be held, the likeliest first; none where what it sees are no upright figures of one height.
    /// Without its matrix the principal point is the middle of the image.
    pub fn of(view: &View, matrix: Option<&Matrix3<f64>>) -> Vec<Self> {
        let figures = figures(view);
        if figures.len() < LEAST_FIGURES {
            return Vec::new();
        }
        let matrices = match matrix {
            Some(known) => vec![*known],
            None => FOCAL_LENGTHS.map(|f| camera_matrix(view.size, f)).to_vec(),
        };
        let mut found: Vec<(f64, Self)> =
            matrices.iter().filter_map(|k| Self::held(k, view.up, &figures)).collect();
        found.sort_by(|p, q| q.0.total_cmp(&p.0));
        let least = found.first().map_or(ALIKE, |best| (NEARLY * best.0).max(ALIKE));
        found.into_iter().take_while(|(agree, _)| *agree >= least).take(KEPT).map(|(_, view)| view).collect()
    }

    /// How a camera of this matrix is held, and the share of the figures that agree.
    fn held(matrix: &Matrix3<f64>, up: [f64; 2], figures: &[Extremes]) -> Option<(f64, Self)> {
        let inverse = matrix.try_inverse()?;
        let seen: Vec<UprightSilhouette> =
            figures.iter().map(|figure| UprightSilhouette::new(&inverse, figure)).collect();
        let of = |tilt: f64, roll: f64| {
            let up = direction_of_up(up, tilt, roll);
            Some((at_height(matrix, &inverse, &up, &seen)?, [tilt, roll]))
        };
        let range = |[from, to, step]: [f64; 3]| {
            (0..=((to - from) / step).round() as usize).map(move |k| from + k as f64 * step)
        };
        let tried = range(TILTS).flat_map(|tilt| range(ROLLS).filter_map(move |roll| of(tilt, roll)));
        let less = |p: &((f64, Self), _), q: &((f64, Self), _)| p.0.0.total_cmp(&q.0.0);
        let mut best = tried.max_by(less)?;
        let (mut tilt_step, mut roll_step) = (TILTS[2], ROLLS[2]);
        for _ in 0..HALVINGS {
            (tilt_step, roll_step) = (0.5 * tilt_step, 0.5 * roll_step);
            let [tilt, roll] = best.1;
            let around = [-1.0, 0.0, 1.0].into_iter().flat_map(|i| [-1.0, 0.0, 1.0].map(|j| (i, j)));
            let tried = around.filter_map(|(i, j)| of(tilt + i * tilt_step, roll + j * roll_step));
            best = tried.max_by(less).unwrap_or(best);
        }
        Some(best.0)
    }

    /// Where a silhouette stands on the floor; `None` where it is not a whole figure.
    pub fn place(&self, figure: &Extremes) -> Option<[f64; 2]> {
        let foot = on_floor(&self.inverse, &self.up(), figure[1])? * self.height;
        (self.off(&foot, figure) <= STANDS).then(|| {
            let at = self.axes.tr_mul(&foot);
            [at.x, at.y]
        })
    }

    /// The pixel of a place of the floor; `None` behind the camera.
    pub fn pixel(&self, place: [f64; 2]) -> Option<[f64; 2]> {
        project(&self.matrix, &(self.axes * Vector3::new(place[0], place[1], -self.height)))
    }

    /// Height of the camera.
    pub fn height(&self) -> f64 {
        self.height
    }

    /// Its matrix, inverted.
    pub fn inverse(&self) -> &Matrix3<f64> {
        &self.inverse
    }

    /// x, y and z of the floor in the camera, as columns.
    pub fn axes(&self) -> &Matrix3<f64> {
        &self.axes
    }

    fn up(&self) -> Vector3<f64> {
        self.axes.column(2).into_owned()
    }

    /// How far the top of a figure that stands at `foot` is off, as a share of its height in the image.
    fn off(&self, foot: &Vector3<f64>, [top, bottom]: &Extremes) -> f64 {
        let Some(at) = project(&self.matrix, &(foot + to_top(&self.up(), foot))) else {
            return f64::INFINITY;
        };
        distance(at, *top) / distance(*top, *bottom)
    }
}

/// Whole silhouettes, some of many.
fn figures(view: &View) -> Vec<Extremes> {
    let least = LEAST_HEIGHT * ImageSize::pixel_scale([view.size; 2]);
    let hulls = (0..view.frames()).flat_map(|frame| view.hulls_of(frame));
    let all: Vec<Extremes> = hulls
        .filter_map(|hull| extremes(view, hull))
        .filter(|[top, bottom]| distance(*top, *bottom) >= least)
        .collect();
    let taken = all.len().min(FIGURES);
    (0..taken).map(|k| all[k * all.len() / taken]).collect()
}

fn camera_matrix(size: ImageSize, focal_length: f64) -> Matrix3<f64> {
    let (w, h) = (size.width() as f64, size.height() as f64);
    let f = focal_length * w;
    Matrix3::new(f, 0.0, 0.5 * (w - 1.0), 0.0, f, 0.5 * (h - 1.0), 0.0, 0.0, 1.0)
}

/// Up in the camera that looks down by `tilt` and is turned by `roll`, degrees, from where up is in its image.
fn direction_of_up(up: [f64; 2], tilt: f64, roll: f64) -> Vector3<f64> {
    let level = Rotation3::from_axis_angle(&Vector3::z_axis(), roll.to_radians())
        * Vector3::new(up[0], up[1], 0.0).normalize();
    let (sin, cos) = tilt.to_radians().sin_cos();
    level * cos - Vector3::z() * sin
}

/// The point of the floor that is seen at a pixel from a camera one unit above it.
fn on_floor(inverse: &Matrix3<f64>, up: &Vector3<f64>, pixel: [f64; 2]) -> Option<Vector3<f64>> {
    let ray = inverse * Vector3::new(pixel[0], pixel[1], 1.0);
    floor_along(&ray, ray.norm(), up)
}

/// The point of the floor along a ray of some length from a camera one unit above it.
fn floor_along(ray: &Vector3<f64>, length: f64, up: &Vector3<f64>) -> Option<Vector3<f64>> {
    let below = -up.dot(ray);
    (below > BELOW_HORIZON * length).then(|| ray / below)
}

/// A silhouette as a camera of some matrix sees it, however it is held.
struct UprightSilhouette {
    /// Rays of its highest and its lowest point.
    to_top: Vector3<f64>,
    to_foot: Vector3<f64>,
    /// Length of the latter.
    length: f64,
    /// Its highest point, pixels, and its height, squared.
    top: [f64; 2],
    height_squared: f64,
}

impl UprightSilhouette {
    fn new(inverse: &Matrix3<f64>, &[top, bottom]: &Extremes) -> Self {
        let ray = |pixel: [f64; 2]| inverse * Vector3::new(pixel[0], pixel[1], 1.0);
        let to_foot = ray(bottom);
        let height_squared = distance_squared(top, bottom);
        Self { to_top: ray(top), to_foot, length: to_foot.norm(), top, height_squared }
    }
}

/// A figure that stands on the floor under a camera that is held in some way: a camera at height `h` sees its top at `h · foot + body`.
struct Stands<'s> {
    seen: &'s UprightSilhouette,
    /// Height of the camera, by its top.
    height: f64,
    /// In the image, homogeneous.
    foot: Vector3<f64>,
    body: Vector3<f64>,
}

impl<'s> Stands<'s> {
    /// `None` where it is seen above the horizon, or by no camera above the floor.
    fn new(matrix: &Matrix3<f64>, up: &Vector3<f64>, seen: &'s UprightSilhouette) -> Option<Self> {
        let foot = floor_along(&seen.to_foot, seen.length, up)?;
        let body = to_top(up, &foot);
        // From a foot at h times the point, the ray of the top passes h times that point and one upwards.
        let across = seen.to_top.cross(&foot);
        let height = -seen.to_top.cross(&body).dot(&across) / across.norm_squared();
        let stands = height > 0.0 && height.is_finite();
        stands.then(|| Self { seen, height, foot: matrix * foot, body: matrix * body })
    }

    /// How well it agrees with a camera at that height, 1 at the most.
    fn agrees(&self, height: f64) -> f64 {
        let top = self.foot * height + self.body;
        if top.z <= NEAREST {
            return 0.0;
        }
        let off = distance_squared([top.x / top.z, top.y / top.z], self.seen.top);
        (1.0 - off / (self.seen.height_squared * AGREES * AGREES)).max(0.0)
    }
}

/// The camera at the height at which most figures agree, and their share.
fn at_height(
    matrix: &Matrix3<f64>,
    inverse: &Matrix3<f64>,
    up: &Vector3<f64>,
    figures: &[UprightSilhouette],
) -> Option<(f64, SingleView)> {
    let stand: Vec<Stands> = figures.iter().filter_map(|seen| Stands::new(matrix, up, seen)).collect();
    let mut heights: Vec<f64> = stand.iter().map(|figure| figure.height).collect();
    heights.sort_unstable_by(f64::total_cmp);
    let x = (Vector3::z() - up * up.z).try_normalize(1e-3)?;
    let axes = Matrix3::from_columns(&[x, up.cross(&x), *up]);
    let tried = HEIGHTS.iter().filter_map(|k| {
        let height = *heights.get(k * heights.len() / 100)?;
        let agree = stand.iter().map(|figure| figure.agrees(height)).sum::<f64>() / figures.len() as f64;
        Some((agree, SingleView { matrix: *matrix, inverse: *inverse, axes, height }))
    });
    tried.max_by(|p, q| p.0.total_cmp(&q.0))
}

/// From the lowest point of a figure that stands there to its highest.
fn to_top(up: &Vector3<f64>, foot: &Vector3<f64>) -> Vector3<f64> {
    let away = foot - up * foot.dot(up);
    up + away * (BODY_DEPTH / away.norm().max(1e-9))
}

fn project(matrix: &Matrix3<f64>, point: &Vector3<f64>) -> Option<[f64; 2]> {
    let p = matrix * point;
    (p.z > NEAREST).then(|| [p.x / p.z, p.y / p.z])
}

fn distance(p: [f64; 2], q: [f64; 2]) -> f64 {
    distance_squared(p, q).sqrt()
}

fn distance_squared(p: [f64; 2], q: [f64; 2]) -> f64 {
    (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2)
}
