//! The numbers that decide between accepted and refused, in one table.
//!
//! `docs/trust.md` says what each is for and names the command that shows its margin.

/// Fewest common frames, and frames in which both cameras see a silhouette, that can be calibrated at all.
pub const MIN_FRAMES: usize = 16;
/// Fewest informative lines of a camera.
pub const MIN_LINES: usize = 2;
/// Fewest candidates that make a pencil.
pub const MIN_CANDIDATES: usize = 3;

/// Evidence below this normal deviate on frames kept aside is none. Unrelated pairs were never seen to reach 3, true ones of
/// 400 frames stood at 7 and more.
pub const MIN_Z: f64 = 5.0;
/// From this normal deviate on something suggests a common scene, if not enough.
pub const SOME_Z: f64 = 2.0;
/// Below this share of A's tangents that meet one of B, an `F` is not the geometry of the scene.
pub const MIN_EXPLAINED: f64 = 0.15;
/// Matched points must leave the best plane by this share of a silhouette's width: less is a path, a wall or no
/// baseline.
pub const MIN_DEPTH: f64 = 0.9;
/// Matched points at fewer different places say nothing: lamps that blink where they stand meet at the right moments under any
/// of many geometries. Such lamps were seen at 5 to 10 places, two walkers in 400 frames at 950.
pub const MIN_PLACES: usize = 50;
/// Size of a place, pixels of a 640×480 image.
pub const PLACE: f64 = 4.0;
/// Half of an image may be known no worse than this, pixels of a 640×480 image, by the covariance alone: of scenes with
/// depth it is 0.2 to 3.4, where all keep to one path 5 and more.
pub const MAX_BEYOND: f64 = 4.0;
/// A class of tangents below this normal deviate matches no better than chance.
pub const MIN_CLASS_Z: f64 = 2.0;
/// Below this on the frames kept aside a class is judged on all frames.
pub const FAINT_CLASS_Z: f64 = 3.0;
/// A different geometry whose score differs by less than this many standard deviations may be the truth as well.
pub const RIVAL_Z: f64 = 2.5;
/// Where nothing says which end of what moves is up, the mirror of the truth may have a higher score than the truth, which
/// was seen with this share of it.
pub const MIRROR_SHARE: f64 = 0.65;

/// Shifts of the clocks that say what is chance.
pub const SHIFTS: usize = 60;
/// Below this normal deviate of a geometry its silhouettes say nothing of the clock.
pub const MIN_Z_FOR_CLOCK: f64 = 4.0;

/// Share of the radius at which outlines agree that counts as a systematic error.
pub const COARSE_SHARE: f64 = 1.0;
/// Residuals of a fraction of a pixel are noise and average out; residuals of several pixels are outlines of different
/// shape, and do not. Their square over this many pixels of a 640×480 image counts as systematic.
pub const ROUGH_DEVIATION: f64 = 1.2;
/// Error that rasterisation leaves even in exact masks, pixels of a 640×480 image.
pub const GRID_ERROR: f64 = 0.06;
/// The covariance knows the noise of the outlines but not what all of them share; twice its error is what
/// `benchmarks/frontier.py` finds to hold for about nine pairs in ten.
pub const FIT_FACTOR: f64 = 2.0;
