//! Where all that moves keeps to one plane, is it the same plane to all pairs?
//!
//! Two cameras that see a plane are related by a homography, and two poses, each with a plane of its own, give the same one (Faugeras and
//! Lustman 1988). So a network may fit in which some cameras stand where the other pose puts them. What a pair of them sees keeps to a
//! plane all the same, and to another one than what the other pairs see.

use nalgebra::Vector3;
use rand::RngExt;

use crate::geometry::median::median;
use crate::network::observations::evenly::evenly;
use crate::network::observations::figures::triangulated;
use crate::network::solve::settle::Settled;
use crate::network::thresholds as limits;
use crate::random::generator;

/// Points that are looked at of each pair.
const POINTS: usize = 200;
/// The share of what a pair sees that is near its plane: of walkers either bottoms or tops may be half and more.
const MOST: f64 = 0.8;
/// Planes through three of them that are tried.
const PLANES: usize = 300;

/// What a pair sees.
struct Seen {
    cameras: [usize; 2],
    points: Vec<Vector3<f64>>,
    /// From a plane of their own, as a share of the extent.
    thickness: f64,
}

/// The camera with most of the pairs that see another plane than the others do, where what the pairs see keeps to one.
pub fn off_plane(settled: &Settled, placed: &[bool]) -> Option<usize> {
    let pairs: Vec<Seen> = settled
        .pairs
        .iter()
        .filter(|p| placed[p.a] && placed[p.b])
        .filter_map(|p| {
            let (a, b) = (&settled.cameras[p.a], &settled.cameras[p.b]);
            let some = evenly(p.meetings.len(), POINTS).map(|k| &p.meetings[k]);
            let points: Vec<_> = some.filter_map(|m| triangulated(a, b, [m.a, m.b])).collect();
            let thickness = thinnest(&points, &[&points])?.0;
            Some(Seen { cameras: [p.a, p.b], points, thickness })
        })
        .collect();
    if median(pairs.iter().map(|p| p.thickness))? >= limits::PLANAR {
        return None;
    }
    let points: Vec<&[Vector3<f64>]> = pairs.iter().map(|p| p.points.as_slice()).collect();
    let is_off = |(pair, off): &(&Seen, f64)| {
        *off > limits::PLANES_APART && *off > limits::PLANES_DIFFER * pair.thickness
    };
    // By the plane of each pair in turn: how many others see another one, whichever camera were taken out.
    let planes = points.iter().filter_map(|of_pair| thinnest(of_pair, &points));
    let blamed = planes.flat_map(|(mean, off)| {
        let off: Vec<[usize; 2]> = pairs.iter().zip(off).filter(is_off).map(|(p, _)| p.cameras).collect();
        let left = |c: usize| off.iter().filter(|cameras| !cameras.contains(&c)).count();
        let of_all = (0..placed.len()).filter(|&c| placed[c]);
        of_all.map(|c| (left(c), off.len(), mean, c)).collect::<Vec<_>>()
    });
    let by = |p: &(usize, usize, f64, usize), q: &(usize, usize, f64, usize)| {
        (p.0, p.1).cmp(&(q.0, q.1)).then(p.2.total_cmp(&q.2))
    };
    blamed.min_by(by).filter(|(_, off, ..)| *off > 0).map(|(.., camera)| camera)
}

/// Of the planes through three of some points the one to which what all pairs see is nearest: the mean, and each, of how far most of what a pair
/// sees is from it, over how far half is from its middle. `None` of few.
fn thinnest(from: &[Vector3<f64>], pairs: &[&[Vector3<f64>]]) -> Option<(f64, Vec<f64>)> {
    if from.len() < limits::LEAST_MEETINGS {
        return None;
    }
    let extents: Vec<f64> = pairs.iter().map(|points| extent(points)).collect::<Option<_>>()?;
    let own = extent(from)?;
    let mut rng = generator(11, 0);
    let mut best: Option<(f64, Vec<f64>)> = None;
    for _ in 0..PLANES {
        let [p, q, r] = std::array::from_fn(|_| from[rng.random_range(0..from.len())]);
        let Some(normal) = (q - p).cross(&(r - p)).try_normalize(1e-3 * own * own) else { continue };
        let off = |points: &&[Vector3<f64>]| within(points.iter().map(|x| normal.dot(&(x - p)).abs()));
        let off: Vec<f64> =
            pairs.iter().zip(&extents).map(|(p, extent)| Some(off(p)? / extent)).collect::<Option<_>>()?;
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        if best.as_ref().is_none_or(|b| mean < b.0) {
            best = Some((mean, off));
        }
    }
    best
}

/// Below which most of some numbers are; `None` of none, or where one is no number.
fn within(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    let mut all: Vec<f64> = numbers.collect();
    if all.is_empty() || all.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let most = (MOST * all.len() as f64) as usize;
    Some(*all.select_nth_unstable_by(most, f64::total_cmp).1)
}

/// How far half of some points are from their middle.
fn extent(points: &[Vector3<f64>]) -> Option<f64> {
    let middle = |k: usize| median(points.iter().map(|p| p[k]));
    let middle = Vector3::new(middle(0)?, middle(1)?, middle(2)?);
    median(points.iter().map(|p| (p - middle).norm()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::solve::settle::tests::seen;

    /// What four cameras see of a plane through the origin; the last is taken to look at another one.
    fn of_plane(other: bool) -> Settled {
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
        assert_eq!(off_plane(&of_plane(false), &[true; 4]), None);
        assert_eq!(off_plane(&of_plane(true), &[true; 4]), Some(3));
        assert_eq!(off_plane(&of_plane(true), &[true, true, true, false]), None);
    }

    #[test]
    fn what_has_depth_keeps_to_no_plane() {
        assert_eq!(off_plane(&seen([0.3; 4]), &[true; 4]), None);
    }
}
