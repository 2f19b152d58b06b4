//! What new footage says of a camera, as a result with its sentence.

use super::one_camera::Move;
use super::replace::{NoPlace, Replaced};
use super::which_moved::Judged;
use crate::network::result::{CameraCheck, CheckStatus};
use crate::network::thresholds as limits;

/// What a camera saw, and how much of it the others saw.
pub struct NewFootage<'o> {
    /// Names of all cameras.
    pub names: &'o [&'o str],
    /// What it has in common with the others, as a normal deviate.
    pub deviate: f64,
}

/// Of one other camera, or several on one line, tangents stay as they are whatever the distance.
const UNSEEN: &str =
    ", but not a shift along the line to who sees the same: film with a camera that stands off that line";

/// The result of one camera.
pub fn said(camera: usize, seen: &NewFootage, judged: &Judged, replaced: Replaced) -> CameraCheck {
    let found = judged.found[camera].as_ref();
    let rivals: Vec<&str> = judged.rivals[camera].iter().map(|&r| seen.names[r]).collect();
    let status = judged.status(camera, seen.deviate);
    let film = |time: f64| judged.now.cameras[camera].clock_at(time);
    let moved = matches!(status, CheckStatus::Moved | CheckStatus::Suspect);
    let since = found.filter(|f| moved && f.is_within()).map(|f| film(f.since));
    // One that is put where it stands now was measured with what outlines are wrong by.
    let stated = found.map(|f| if replaced.is_ok() { *f } else { f.beside_stored() });
    let of = |value: fn(&Move) -> f64| stated.as_ref().map_or(f64::NAN, value);
    let reason = match (status, found.zip(stated.as_ref())) {
        (CheckStatus::Moved, Some((_, stated))) => {
            let what = of_move("it", stated, since);
            replaced.as_ref().err().map_or_else(|| what.clone(), |why| format!("{what}; {}", no_place(*why)))
        }
        (CheckStatus::Suspect, Some((_, stated))) => format!(
            "it or {} moved, and what was filmed does not tell which; if it was this one, {}",
            rivals.join(" or "),
            of_move("it", stated, since)
        ),
        (CheckStatus::Unmoved, Some((found, _))) => format!(
            "it stands as stored: a turn of {:.2} degrees would have been noticed, and a focal length changed by {:.1} %{}",
            limits::MOVED * found.turned_error.to_degrees(),
            100.0 * limits::MOVED * found.focal_error,
            if found.shifted_error.is_finite() { "" } else { UNSEEN }
        ),
        (CheckStatus::Unsure, Some((found, stated))) if found.is_far() && seen.deviate >= limits::CAMERA_DEVIATES => {
            format!(
                "it may have moved, but too few moments say so: film for longer; if so, {}",
                of_move("it", stated, None)
            )
        }
        _ => {
            "what moves in it does not agree with the others: too little moved before several cameras, it moved by more than a few degrees, or it shows something else".to_owned()
        }
    };
    CameraCheck {
        name: seen.names[camera].to_owned(),
        status,
        reason,
        turned: of(|f| f.turned),
        turned_error: of(|f| f.turned_error),
        shifted: of(|f| f.shifted),
        shifted_error: of(|f| f.shifted_error),
        focal: of(|f| f.focal.exp_m1()),
        focal_error: of(|f| f.focal_error * f.focal.exp()),
        deviate: seen.deviate,
        since,
        place: replaced.ok().filter(|_| status == CheckStatus::Moved),
        rivals: if status == CheckStatus::Suspect { judged.rivals[camera].clone() } else { Vec::new() },
    }
}

fn no_place(why: NoPlace) -> &'static str {
    match why {
        NoPlace::Stands => "it did not move",
        NoPlace::OneOfSeveral => {
            "another camera moved of which it is not known which, so its new place is not certain"
        }
        NoPlace::Unconfirmed => "too few cameras that stand confirm its new place",
        NoPlace::OrZoomed => "its new place is not certain",
        NoPlace::LeftOver => {
            "its new place leaves something over: a pair by itself agrees clearly better with another one"
        }
    }
}

fn of_move(which: &str, found: &Move, since: Option<f64>) -> String {
    let when = since.map_or_else(|| "before this footage".to_owned(), |s| format!("at about {s:.0} s"));
    let shifted = match found.shifted_error {
        error if error.is_finite() => {
            format!(
                "and {:.3} from where it stood (to {error:.3}), in the unit of the network",
                found.shifted
            )
        }
        _ => "and may stand elsewhere on the line to who sees the same, which nothing tells".to_owned(),
    };
    let turned = format!(
        "turned by {:.2} degrees (to {:.2}), {shifted}",
        found.turned.to_degrees(),
        found.turned_error.to_degrees(),
    );
    let zoomed = format!(
        "its focal length changed by {:+.2} % (to {:.2} %)",
        100.0 * found.focal.exp_m1(),
        100.0 * found.focal_error * found.focal.exp()
    );
    match (found.zoomed, found.reposed) {
        (true, true) => format!("{which} changed {when}: {zoomed}, and it is {turned}"),
        (true, false) => format!("{which} was zoomed {when}: {zoomed}; it stands and looks as stored"),
        (false, _) if found.or_zoomed => {
            format!("{which} moved {when}: it is {turned}; or instead {zoomed}, which explains as much")
        }
        (false, _) => format!("{which} moved {when}: it is {turned}"),
    }
}
