//! Cameras that a solution has put at one place, though they see what moves from different sides.
//!
//! An epipolar constraint knows the direction of a baseline and not its length. Of two cameras that come together as far as
//! rounding goes any direction fits, so that their pair agrees with whatever else: it then says nothing of where they stand. But their rays still
//! meet at an angle, and so at next to no distance.

use super::settle::Settled;
use crate::geometry::median::median;
use crate::network::model::camera::Camera;
use crate::network::model::joint::PairMeetings;
use crate::network::thresholds as limits;

/// Pairs of cameras whose rays meet much nearer to them than those of other pairs do.
pub fn collapsed(settled: &Settled) -> Vec<(usize, usize)> {
    let reaches: Vec<Option<f64>> = settled.pairs.iter().map(|p| reach(&settled.cameras, p)).collect();
    let Some(usual) = median(reaches.iter().copied().flatten()) else { return Vec::new() };
    let is_near = |reach: &Option<f64>| reach.is_some_and(|r| r < limits::COLLAPSED * usual);
    let pairs = settled.pairs.iter().zip(&reaches);
    pairs.filter(|(_, reach)| is_near(reach)).map(|(p, _)| (p.a, p.b)).collect()
}

/// About how far from two cameras their rays meet: the baseline over the median angle.
fn reach(cameras: &[Camera], pair: &PairMeetings) -> Option<f64> {
    let baseline = (cameras[pair.a].position - cameras[pair.b].position).norm();
    Some(baseline / pair.median_angle(cameras)?.max(1e-9))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::solve::settle::tests::seen;

    #[test]
    fn cameras_that_come_together_are_noticed() {
        let mut settled = seen([0.3; 4]);
        assert!(collapsed(&settled).is_empty());
        let place = settled.cameras[1].position;
        settled.cameras[2].position = place + (settled.cameras[2].position - place) * 1e-5;
        assert_eq!(collapsed(&settled), [(1, 2)]);
        settled.pairs.clear();
        assert!(collapsed(&settled).is_empty());
    }
}
