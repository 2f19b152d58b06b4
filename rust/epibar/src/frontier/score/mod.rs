//! The frontier score: epipolar tangents of A that meet tangents of B, over chance, silhouette by silhouette.
//!
//! For a proposed `F`, every silhouette has two tangents from the epipole. A tangent of A, sent to B, should
//! meet a tangent of B that has its object on the corresponding side. A match counts by how unlikely it was, with
//! `q` the chance that *some* tangent of B lies that near at any other time, and `m = max(0, 1 − d²/r²)` for the Sampson
//! distance `d` of its match. Where everything is tangent at one place all the time (heads on the horizon, an epipole on the
//! border) `q ≈ 1` and nothing is gained.
//!
//! The score is the evidence of whole silhouettes ([`objects`]): what both ends of one say together, and what it says that an
//! end misses. Beside it, tops and bottoms are summed apart, each tangent with `(m − ⅔ q) · (−ln q)`, which is nought in the
//! mean by chance, so that each class can be asked whether it stands out.
//!
//! *Orientation.* Epipolar rays, not just lines, correspond (Laveau and Faugeras 1996): seen from both
//! cameras a point in front of both lies on one half of its epipolar line. The map of rays is `± F`; the map of
//! sides is fixed by `F` alone: it is the orientation of the 1-D homography.

mod angles;
mod arrays;
mod comparer;
mod elementary;
mod objects;
mod passes;
mod tangents;

pub use comparer::{Comparer, Paired};
pub(crate) use elementary::logarithm;

use super::matches::{FrontierScore, TangentMatch};
use super::views::Views;
use crate::geometry::Fundamental;

/// The comparison of all tangents under one `F`.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// Score of `F`.
    pub score: FrontierScore,
    /// The tangents that meet, by frames.
    pub matches: Vec<TangentMatch>,
}

/// Compares all tangents of two views under `F`; two meet below a Sampson distance of `radius` pixels.
pub fn compare(views: &Views, f: &Fundamental, radius: f64) -> Comparison {
    let mut comparer = Comparer::new(views, f);
    let mut paired = comparer.pair(0, radius);
    let weighed = paired.weigh(radius);
    Comparison { score: weighed.score(), matches: weighed.matches() }
}

/// [`Comparison::matches`] of [`compare`], which takes less than the whole of it.
pub fn tangent_matches(views: &Views, f: &Fundamental, radius: f64) -> Vec<TangentMatch> {
    Comparer::new(views, f).pair(0, radius).matches(radius)
}

/// The score of `F` alone; two tangents meet below a Sampson distance of `radius` pixels.
pub fn frontier_score(views: &Views, f: &Fundamental, radius: f64) -> FrontierScore {
    shifted_score(views, f, radius, 0)
}

/// [`FrontierScore::total`] of [`frontier_score`], which takes less than the whole of it.
pub fn total_score(views: &Views, f: &Fundamental, radius: f64) -> f64 {
    Comparer::new(views, f).pair(0, radius).weigh(radius).total()
}

/// The score of `F` with frame `t` of A beside frame `t + shift` of B, cyclically: what chance gives.
pub fn shifted_score(views: &Views, f: &Fundamental, radius: f64, shift: usize) -> FrontierScore {
    Comparer::new(views, f).pair(shift, radius).weigh(radius).score()
}
