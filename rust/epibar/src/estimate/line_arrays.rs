//! Candidates as flat arrays, for what is asked of all of them under every hypothesis.

use pulp::{Arch, Simd, WithSimd};

use super::line_model::AREA_THRESHOLD;
use crate::bits::{ones_of, word_of};
use crate::geometry::Fundamental;
use crate::line::{Homogeneous, ImageSize};
use crate::matching::Candidate;

/// Candidates whose answers are one word.
const WORD: usize = 64;
/// Mean widths of the largest area of an inlier that a line may be off in the middle of its segment.
const WIDTHS: f64 = 4.0;

/// The lines of candidates, and the middles of their segments; whole words of them, what is beyond the last is never chosen.
pub(super) struct LineArrays {
    count: usize,
    lines_a: [Vec<f64>; 3],
    lines_b: [Vec<f64>; 3],
    middles_a: [Vec<f64>; 2],
    middles_b: [Vec<f64>; 2],
    /// The distance of a middle in B that no inlier exceeds, pixels².
    most2: Vec<f64>,
}

impl LineArrays {
    pub(super) fn new(candidates: &[Candidate], size_b: ImageSize) -> Self {
        let len = candidates.len().next_multiple_of(WORD);
        let filled = |of: &dyn Fn(&Candidate) -> f64, beyond: f64| -> Vec<f64> {
            let mut values: Vec<f64> = candidates.iter().map(of).collect();
            values.resize(len, beyond);
            values
        };
        let limit = WIDTHS * AREA_THRESHOLD * size_b.width as f64;
        Self {
            count: candidates.len(),
            lines_a: [0, 1, 2].map(|k| filled(&|c| c.lines.a.homogeneous()[k], 0.0)),
            lines_b: [0, 1, 2].map(|k| filled(&|c| c.lines.b.homogeneous()[k], 0.0)),
            middles_a: [0, 1].map(|k| filled(&|c| c.segment_a.midpoint()[k], 0.0)),
            middles_b: [0, 1].map(|k| filled(&|c| c.segment_b.midpoint()[k], 0.0)),
            // With room for rounding: whatever is near the limit is looked at.
            most2: filled(&|c| (limit / (0.5 * c.segment_b.length())).powi(2) * (1.0 + 1e-9), -1.0),
        }
    }

    /// The candidate with the least `|l·e| s + |l'·e'| s'`, other than two, and the first of equal ones.
    pub(super) fn nearest(&self, points: [(Homogeneous, f64); 2], except: [usize; 2]) -> Option<usize> {
        Arch::new().dispatch(Nearest { arrays: self, points, except })
    }

    /// Tells, in their order, of all candidates whose line in B may be within the area of an inlier.
    pub(super) fn possible(&self, f: &Fundamental, mut tell: impl FnMut(usize)) {
        let mut words = vec![0u64; self.most2.len() / WORD];
        Arch::new().dispatch(Possible { arrays: self, f, words: &mut words });
        for (w, word) in words.into_iter().enumerate() {
            ones_of(word).for_each(|k| tell(w * WORD + k));
        }
    }
}

/// Pass: see [`LineArrays::nearest`].
struct Nearest<'a> {
    arrays: &'a LineArrays,
    points: [(Homogeneous, f64); 2],
    except: [usize; 2],
}

impl WithSimd for Nearest<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<usize> {
        let Self { arrays, points: [e, f], except } = self;
        let mut distances = vec![0.0; arrays.most2.len()];
        let sums = S::as_mut_simd_f64s(&mut distances).0;
        for (lines, (point, scale)) in [(&arrays.lines_a, e), (&arrays.lines_b, f)] {
            let [a, b, c] = lines.each_ref().map(|part| S::as_simd_f64s(part).0);
            let [x, y, w] = [point.x, point.y, point.z].map(|part| simd.splat_f64s(part));
            let scale = simd.splat_f64s(scale);
            for (sum, ((a, b), c)) in sums.iter_mut().zip(a.iter().zip(b).zip(c)) {
                let dot = simd.add_f64s(simd.mul_f64s(*a, x), simd.mul_f64s(*b, y));
                let dot = simd.add_f64s(dot, simd.mul_f64s(*c, w));
                *sum = simd.add_f64s(*sum, simd.abs_f64s(simd.mul_f64s(dot, scale)));
            }
        }
        distances[arrays.count..].fill(f64::INFINITY);
        for at in except {
            distances[at] = f64::INFINITY;
        }
        let mut least = simd.splat_f64s(f64::INFINITY);
        for values in S::as_simd_f64s(&distances).0 {
            least = simd.min_f64s(*values, least);
        }
        let least = simd.reduce_min_f64s(least);
        if least < f64::INFINITY { distances.iter().position(|d| *d == least) } else { None }
    }
}

/// Pass: see [`LineArrays::possible`].
struct Possible<'a> {
    arrays: &'a LineArrays,
    f: &'a Fundamental,
    words: &'a mut [u64],
}

impl WithSimd for Possible<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { arrays, f, words } = self;
        let m = f.matrix();
        let n = words.len() * WORD;
        let [ax, ay] = arrays.middles_a.each_ref().map(|part| &part[..n]);
        let [bx, by] = arrays.middles_b.each_ref().map(|part| &part[..n]);
        let most2 = &arrays.most2[..n];
        for (w, word) in words.iter_mut().enumerate() {
            let mut bytes = [0u8; WORD];
            for (k, byte) in bytes.iter_mut().enumerate() {
                let i = w * WORD + k;
                let line = [0, 1, 2].map(|r| m[(r, 0)] * ax[i] + m[(r, 1)] * ay[i] + m[(r, 2)]);
                let algebraic = line[0] * bx[i] + line[1] * by[i] + line[2];
                let norm2 = line[0] * line[0] + line[1] * line[1];
                *byte = u8::from(algebraic * algebraic <= most2[i] * norm2);
            }
            *word = word_of(&bytes);
        }
    }
}
