//! Was a camera turned a little while it filmed?
//!
//! Where it was turned far its pairs agree in one half only. Where it was turned by a degree they still agree in both, and all cameras
//! stand where that is a compromise: too far to one side in the first half and to the other in the second. That shows in the residuals:
//! those of one camera's pairs are what a turn of it between the halves makes. Where it was turned by more the network may stand by one half,
//! and what meets less in the other is what shows. Either is a suspicion; it was knocked if another pose of it explains one side better.

use nalgebra::{Matrix3, Vector3};

use super::knocks::knocked;
use crate::network::model::camera::{PARAMETERS, ROTATION};
use crate::network::model::joint::weight;
use crate::network::model::residual::CameraPair;
use crate::network::observations::observed::Observed;
use crate::network::observations::survey::Survey;
use crate::network::solve::networks::Solved;
use crate::network::solve::settle::{Settled, settle};
use crate::network::thresholds as limits;

/// Frames of each camera on which another pose is asked for.
const FRAMES: usize = 250;

/// Blocks of time over which residuals are dependent.
const BLOCKS: usize = 24;

/// The camera of which most speaks for a knock by a little, and at which of the network's time.
pub fn knocked_a_little(observed: &[Observed], survey: &Survey, now: &Solved) -> Option<(usize, f64)> {
    let maybe = knocked(survey, &now.network, limits::KNOCKED_MAYBE);
    let maybe = maybe.into_iter().enumerate().filter_map(|(c, knock)| Some((c, knock?.at)));
    let turned = turns(&now.settled).into_iter();
    let turned = turned.filter(|t| t.pixels > limits::TURNED.0 && t.deviates > limits::TURNED.1);
    maybe
        .chain(turned.map(|t| (t.camera, t.at)))
        .map(|(c, at)| (kept(observed, now, c, at), c, at))
        .filter(|(kept, ..)| *kept < limits::KNOCKED_OTHER)
        .min_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)))
        .map(|(_, c, at)| (c, at))
}

/// The evidence of a camera as it stands, as a share of what it has in the pose that suits one side of a moment best; of the two sides the
/// less.
fn kept(observed: &[Observed], now: &Solved, camera: usize, at: f64) -> f64 {
    let cameras = &now.network.cameras;
    let pairs: Vec<(usize, usize)> =
        now.network.pairs().into_iter().filter(|&(a, b)| a == camera || b == camera).collect();
    let alone: Vec<bool> = (0..cameras.len()).map(|c| c == camera).collect();
    let of_side = |before: bool| {
        let side = Survey::among(observed, FRAMES, |c, t| (cameras[c].time_of(t) < at) == before);
        let excess = |cameras: &[_]| -> f64 {
            side.scores(cameras, &pairs, limits::COMPARED, 0).iter().map(|s| s.excess).sum()
        };
        let other = excess(&settle(&side, cameras, &now.beliefs, &pairs, &alone, None).cameras);
        if other > limits::KNOCKED_CLEAR { excess(cameras) / other } else { 1.0 }
    };
    of_side(true).min(of_side(false))
}

/// A turn of a camera between the halves of the time in which it meets anything.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Turn {
    /// The camera.
    camera: usize,
    /// Between the halves, the network's time.
    at: f64,
    /// By how many pixels that moves its image where things moved, root mean square over what meets.
    pixels: f64,
    /// How far that is from none, in standard deviations.
    deviates: f64,
}

/// One meeting as camera `c` has it.
struct TimedRow {
    row: Vector3<f64>,
    residual: f64,
    weight: f64,
    time: f64,
}

/// The turn that each camera would have to have made, by the meetings of its pairs; none of one that hardly meets anything.
fn turns(settled: &Settled) -> Vec<Turn> {
    (0..settled.cameras.len()).filter_map(|camera| turn(camera, &seen(settled, camera))).collect()
}

fn seen(settled: &Settled, camera: usize) -> Vec<TimedRow> {
    let mut all = Vec::new();
    for p in settled.pairs.iter().filter(|p| p.a == camera || p.b == camera) {
        let from = if p.a == camera { ROTATION } else { PARAMETERS + ROTATION };
        let pair = CameraPair::new(&settled.cameras[p.a], &settled.cameras[p.b]);
        for m in &p.meetings {
            let Some((residual, row)) = pair.row(m) else { continue };
            let row = row.fixed_rows::<3>(from).into_owned();
            let weight = m.weight * weight(residual, settled.scale, p.coarseness);
            all.push(TimedRow { row, residual, weight, time: settled.cameras[p.a].time_of(m.time_a) });
        }
    }
    all
}

fn turn(camera: usize, seen: &[TimedRow]) -> Option<Turn> {
    if seen.len() < limits::LEAST_MEETINGS {
        return None;
    }
    let (start, end) =
        seen.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), s| (l.min(s.time), h.max(s.time)));
    let share = |s: &TimedRow| (s.time - start) / (end - start).max(1e-9);
    let side = |s: &TimedRow| if share(s) < 0.5 { -0.5 } else { 0.5 };
    let mut information = Matrix3::zeros();
    let mut gradient = Vector3::zeros();
    for s in seen {
        information += s.weight * 0.25 * s.row * s.row.transpose();
        gradient += s.weight * side(s) * s.residual * s.row;
    }
    let inverse = information.try_inverse()?;
    let turned = inverse * gradient;
    let mut blocks = [Vector3::zeros(); BLOCKS];
    for s in seen {
        let block = ((share(s) * BLOCKS as f64) as usize).min(BLOCKS - 1);
        blocks[block] += s.weight * side(s) * (s.residual - side(s) * s.row.dot(&turned)) * s.row;
    }
    let scatter: Matrix3<f64> = blocks.iter().map(|g| g * g.transpose()).sum();
    let spread = inverse * scatter * inverse * (BLOCKS as f64 / (BLOCKS as f64 - 3.0));
    let wald = turned.dot(&(spread.try_inverse()? * turned));
    let sum: f64 = seen.iter().map(|s| s.weight).sum();
    let squares: f64 = seen.iter().map(|s| s.weight * s.row.dot(&turned).powi(2)).sum();
    Some(Turn {
        camera,
        at: 0.5 * (start + end),
        pixels: (squares / sum).sqrt(),
        deviates: wald.max(0.0).sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::solve::settle::tests::seen;

    /// Four cameras, one of which was moved on by so many pixels for the second half.
    fn moved_on(camera: usize, pixels: f64) -> Settled {
        let mut settled = seen([0.3; 4]);
        for p in &mut settled.pairs {
            let half = p.meetings.len() / 2;
            for (k, m) in p.meetings.iter_mut().enumerate() {
                let by = if k < half { -0.5 * pixels } else { 0.5 * pixels };
                (m.time_a, m.time_b) = (k as f64, k as f64);
                if p.a == camera {
                    m.a[0] += by;
                } else if p.b == camera {
                    m.b[0] += by;
                }
            }
        }
        settled
    }

    #[test]
    fn a_small_turn_shows_in_the_residuals_of_its_camera() {
        let still = turns(&moved_on(2, 0.0));
        assert_eq!(still.len(), 4);
        assert!(still.iter().all(|t| t.pixels < 0.3 * limits::TURNED.0), "{still:?}");
        for camera in 0..4 {
            let found = turns(&moved_on(camera, 1.5));
            let most = found.iter().max_by(|p, q| p.pixels.total_cmp(&q.pixels)).unwrap();
            assert_eq!(most.camera, camera, "{found:?}");
            assert!(most.pixels > limits::TURNED.0 && most.deviates > limits::TURNED.1, "{found:?}");
        }
    }
}
