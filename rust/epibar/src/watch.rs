//! A long computation that is watched, and can be stopped.

use crate::error::{Error, Result};

/// What [`calibrate`](fn@crate::calibrate) is at, in about this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Stage {
    /// The offset between the clocks is searched by barcodes.
    TimeOffset,
    /// Lines with similar motion barcodes are sought.
    Candidates,
    /// A few hypotheses of every kind: where one geometry stands out among them, the stages up to [`Settle`](Self::Settle) are left out.
    Few,
    /// Hypotheses from the best candidates, scored by tangents.
    BestLines,
    /// Hypotheses from all candidates, scored by tangents.
    AllLines,
    /// Hypotheses from the best candidates, scored by line inliers.
    LineInliers,
    /// Homographies of a floor.
    Floor,
    /// Hypotheses from a floor.
    FloorEpipoles,
    /// Hypotheses from silhouettes followed through time.
    Tracks,
    /// Hypotheses from where figures stand on the floor.
    TopView,
    /// The best hypotheses are refined.
    Refine,
    /// The best solutions are fitted anew to samples of what meets under them, and refined.
    Restart,
    /// The best solutions are followed along the valley of the score that they lie in.
    Explore,
    /// The remaining solutions are refined on all frames.
    Settle,
    /// Line pairs alone, as in the paper.
    Lines,
    /// Pairs of a network are calibrated by themselves.
    Pairs,
    /// All cameras together.
    Network,
}

impl Stage {
    /// A word for programs and progress bars.
    pub fn name(self) -> &'static str {
        match self {
            Self::TimeOffset => "time_offset",
            Self::Candidates => "candidates",
            Self::Few => "few",
            Self::BestLines => "best_lines",
            Self::AllLines => "all_lines",
            Self::LineInliers => "line_inliers",
            Self::Floor => "floor",
            Self::FloorEpipoles => "floor_epipoles",
            Self::Tracks => "tracks",
            Self::TopView => "top_view",
            Self::Refine => "refine",
            Self::Restart => "restart",
            Self::Explore => "explore",
            Self::Settle => "settle",
            Self::Lines => "lines",
            Self::Pairs => "pairs",
            Self::Network => "network",
        }
    }
}

/// Lets a caller watch a long computation and stop it.
///
/// Closures `FnMut(Stage, f64) -> bool` watch:
///
/// ```
/// use epibar::{Stage, Watch};
///
/// let mut percent = |stage: Stage, done: f64| {
///     eprintln!("{}: {:.0} %", stage.name(), 100.0 * done);
///     true
/// };
/// assert!(Watch::keep_going(&mut percent, Stage::Refine, 0.5));
/// ```
pub trait Watch {
    /// Called between batches of work, on the calling thread: a stage, and how much of it is done (0 to 1). `false`
    /// stops with [`Error::Interrupted`].
    fn keep_going(&mut self, stage: Stage, done: f64) -> bool;
}

impl<F: FnMut(Stage, f64) -> bool> Watch for F {
    fn keep_going(&mut self, stage: Stage, done: f64) -> bool {
        self(stage, done)
    }
}

/// Watches nothing and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unwatched;

impl Watch for Unwatched {
    fn keep_going(&mut self, _stage: Stage, _done: f64) -> bool {
        true
    }
}

/// Reports to the watch.
///
/// # Errors
/// [`Error::Interrupted`] where the watch says so.
pub(crate) fn report(watch: &mut dyn Watch, stage: Stage, done: f64) -> Result<()> {
    if watch.keep_going(stage, done) { Ok(()) } else { Err(Error::Interrupted) }
}
