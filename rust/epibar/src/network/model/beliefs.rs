//! What is known of a camera before anything is seen.

use super::optics::INTRINSIC;

/// What is known of one number before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belief {
    /// Its most likely value.
    pub mean: f64,
    /// Standard deviation; 0 where it is not solved for, infinite where nothing is known.
    pub deviation: f64,
}

impl Belief {
    /// Given, and not solved for.
    pub fn fixed(mean: f64) -> Self {
        Self { mean, deviation: 0.0 }
    }

    /// With a standard deviation.
    pub fn about(mean: f64, deviation: f64) -> Self {
        Self { mean, deviation }
    }
}

/// What is known of a camera before: beliefs in the order of the parameters `log f, log f_y / f_x, c_x, c_y, k₁, k₂, k₃`.
///
/// The belief on `k₂` is about `BEND k₁²`, and the one on `k₃` about `BEND k₁³`: lenses of one family differ in one number, and one that
/// bends strongly does not fold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beliefs {
    /// Of the camera by itself.
    pub intrinsic: [Belief; INTRINSIC],
    /// Of the clock: offset, seconds, and drift, ppm. That of the first camera is the network's, and fixed where all are solved for.
    pub clock: [Belief; 2],
    /// The principal point is near the middle, as those of the other cameras are, and nothing else is known of it.
    pub centred: bool,
    /// Of the insets of its silhouettes.
    pub insets: InsetBeliefs,
    /// Where it stands and looks is given, and not solved for.
    pub posed: bool,
}

/// What is known before of the [`Insets`](super::insets::Insets) of a camera, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InsetBeliefs {
    /// Of that all around.
    pub all: Belief,
    /// Of how much more it is of silhouettes half as large as usual.
    pub small: Belief,
    /// Of how much more it is on each side.
    pub sides: Belief,
}

impl InsetBeliefs {
    /// The same everywhere.
    pub fn all_around(all: Belief) -> Self {
        Self { all, small: Belief::fixed(0.0), sides: Belief::fixed(0.0) }
    }
}

/// Other focal lengths are tried as well where the standard deviation of its log is not below this.
const NARROW_FOCAL: f64 = 0.1;

impl Beliefs {
    /// Whether the focal length is known so well that no other needs to be tried.
    pub fn has_focal(&self) -> bool {
        self.intrinsic[0].deviation < NARROW_FOCAL
    }
}
