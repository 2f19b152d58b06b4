//! Where all that moves keeps to one plane, is it the same plane to all pairs?
//!
//! Two cameras that see a plane are related by a homography, and two poses, each with a plane of its own, give the same one (Faugeras and
//! Lustman 1988). So a network may fit in which some cameras stand where the other pose puts them. What a pair of them sees keeps to a
//! plane all the same, and to another one than what the other pairs see.

use nalgebra::Vector3;
use rand::RngExt;

use crate::geometry::median::{median, quantile};
use crate::network::model::camera::Camera;
use crate::network::model::joint::PairMeetings;
use crate::network::model::residual::Meeting;
use crate::network::observations::evenly::evenly;
use crate::network::observations::figures::triangulated;
use crate::network::solve::settle::Settled;
use crate::network::thresholds as limits;
use crate::random::Stream;

/// Points that are looked at of each pair.
const POINTS: usize = 200;
/// Pairs whose planes are held against what all others see.
const MOST_PLANES: usize = 40;
/// The share of what a pair sees that is near its plane: of walkers either bottoms or tops may be half and more.
const MOST: f64 = 0.8;
/// Planes through three of them that are tried.
const PLANES: usize = 300;

/// A plane through a point.
#[derive(Clone, Copy)]
struct WorldPlane {
    normal: Vector3<f64>,
    through: Vector3<f64>,
}

impl WorldPlane {
    /// How far from what one camera sees the other would see it, did it lie in the plane, pixels; a great deal where that is nowhere.
    fn misses(&self, from: &Camera, to: &Camera, [seen, other]: [[f64; 2]; 2]) -> f64 {
        let on = from.ray(seen).and_then(|ray| {
            let along = self.normal.dot(&(self.through - from.position)) / self.normal.dot(&ray);
            (along > 0.0).then(|| from.position + ray * along)
        });
        let there = on.and_then(|on| to.project(&on));
        there.map_or(f64::MAX, |[x, y]| (x - other[0]).hypot(y - other[1]))
    }

    /// How near most of some points are; `None` of none, or where one is nowhere.
    fn off(&self, points: &[Vector3<f64>]) -> Option<f64> {
        quantile(points.iter().map(|x| self.normal.dot(&(x - self.through)).abs()), MOST)
    }
}

/// What a pair sees.
pub struct Seen {
    cameras: [usize; 2],
    points: Vec<Vector3<f64>>,
    /// How far half of them are from their middle.
    extent: f64,
    /// Of the planes through three of them the one that most are nearest to.
    plane: WorldPlane,
    /// How near, over the extent.
    thickness: f64,
}

/// The camera with most of those of some pairs that see another plane than the others do, where what most of them see keeps to one.
pub fn off_plane(settled: &Settled, placed: &[bool], confirmed: &[(usize, usize)]) -> Option<usize> {
    let stand = settled.of_confirmed(placed, confirmed);
    let pairs: Vec<Seen> = stand.filter_map(|p| Seen::of(settled, p)).collect();
    if median(pairs.iter().map(|p| p.thickness))? >= limits::PLANAR {
        return None;
    }
    // By the plane of one pair after the other: how many others see another one, whichever camera were taken out.
    let mut blamed: Option<(usize, usize, usize)> = None;
    for k in evenly(pairs.len(), MOST_PLANES) {
        let is_off = |p: &&Seen| {
            let off = pairs[k].plane.off(&p.points).map_or(f64::INFINITY, |off| off / p.extent);
            let turned = pairs[k].plane.normal.cross(&p.plane.normal).norm().min(1.0).asin();
            off > limits::PLANES_APART
                && off > limits::PLANES_DIFFER * p.thickness
                && turned > limits::PLANES_TURNED
        };
        let off: Vec<[usize; 2]> = pairs.iter().filter(is_off).map(|p| p.cameras).collect();
        for camera in (0..placed.len()).filter(|&c| placed[c]) {
            let left = off.iter().filter(|cameras| !cameras.contains(&camera)).count();
            if blamed.is_none_or(|b| (left, off.len()) < (b.0, b.1)) {
                blamed = Some((left, off.len(), camera));
            }
        }
    }
    blamed.filter(|(_, off, _)| *off > 0).map(|(.., camera)| camera)
}

impl Seen {
    /// `None` where a pair sees little.
    pub fn of(settled: &Settled, pair: &PairMeetings) -> Option<Self> {
        let (a, b) = (&settled.cameras[pair.a], &settled.cameras[pair.b]);
        let some = evenly(pair.meetings.len(), POINTS).map(|k| &pair.meetings[k]);
        let points: Vec<_> = some.filter_map(|m| triangulated(a, b, [m.a, m.b])).collect();
        if points.len() < limits::LEAST_MEETINGS {
            return None;
        }
        let middle = |k: usize| median(points.iter().map(|p| p[k]));
        let middle = Vector3::new(middle(0)?, middle(1)?, middle(2)?);
        let extent = median(points.iter().map(|p| (p - middle).norm()))?;
        let mut rng = Stream::PlanesOfPairs.generator(0, 0);
        let mut best: Option<(f64, WorldPlane)> = None;
        for _ in 0..PLANES {
            let [p, q, r] = std::array::from_fn(|_| points[rng.random_range(0..points.len())]);
            let normal = (q - p).cross(&(r - p)).try_normalize(1e-3 * extent * extent);
            let Some(plane) = normal.map(|normal| WorldPlane { normal, through: p }) else { continue };
            let off = plane.off(&points)?;
            if best.is_none_or(|b| off < b.0) {
                best = Some((off, plane));
            }
        }
        let (off, plane) = best?;
        Some(Self { cameras: [pair.a, pair.b], points, extent, plane, thickness: off / extent })
    }

    /// How near to where the plane would have it most of what meets in the pair is seen, pixels: in the camera in which that is more.
    pub fn relief(&self, pair: &PairMeetings, [a, b]: [&Camera; 2]) -> f64 {
        let most = |misses: &dyn Fn(&Meeting) -> f64| quantile(pair.meetings.iter().map(misses), MOST);
        let in_b = most(&|m| self.plane.misses(a, b, [m.a, m.b]));
        let in_a = most(&|m| self.plane.misses(b, a, [m.b, m.a]));
        in_a.zip(in_b).map_or(f64::INFINITY, |(a, b)| a.max(b))
    }
}

#[cfg(test)]
pub(in crate::network) mod tests {
    use super::*;
    use crate::network::solve::settle::tests::seen;

    /// What four cameras see of a plane through the origin; the last is taken to look at another one.
    pub fn of_plane(other: bool) -> Settled {
        let mut settled = seen([0.0; 4]);
        let cameras = settled.cameras.clone();
        for pair in &mut settled.pairs {
            let tilted = if other && pair.b == 3 { -0.8 } else { 0.5 };
            let normal = Vector3::new(tilted, 0.2, 1.0).normalize();
            pair.meetings.retain_mut(|m| {
                let (a, b) = (&cameras[pair.a], &cameras[pair.b]);
                let Some(ray) = a.ray(m.a) else { return false };
                let on = a.position - ray * (normal.dot(&a.position) / normal.dot(&ray));
                m.b = b.project(&on).unwrap_or([f64::NAN; 2]);
                on.norm() < 3.0 && m.b[0].is_finite()
            });
        }
        settled
    }

    #[test]
    fn a_camera_that_sees_another_plane_is_named() {
        let all = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
        assert_eq!(off_plane(&of_plane(false), &[true; 4], &all), None);
        assert_eq!(off_plane(&of_plane(true), &[true; 4], &all), Some(3));
        assert_eq!(off_plane(&of_plane(true), &[true, true, true, false], &all), None);
        assert_eq!(off_plane(&of_plane(true), &[true; 4], &[(0, 1), (0, 2), (1, 2)]), None);
    }

    #[test]
    fn what_has_depth_keeps_to_no_plane() {
        let all = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
        assert_eq!(off_plane(&seen([0.3; 4]), &[true; 4], &all), None);
    }
}
