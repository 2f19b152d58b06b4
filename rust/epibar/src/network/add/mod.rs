//! One more camera for a network that stands: where is it, by footage that it and cameras of the network filmed together?
//!
//! The cameras of the network are held as they are stored, but for their clocks, which are those of the new footage. A new one is put
//! wherever one of its pairs would have it, and what it sees with all of them decides, as for a camera of a new network. Each is solved
//! for and judged by itself, against the stored ones alone: two that filmed another scene together would vouch for each other.
//!
//! * `pairs`: which pairs are worth a search.
//! * `held`: the cameras of the network, and what is given of a new one.
//! * `newcomer`: where one camera stands, what speaks for it, and by how much that may be wrong.

mod held;
mod newcomer;
mod pairs;

use held::{Given, Held};
use newcomer::Newcomer;
pub use pairs::pairs_to_add;

use super::check::{StoredCamera, refuse, refused};
use super::evidence::support::{Deviates, Support};
use super::given::clocks::Offsets;
use super::given::input::CameraInput;
use super::given::pair::PairFound;
use super::observations::observed::Observed;
use super::observations::survey::Survey;
use super::result::{NetworkCamera, NetworkPair, PairStatus, fundamental};
use super::solve::networks::FRAMES;
use super::solve::relocate::Placed;
use super::thresholds as limits;
use super::verdict::{outside, position_error};
use crate::error::Result;
use crate::watch::{Stage, Watch, report};

/// Cameras that were to be added to a network.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Added {
    /// The new cameras in the order given, in the world of the network; one that is not accepted says why, and is no part of it.
    pub cameras: Vec<NetworkCamera>,
    /// All pairs `a < b` of which one camera at least is new; the stored cameras are counted first.
    pub pairs: Vec<NetworkPair>,
}

/// Adds cameras to a network by new footage: focal length, lens, rotation, position and clock of each, the cameras of the network held as
/// they are stored.
///
/// `pairs` and `clocks` count the stored cameras first, and then the new ones; the clock of the first stored camera is the network's.
/// A stored camera that has moved must not be among them: see [`check_network`](super::check_network). Refusing is a result, not an
/// error: at least two stored cameras must confirm a new one on moments kept aside, and what is stated of its errors holds theirs.
///
/// # Errors
/// [`Error::Argument`](crate::Error::Argument) for fewer than two stored cameras, for two of one name, for numbers that no camera has, for
/// pairs of cameras that are not there, and where there is not a clock for each; [`Error::Interrupted`](crate::Error::Interrupted).
pub fn add_cameras(
    stored: &[StoredCamera],
    added: &[CameraInput],
    pairs: &[PairFound],
    clocks: &Offsets,
    watch: &mut dyn Watch,
) -> Result<Added> {
    refuse_given(stored, added, pairs, clocks)?;
    report(watch, Stage::Network, 0.0)?;
    let held = Held::of(stored, clocks);
    let n = stored.len();
    let mut cameras = Vec::new();
    let mut of_stored = Vec::new();
    for (k, input) in added.iter().enumerate() {
        let mut tell = |share: f64| report(watch, Stage::Network, (k as f64 + share) / added.len() as f64);
        tell(0.0)?;
        let given = Given::of(&held, input, n + k, pairs, clocks);
        let (camera, pairs) = Newcomer::new(&held, &given).judged(&mut tell)?;
        of_stored.extend(pairs.into_iter().map(|pair| NetworkPair { b: n + k, ..pair }));
        cameras.push(camera);
    }
    let mut pairs = of_stored;
    pairs.extend(between(&held, added, &cameras));
    pairs.sort_by_key(|p| (p.a, p.b));
    Ok(Added { cameras, pairs })
}

/// Pairs of new cameras, of which neither had a part in where the other stands.
fn between(held: &Held, added: &[CameraInput], cameras: &[NetworkCamera]) -> Vec<NetworkPair> {
    let n = held.stored.len();
    let new: Vec<(usize, usize)> =
        (0..added.len()).flat_map(|a| (a + 1..added.len()).map(move |b| (a, b))).collect();
    let accepted = |c: usize| cameras[c].camera.filter(|_| cameras[c].accepted());
    let observed: Vec<Observed> = added.iter().map(|i| Observed::new(i.recording)).collect();
    let survey = Survey::new(&observed, FRAMES[1]);
    let of = |(a, b): (usize, usize)| {
        let outside = outside((n + a, n + b));
        let (Some(one), Some(other)) = (accepted(a), accepted(b)) else { return outside };
        let placed = (0..added.len()).map(|c| c == a || c == b).collect();
        let all = cameras.iter().map(|c| c.camera.unwrap_or(one)).collect();
        let found = Support::on(&survey, &Placed { cameras: all, placed });
        let deviates = found.pairs.first().map_or(Deviates::default(), |(_, deviates)| *deviates);
        let confirmed = deviates.tangents >= limits::PAIR_DEVIATES;
        let status = if confirmed { PairStatus::Confirmed } else { PairStatus::Predicted };
        let pair = NetworkPair { status, fundamental: fundamental(&one, &other), deviates, ..outside };
        pair.accepted_with_baseline([&one, &other], position_error([&cameras[a], &cameras[b]]))
    };
    new.into_iter().map(of).collect()
}

fn refuse_given(
    stored: &[StoredCamera],
    added: &[CameraInput],
    pairs: &[PairFound],
    clocks: &Offsets,
) -> Result<()> {
    refuse(stored)?;
    let count = stored.len() + added.len();
    if clocks.seconds.len() != count {
        return refused("clocks", clocks.seconds.len().to_string(), "a clock for each camera");
    }
    if !clocks.seconds[..stored.len()].iter().all(|s| s.is_finite()) {
        return refused("clocks", format!("{:?}", clocks.seconds), "the clock of every stored camera");
    }
    for (k, input) in added.iter().enumerate() {
        let named = |name: &str| name == input.name;
        if stored.iter().any(|c| named(c.name)) || added[..k].iter().any(|c| named(c.name)) {
            return refused("cameras", input.name.to_owned(), "names of cameras that differ");
        }
        input.known.check()?;
    }
    for pair in pairs {
        if pair.a >= pair.b || pair.b >= count || pair.geometries.is_empty() {
            return refused("pairs", format!("{}, {}", pair.a, pair.b), "two cameras a < b, with a geometry");
        }
    }
    Ok(())
}
