//! Whole silhouettes that meet: what both ends of one say together, and what it says that an end misses.
//!
//! A silhouette of A has two epipolar tangents, its *ends*. If `F` is right and B sees the same object, both meet the ends
//! of *one* silhouette of B. Where the view ends before an end does, the other end has to do. One end alone meets as well
//! where two objects are one silhouette in a view, or something hides a part; that happens, but a geometry under which
//! it is all that happens has the floor right and nothing else.
//!
//! So a silhouette is evidence by the likelihood ratio of a mixture against chance,
//!
//! ```text
//! ln(1 − π + π ((1 − τ) X_whole + τ ½ (X₁ + X₂))),   X = (3/2) m / q
//! ```
//!
//! with `π` the share of silhouettes whose object the other camera sees, `τ` the share of these with but one end
//! that meets, and for each end the likelihood ratio `X` of a match of quality `m` whose chance is `q`: the quality of matches
//! by chance is 2/3 in the mean, so the mean of `X` is 1 under chance. `X_whole` is the product of both where both ends
//! meet the same silhouette, that of one end where the other is cut off, and 0 otherwise. A miss counts `ln(1 − π)`, if chance had
//! it met as seldom as that; by chance the mean of the whole is below nought (Jensen).

use super::super::matches::Outcome;
use super::arrays::Sent;
use super::elementary::logarithm;
use super::tangents::{NONE, Sides, Tangents, partner};

/// Share of the silhouettes whose object the other camera is taken to see as well, on the low side: under true geometries
/// 0.15 to 0.9 met.
const COMMON: f64 = 0.15;
/// Share of these that meet with one end only: of those that met seen 0.1 in open rooms, 0.75 in crowds.
const TORN: f64 = 0.4;

/// The silhouettes of A.
#[derive(Debug, Default)]
pub(super) struct Objects {
    pub(super) outcome: Vec<Outcome>,
    /// What each adds to the evidence.
    pub(super) evidence: Vec<f64>,
}

impl Objects {
    /// From what became of the tangents of both sides at a radius.
    pub(super) fn fill(
        &mut self,
        a: &[Tangents; 2],
        b: &[Tangents; 2],
        sent: &[Sent; 2],
        sides: Sides,
        radius: f64,
    ) {
        let radius2 = radius * radius;
        let hulls = a[0].of_hull.len();
        self.outcome.clear();
        self.evidence.clear();
        let targets = [0, 1].map(|side| &b[partner(side, sides)]);
        for hull in 0..hulls {
            let ends = [0, 1].map(|side| a[side].of_hull[hull]);
            // The silhouette that each end met, and the likelihood ratio of that.
            let met = [0, 1].map(|side| {
                let i = ends[side] as usize;
                if ends[side] == NONE || sent[side].squared[i] >= radius2 {
                    return (NONE, 0.0);
                }
                let quality = 1.0 - sent[side].squared[i] / radius2;
                (targets[side].hull[sent[side].met[i] as usize], 1.5 * quality / sent[side].chance[i])
            });
            let [(first, x), (second, y)] = met;
            let shows = ends.map(|end| end != NONE);
            let (outcome, ratio) = match shows {
                [false, false] => (Outcome::Hidden, 1.0),
                [true, true] if first != NONE && first == second => {
                    (Outcome::Whole, (1.0 - TORN) * x * y + TORN * 0.5 * (x + y))
                }
                _ => {
                    // The end of a partner that an end of this silhouette should have met.
                    let cut = |side: usize, partner: u32| {
                        !shows[1 - side] || targets[1 - side].of_hull[partner as usize] == NONE
                    };
                    let ratio_of = |side: usize, partner: u32, ratio: f64| match partner {
                        NONE => (Outcome::Missed, 0.0),
                        _ if cut(side, partner) => (Outcome::Cut, ratio),
                        _ => (Outcome::Torn, TORN * 0.5 * ratio),
                    };
                    let (p, q) = (ratio_of(0, first, x), ratio_of(1, second, y));
                    let outcome = match (p.0, q.0) {
                        (Outcome::Cut, _) | (_, Outcome::Cut) => Outcome::Cut,
                        (Outcome::Torn, _) | (_, Outcome::Torn) => Outcome::Torn,
                        _ => Outcome::Missed,
                    };
                    (outcome, p.1 + q.1)
                }
            };
            self.outcome.push(outcome);
            let evidence =
                if outcome == Outcome::Hidden { 0.0 } else { logarithm(1.0 - COMMON + COMMON * ratio) };
            self.evidence.push(evidence);
        }
    }
}
