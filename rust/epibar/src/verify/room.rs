//! Does what moves fill a room?
//!
//! On one path, in one plane or on the floor what moves keeps to a slab, in which `F` is known, and beside which there is room where nothing says how it goes on. Where
//! the lower edges lie all over an area and the upper ones clearly off the plane of these, what moves has the depth of a room, in which `F`
//! is known; how it goes on beyond is of no use to anybody. So it is asked how far most bottoms lie from any straight line, image by image, and how far tops
//! lie from where the plane of the bottoms would have them. Whoever walks is on the floor, so the first asks nothing of the geometry, and the second knows it.

use super::plane::Plane;
use super::thresholds::{MIN_POINTS, smaller};
use crate::frontier::{Class, TangentMatch};
use crate::geometry::Fundamental;
use crate::image::ImageSize;

/// Share of the bottoms that must be near a line for them to lie on it.
const SHARE: f64 = 0.8;
/// Points between which lines are drawn.
const ENDS: usize = 40;
/// Most points looked at.
const POINTS: usize = 1500;
/// Heights are told in widths of a silhouette, and in these of one that is less, pixels of a 640×480 image: what lies off the floor must be clear beside what
/// outlines are off.
const LEAST_WIDTH: f64 = 30.0;

/// How far what moves goes to all sides, in widths of a silhouette.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Room {
    /// How far four fifths of the bottoms lie from any straight line, in the image in which that is less.
    pub area: f64,
    /// How far the tops lie from the plane of the bottoms, the median of those that do not meet by chance, the mean of both images; of narrow
    /// silhouettes in units of [`LEAST_WIDTH`].
    pub height: f64,
}

impl Room {
    const UNKNOWN: Self = Self { area: f64::NAN, height: f64::NAN };

    /// By the tangents that meet, of which a share meets as it would by chance, between images of some sizes whose median silhouettes have some
    /// widths, pixels; NaN where there are too few to tell.
    pub fn new(
        of: &Fundamental,
        matches: &[TangentMatch],
        by_chance: f64,
        sizes: [ImageSize; 2],
        widths: [f64; 2],
    ) -> Self {
        let class = |class: Class| move |p: &&TangentMatch| p.class == class;
        let bottoms = || matches.iter().filter(class(Class::Bottom));
        let tops = || matches.iter().filter(class(Class::Top));
        let few = bottoms().count() < MIN_POINTS || tops().count() < MIN_POINTS;
        if few || by_chance.is_nan() || !widths.iter().all(|width| *width > 0.0) {
            return Self::UNKNOWN;
        }
        let in_a = off_lines(bottoms().map(|p| p.a)) / widths[0];
        let in_b = off_lines(bottoms().map(|p| p.b)) / widths[1];
        let Some(floor) = Plane::new(of, bottoms(), sizes) else { return Self::UNKNOWN };
        let least = LEAST_WIDTH * ImageSize::pixel_scale(sizes);
        let unit = [0, 1].map(|k| 0.5 * sizes[k].diagonal() / widths[k].max(least));
        let off_floor = |p: &TangentMatch| {
            let [in_a, in_b] = floor.distances(p);
            0.5 * (unit[0] * in_a + unit[1] * in_b)
        };
        let mut heights: Vec<f64> = tops().map(off_floor).collect();
        let middle = 0.5 * (1.0 - by_chance).clamp(0.0, 1.0) * (heights.len() - 1) as f64;
        let (_, height, _) = heights.select_nth_unstable_by(middle as usize, f64::total_cmp);
        Self { area: smaller(in_a, in_b), height: *height }
    }
}

/// How far [`SHARE`] of some points lie from the line that keeps closest to them, of those through two of them.
fn off_lines(points: impl Iterator<Item = [f64; 2]>) -> f64 {
    let points: Vec<[f64; 2]> = points.collect();
    let some: Vec<[f64; 2]> = points.iter().step_by(points.len().div_ceil(POINTS)).copied().collect();
    let ends: Vec<[f64; 2]> = points.iter().step_by(points.len().div_ceil(ENDS)).copied().collect();
    let off = |p: &[f64; 2], q: &[f64; 2]| {
        let (x, y) = (q[0] - p[0], q[1] - p[1]);
        let length = x.hypot(y);
        let mut off: Vec<f64> =
            some.iter().map(|r| (x * (r[1] - p[1]) - y * (r[0] - p[0])).abs() / length).collect();
        let at = ((SHARE * off.len() as f64) as usize).min(off.len() - 1);
        *off.select_nth_unstable_by(at, f64::total_cmp).1
    };
    let lines = ends.iter().enumerate().flat_map(|(k, p)| ends[k + 1..].iter().map(move |q| (p, q)));
    // At one place all lie on any line.
    lines.filter(|(p, q)| p != q).map(|(p, q)| off(p, q)).reduce(f64::min).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frontier::CommonFrame;
    use crate::random::generator;
    use nalgebra::{Matrix3, Rotation3, Vector3};
    use rand::RngExt;

    const FOCAL: f64 = 600.0;

    fn sizes() -> [ImageSize; 2] {
        [ImageSize::new(640, 480).unwrap(); 2]
    }

    /// Two cameras 10 m from the middle of a floor, 3 m above it, a third of a turn apart: `X_c = R (X - C)`, z up.
    fn cameras() -> [(Rotation3<f64>, Vector3<f64>); 2] {
        [0.0_f64, 2.1].map(|turn| {
            let centre = Vector3::new(10.0 * turn.cos(), 10.0 * turn.sin(), 3.0);
            let forward = (Vector3::new(0.0, 0.0, 0.8) - centre).normalize();
            let right = forward.cross(&Vector3::z()).normalize();
            let rows = [right, forward.cross(&right), forward].map(|row| row.transpose());
            (Rotation3::from_matrix_unchecked(Matrix3::from_rows(&rows)), centre)
        })
    }

    fn seen((rotation, centre): &(Rotation3<f64>, Vector3<f64>), at: &Vector3<f64>) -> [f64; 2] {
        let p = rotation * (at - centre);
        [FOCAL * p.x / p.z + 319.5, FOCAL * p.y / p.z + 239.5]
    }

    fn geometry() -> Fundamental {
        let [a, b] = cameras();
        let rotation = (b.0 * a.0.inverse()).into_inner();
        let essential = (b.0 * (a.1 - b.1)).cross_matrix() * rotation;
        let inverse =
            Matrix3::new(FOCAL, 0.0, 319.5, 0.0, FOCAL, 239.5, 0.0, 0.0, 1.0).try_inverse().unwrap();
        Fundamental::from_matrix(&(inverse.transpose() * essential * inverse), sizes()[0], sizes()[1])
            .unwrap()
    }

    /// Of figures on an area, metres, tops so high above the bottoms, some of them at any other place in B; half a metre is 30 pixels wide.
    fn room(area: [f64; 2], height: f64, by_chance: f64) -> Room {
        let (mut random, [a, b]) = (generator(5, 0), cameras());
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let mut matches = Vec::new();
        for k in 0..600 {
            let at = Vector3::new(between(-0.5, 0.5) * area[0], between(-0.5, 0.5) * area[1], 0.0);
            let chance = between(0.0, 1.0) < by_chance;
            for (class, z) in [(Class::Bottom, 0.0), (Class::Top, height)] {
                let at = at + Vector3::z() * z;
                let (in_a, mut in_b) = (seen(&a, &at), seen(&b, &at));
                if chance && class == Class::Top {
                    in_b = [between(0.0, 640.0), between(0.0, 480.0)];
                }
                let frame = CommonFrame(k);
                matches.push(TangentMatch { frame, a: in_a, b: in_b, distance: 0.0, surprise: 1.0, class });
            }
        }
        Room::new(&geometry(), &matches, by_chance, sizes(), [30.0; 2])
    }

    #[test]
    fn walkers_all_over_a_floor_fill_a_room() {
        let Room { area, height } = room([6.0, 6.0], 1.75, 0.0);
        assert!(area > 1.0 && height > 2.0, "{area} {height}");
        // Tops that meet by chance say nothing of how high the others are.
        let of_chance = room([6.0, 6.0], 1.75, 0.6);
        assert!(of_chance.height > 2.0, "{of_chance:?}");
    }

    #[test]
    fn a_path_and_a_bare_floor_do_not() {
        for area in [[8.0, 0.8], [0.8, 8.0]] {
            let path = room(area, 1.75, 0.0);
            assert!(path.area < 0.75 && path.height > 0.5, "{path:?}");
        }
        for by_chance in [0.0, 0.6] {
            let floor = room([6.0, 6.0], 0.02, by_chance);
            assert!(floor.area > 1.0 && floor.height < 0.2, "{floor:?}");
        }
        assert_eq!(off_lines([[3.0, 4.0]; 50].into_iter()), 0.0);
    }

    #[test]
    fn what_cannot_be_told_is_no_number() {
        let [a, b] = [[1.0, 2.0], [3.0, 4.0]];
        let few =
            vec![
                TangentMatch { frame: CommonFrame(0), a, b, distance: 0.0, surprise: 1.0, class: Class::Top };
                50
            ];
        let of = |matches: &[TangentMatch], by_chance, width| {
            Room::new(&geometry(), matches, by_chance, sizes(), [30.0, width])
        };
        let mut both = few.clone();
        both.extend(few.iter().map(|p| TangentMatch { class: Class::Bottom, ..*p }));
        for unknown in [of(&few, 0.0, 30.0), of(&both, f64::NAN, 30.0), of(&both, 0.0, 0.0)] {
            assert!(unknown.area.is_nan() && unknown.height.is_nan(), "{unknown:?}");
        }
    }
}
