//! The verdict: what is said of each camera, each pair and the whole.

use super::case::{Case, Finished, Out};
use super::evidence::knocks::knocked;
use super::evidence::stated_errors::{Expected, NINE_IN_TEN_IN_SPACE};
use super::evidence::support::{Deviates, Support};
use super::given::input::Kind;
use super::given::pair::PairFound;
use super::given::pair_choice::all_pairs;
use super::model::camera::Camera;
use super::model::residual::Pair;
use super::observations::survey::Survey;
use super::prose;
use super::result::{CameraStatus, Network, NetworkCamera, NetworkPair, PairStatus, fundamental};
use super::solve::networks::{Solved, gain};
use super::solve::relocate::Placed;
use super::solve::world::{self, World};
use super::thresholds as limits;
use crate::geometry::median::median;
use crate::image::ImageSize;

/// Whether another network has about the same evidence, and another geometry.
pub(super) fn is_rival(survey: &Survey, best: &Solved, rival: &Solved) -> bool {
    let of_best = &best.network.placed;
    if of_best.iter().zip(&rival.network.placed).any(|(best, rival)| *best && !rival) {
        return false;
    }
    is_as_good(survey, &best.network.pairs(), &best.network, &rival.network)
}

/// Whether another geometry of the same cameras has about the same evidence in some pairs.
pub(super) fn is_as_good(survey: &Survey, pairs: &[(usize, usize)], best: &Placed, rival: &Placed) -> bool {
    let differs = best.turns(rival).any(|turn| turn > limits::RIVAL_TURN);
    let (share, z) = gain(survey, pairs, best, rival);
    differs && share > -limits::RIVAL_SHARE && z > -limits::RIVAL_DEVIATES
}

/// The largest distance between the cameras of some pairs.
pub(super) fn rig(cameras: &[Camera], pairs: &[(usize, usize)]) -> f64 {
    let distances = pairs.iter().map(|&(a, b)| (cameras[a].position - cameras[b].position).norm());
    distances.fold(0.0, f64::max)
}

/// Those cameras that stand and should not: the one for which least speaks, if that is too little; else those of all
/// groups but the largest, if nothing joins them; else one that was knocked far.
pub(super) fn worst(survey: &Survey, network: &Placed, support: &Support) -> Vec<Out> {
    let stand: Vec<usize> = (0..network.cameras.len()).filter(|&c| network.placed[c]).collect();
    let confirmed = support.confirmed();
    let needed = if stand.len() > 2 { limits::CONFIRMED_PAIRS } else { 1 };
    let enough = |c: usize| {
        let pairs = confirmed.iter().filter(|p| p.0 == c || p.1 == c).count();
        stands_out(support, c) && pairs >= needed
    };
    let out = |camera: usize, status: CameraStatus, at: Option<f64>| Out {
        camera,
        status,
        deviates: support.cameras[camera],
        at,
    };
    let by_deviate =
        |&c: &usize, &d: &usize| support.cameras[c].tangents.total_cmp(&support.cameras[d].tangents);
    if let Some(camera) = stand.iter().copied().filter(|&c| !enough(c)).min_by(|c, d| by_deviate(c, d)) {
        return vec![out(camera, CameraStatus::NothingInCommon, None)];
    }
    let largest = largest_group(&stand, &confirmed);
    if largest.len() < stand.len() {
        let others = stand.iter().filter(|c| !largest.contains(c));
        return others.map(|&camera| out(camera, CameraStatus::Apart, None)).collect();
    }
    let knocked =
        knocked(survey, network, limits::KNOCKED).into_iter().enumerate().find_map(|(c, at)| Some((c, at?)));
    knocked.map(|(camera, at)| out(camera, CameraStatus::Knocked, Some(at))).into_iter().collect()
}

/// Whether so much speaks for a camera on moments kept aside that chance does not, and that explains what it sees.
pub(super) fn stands_out(support: &Support, camera: usize) -> bool {
    let (d, share) = (support.cameras[camera], support.shares[camera]);
    let explains = share.whole >= limits::CAMERA_WHOLE || share.excess >= limits::CAMERA_EXCESS;
    d.tangents >= limits::CAMERA_DEVIATES && d.whole >= limits::WHOLE_DEVIATES && explains
}

/// The most cameras that confirmed pairs join; of equals those with the most pairs, then the first.
fn largest_group(stand: &[usize], confirmed: &[(usize, usize)]) -> Vec<usize> {
    let mut groups: Vec<Vec<usize>> = stand.iter().map(|&c| vec![c]).collect();
    for (a, b) in confirmed {
        let place = |c: &usize| groups.iter().position(|g| g.contains(c));
        if let (Some(p), Some(q)) = (place(a), place(b))
            && p != q
        {
            let moved = groups.swap_remove(p.max(q));
            groups[p.min(q)].extend(moved);
        }
    }
    let pairs = |group: &Vec<usize>| confirmed.iter().filter(|(a, _)| group.contains(a)).count();
    let first = |group: &Vec<usize>| std::cmp::Reverse(group.iter().min().copied());
    groups.into_iter().max_by_key(|g| (g.len(), pairs(g), first(g))).unwrap_or_default()
}

impl Case<'_> {
    /// What is said of a network.
    pub(super) fn network(&self, finished: &Finished, out: &[Out], rivalled: bool) -> Network {
        let network = &finished.solved.network;
        let rotations = finished.expected.iter().zip(&network.placed).filter(|(_, stands)| **stands);
        let turned =
            median(rotations.map(|(e, _)| e.rotation / NINE_IN_TEN_IN_SPACE)).unwrap_or(f64::INFINITY);
        let World { cameras: placed, ground, turn, unit } =
            world::placed(network, finished.floor.as_ref(), turned);
        let rig = rig(&placed, &network.pairs());
        let cameras: Vec<NetworkCamera> = (0..self.count())
            .map(|c| {
                let found = out.iter().find(|o| o.camera == c);
                let stands = network.placed[c];
                let contradicted = self.contradicted(finished, c);
                let expected = finished.expected[c].in_world(&turn, unit);
                let status = match found {
                    Some(out) => out.status,
                    None if !stands => CameraStatus::NothingInCommon,
                    None if rivalled => CameraStatus::Ambiguous,
                    None if contradicted.is_some() => CameraStatus::Contradicted,
                    None => status_by_errors(&expected, rig),
                };
                let mut camera = NetworkCamera {
                    camera: stands.then_some(placed[c]),
                    expected: stands.then_some(expected),
                    deviates: found.map_or(finished.support.cameras[c], |o| o.deviates),
                    offset_error: finished.offsets[c],
                    ..self.unplaced(c, status, found, &expected, rig)
                };
                match (status, contradicted) {
                    (CameraStatus::Accepted, _) => camera.reason += &self.remarks(finished, &camera, c),
                    (CameraStatus::Contradicted, Some(said)) => camera.reason = said,
                    (CameraStatus::FocalLength | CameraStatus::Rotation | CameraStatus::Position, _) => {
                        camera.reason += &prose::doubted(&finished.doubts, c, &network.cameras[c]);
                    }
                    _ => (),
                }
                camera
            })
            .collect();
        let pairs =
            all_pairs(self.count()).map(|(a, b)| self.pair(a, b, &cameras, finished)).collect::<Vec<_>>();
        let radius = finished.solved.settled.radius;
        let accepted = cameras.iter().all(NetworkCamera::accepted);
        let reason = prose::of_network(&cameras, &pairs, &ground);
        Network { cameras, pairs, accepted, reason, ground, radius }
    }

    /// What was given of a camera and is contradicted by what moves, in words; or what was given of it as of several that are contradicted.
    fn contradicted(&self, finished: &Finished, camera: usize) -> Option<String> {
        let all = || finished.contradicted.iter().filter(|c| !self.is_of_default(c.camera, c.kind));
        let fits = &finished.solved.network.cameras[camera];
        let own = all().filter(|c| c.camera == camera);
        let said: Vec<String> = own.map(|c| prose::contradiction(c, &self.beliefs[camera], fits)).collect();
        if !said.is_empty() {
            return Some(said.join("; "));
        }
        let given = |kind: Kind| kind.is_given(&self.beliefs[camera]) && !self.is_of_default(camera, kind);
        let of_several = |kind: Kind| all().filter(|c| c.kind == kind).count() > 1 && given(kind);
        Kind::ALL.into_iter().find(|kind| of_several(*kind)).map(prose::given_like_others)
    }

    /// What there is to know of a camera that is accepted.
    fn remarks(&self, finished: &Finished, said: &NetworkCamera, camera: usize) -> String {
        let fits = &finished.solved.network.cameras[camera];
        let mut text = String::new();
        if finished.contradicted.iter().any(|c| c.camera == camera && self.is_of_default(camera, c.kind)) {
            text += &prose::pixels_not_square(fits);
        }
        if finished.strained && Kind::PrincipalPoint.is_given(&finished.solved.beliefs[camera]) {
            text += prose::PRINCIPAL_POINT_TAKEN_FOR_RIGHT;
        }
        text += &prose::doubted(&finished.doubts, camera, fits);
        if let Some(reach) = said.lens_reach() {
            text += &prose::short_lens(reach);
        }
        text
    }

    /// A camera with what is said of it, and without a place.
    pub(super) fn unplaced(
        &self,
        camera: usize,
        status: CameraStatus,
        out: Option<&Out>,
        expected: &Expected,
        rig: f64,
    ) -> NetworkCamera {
        let input = &self.inputs[camera];
        let seconds = self.observed[camera].times.last().copied().unwrap_or(0.0);
        let knocked_at = out.and_then(|o| o.at).map(|share| share * seconds);
        NetworkCamera {
            name: input.name.to_owned(),
            status,
            reason: prose::of_camera(status, expected, rig, knocked_at, input, &self.pairs_of(camera)),
            camera: None,
            expected: None,
            deviates: out.map_or(Deviates::default(), |o| o.deviates),
            size: input.recording.size(),
            offset_error: f64::NAN,
        }
    }

    fn pairs_of(&self, camera: usize) -> Vec<&PairFound> {
        self.pairs.iter().filter(|p| p.a == camera || p.b == camera).collect()
    }

    fn pair(&self, a: usize, b: usize, cameras: &[NetworkCamera], finished: &Finished) -> NetworkPair {
        let (Some(one), Some(other)) = (&cameras[a].camera, &cameras[b].camera) else {
            return outside((a, b));
        };
        let accepted = cameras[a].accepted() && cameras[b].accepted();
        self.pair_of((a, b), [one, other], &finished.support, accepted)
    }

    /// A pair of cameras that stand.
    pub(super) fn pair_of(
        &self,
        (a, b): (usize, usize),
        [one, other]: [&Camera; 2],
        support: &Support,
        both_accepted: bool,
    ) -> NetworkPair {
        let support = support.pairs.iter().find(|(pair, _)| *pair == (a, b));
        let deviates = support.map_or(Deviates::default(), |s| s.1);
        let alone = self.pairs.iter().find(|p| (p.a, p.b) == (a, b)).is_some_and(|p| p.accepted);
        let status = if alone && self.contradicts(a, b, one, other) {
            PairStatus::Contradicts
        } else if deviates.tangents >= limits::PAIR_DEVIATES {
            PairStatus::Confirmed
        } else {
            PairStatus::Predicted
        };
        let accepted = both_accepted && status != PairStatus::Contradicts;
        NetworkPair { a, b, status, accepted, fundamental: fundamental(one, other), deviates }
    }

    /// Whether what a pair found by itself disagrees with the network.
    fn contradicts(&self, a: usize, b: usize, one: &Camera, other: &Camera) -> bool {
        let Some(pair) = self.hypotheses.iter().find(|h| (h.a, h.b) == (a, b)) else { return false };
        let geometry = Pair::new(one, other);
        let meetings = &pair.hypotheses[0].meetings;
        let within = limits::AGREE * ImageSize::pixel_scale([one.size, other.size]);
        (geometry.agreeing(meetings, within) as f64) < limits::CONTRADICTS * meetings.len() as f64
    }

    /// No camera stands.
    pub(super) fn nothing(&self, status: CameraStatus) -> Network {
        let all =
            (0..self.count()).map(|camera| Out { camera, status, deviates: Deviates::default(), at: None });
        self.without(&all.collect::<Vec<_>>())
    }

    pub(super) fn without(&self, out: &[Out]) -> Network {
        let cameras: Vec<NetworkCamera> = (0..self.count())
            .map(|c| {
                let found = out.iter().find(|o| o.camera == c);
                let status = found.map_or(CameraStatus::NothingInCommon, |o| o.status);
                self.unplaced(c, status, found, &Expected::UNKNOWN, 1.0)
            })
            .collect();
        let pairs: Vec<NetworkPair> = all_pairs(self.count()).map(outside).collect();
        let reason = prose::of_network(&cameras, &pairs, &world::Ground::Cameras);
        Network { cameras, pairs, accepted: false, reason, ground: world::Ground::Cameras, radius: f64::NAN }
    }
}

/// A pair of which a camera does not stand.
pub(super) fn outside((a, b): (usize, usize)) -> NetworkPair {
    NetworkPair {
        a,
        b,
        status: PairStatus::Outside,
        accepted: false,
        fundamental: None,
        deviates: Deviates::default(),
    }
}

/// Whether errors are small enough.
pub(super) fn status_by_errors(expected: &Expected, rig: f64) -> CameraStatus {
    // Each so that NaN refuses.
    let errors = [
        (expected.focal, limits::MAX_FOCAL, CameraStatus::FocalLength),
        (expected.rotation, limits::MAX_ROTATION, CameraStatus::Rotation),
        (expected.position, limits::MAX_POSITION * rig, CameraStatus::Position),
    ];
    let small = |error: f64, limit: f64| error <= limit;
    let too_large = errors.into_iter().find(|(error, limit, _)| !small(*error, *limit));
    too_large.map_or(CameraStatus::Accepted, |(_, _, status)| status)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_that_nothing_joins_stay_apart() {
        let confirmed = [(0, 1), (1, 2), (0, 2), (3, 4), (4, 5), (5, 6), (3, 6)];
        let mut group = largest_group(&[0, 1, 2, 3, 4, 5, 6], &confirmed);
        group.sort_unstable();
        assert_eq!(group, [3, 4, 5, 6]);
        let mut group = largest_group(&[0, 1, 2, 3, 4, 5], &confirmed[..5]);
        group.sort_unstable();
        assert_eq!(group, [0, 1, 2]);
        assert!(largest_group(&[], &[]).is_empty());
    }

    #[test]
    fn what_is_no_number_is_refused() {
        let good = Expected::new(0.01, 0.01, 0.01);
        assert_eq!(status_by_errors(&good, 1.0), CameraStatus::Accepted);
        assert_eq!(status_by_errors(&Expected::UNKNOWN, 1.0), CameraStatus::FocalLength);
        assert_eq!(status_by_errors(&Expected { rotation: f64::NAN, ..good }, 1.0), CameraStatus::Rotation);
        assert_eq!(status_by_errors(&good, f64::NAN), CameraStatus::Position);
        assert_eq!(status_by_errors(&Expected { position: 0.2, ..good }, 1.0), CameraStatus::Position);
    }
}
