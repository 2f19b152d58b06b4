//! The score of a geometry, both cameras' tangents taken in turn, at the radius that suits the masks.

use super::score::{Comparer, Paired};
use super::views::Views;
use crate::geometry::Fundamental;

/// Radii, in pixels of a 640×480 image, at which tangents are weighed.
const RADII: [f64; 4] = [1.5, 3.0, 6.0, 10.0];
/// The one within which matches tell the sign of the map of rays.
const SIGN_RADIUS: f64 = RADII[2];

/// Score of an `F` at one radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SymmetricScore {
    /// Mean of the score from A to B and from B to A.
    pub total: f64,
    /// The radius, pixels.
    pub radius: f64,
}

/// Comparisons from A to B and from B to A, one after the other, so that they share their buffers.
fn both_ways<T>(views: &Views, f: &Fundamental, of: impl Fn(&mut Comparer) -> T) -> (T, T) {
    let mut comparer = Comparer::new(views, f);
    let there = of(&mut comparer);
    (there, of(&mut comparer.turned_round(views, f)))
}

/// The score at the radius that gives most: masks are clean or coarse, and the best radius is theirs.
pub fn symmetric_score(views: &Views, f: &Fundamental) -> SymmetricScore {
    let (there, back) = at_all_radii(views, f, |paired, radius| paired.weigh(radius).total());
    best_radius(views, there, back).1
}

/// [`symmetric_score`] with the evidence of each frame at its radius, which sums to its total.
pub fn symmetric_score_by_frame(views: &Views, f: &Fundamental) -> (SymmetricScore, Vec<f64>) {
    let (there, back) = at_all_radii(views, f, |paired, radius| {
        let weighed = paired.weigh(radius);
        (weighed.total(), weighed.per_frame())
    });
    let (k, score) = best_radius(views, there.each_ref().map(|way| way.0), back.each_ref().map(|way| way.0));
    (score, there[k].1.iter().zip(&back[k].1).map(|(p, q)| 0.5 * (p + q)).collect())
}

/// What is asked of the tangents that are paired at each of the [`RADII`], from A to B and back.
fn at_all_radii<T>(views: &Views, f: &Fundamental, of: impl Fn(&mut Paired, f64) -> T) -> ([T; 4], [T; 4]) {
    let scale = views.pixel_scale();
    both_ways(views, f, |comparer| {
        let mut paired = comparer.pair(0, SIGN_RADIUS * scale);
        RADII.map(|radius| of(&mut paired, radius * scale))
    })
}

/// The radius that gives most, by its place among the [`RADII`], and the score there.
fn best_radius(views: &Views, there: [f64; 4], back: [f64; 4]) -> (usize, SymmetricScore) {
    let scale = views.pixel_scale();
    let mut best = (0, SymmetricScore { total: f64::NEG_INFINITY, radius: RADII[0] * scale });
    for (k, radius) in RADII.into_iter().enumerate() {
        let total = 0.5 * (there[k] + back[k]);
        if total > best.1.total {
            best = (k, SymmetricScore { total, radius: radius * scale });
        }
    }
    best
}

/// Shifts of the clocks that tell what the score is by chance.
const CHANCE_SHIFTS: usize = 5;

/// Shifts that are even parts of the recording.
fn chance_shifts(frames: usize) -> [usize; CHANCE_SHIFTS] {
    std::array::from_fn(|k| (k + 1) * frames / (CHANCE_SHIFTS + 1))
}

/// Mean score at `radius` with the clocks shifted, from A to B and from B to A, not below nought.
///
/// The score's own model of chance takes moments as independent; where the same places are busy all the time
/// a wrong geometry may beat it, and does so at every shift.
pub fn chance_level(views: &Views, f: &Fundamental, radius: f64) -> f64 {
    let shifts = chance_shifts(views.frames());
    let (there, back) = both_ways(views, f, |comparer| {
        shifts.iter().map(|&shift| comparer.pair(shift, radius).weigh(radius).total()).sum::<f64>()
    });
    (0.5 * (there + back) / CHANCE_SHIFTS as f64).max(0.0)
}

/// Scores of tops and of bottoms, the mean of both ways, less those of chance where positive, at the radius that suits the
/// masks.
pub fn class_scores(views: &Views, f: &Fundamental) -> [f64; 2] {
    let radius = symmetric_score(views, f).radius;
    let (there, back) = both_ways(views, f, |comparer| {
        let mut at = |shift: usize, sign_radius: f64| {
            let score = comparer.pair(shift, sign_radius).weigh(radius).score();
            [score.tops.excess, score.bottoms.excess]
        };
        let own = at(0, SIGN_RADIUS * views.pixel_scale());
        let chance = chance_shifts(views.frames()).map(|shift| at(shift, radius));
        [0, 1].map(|k| own[k] - (chance.iter().map(|c| c[k]).sum::<f64>() / CHANCE_SHIFTS as f64).max(0.0))
    });
    [0, 1].map(|class| 0.5 * (there[class] + back[class]))
}

#[cfg(test)]
pub(crate) mod tests {
    use nalgebra::{Matrix3, Rotation3, Vector3};
    use rand::RngExt;

    use super::*;
    use crate::frontier::views::View;
    use crate::image::ImageSize;
    use crate::random::generator;
    use crate::recording::FramePair;

    /// Walkers 1.7 m tall on a floor 3 m below two cameras; returns the views, the rotation and the translation from A to B.
    pub(crate) fn walkers(camera: &Matrix3<f64>, size: ImageSize) -> (Views, Rotation3<f64>, Vector3<f64>) {
        let rotation = Rotation3::from_euler_angles(0.0, -1.2, 0.0);
        let translation = Vector3::new(6.0, 0.0, 5.0);
        let mut random = generator(5, 0);
        let mut frames: [Vec<Vec<Vec<[f64; 2]>>>; 2] = [Vec::new(), Vec::new()];
        for _ in 0..200 {
            let mut seen: [Vec<Vec<[f64; 2]>>; 2] = [Vec::new(), Vec::new()];
            for _ in 0..3 {
                let foot = Vector3::new(random.random_range(-2.5..2.5), 3.0, random.random_range(5.0..10.0));
                for (view, hulls) in seen.iter_mut().enumerate() {
                    let pixel = |up: f64| {
                        let world = foot - Vector3::new(0.0, up, 0.0);
                        let p = camera * if view == 0 { world } else { rotation * world + translation };
                        [p.x / p.z, p.y / p.z]
                    };
                    let ([x, low], [_, middle], [_, high]) = (pixel(0.0), pixel(0.9), pixel(1.7));
                    let half = 0.15 * (low - high);
                    hulls.push(vec![[x, high], [x + half, middle], [x, low], [x - half, middle]]);
                }
            }
            for (all, seen) in frames.iter_mut().zip(seen) {
                all.push(seen);
            }
        }
        let [a, b] = frames.map(|frames| View::made_up(size, &frames));
        let views = Views::of(a, b, (0..200).map(|k| FramePair::new(k, k)).collect());
        (views, rotation, translation)
    }

    #[test]
    fn the_floor_with_a_wrong_epipole_has_one_class_alone() {
        let size = ImageSize::new(640, 480).unwrap();
        let camera = Matrix3::new(400.0, 0.0, 320.0, 0.0, 400.0, 240.0, 0.0, 0.0, 1.0);
        let (views, rotation, translation) = walkers(&camera, size);
        let inverse = camera.try_inverse().unwrap();
        let of = |m: Matrix3<f64>| Fundamental::from_matrix(&m, size, size).unwrap();
        let truth = of(inverse.transpose() * translation.cross_matrix() * rotation.matrix() * inverse);
        // The floor is y = 3: X ↦ R X + t nᵀX / 3 with n = (0, 1, 0).
        let floor = camera * (rotation.matrix() + translation * Vector3::y().transpose() / 3.0) * inverse;
        let wrong = of(Vector3::new(900.0, -700.0, 1.0).cross_matrix() * floor);

        let [tops, bottoms] = class_scores(&views, &truth);
        assert!(tops > 0.5 * bottoms && bottoms > 0.5 * tops, "{tops} {bottoms}");
        let [tops, bottoms] = class_scores(&views, &wrong);
        assert!(bottoms > 100.0 && tops < 0.1 * bottoms, "{tops} {bottoms}");
        // Its bottoms alone are worth hundreds. But no silhouette is whole, and what they miss counts.
        let (right, floor) = (symmetric_score(&views, &truth).total, symmetric_score(&views, &wrong).total);
        assert!(floor < 0.2 * right && floor < 0.2 * bottoms, "{floor} of {right}, bottoms {bottoms}");
        let objects = |f| Comparer::new(&views, f).pair(0, 3.0).weigh(3.0).score().objects;
        let (right, floor) = (objects(&truth), objects(&wrong));
        assert!(right.whole > 500 && floor.whole < 20 && floor.torn > 200, "{right:?} {floor:?}");
    }

    #[test]
    fn either_order_of_the_cameras_is_the_same_pair() {
        let size = ImageSize::new(640, 480).unwrap();
        let camera = Matrix3::new(400.0, 0.0, 320.0, 0.0, 400.0, 240.0, 0.0, 0.0, 1.0);
        let (mut views, rotation, translation) = walkers(&camera, size);
        // B sees two of the three.
        let fewer: Vec<_> =
            (0..200).map(|t| views.b.hulls_of(t).take(2).map(<[_]>::to_vec).collect()).collect();
        views.b = View::made_up(size, &fewer);
        let inverse = camera.try_inverse().unwrap();
        let matrix = inverse.transpose() * translation.cross_matrix() * rotation.matrix() * inverse;
        let f = Fundamental::from_matrix(&matrix, size, size).unwrap();
        let (there, back) = both_ways(&views, &f, |c| c.pair(0, 3.0).weigh(3.0).score().total());
        let swapped = views.swapped();
        let of_swapped = both_ways(&swapped, &f.transposed(), |c| c.pair(0, 3.0).weigh(3.0).score().total());
        assert!((there - back).abs() > 10.0, "{there} {back}");
        assert!((of_swapped.0 - back).abs() < 1e-6 && (of_swapped.1 - there).abs() < 1e-6, "{of_swapped:?}");
    }
}
