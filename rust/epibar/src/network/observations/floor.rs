//! The floor: the plane on which figures stand, and how well it is known.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use super::figures::Upright;
use crate::geometry::across::across;
use crate::geometry::median::{deviation, median, quantile};
use crate::network::thresholds as limits;

/// The plane on which walkers stand, and how tall they are, in the unit of the network.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Floor {
    /// Up, unit length.
    pub up: Vector3<f64>,
    /// `up · X` of its points.
    pub level: f64,
    /// Height of those who walk on it, their median.
    pub height: f64,
    /// Robust standard deviation of all bottoms from the floor, over the height: of those that are near it is small by itself.
    pub unevenness: f64,
    /// Robust standard deviation of heights over their median.
    pub diversity: f64,
    /// Median breadth of figures over their height; `None` where all are seen from straight above.
    pub breadth: Option<f64>,
    /// Angle between up and the mean of the segments, radians.
    pub lean: f64,
    /// Standard error of up, radians.
    pub vertical_error: f64,
    /// Standard error of the level where the figures stand.
    pub level_error: f64,
    /// Mean of the bottoms.
    pub middle: Vector3<f64>,
    /// Figures that it rests on.
    pub figures: usize,
}

/// Samples of three bottoms.
const SAMPLES: usize = 300;
/// Three bottoms nearer to one line tell no plane: twice the area of their triangle, in squares of the median height.
const LEAST_TRIANGLE: f64 = 0.05;
/// Bottoms that are nearer to each other than about this share of the height are at one place.
const PLACE: f64 = 1.0;
/// Rounds of least squares.
const REFITS: usize = 5;
/// The share of the bottoms within reach of a floor that are certainly of feet that stand.
const STANDING: f64 = 0.7;
/// Of normal deviates that share is smaller than this.
const STANDING_DEVIATE: f64 = 1.036;
/// Feet stand that are nearer to the floor than so many standard deviations of those. Of 16 made-up networks of development, 400 figures each, the
/// vertical by these was 0.08 degrees off in the median, by all within [`limits::ON_FLOOR`] 0.15; the level where most are 1.1 cm, that of all within it 1.2.
const STANDS_WITHIN: f64 = 2.5;
/// Bottoms pass the distance within which they are counted, as the floor moves, that are within so much of it, as a share.
const PASSING: f64 = 0.25;
/// The share of the normal equations that holds, at least: of normal deviates 0.91 does.
const LEAST_HELD: f64 = 0.1;
/// Rounds of least squares of those that are nearest to the plane of the round before, at most.
const TRIMMED: usize = 30;

impl Floor {
    /// The floor of figures in space; `None` where they are too few, or have none in common.
    pub fn of(figures: &[Upright]) -> Option<Self> {
        if figures.len() < limits::FLOOR_FIGURES {
            return None;
        }
        let height = median(figures.iter().map(|f| (f.top - f.bottom).norm()))?;
        let mean_up: Vector3<f64> = figures.iter().map(|f| (f.top - f.bottom).normalize()).sum();
        let mean_up = mean_up.normalize();
        let (mut up, mut level) = most_common(figures, &mean_up, height)?;
        for _ in 0..REFITS {
            (up, level) = refitted(figures, up, level, limits::ON_FLOOR * height)?;
        }
        let (up, level) = if up.dot(&mean_up) < 0.0 { (-up, -level) } else { (up, level) };
        let floor = trimmed(figures, up, level, 2.0 * limits::ON_FLOOR * height)?;
        let (up, level) = (floor.up, floor.standing);
        let on_it = |f: &&Upright| (up.dot(&f.bottom) - level).abs() < 2.0 * limits::ON_FLOOR * height;
        let standing: Vec<&Upright> = figures.iter().filter(on_it).collect();
        if standing.len() < limits::FLOOR_FIGURES {
            return None;
        }
        let tall = median(standing.iter().map(|f| up.dot(&f.top) - level))?;
        let mean: Vector3<f64> = standing.iter().map(|f| (f.top - f.bottom) / tall).sum();
        let middle = standing.iter().map(|f| f.bottom).sum::<Vector3<f64>>() / standing.len() as f64;
        let (vertical_error, level_error) = errors(&standing, &middle, &floor, tall)?;
        Some(Self {
            up,
            level,
            height: tall,
            unevenness: deviation(figures.iter().map(|f| (up.dot(&f.bottom) - level) / tall))?,
            diversity: deviation(standing.iter().map(|f| (up.dot(&f.top) - level) / tall - 1.0))?,
            breadth: median(standing.iter().filter_map(|f| f.breadth)),
            lean: mean.normalize().dot(&up).clamp(-1.0, 1.0).acos(),
            vertical_error,
            level_error,
            middle,
            figures: standing.len(),
        })
    }
}

/// The plane through three bottoms that most others lie on: its normal and level.
fn most_common(figures: &[Upright], mean_up: &Vector3<f64>, height: f64) -> Option<(Vector3<f64>, f64)> {
    let mut best: Option<(usize, Vector3<f64>, f64)> = None;
    for k in 0..SAMPLES {
        // Three bottoms far apart in the list, each sample other ones.
        let n = figures.len();
        let pick = |j: usize| figures[(k * 7919 + j * n / 3 + (k * k + 31 * j) % 97) % n].bottom;
        let (p, q, r) = (pick(0), pick(1), pick(2));
        let normal = (q - p).cross(&(r - p));
        if normal.norm() < LEAST_TRIANGLE * height * height {
            continue;
        }
        let normal = normal.normalize();
        let normal = if normal.dot(mean_up) < 0.0 { -normal } else { normal };
        let level = normal.dot(&p);
        let near = |f: &&Upright| (normal.dot(&f.bottom) - level).abs() < limits::ON_FLOOR * height;
        let on = figures.iter().filter(near).count();
        if best.is_none_or(|b| on > b.0) {
            best = Some((on, normal, level));
        }
    }
    best.map(|(_, normal, level)| (normal, level))
}

/// Standard errors of the normal of a floor, radians, and of its level where the figures stand; `None` where they stand at three places or
/// fewer.
///
/// How far a bottom is from the floor depends on where it is: which point of a foot an epipolar plane touches, and what the lens is wrong
/// by. So bottoms at one place say what one would, and the covariance of the plane is by how much it moves without each place in turn
/// ("cluster-robust": Liang and Zeger, Biometrika 1986; the jackknife of Bell and `McCaffrey` 2002, as places may be few). What is nearer
/// than some distance is counted, and as the plane moves some pass that on either side: so much less the normal equations hold
/// (Víšek, Kybernetika 2006). All planes through two cameras touch feet from below at a slant, and so a little above the
/// floor, here more and there less: that is besides.
fn errors(
    standing: &[&Upright],
    middle: &Vector3<f64>,
    &Trimmed { up, level, within, .. }: &Trimmed,
    tall: f64,
) -> Option<(f64, f64)> {
    let distance = |f: &&&Upright| off((up, level), &f.bottom);
    let feet: Vec<&&Upright> = standing.iter().filter(|f| distance(f) <= within).collect();
    let passing = standing.iter().filter(|f| (distance(f) / within - 1.0).abs() <= PASSING).count();
    let held = 1.0 - passing as f64 / (2.0 * PASSING) / feet.len() as f64;
    let [along, aside] = across(&up);
    let count = feet.len() as f64;
    let mut normal_matrix = Matrix3::zeros();
    let mut places: BTreeMap<[i64; 2], (Matrix3<f64>, Vector3<f64>)> = BTreeMap::new();
    for figure in feet {
        let from = figure.bottom - middle;
        let row = Vector3::new(1.0, along.dot(&from), aside.dot(&from));
        let own = row * row.transpose();
        normal_matrix += own;
        let place = [row[1], row[2]].map(|x| (x / (PLACE * tall)).floor() as i64);
        let (normal, score) = places.entry(place).or_default();
        *normal += own;
        *score += row * (up.dot(&figure.bottom) - level);
    }
    if places.len() <= 3 {
        return None;
    }
    let mut covariance = Matrix3::zeros();
    for (normal, score) in places.values() {
        let without = (normal_matrix - normal).try_inverse()? * score / held.max(LEAST_HELD);
        covariance += without * without.transpose();
    }
    let scattered = covariance[(1, 1)] + covariance[(2, 2)];
    let spread =
        normal_matrix.fixed_view::<2, 2>(1, 1).into_owned().symmetric_eigen().eigenvalues.min() / count;
    // Where all stand in one line, left and right feet alone tell how it is turned about that.
    let in_line = (limits::STANCE * tall).powi(2) / spread;
    let foot = limits::FOOT_LEANING + limits::FOOT_ASIDE * in_line.min(1.0);
    let leaning = (foot * tall).powi(2) / spread;
    let level = (covariance * normal_matrix).trace() / count + (limits::FOOT_ABOVE * tall).powi(2);
    Some(((scattered + leaning).sqrt(), level.sqrt()))
}

/// The plane by least squares of the bottoms within reach of one.
fn refitted(figures: &[Upright], up: Vector3<f64>, level: f64, reach: f64) -> Option<(Vector3<f64>, f64)> {
    let near: Vec<Vector3<f64>> =
        figures.iter().map(|f| f.bottom).filter(|b| (up.dot(b) - level).abs() < reach).collect();
    fitted(&near, &up)
}

/// A plane on which feet stand.
struct Trimmed {
    up: Vector3<f64>,
    /// The level of the mean of the feet.
    level: f64,
    /// How near to it they are.
    within: f64,
    /// The level about which most bottoms are: some of those that are near swing a little above it.
    standing: f64,
}

/// The plane on which feet stand, of the bottoms within reach of one.
///
/// A foot that swings is touched above the floor and none below it, so the mean of all is too high, by other amounts in other places. Those that
/// scatter least about a plane of their own are feet that stand: least trimmed squares (Rousseeuw, JASA 1984), by concentration
/// steps (Rousseeuw and Van Driessen 2006) from the middle of the shortest interval that holds as many. That says how much they
/// scatter, and the normal is that of all which are as near ("reweighted": Rousseeuw and Leroy 1987).
fn trimmed(figures: &[Upright], up: Vector3<f64>, level: f64, reach: f64) -> Option<Trimmed> {
    let mut near: Vec<Vector3<f64>> =
        figures.iter().map(|f| f.bottom).filter(|b| (up.dot(b) - level).abs() < reach).collect();
    let count = (STANDING * near.len() as f64) as usize;
    let mut plane = (up, standing_level(&near, &up)?);
    for _ in 0..TRIMMED {
        let before = plane;
        near.sort_by(|p, q| off(before, p).total_cmp(&off(before, q)));
        plane = fitted(&near[..count], &before.0)?;
        if plane == before {
            break;
        }
    }
    let scatter = quantile(near.iter().map(|b| off(plane, b)), STANDING)? / STANDING_DEVIATE;
    let within = STANDS_WITHIN * scatter;
    let feet: Vec<Vector3<f64>> = near.iter().copied().filter(|b| off(plane, b) <= within).collect();
    let (up, level) = fitted(&feet, &plane.0)?;
    Some(Trimmed { up, level, within, standing: standing_level(&near, &up)? })
}

/// The middle of the shortest interval that holds [`STANDING`] of the levels of some bottoms along a normal.
fn standing_level(near: &[Vector3<f64>], up: &Vector3<f64>) -> Option<f64> {
    let mut levels: Vec<f64> = near.iter().map(|b| up.dot(b)).collect();
    levels.sort_unstable_by(f64::total_cmp);
    let count = (STANDING * levels.len() as f64) as usize;
    let ends = (0..levels.len() - count).map(|k| (levels[k], levels[k + count]));
    let shortest = ends.min_by(|p, q| (p.1 - p.0).total_cmp(&(q.1 - q.0)))?;
    Some(0.5 * (shortest.0 + shortest.1))
}

/// How far a bottom is off a plane.
fn off((up, level): (Vector3<f64>, f64), bottom: &Vector3<f64>) -> f64 {
    (up.dot(bottom) - level).abs()
}

/// The plane by least squares of some bottoms, its normal on the side of another one; `None` of few.
fn fitted(near: &[Vector3<f64>], up: &Vector3<f64>) -> Option<(Vector3<f64>, f64)> {
    if near.len() < limits::FLOOR_FIGURES / 2 {
        return None;
    }
    let mean = near.iter().sum::<Vector3<f64>>() / near.len() as f64;
    let scatter: Matrix3<f64> = near.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
    let eigen = scatter.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let normal = eigen.eigenvectors.column(least).into_owned();
    let normal = if normal.dot(up) < 0.0 { -normal } else { normal };
    Some((normal, normal.dot(&mean)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::generator;
    use rand::RngExt;

    /// Walkers of height 1 who stand on the plane `z = 0` of `room`, as many times at each of so many places, with errors of these
    /// standard deviations that a place has once and each figure anew.
    fn figures(places: usize, room: f64, errors: [f64; 2], seed: u64) -> Vec<Upright> {
        let mut rng = generator(7, seed);
        let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let mut found = Vec::new();
        for place in 0..places {
            let (x, y) = (room * normal(), room * normal());
            let common = errors[0] * normal();
            for _ in 0..600 / places {
                let bottom =
                    Vector3::new(x + 0.01 * normal(), y + 0.01 * normal(), common + errors[1] * normal());
                let breadth = (place % 2 == 0).then_some(0.4);
                found.push(Upright { top: bottom + Vector3::z(), bottom, breadth });
            }
        }
        found
    }

    #[test]
    fn a_floor_is_found_with_its_height_and_breadth() {
        let floor = Floor::of(&figures(40, 3.0, [0.0, 0.01], 1)).unwrap();
        assert!(floor.up.angle(&Vector3::z()) < 0.002, "{}", floor.up);
        assert!(floor.level.abs() < 0.002 && (floor.height - 1.0).abs() < 0.01);
        assert_eq!(floor.breadth, Some(0.4));
        assert_eq!(floor.figures, 600);
    }

    #[test]
    fn what_a_place_is_off_by_counts_once() {
        let mut squares = [0.0; 2];
        let runs = 40;
        for seed in 0..runs {
            let floor = Floor::of(&figures(30, 2.0, [0.02, 0.01], seed)).unwrap();
            let off = floor.up.angle(&Vector3::z());
            squares[0] += (off / floor.vertical_error).powi(2) / runs as f64;
            // As if each figure were by itself: far too little.
            squares[1] += (off * 2.0 * f64::from(600u16).sqrt() / 0.0224).powi(2) / runs as f64;
        }
        assert!((0.3..1.5).contains(&squares[0]), "{squares:?}");
        assert!(squares[1] > 10.0, "{squares:?}");
    }

    #[test]
    fn feet_that_swing_do_not_lift_or_tilt_the_floor() {
        let mut found = figures(40, 3.0, [0.0, 0.005], 2);
        for (k, figure) in found.iter_mut().enumerate() {
            // A quarter is touched up to 5 % of the height above it, on one side of the room alone.
            if k % 2 == 0 && figure.bottom.x > 0.0 {
                figure.bottom.z += 0.06 * (k % 10) as f64 / 10.0;
            }
        }
        let floor = Floor::of(&found).unwrap();
        let mean = found.iter().map(|f| f.bottom.z).sum::<f64>() / found.len() as f64;
        assert!(mean > 0.005, "{mean}");
        assert!(floor.level.abs() < 0.002, "{}", floor.level);
        assert!(floor.up.angle(&Vector3::z()) < 0.001, "{}", floor.up);
    }

    #[test]
    fn what_flies_is_uneven() {
        let mut found = figures(40, 3.0, [0.0, 0.01], 4);
        assert!(Floor::of(&found).unwrap().unevenness < limits::FLOOR_UNEVEN);
        for (k, figure) in found.iter_mut().enumerate() {
            figure.bottom.z += 4.0 * (k % 40) as f64 / 40.0;
            figure.top.z = figure.bottom.z + 1.0;
        }
        assert!(Floor::of(&found).is_none_or(|floor| floor.unevenness > limits::FLOOR_UNEVEN));
    }

    #[test]
    fn of_figures_in_one_line_less_is_known_how_the_floor_is_turned_about_it() {
        let stated = |width: f64| {
            let mut found = figures(40, 3.0, [0.0, 0.005], 6);
            for figure in &mut found {
                figure.bottom.y *= width / 3.0;
                figure.top.y = figure.bottom.y;
            }
            Floor::of(&found).unwrap().vertical_error.to_degrees()
        };
        let (room, path) = (stated(1.0), stated(0.08));
        assert!(room < 0.2 && (2.0..6.0).contains(&path), "{room} {path}");
    }

    #[test]
    fn three_places_tell_no_floor() {
        assert!(Floor::of(&figures(3, 3.0, [0.0, 0.01], 5)).is_none());
        assert!(Floor::of(&figures(6, 3.0, [0.0, 0.01], 5)).is_some());
    }
}
