//! The numbers that a verdict rests on.

/// The statistics behind a verdict.
///
/// A *top* is a tangent whose object lies below it, a *bottom* one whose object lies above.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Evidence {
    /// Normal deviate of the score of all tangents against that with the clocks shifted, on frames kept aside.
    pub z: f64,
    /// Normal deviate of the score of tops alone.
    pub z_tops: f64,
    /// Normal deviate of the score of bottoms alone.
    pub z_bottoms: f64,
    /// Normal deviate of the number of silhouettes both of whose tangents meet those of one of the other camera.
    pub z_whole: f64,
    /// Share of the silhouettes that met with both ends, or with one though the other shows as well, on frames kept aside.
    pub both_ends: f64,
    /// Of tops, bottoms and whole silhouettes some deviate is of all frames, cross-validated, as it was faint on those kept
    /// aside.
    pub on_all_frames: bool,
    /// Share of both cameras' tangents that meet one of the other camera, on frames kept aside.
    pub explained: f64,
    /// Share of the tops that meet.
    pub explained_tops: f64,
    /// Share of the bottoms that meet.
    pub explained_bottoms: f64,
    /// Share of the tangents that meet with the clocks shifted, in the mean.
    pub explained_by_chance: f64,
    /// Mean symmetric epipolar distance, over the volume where things moved, of the matrix that was tested on frames kept
    /// aside from the one that is returned, pixels; NaN where nothing was tested.
    pub tested_distance: f64,
    /// How far four fifths of the frontier points lie from the best plane, in widths of a silhouette; NaN
    /// where there are too few to tell.
    pub plane_residual: f64,
    /// How far four fifths of the bottoms that meet lie from any straight line, in widths of a silhouette, in the image in which that is
    /// less: small on one path; NaN where that was not asked.
    pub spread_of_bottoms: f64,
    /// How far the tops that meet lie from the plane of the bottoms, their median with chance meetings taken off. In widths of a
    /// silhouette, of at least 30 px in a 640×480 image. Small in one plane, on a bare floor and without a baseline; NaN where that
    /// was not asked.
    pub tops_off_floor: f64,
    /// How far `F` may turn about the plane that half of the frontier points keep to without losing evidence: median over either
    /// image of the symmetric epipolar distance, pixels. 0 where it may not, or they keep to no plane; NaN where that was not
    /// asked.
    pub may_turn: f64,
    /// Whether the cameras stood still. At some moments the recording is cut in two, and the evidence on the worse side is divided
    /// by that of whichever geometry explains that side best; this is the least of these shares. 1 where neither side is worse
    /// than chance explains, near 0 where a camera was moved; NaN where that was not asked.
    pub holds: f64,
    /// How far the two halves of the recording disagree: `F` is refined on either, and this is the mean symmetric epipolar distance
    /// between the two over the volume where things moved, pixels. 0 where neither half has more evidence for its own than for the
    /// `F` of the whole; NaN where that was not asked.
    pub halves_apart: f64,
    /// How much both cameras' barcodes resemble those of a later moment at which others are in the places, a correlation; NaN
    /// where that was not asked.
    pub repeats: f64,
    /// `(s₁ − s₂) / (s₁ + s₂)` of the singular values of `K_bᵀ F K_a`, 0 for an essential matrix; NaN where the camera
    /// matrices are not known.
    pub essential_deviation: f64,
}

impl Default for Evidence {
    /// None.
    fn default() -> Self {
        Self {
            z: 0.0,
            z_tops: 0.0,
            z_bottoms: 0.0,
            z_whole: 0.0,
            both_ends: 0.0,
            on_all_frames: false,
            explained: 0.0,
            explained_tops: 0.0,
            explained_bottoms: 0.0,
            explained_by_chance: 0.0,
            tested_distance: f64::NAN,
            plane_residual: f64::NAN,
            spread_of_bottoms: f64::NAN,
            tops_off_floor: f64::NAN,
            may_turn: f64::NAN,
            holds: f64::NAN,
            halves_apart: f64::NAN,
            repeats: f64::NAN,
            essential_deviation: f64::NAN,
        }
    }
}
