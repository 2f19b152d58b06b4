//! Does a geometry hold throughout the recording?
//!
//! Where a camera was turned while it filmed, the geometry of one part is right, stands far above chance, and is wrong for all
//! that is filmed from now on. Then next to nothing meets before some moment or after it, while both cameras see as much as ever.

use super::thresholds::{HOLDS_CLEAR, HOLDS_DIFFERS, HOLDS_SHOWS};
use crate::frontier::{Comparer, Views};
use crate::geometry::Fundamental;

/// Parts between which the moment is looked for.
const PARTS: usize = 8;
/// Shifts of the clocks whose evidence is what chance has there.
const SHIFTS: usize = 3;

/// Evidence beyond chance, and tangents that could meet.
#[derive(Debug, Clone, Copy, Default)]
struct Side {
    excess: f64,
    ends: f64,
}

impl Side {
    fn of(parts: &[Self]) -> Self {
        parts.iter().fold(Self::default(), |sum, part| Self {
            excess: sum.excess + part.excess,
            ends: sum.ends + part.ends,
        })
    }

    fn rate(&self) -> f64 {
        (self.excess / self.ends.max(1.0)).max(0.0)
    }
}

/// The evidence of a tangent before some moment as a share of that after it, or the other way about, the least that any moment gives;
/// 1 where too little is seen on one side, or where the parts of either differ so much among themselves that it may be chance.
pub fn holds(views: &Views, f: &Fundamental, radius: f64) -> f64 {
    let parts = parts(views, f, radius);
    let share = |boundary: usize| {
        let [before, after] = [Side::of(&parts[..boundary]), Side::of(&parts[boundary..])];
        let (worse, better) = if before.rate() < after.rate() { (before, after) } else { (after, before) };
        let tells = better.excess > HOLDS_CLEAR
            && worse.ends > HOLDS_SHOWS * better.ends
            && difference(&parts[..boundary], &parts[boundary..]) > HOLDS_DIFFERS;
        if tells { worse.rate() / better.rate() } else { 1.0 }
    };
    (2..PARTS - 1).map(share).fold(1.0, f64::min)
}

/// How far the rates of two sides are apart, in standard errors by how those of their parts scatter (two samples of one variance).
fn difference(before: &[Side], after: &[Side]) -> f64 {
    let [m, n] = [before.len(), after.len()].map(|n| n as f64);
    let mean = |side: &[Side]| side.iter().map(Side::rate).sum::<f64>() / side.len() as f64;
    let squares = |side: &[Side]| side.iter().map(|part| (part.rate() - mean(side)).powi(2)).sum::<f64>();
    let variance = (squares(before) + squares(after)) / (m + n - 2.0);
    (mean(before) - mean(after)).abs() / (variance * (1.0 / m + 1.0 / n)).sqrt()
}

fn parts(views: &Views, f: &Fundamental, radius: f64) -> [Side; PARTS] {
    let frames = views.frames();
    let mut comparer = Comparer::new(views, f);
    let sign = comparer.sign(0, radius);
    let mut parts = [Side::default(); PARTS];
    for shift in 0..=SHIFTS {
        let mut paired = comparer.pair_by(sign, shift * frames / (SHIFTS + 1));
        let weighed = paired.weigh(radius);
        for (k, part) in parts.iter_mut().enumerate() {
            let score = weighed.score_of(&(k * frames / PARTS..(k + 1) * frames / PARTS).collect::<Vec<_>>());
            if shift == 0 {
                part.excess += score.total();
                part.ends += score.tangents() as f64;
            } else {
                part.excess -= score.total() / SHIFTS as f64;
            }
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frontier::View;
    use crate::image::ImageSize;
    use crate::random::generator;
    use crate::recording::FramePair;
    use rand::RngExt;

    /// Boxes that jump about, seen by two cameras side by side; from one frame on the second looks so many pixels further down.
    fn seen(frames: usize, from: usize, lower: f64) -> (Views, Fundamental) {
        let size = ImageSize::new(640, 480).unwrap();
        let mut random = generator(11, 0);
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let mut views: [Vec<Vec<Vec<[f64; 2]>>>; 2] = [vec![], vec![]];
        for frame in 0..frames {
            let boxes: Vec<_> =
                (0..4).map(|_| [between(60.0, 500.0), between(50.0, 300.0), between(0.0, 50.0)]).collect();
            for (k, view) in views.iter_mut().enumerate() {
                let hull = |&[x, y, near]: &[f64; 3]| {
                    let x = if k == 0 { x } else { x - near };
                    let y = if k == 1 && frame >= from { y + lower } else { y };
                    vec![[x, y], [x + 30.0, y + 5.0], [x + 40.0, y + 60.0], [x - 5.0, y + 55.0]]
                };
                view.push(boxes.iter().map(hull).collect());
            }
        }
        let [a, b] = views.map(|frames| View::made_up(size, &frames));
        let pairs = (0..frames as u32).map(|i| FramePair { a: i, b: i }).collect();
        let rows = nalgebra::Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0);
        (Views::of(a, b, pairs), Fundamental::from_matrix(&rows, size, size).unwrap())
    }

    #[test]
    fn a_camera_that_was_moved_is_noticed() {
        let of = |from, lower| {
            let (views, f) = seen(240, from, lower);
            holds(&views, &f, 2.0)
        };
        assert!(of(0, 0.0) > 0.8, "{}", of(0, 0.0));
        for from in [80, 120, 170] {
            assert!(of(from, 25.0) < 0.1, "{from}: {}", of(from, 25.0));
        }
        // Of hardly anything nothing is told.
        let (views, f) = seen(4, 2, 25.0);
        assert_eq!(holds(&views, &f, 2.0), 1.0);
    }
}
