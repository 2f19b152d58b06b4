//! What comes out: a walker at one moment, and what two cameras saw of it.

/// A walker at one moment.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TrackPoint {
    /// Seconds of the network's clock.
    pub time: f64,
    /// Which track, from 0 in the order of their beginnings.
    pub track: u32,
    /// The bottom: a foot, in the network's unit.
    pub foot: [f64; 3],
    /// The top.
    pub top: [f64; 3],
    /// Which cameras saw both.
    pub cameras: Vec<bool>,
    /// Root mean square of what top and bottom are off in these cameras, pixels.
    pub residual: f64,
    /// What each two of these cameras saw, at 1000 moments at most that are spread over the time; none at the others.
    pub sightings: Vec<TrackSighting>,
}

/// The top and the bottom of a walker in two cameras: frontier points, of which either is one point of the surface.
///
/// Two other cameras see another point of the same head, so no top is that of three cameras.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TrackSighting {
    /// The cameras, the first by number first.
    pub cameras: [usize; 2],
    /// Raw pixels of the top in either; where a moment falls between two frames, between what they show.
    pub top: [[f64; 2]; 2],
    /// Raw pixels of the bottom in either.
    pub foot: [[f64; 2]; 2],
}
