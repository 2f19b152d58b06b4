//! Do the rays of a camera meet those of others at an angle?
//!
//! Where all cameras stand at one place a turn explains all that meets, and whichever way the baselines are laid fits as well:
//! what is left of the angle between two rays is what outlines are wrong by, and covariances, which are of small errors, know nothing of that.

use crate::image::ImageSize;
use crate::network::model::camera::Camera;
use crate::network::model::joint::PairMeetings;
use crate::network::solve::settle::Settled;

/// Of each camera the parallax of what meets, in the pair in which that is largest, pixels of a 640×480 image; 0 where nothing does.
pub fn parallax(settled: &Settled) -> Vec<f64> {
    let mut largest = vec![0.0; settled.cameras.len()];
    for pair in &settled.pairs {
        let Some(found) = of_pair(&settled.cameras, pair) else { continue };
        for camera in [pair.a, pair.b] {
            largest[camera] = f64::max(largest[camera], found);
        }
    }
    largest
}

/// The median angle between the rays of what meets in a pair, as pixels of the camera with the shorter focal length.
fn of_pair(cameras: &[Camera], pair: &PairMeetings) -> Option<f64> {
    let focal =
        [pair.a, pair.b].map(|c| cameras[c].focal()[0] / ImageSize::pixel_scale([cameras[c].size; 2]));
    Some(pair.median_angle(cameras)? * focal[0].min(focal[1]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::solve::settle::tests::seen;

    #[test]
    fn cameras_at_one_place_have_no_parallax() {
        let mut settled = seen([0.3; 4]);
        let found = parallax(&settled);
        assert!(found.iter().all(|p| *p > 100.0), "{found:?}");
        // Two beside each other, the others far away.
        let place = settled.cameras[0].position;
        settled.pairs.retain(|p| (p.a, p.b) == (0, 1));
        for meeting in &mut settled.pairs[0].meetings {
            let far = place + 1e4 * settled.cameras[0].ray(meeting.a).unwrap().normalize();
            meeting.b = settled.cameras[1].project(&far).unwrap_or(meeting.b);
        }
        settled.pairs[0].meetings.retain(|m| {
            let [a, b] = [settled.cameras[0].ray(m.a), settled.cameras[1].ray(m.b)].map(Option::unwrap);
            a.angle(&b) < 0.01
        });
        assert!(settled.pairs[0].meetings.len() > 20);
        let found = parallax(&settled);
        assert!(found[0] < 1.0 && found[0] == found[1] && found[2..] == [0.0; 2], "{found:?}");
    }
}
