//! The cameras of the network that are held, and what is given of a new one beside them.

use crate::network::check::{StoredCamera, by_new_clocks};
use crate::network::given::clocks::Offsets;
use crate::network::given::input::{CameraInput, Knowledge};
use crate::network::given::pair::PairFound;
use crate::network::model::beliefs::Beliefs;
use crate::network::model::camera::Camera;
use crate::network::observations::observed::Observed;
use crate::network::observations::survey::Survey;
use crate::network::solve::networks::FRAMES;

/// The cameras that are held.
pub struct Held<'a> {
    /// As they are stored.
    pub stored: &'a [StoredCamera<'a>],
    /// What they saw.
    pub observed: Vec<Observed>,
    /// By the clocks and insets of the new footage.
    pub cameras: Vec<Camera>,
    /// What is believed of them.
    pub beliefs: Vec<Beliefs>,
}

impl<'a> Held<'a> {
    /// Stored cameras, with the clocks that they have by what they saw together.
    pub fn of(stored: &'a [StoredCamera], clocks: &Offsets) -> Self {
        let through = |c: &StoredCamera| c.solvable();
        let observed: Vec<Observed> =
            stored.iter().map(|c| Observed::new(c.recording).through(&through(c))).collect();
        let (held, beliefs) = by_new_clocks(stored, clocks, &Survey::new(&observed, FRAMES[1]));
        Self { stored, observed, cameras: held.cameras, beliefs }
    }
}

/// What is given of one new camera, which is counted after those that are held.
pub struct Given<'a> {
    /// All cameras.
    pub inputs: Vec<CameraInput<'a>>,
    /// Its pairs with those that are held.
    pub pairs: Vec<PairFound>,
    /// Clocks of all.
    pub clocks: Offsets,
}

impl<'a> Given<'a> {
    /// Of the camera that is number `camera` where all new ones are counted.
    pub fn of(
        held: &Held<'a>,
        added: &'a CameraInput,
        camera: usize,
        pairs: &[PairFound],
        clocks: &Offsets,
    ) -> Self {
        let n = held.stored.len();
        let known =
            |c: &StoredCamera| Knowledge::new().matrix(c.camera.matrix).distortions(c.camera.distortions);
        let input = |c: &StoredCamera<'a>| CameraInput::new(c.name, c.recording).known(known(c));
        let own = pairs.iter().filter(|p| p.b == camera && p.a < n);
        Self {
            inputs: held.stored.iter().map(input).chain([*added]).collect(),
            pairs: own.map(|p| PairFound { b: n, ..p.clone() }).collect(),
            clocks: Offsets {
                seconds: [&clocks.seconds[..n], &[clocks.seconds[camera]]].concat(),
                ..*clocks
            },
        }
    }
}
