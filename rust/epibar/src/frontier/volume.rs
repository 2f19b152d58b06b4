//! The volume where things moved, as correspondences under a proposed `F`.
//!
//! Without a metric frame a volume is what both images show of it: a spot inside some silhouette of A and, on its
//! epipolar line, a spot inside a silhouette of B. While `F` is searched that is [any silhouette](moving_correspondences), at whatever
//! moment; the pairs then reach beyond the true volume, to depths that nothing had. Once `F` is found, it is one that [met](met_correspondences)
//! that of A at the same moment: by any silhouette a pair that was 0.1 px off was 5.3 px from its rivals, at depths that nobody was at.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rand::RngExt;

use super::matches::{CommonFrame, TangentMatch};
use super::views::{View, Views};
use crate::geometry::hull::{mean_of_three, on_chord};
use crate::geometry::{Fundamental, symmetric_epipolar_distance};
use crate::random::{Generator, Stream};

/// A spot in A and a spot in B on its epipolar line, pixels.
pub type Correspondence = ([f64; 2], [f64; 2]);

/// Silhouettes of B tried for each spot of A.
const TRIES: usize = 12;

fn random_hull<'v>(view: &'v View, random: &mut Generator) -> Option<&'v [[f64; 2]]> {
    if view.frames() == 0 {
        return None;
    }
    let frame = random.random_range(0..view.frames());
    let count = view.hulls_of(frame).count();
    if count == 0 {
        return None;
    }
    view.hulls_of(frame).nth(random.random_range(0..count))
}

/// A random point inside of a hull.
fn inside(hull: &[[f64; 2]], random: &mut Generator) -> [f64; 2] {
    mean_of_three(|| hull[random.random_range(0..hull.len())])
}

/// About `count` correspondences under `f`, drawn by a seed; fewer where its epipolar lines miss what moved in B.
pub fn moving_correspondences(
    views: &Views,
    f: &Fundamental,
    count: usize,
    seed: u64,
) -> Vec<Correspondence> {
    (0..count)
        .filter_map(|k| {
            let mut random = Stream::Points.generator(seed, k as u64);
            let hull = random_hull(&views.a, &mut random)?;
            let a = inside(hull, &mut random);
            let line = f.line_in_b(&Vector3::new(a[0], a[1], 1.0));
            (0..TRIES).find_map(|_| {
                let at = random.random::<f64>();
                on_chord(random_hull(&views.b, &mut random)?, &line, at).map(|b| (a, b))
            })
        })
        .collect()
}

/// Fewest pairs of silhouettes that tell where things moved.
const LEAST_MET: usize = 20;
/// Those that met with both ends tell it by themselves where they are at least this share of all that met.
const SHARE_OF_WHOLE: f64 = 0.25;
/// Most tangents that are looked at, evenly over time.
const MOST_TANGENTS: usize = 8000;

/// About `count` correspondences under `f` inside silhouettes that met, drawn by a seed.
///
/// Where enough silhouettes met with both of their ends these are taken alone, for they hardly ever meet by chance; where next to none met at all,
/// what moved at any moment is taken ([`moving_correspondences`]).
pub fn met_correspondences(
    views: &Views,
    f: &Fundamental,
    matches: &[TangentMatch],
    count: usize,
    seed: u64,
) -> Vec<Correspondence> {
    let mut met = silhouettes_that_met(views, matches);
    let whole = met.iter().filter(|m| m.whole).count();
    if whole >= LEAST_MET && whole as f64 >= SHARE_OF_WHOLE * met.len() as f64 {
        met.retain(|m| m.whole);
    }
    if met.len() < LEAST_MET {
        return moving_correspondences(views, f, count, seed);
    }
    (0..count)
        .filter_map(|k| {
            let mut random = Stream::Met.generator(seed, k as u64);
            (0..TRIES).find_map(|_| {
                let Met { hulls: [of_a, of_b], .. } = met[random.random_range(0..met.len())];
                let a = inside(of_a, &mut random);
                let line = f.line_in_b(&Vector3::new(a[0], a[1], 1.0));
                on_chord(of_b, &line, random.random()).map(|b| (a, b))
            })
        })
        .collect()
}

/// A silhouette of A and one of B that met at the same moment.
struct Met<'v> {
    hulls: [&'v [[f64; 2]]; 2],
    /// With both ends.
    whole: bool,
}

/// All pairs of silhouettes that met, moment by moment.
fn silhouettes_that_met<'v>(views: &'v Views, matches: &[TangentMatch]) -> Vec<Met<'v>> {
    let mut counts: BTreeMap<(CommonFrame, usize, usize), usize> = BTreeMap::new();
    let step = matches.len().div_ceil(MOST_TANGENTS).max(1);
    for p in matches.iter().filter(|p| p.frame.index().is_multiple_of(step)) {
        let frame = p.frame.index();
        let of = |view: &View, vertex: [f64; 2]| view.hulls_of(frame).position(|hull| hull.contains(&vertex));
        if let (Some(a), Some(b)) = (of(&views.a, p.a), of(&views.b, p.b)) {
            *counts.entry((p.frame, a, b)).or_default() += 1;
        }
    }
    let met = |((frame, a, b), count): ((CommonFrame, usize, usize), usize)| {
        let hulls = [views.a.hulls_of(frame.index()).nth(a)?, views.b.hulls_of(frame.index()).nth(b)?];
        Some(Met { hulls, whole: count >= 2 })
    };
    counts.into_iter().filter_map(met).collect()
}

/// Mean symmetric epipolar distance of correspondences under another geometry, pixels.
pub fn disagreement(correspondences: &[Correspondence], other: &Fundamental) -> f64 {
    if correspondences.is_empty() {
        return f64::INFINITY;
    }
    // Capped, so that one spot near an epipole does not decide.
    let sum: f64 =
        correspondences.iter().map(|(a, b)| symmetric_epipolar_distance(other, *a, *b).min(100.0)).sum();
    sum / correspondences.len() as f64
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Matrix4x3, Vector4};

    use super::super::score::Comparer;
    use super::super::symmetric::tests::walkers;
    use super::*;
    use crate::image::ImageSize;

    #[test]
    fn silhouettes_that_met_are_where_things_were_and_any_reach_beyond() {
        let size = ImageSize::new(640, 480).unwrap();
        let camera = Matrix3::new(400.0, 0.0, 320.0, 0.0, 400.0, 240.0, 0.0, 0.0, 1.0);
        let (views, rotation, translation) = walkers(&camera, size);
        let inverse = camera.try_inverse().unwrap();
        let truth = inverse.transpose() * translation.cross_matrix() * rotation.matrix() * inverse;
        let f = Fundamental::from_matrix(&truth, size, size).unwrap();
        let matches = Comparer::new(&views, &f).pair(0, 3.0).weigh(3.0).matches();
        // Walkers are 5 to 10 m before A, and no farther than 2.5 m to either side.
        let outside = |volume: &[Correspondence]| {
            let place = |(a, b): &Correspondence| {
                let [ray_a, ray_b] = [a, b].map(|p| inverse * Vector3::new(p[0], p[1], 1.0));
                // depth_a R ray_a + t = depth_b ray_b
                let columns = [rotation * ray_a, -ray_b, Vector3::zeros()];
                let system = Matrix4x3::from_fn(|row, k| if row < 3 { columns[k][row] } else { 0.0 });
                let known = Vector4::new(-translation.x, -translation.y, -translation.z, 0.0);
                ray_a * system.columns(0, 2).into_owned().svd(true, true).solve(&known, 1e-12).unwrap()[0]
            };
            let far = |p: &Vector3<f64>| !(4.5..10.5).contains(&p.z) || p.x.abs() > 3.0;
            volume.iter().map(place).filter(far).count() as f64 / volume.len() as f64
        };
        let met = met_correspondences(&views, &f, &matches, 300, 1);
        assert!(met.len() > 290 && outside(&met) < 0.02, "{} {}", met.len(), outside(&met));
        assert!(met.iter().all(|(a, b)| symmetric_epipolar_distance(&f, *a, *b) < 1e-6));
        let any = moving_correspondences(&views, &f, 300, 1);
        assert!(outside(&any) > 0.1, "{}", outside(&any));
        // Where nothing met there is no better than that.
        assert_eq!(met_correspondences(&views, &f, &matches[..3], 300, 1), any);
    }
}
