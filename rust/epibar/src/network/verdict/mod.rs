//! The verdict put together: what is said of each camera, each pair and the whole.
//!
//! * `decide`: the tests by name, in their order.
//! * `prose`: sentences.

pub mod decide;
pub mod prose;

use self::decide::CameraFindings;
use crate::image::ImageSize;
use crate::network::case::{Finished, NetworkCase, Out};
use crate::network::evidence::clocks_by_motion::{ClockByMotion, clocks_by_motion};
use crate::network::evidence::floor_errors::FloorErrors;
use crate::network::evidence::stated_errors::Expected;
use crate::network::evidence::support::{Deviates, Support};
use crate::network::given::input::IntrinsicKind;
use crate::network::given::pair::PairFound;
use crate::network::given::pair_choice::all_pairs;
use crate::network::model::camera::Camera;
use crate::network::model::residual::CameraPair;
use crate::network::result::{CameraStatus, Network, NetworkCamera, NetworkPair, PairStatus, fundamental};
use crate::network::solve::world::{self, World};
use crate::network::thresholds as limits;

/// The largest distance between the cameras of some pairs.
pub(super) fn rig(cameras: &[Camera], pairs: &[(usize, usize)]) -> f64 {
    let distances = pairs.iter().map(|&(a, b)| (cameras[a].position - cameras[b].position).norm());
    distances.fold(0.0, f64::max)
}

impl NetworkCase<'_> {
    /// What is said of a network.
    pub(super) fn network(&self, finished: &Finished, out: &[Out], rivalled: bool) -> Network {
        let network = &finished.solved.network;
        let FloorErrors { vertical, level } = finished.floor_errors;
        let floor = finished.floor.as_ref().map(|found| &found.floor);
        let World { cameras: placed, ground, turn, unit } = world::placed(network, floor, [vertical, level]);
        let rig = rig(&placed, &network.pairs());
        let expected = |c: usize| finished.expected[c].in_world(&turn, unit);
        let clocks_by_motion = self.clocks_by_motion(&network.cameras, &finished.support);
        let status = |c: usize, pair_refused: bool| match out.iter().find(|o| o.camera == c) {
            Some(out) => out.status,
            None if !network.placed[c] => CameraStatus::NothingInCommon,
            None => decide::status(&CameraFindings {
                rivalled,
                clock_doubted: self.is_clock_doubted(clocks_by_motion[c]),
                contradicted: self.contradicted(finished, c).is_some(),
                parallax: finished.parallax[c],
                relief: finished.relief[c],
                pair_refused,
                expected: &expected(c),
                rig,
            }),
        };
        let sound = |c: &usize| network.placed[*c] && status(*c, false) != CameraStatus::Contradicted;
        let stand: Vec<usize> = (0..self.count()).filter(|c| network.placed[*c]).collect();
        let sound: Vec<usize> = (0..self.count()).filter(sound).collect();
        let refused = [stand, sound].into_iter().find(|two| self.is_refused_pair(two, &network.cameras));
        let cameras: Vec<NetworkCamera> = (0..self.count())
            .map(|c| {
                let found = out.iter().find(|o| o.camera == c);
                let stands = network.placed[c];
                let contradicted = self.contradicted(finished, c);
                let expected = expected(c);
                let status = status(c, refused.as_ref().is_some_and(|two| two.contains(&c)));
                let mut camera = NetworkCamera {
                    camera: stands.then_some(placed[c]),
                    expected: stands.then_some(expected),
                    deviates: found.map_or(finished.support.cameras[c], |o| o.deviates),
                    offset_error: finished.offsets[c],
                    ..self.unplaced(c, status, found, &expected, rig)
                };
                match (status, contradicted) {
                    (CameraStatus::Accepted, _) => {
                        camera.reason += &self.remarks(finished, &camera, c);
                        if self.clocks_given && clocks_by_motion[c].open {
                            camera.reason += prose::GIVEN_CLOCK_BELIEVED;
                        }
                    }
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

    /// Whether what moves leaves a clock open, or speaks against one that was given.
    fn is_clock_doubted(&self, clock: ClockByMotion) -> bool {
        if self.clocks_given { clock.refuted } else { clock.open }
    }

    /// Of each camera what moves tells of its clock, by the pairs that agree with the network.
    fn clocks_by_motion(&self, cameras: &[Camera], support: &Support) -> Vec<ClockByMotion> {
        let confirmed = support.confirmed();
        let agrees = |p: &&PairFound| {
            confirmed.contains(&(p.a, p.b)) && !self.contradicts(p.a, p.b, &cameras[p.a], &cameras[p.b])
        };
        let agreeing: Vec<&PairFound> = self.pairs.iter().filter(agrees).collect();
        clocks_by_motion(self.inputs, &agreeing)
    }

    /// Whether these are two cameras, whose pair was not accepted by itself with the geometry that they have here. Nothing else speaks for them: whether one was knocked and whether all
    /// moved in one plane is asked of the pair, and of a network by what more cameras see.
    fn is_refused_pair(&self, two: &[usize], cameras: &[Camera]) -> bool {
        let accepted = |a: usize, b: usize| {
            self.pairs.iter().any(|p| (p.a, p.b) == (a, b) && p.accepted)
                && !self.contradicts(a, b, &cameras[a], &cameras[b])
        };
        matches!(*two, [a, b] if !accepted(a, b))
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
        let given =
            |kind: IntrinsicKind| kind.is_given(&self.beliefs[camera]) && !self.is_of_default(camera, kind);
        let of_several = |kind: IntrinsicKind| all().filter(|c| c.kind == kind).count() > 1 && given(kind);
        IntrinsicKind::ALL.into_iter().find(|kind| of_several(*kind)).map(prose::given_like_others)
    }

    /// What there is to know of a camera that is accepted.
    fn remarks(&self, finished: &Finished, said: &NetworkCamera, camera: usize) -> String {
        let fits = &finished.solved.network.cameras[camera];
        let mut text = String::new();
        if finished.contradicted.iter().any(|c| c.camera == camera && self.is_of_default(camera, c.kind)) {
            text += &prose::pixels_not_square(fits);
        }
        if finished.strained && IntrinsicKind::PrincipalPoint.is_given(&finished.solved.beliefs[camera]) {
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
        let knocked_at = out.and_then(|o| o.at);
        let reason = match status {
            CameraStatus::Clock if self.clocks_given => prose::GIVEN_CLOCK.to_owned(),
            _ => prose::of_camera(status, expected, rig, knocked_at, input, &self.pairs_of(camera)),
        };
        NetworkCamera {
            name: input.name.to_owned(),
            status,
            reason,
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
        let found = self.pair_of((a, b), [one, other], &finished.support);
        if !(cameras[a].accepted() && cameras[b].accepted()) {
            return found;
        }
        found.accepted_with_baseline([one, other], position_error([&cameras[a], &cameras[b]]))
    }

    /// A pair of cameras that stand, not accepted yet.
    pub(super) fn pair_of(
        &self,
        (a, b): (usize, usize),
        [one, other]: [&Camera; 2],
        support: &Support,
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
        NetworkPair { a, b, status, accepted: false, fundamental: fundamental(one, other), deviates }
    }

    /// Whether what a pair found by itself disagrees with the network.
    fn contradicts(&self, a: usize, b: usize, one: &Camera, other: &Camera) -> bool {
        let Some(pair) = self.hypotheses.iter().find(|h| (h.a, h.b) == (a, b)) else { return false };
        let geometry = CameraPair::new(one, other);
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

impl NetworkPair {
    /// A pair of accepted cameras, of whose positions together this is the error: accepted too, unless it contradicts or its baseline is not known by that.
    pub(super) fn accepted_with_baseline(self, [one, other]: [&Camera; 2], position_error: f64) -> Self {
        if self.status == PairStatus::Contradicts {
            return self;
        }
        let accepted = (one.position - other.position).norm() >= limits::BASELINE * position_error;
        let status = if accepted { self.status } else { PairStatus::NoBaseline };
        Self { status, accepted, ..self }
    }
}

/// The error to expect of the positions of two cameras together; NaN where that of one is not known.
pub(super) fn position_error(two: [&NetworkCamera; 2]) -> f64 {
    let [one, other] = two.map(|c| c.expected.map_or(f64::NAN, |expected| expected.position));
    one.hypot(other)
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
