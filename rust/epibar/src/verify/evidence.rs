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
    /// Share of A's tangents that meet a tangent of B, on frames kept aside.
    pub explained: f64,
    /// That share with the clocks shifted, in the mean.
    pub explained_by_chance: f64,
    /// How far four fifths of the frontier points lie from the best plane, in widths of a silhouette.
    pub plane_residual: f64,
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
            explained: 0.0,
            explained_by_chance: 0.0,
            plane_residual: f64::NAN,
            essential_deviation: f64::NAN,
        }
    }
}
