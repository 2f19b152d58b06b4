//! What is said of cameras and networks, as sentences.

use crate::network::evidence::contradictions::Contradiction;
use crate::network::evidence::doubts::Doubt;
use crate::network::evidence::stated_errors::Expected;
use crate::network::given::input::{CameraInput, IntrinsicKind};
use crate::network::given::pair::PairFound;
use crate::network::model::beliefs::Beliefs;
use crate::network::model::camera::{Camera, INTRINSIC};
use crate::network::result::{CameraStatus, NetworkCamera, NetworkPair, PairStatus};
use crate::network::solve::world::Ground;
use crate::network::thresholds::{DOUBT_SAID, MAX_FOCAL, MAX_POSITION, MAX_ROTATION};

/// What was found of a camera.
pub(in crate::network) fn of_camera(
    status: CameraStatus,
    expected: &Expected,
    rig: f64,
    knocked_at: Option<f64>,
    input: &CameraInput,
    pairs: &[&PairFound],
) -> String {
    let percent = |share: f64| 100.0 * share;
    match status {
        CameraStatus::Accepted => {
            let focal = if expected.focal > 0.0 {
                format!("calibrated: nine times in ten the focal length is right to {:.2} %, the rotation", percent(expected.focal))
            } else {
                "calibrated with the focal length that is given: nine times in ten the rotation is right".to_owned()
            };
            let (rotation, position) = (expected.rotation.to_degrees(), percent(expected.position / rig));
            format!("{focal} to {rotation:.2} degrees, the position to {position:.2} % of the rig")
        }
        CameraStatus::NothingInCommon => {
            let recording = input.recording;
            let still = (0..recording.frames()).all(|i| recording.silhouettes.hulls(i).is_empty());
            let sees = if still {
                "nothing moves in it".to_owned()
            } else if pairs.iter().any(|p| p.accepted) {
                "too few of the other cameras confirm its place, though it agrees with one of them".to_owned()
            } else {
                "what moves in it does not move as in the other cameras".to_owned()
            };
            format!(
                "left out: {sees}. Does it show the same place at the same time, unmirrored? Film where several cameras see the same things move"
            )
        }
        CameraStatus::Apart => {
            "left out: it belongs to a smaller group of cameras, and nothing moved that cameras of both groups saw. Film where they see the same things move, or calibrate the groups by themselves".to_owned()
        }
        CameraStatus::Knocked => format!(
            "left out: it agrees with the others only before or only after about {:.0} s of its recording, so it was moved or stopped then. Cut the recording there",
            knocked_at.unwrap_or(f64::NAN)
        ),
        CameraStatus::FocalLength => format!(
            "the focal length is not determined: the error may be {:.0} %, and {:.0} % is the most that is accepted. Give it, or film longer and closer to the edges of the image",
            percent(expected.focal),
            percent(MAX_FOCAL)
        ),
        CameraStatus::Rotation => format!(
            "the rotation is not determined: the error may be {:.1} degrees, and {:.1} is the most that is accepted. Give the principal point, or film longer with more precise masks",
            expected.rotation.to_degrees(),
            MAX_ROTATION.to_degrees()
        ),
        CameraStatus::Position => format!(
            "the position is not determined: the error may be {:.0} % of the rig, and {:.0} % is the most that is accepted. Film where more cameras see the same things move",
            percent(expected.position / rig),
            percent(MAX_POSITION)
        ),
        CameraStatus::Ambiguous => {
            "it may as well stand elsewhere: another network explains what moves nearly as well. Film for longer, with movers everywhere in the images".to_owned()
        }
        CameraStatus::Clock => {
            "what moves does not tell when it filmed, and with that where it stands: with another offset of its clock other geometries explain as much, as where all moves one way at one speed. Give the offsets, or film what moves in different ways".to_owned()
        }
        CameraStatus::Contradicted => "what is given of it contradicts what moves".to_owned(),
        CameraStatus::NoBaseline => {
            "seen from here all that moves is in the same directions as from the other cameras, so they stand at one place, or what moves is too far away for them to stand apart: nothing tells how far, and which way. Place cameras at different sides of what moves".to_owned()
        }
        CameraStatus::OnePlane => {
            "all that moves keeps to one plane, as far as outlines tell, and of that unknown focal lengths cannot be told: give the focal length of this camera or of two others, or film people who walk all over the place, not flat things on the floor and not one file of people".to_owned()
        }
        CameraStatus::PairRefused => {
            "two cameras stand, of which nothing but their pair speaks, and that was not accepted by itself with this geometry: its verdict says why, and what to do (where lenses bend, with the lens taken out first). Or add a camera that sees the same".to_owned()
        }
        CameraStatus::TooFew => {
            "two cameras determine a network only with known focal lengths: give intrinsics, or add a third camera".to_owned()
        }
    }
}

/// Of a camera whose clock was given, where another one explains clearly more.
pub(in crate::network) const GIVEN_CLOCK: &str = "what moves speaks against the offset that was given of its clock, or of those it is compared with: with another one other geometries explain clearly more. Have the offsets found, or give the true ones";

/// Of a camera whose clock was given, where others explain as much.
pub(in crate::network) const GIVEN_CLOCK_BELIEVED: &str =
    "; the offset that was given of its clock is believed, as what moves does not tell it";

/// What was given of a camera and is contradicted by what moves.
pub(in crate::network) fn contradiction(found: &Contradiction, given: &Beliefs, fits: &Camera) -> String {
    let given = given.intrinsic.map(|belief| belief.mean);
    format!(
        "the {} that is given, {}, contradicts what moves: {} agrees with it, {:.0} standard deviations away. Correct what is given, or leave it out",
        name(found.kind),
        value(found.kind, given),
        value(found.kind, fits.intrinsic()),
        found.deviate
    )
}

/// What is added of a camera of which something that was given may be wrong.
pub(in crate::network) fn doubted(doubts: &[Doubt], camera: usize, held: &Camera) -> String {
    let of_camera = doubts.iter().filter(|d| d.share >= DOUBT_SAID && d.cameras.contains(&camera));
    let said = |doubt: &Doubt| {
        format!(
            "; the {} that is given, {}, may be wrong: {} would explain more of what moves, and the errors count that. Check it, or leave it out",
            name(doubt.kind),
            value(doubt.kind, held.intrinsic()),
            value(doubt.kind, held.stepped(&doubt.steps[camera]).intrinsic())
        )
    };
    of_camera.map(said).collect()
}

/// The numbers of one kind.
fn value(kind: IntrinsicKind, numbers: [f64; INTRINSIC]) -> String {
    let [log_focal, log_aspect, cx, cy, k1, k2, k3] = numbers;
    match kind {
        IntrinsicKind::Focal => format!("{:.1} px", log_focal.exp()),
        IntrinsicKind::Aspect => format!("{:.4}", log_aspect.exp()),
        IntrinsicKind::PrincipalPoint => format!("({cx:.1}, {cy:.1})"),
        IntrinsicKind::Lens => format!("k1 {k1:.3}, k2 {k2:.3}, k3 {k3:.3}"),
    }
}

/// Of a camera of which the same was given as of several others that are contradicted.
pub(in crate::network) fn given_like_others(kind: IntrinsicKind) -> String {
    let what = name(kind);
    format!(
        "the {what} that is given contradicts what moves in other cameras, so that of this one is not relied on. Correct what is given, or leave it out"
    )
}

fn name(kind: IntrinsicKind) -> &'static str {
    match kind {
        IntrinsicKind::Focal => "focal length",
        IntrinsicKind::Aspect => "fy / fx (1 where nothing is said)",
        IntrinsicKind::PrincipalPoint => "principal point",
        IntrinsicKind::Lens => "distortion",
    }
}

/// What is added of a camera whose pixels were taken for square.
pub(in crate::network) fn pixels_not_square(fits: &Camera) -> String {
    format!("; its pixels are not square, as they were taken to be: fy / fx is {:.4}", fits.log_aspect.exp())
}

/// What is added of a camera where that cannot be told.
pub(in crate::network) const PRINCIPAL_POINT_TAKEN_FOR_RIGHT: &str = "; what moves asks for another principal point than the one that is given, as boxes and ellipses do that stand for people: this holds if what is given is right";

/// What is added of a camera whose lens shows nothing in the corners of its images.
pub(in crate::network) fn short_lens(reach: f64) -> String {
    format!("; its lens holds up to {reach:.0} px from the principal point: use no pixels farther out")
}

/// What was found of the whole.
pub(in crate::network) fn of_network(
    cameras: &[NetworkCamera],
    pairs: &[NetworkPair],
    ground: &Ground,
) -> String {
    let names = |chosen: &dyn Fn(&NetworkCamera) -> bool| -> Vec<String> {
        cameras.iter().filter(|c| chosen(c)).map(|c| c.name.clone()).collect()
    };
    let refused = names(&|c| !c.accepted());
    let mut text = if refused.is_empty() {
        format!("all {} cameras are calibrated", cameras.len())
    } else if refused.len() == cameras.len() {
        let first = &cameras[0];
        if cameras.iter().all(|c| c.status == first.status) {
            format!("no camera is calibrated: {}", first.reason)
        } else {
            "no camera is calibrated; each says why".to_owned()
        }
    } else {
        format!(
            "{} of {} cameras are calibrated, not {}",
            cameras.len() - refused.len(),
            cameras.len(),
            refused.join(", ")
        )
    };
    let of_status = |status: PairStatus| {
        let pairs = pairs.iter().filter(|p| p.status == status);
        pairs.map(|p| format!("{}-{}", cameras[p.a].name, cameras[p.b].name)).collect::<Vec<_>>().join(", ")
    };
    let against = of_status(PairStatus::Contradicts);
    if !against.is_empty() {
        text += "; by themselves these pairs would have another geometry: ";
        text += &against;
    }
    let together = of_status(PairStatus::NoBaseline);
    if !together.is_empty() {
        text += "; these pairs stand at one place, as far as is known, so that they have no F, or are one film by two names: ";
        text += &together;
    }
    if cameras.iter().any(NetworkCamera::accepted) && *ground == Ground::Cameras {
        text += "; no floor was found, so up is the mean of the cameras' own";
    }
    text
}
