//! What is decided of each camera, test by test: which are taken out of a network, and what is said of those that stand.

use crate::network::case::Out;
use crate::network::evidence::cheirality;
use crate::network::evidence::knocks::{Knock, knocked};
use crate::network::evidence::planes;
use crate::network::evidence::slight_knocks;
use crate::network::evidence::stated_errors::Expected;
use crate::network::evidence::support::Support;
use crate::network::observations::observed::Observed;
use crate::network::observations::survey::Survey;
use crate::network::result::CameraStatus;
use crate::network::solve::collapse::collapsed;
use crate::network::solve::networks::{Solved, gain};
use crate::network::solve::relocate::Placed;
use crate::network::thresholds as limits;

/// A network whose cameras are to be sifted.
pub(in crate::network) struct NetworkFindings<'a> {
    /// Of all cameras.
    pub(in crate::network) observed: &'a [Observed],
    /// Of the moments that it was solved on.
    pub(in crate::network) survey: &'a Survey<'a>,
    pub(in crate::network) solved: &'a Solved,
    /// What speaks for it on moments kept aside.
    pub(in crate::network) support: &'a Support,
}

/// Finds cameras that stand and should not.
type NetworkTest = fn(&NetworkFindings) -> Vec<Out>;

/// Tests of the cameras of a network by name, in their order.
pub(in crate::network) const NETWORK_TESTS: [(&str, NetworkTest); 7] = [
    ("enough speaks for each camera", least_supported),
    ("no two were put at one place", put_together),
    ("what meets is before the cameras", behind),
    ("pairs that see a plane see the same", off_plane),
    ("confirmed pairs join all cameras", apart),
    ("no camera was knocked far", knocked_far),
    ("no camera was knocked a little", knocked_a_little),
];

/// Those cameras that stand and should not, by the first test that finds some.
pub(in crate::network) fn to_take_out(findings: &NetworkFindings) -> Vec<Out> {
    NETWORK_TESTS.iter().map(|(_, test)| test(findings)).find(|out| !out.is_empty()).unwrap_or_default()
}

impl NetworkFindings<'_> {
    fn stand(&self) -> Vec<usize> {
        let Placed { cameras, placed } = &self.solved.network;
        (0..cameras.len()).filter(|&c| placed[c]).collect()
    }

    /// `at` is the network's time.
    fn out(&self, camera: usize, status: CameraStatus, at: Option<f64>) -> Out {
        let at = at.map(|time| self.solved.network.cameras[camera].clock_at(time));
        Out { camera, status, deviates: self.support.cameras[camera], at }
    }
}

/// The camera for which least speaks, if that is too little.
fn least_supported(f: &NetworkFindings) -> Vec<Out> {
    let stand = f.stand();
    let confirmed = f.support.confirmed();
    let needed = if stand.len() > 2 { limits::CONFIRMED_PAIRS } else { 1 };
    let enough = |c: usize| {
        let pairs = confirmed.iter().filter(|p| p.0 == c || p.1 == c).count();
        stands_out(f.support, c) && pairs >= needed
    };
    let deviate = |c: usize| f.support.cameras[c].tangents;
    let least = stand.into_iter().filter(|&c| !enough(c)).min_by(|&c, &d| deviate(c).total_cmp(&deviate(d)));
    least.map(|camera| f.out(camera, CameraStatus::NothingInCommon, None)).into_iter().collect()
}

/// Of two that the solution put at one place, the one for which less speaks.
fn put_together(f: &NetworkFindings) -> Vec<Out> {
    let confirmed = f.support.confirmed();
    let pairs = collapsed(&f.solved.settled).into_iter().filter(|pair| confirmed.contains(pair));
    let together = pairs.flat_map(|(a, b)| [a, b]);
    let deviate = |c: usize| f.support.cameras[c].tangents;
    let least = together.min_by(|&c, &d| deviate(c).total_cmp(&deviate(d)));
    least.map(|camera| f.out(camera, CameraStatus::Ambiguous, None)).into_iter().collect()
}

/// The camera with most of the pairs whose rays would meet behind one.
fn behind(f: &NetworkFindings) -> Vec<Out> {
    let found = cheirality::behind(&f.solved.settled, &f.solved.network.placed, &f.support.confirmed());
    found.map(|camera| f.out(camera, CameraStatus::Ambiguous, None)).into_iter().collect()
}

/// Where all that moves keeps to one plane, the camera with which it is not the same one to all pairs.
fn off_plane(f: &NetworkFindings) -> Vec<Out> {
    let found = planes::off_plane(&f.solved.settled, &f.solved.network.placed, &f.support.confirmed());
    found.map(|camera| f.out(camera, CameraStatus::Ambiguous, None)).into_iter().collect()
}

/// All groups but the largest, if nothing joins them.
fn apart(f: &NetworkFindings) -> Vec<Out> {
    let stand = f.stand();
    let largest = largest_group(&stand, &f.support.confirmed());
    let others = stand.into_iter().filter(|c| !largest.contains(c));
    others.map(|camera| f.out(camera, CameraStatus::Apart, None)).collect()
}

/// One that agrees with the others only before or after some moment; of several the one that keeps least, as pairs with it fail the others too.
fn knocked_far(f: &NetworkFindings) -> Vec<Out> {
    let found = knocked(f.survey, &f.solved.network, limits::KNOCKED);
    worst_knock(&found)
        .map(|(camera, at)| f.out(camera, CameraStatus::Knocked, Some(at)))
        .into_iter()
        .collect()
}

/// The camera that keeps least beyond its knock, and when that was; of equals the first.
fn worst_knock(found: &[Option<Knock>]) -> Option<(usize, f64)> {
    let knocks = found.iter().enumerate().filter_map(|(c, knock)| Some((c, (*knock)?)));
    let worst = knocks.min_by(|p, q| p.1.keeps.total_cmp(&q.1.keeps));
    worst.map(|(camera, knock)| (camera, knock.at))
}

/// One that turned so little that it agrees with the others throughout. Of two nobody can say which did.
fn knocked_a_little(f: &NetworkFindings) -> Vec<Out> {
    if f.stand().len() <= 2 {
        return Vec::new();
    }
    let found = slight_knocks::knocked_a_little(f.observed, f.survey, f.solved);
    found.map(|(camera, at)| f.out(camera, CameraStatus::Knocked, Some(at))).into_iter().collect()
}

/// Whether so much speaks for a camera on moments kept aside that chance does not, and that explains what it sees.
pub(in crate::network) fn stands_out(support: &Support, camera: usize) -> bool {
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

/// Whether another network has about the same evidence, and another geometry.
pub(in crate::network) fn is_rival(survey: &Survey, best: &Solved, rival: &Solved) -> bool {
    let of_best = &best.network.placed;
    if of_best.iter().zip(&rival.network.placed).any(|(best, rival)| *best && !rival) {
        return false;
    }
    is_as_good(survey, &best.network.pairs(), &best.network, &rival.network)
}

/// Whether another geometry of the same cameras has about the same evidence in some pairs.
pub(in crate::network) fn is_as_good(
    survey: &Survey,
    pairs: &[(usize, usize)],
    best: &Placed,
    rival: &Placed,
) -> bool {
    let differs = best.turns(rival).any(|turn| turn > limits::RIVAL_TURN);
    let (share, z) = gain(survey, pairs, best, rival);
    differs && share > -limits::RIVAL_LESS && z > -limits::RIVAL_DEVIATES
}

/// A camera that stands.
#[derive(Clone, Copy)]
#[allow(clippy::struct_excessive_bools, reason = "each is the answer to a question of its own")]
pub(in crate::network) struct CameraFindings<'a> {
    /// Another network explains what moves nearly as well.
    pub(in crate::network) rivalled: bool,
    /// What moves leaves open when it filmed, or speaks against what was given of that.
    pub(in crate::network) clock_doubted: bool,
    /// What was given of it is contradicted by what moves.
    pub(in crate::network) contradicted: bool,
    /// At which angle its rays meet those of others, pixels of a 640×480 image.
    pub(in crate::network) parallax: f64,
    /// How far from one plane all that is seen is, pixels of a 640×480 image; infinite where focal lengths are known all the same.
    pub(in crate::network) relief: f64,
    /// It and one other are all that is sound, and their pair was refused by itself.
    pub(in crate::network) pair_refused: bool,
    pub(in crate::network) expected: &'a Expected,
    /// The largest distance between two cameras.
    pub(in crate::network) rig: f64,
}

/// A test that finds fault, or does not.
type CameraTest = fn(&CameraFindings) -> Option<CameraStatus>;

/// Tests of a camera that stands by name, in their order.
pub(in crate::network) const CAMERA_TESTS: [(&str, CameraTest); 9] = [
    ("no rival network", |f| f.rivalled.then_some(CameraStatus::Ambiguous)),
    ("what moves tells its clock", |f| f.clock_doubted.then_some(CameraStatus::Clock)),
    ("what was given agrees", |f| f.contradicted.then_some(CameraStatus::Contradicted)),
    ("rays meet at an angle", |f| unless(f.parallax >= limits::PARALLAX, CameraStatus::NoBaseline)),
    ("a plane leaves no focal length open", |f| unless(f.relief >= limits::RELIEF, CameraStatus::OnePlane)),
    ("of two the pair was accepted", |f| f.pair_refused.then_some(CameraStatus::PairRefused)),
    ("focal length known", |f| unless(f.expected.focal <= limits::MAX_FOCAL, CameraStatus::FocalLength)),
    ("rotation known", |f| unless(f.expected.rotation <= limits::MAX_ROTATION, CameraStatus::Rotation)),
    ("position known", |f| {
        unless(f.expected.position <= limits::MAX_POSITION * f.rig, CameraStatus::Position)
    }),
];

/// Fault, unless it is sound; so that NaN refuses.
fn unless(sound: bool, status: CameraStatus) -> Option<CameraStatus> {
    (!sound).then_some(status)
}

/// What is said of a camera that stands.
pub(in crate::network) fn status(findings: &CameraFindings) -> CameraStatus {
    CAMERA_TESTS.iter().find_map(|(_, test)| test(findings)).unwrap_or(CameraStatus::Accepted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_knock_that_keeps_least_is_named_first() {
        let knock = |at, keeps| Some(Knock { at, keeps });
        assert_eq!(
            worst_knock(&[knock(3.0, 0.17), None, knock(30.0, 0.02), knock(3.0, 0.02)]),
            Some((2, 30.0))
        );
        assert_eq!(worst_knock(&[None, None]), None);
    }

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
        let status_by_errors = |expected: &Expected, rig| {
            status(&CameraFindings {
                rivalled: false,
                clock_doubted: false,
                contradicted: false,
                parallax: limits::PARALLAX,
                relief: limits::RELIEF,
                pair_refused: false,
                expected,
                rig,
            })
        };
        assert_eq!(status_by_errors(&good, 1.0), CameraStatus::Accepted);
        assert_eq!(status_by_errors(&Expected::UNKNOWN, 1.0), CameraStatus::FocalLength);
        assert_eq!(status_by_errors(&Expected { rotation: f64::NAN, ..good }, 1.0), CameraStatus::Rotation);
        assert_eq!(status_by_errors(&good, f64::NAN), CameraStatus::Position);
        assert_eq!(status_by_errors(&Expected { position: 0.2, ..good }, 1.0), CameraStatus::Position);
    }

    #[test]
    fn the_first_fault_is_said_of_a_camera() {
        let unknown = CameraFindings {
            rivalled: true,
            clock_doubted: true,
            contradicted: true,
            parallax: f64::NAN,
            relief: f64::NAN,
            pair_refused: true,
            expected: &Expected::UNKNOWN,
            rig: 1.0,
        };
        assert_eq!(status(&unknown), CameraStatus::Ambiguous);
        let at_any_time = CameraFindings { rivalled: false, ..unknown };
        assert_eq!(status(&at_any_time), CameraStatus::Clock);
        let contradicted = CameraFindings { clock_doubted: false, ..at_any_time };
        assert_eq!(status(&contradicted), CameraStatus::Contradicted);
        let at_one_place = CameraFindings { contradicted: false, ..contradicted };
        assert_eq!(status(&at_one_place), CameraStatus::NoBaseline);
        let in_one_plane = CameraFindings { parallax: limits::PARALLAX, ..at_one_place };
        assert_eq!(status(&in_one_plane), CameraStatus::OnePlane);
        let refused = CameraFindings { relief: limits::RELIEF, ..in_one_plane };
        assert_eq!(status(&refused), CameraStatus::PairRefused);
        assert_eq!(status(&CameraFindings { pair_refused: false, ..refused }), CameraStatus::FocalLength);
    }
}
