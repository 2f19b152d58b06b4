//! Candidates as flat arrays: prefilters that are asked of all of them under every hypothesis.
//!
//! A prefilter passes every candidate that the exact test may accept, and some more; the exact test is the caller's.

use nalgebra::Matrix3;
use pulp::{Arch, Simd, WithSimd};

use crate::bits_of_bytes::{ones_of, word_of};
use crate::geometry::Fundamental;
use crate::image::{Homogeneous, Segment};
use crate::matching::Candidate;

/// Candidates whose bits are one word.
const WORD: usize = 64;
/// So many times its mean width, area by length, may an area between two lines be wide in the middle of a segment.
const WIDTHS: f64 = 8.0;
/// Room for rounding: whatever is near a limit passes.
const ROOM: f64 = 1.0 + 1e-9;

/// The lines of candidates and the ends of their segments, of A and of B; whole words of them, of which those beyond the
/// last never pass.
pub(super) struct LineArrays {
    count: usize,
    lines: [[Vec<f64>; 3]; 2],
    /// x and y of one end, x and y of the other.
    ends: [[Vec<f64>; 4]; 2],
    /// Square of the length of each segment in B, pixels².
    length2: Vec<f64>,
}

impl LineArrays {
    pub(super) fn new(candidates: &[Candidate]) -> Self {
        let len = candidates.len().next_multiple_of(WORD);
        let filled = |of: &dyn Fn(&Candidate) -> f64, beyond: f64| -> Vec<f64> {
            let mut values: Vec<f64> = candidates.iter().map(of).collect();
            values.resize(len, beyond);
            values
        };
        let of_view = |c: &Candidate, view: usize| {
            [(c.lines.a.homogeneous(), c.segment_a), (c.lines.b.homogeneous(), c.segment_b)][view]
        };
        let end = |s: Segment, k: usize| [s.x0, s.y0, s.x1, s.y1][k];
        Self {
            count: candidates.len(),
            lines: [0, 1].map(|view| [0, 1, 2].map(|k| filled(&|c| of_view(c, view).0[k], 0.0))),
            ends: [0, 1].map(|view| [0, 1, 2, 3].map(|k| filled(&|c| end(of_view(c, view).1, k), f64::NAN))),
            length2: filled(&|c| c.segment_b.length().powi(2), f64::NAN),
        }
    }

    /// The candidate with the least `|l·e| s + |l'·e'| s'`, two excepted, and the first of equal ones.
    pub(super) fn nearest(&self, points: [(Homogeneous, f64); 2], except: [usize; 2]) -> Option<usize> {
        Arch::new().dispatch(Nearest { arrays: self, points, except })
    }

    /// Visits, in order, the candidates whose line in B may enclose less than `area` pixels² with the line that `f` gives.
    ///
    /// What passes is near in the middle of its segment: not farther than [`WIDTHS`] times the mean width of such an area.
    /// Lines of any direction that go about the same corner enclose little too, but are not alike.
    pub(super) fn prefilter_area(&self, f: &Fundamental, area: f64, visit: impl FnMut(usize)) {
        let most2 = (WIDTHS * area).powi(2) * ROOM;
        self.visit(|words| Arch::new().dispatch(ByArea { arrays: self, f: f.matrix(), most2, words }), visit);
    }

    /// Visits, in order, the candidates that may fit a homography of points: both ends of both segments lie within
    /// `tolerances` pixels (in A, in B) of the line that `h`, or its inverse, gives the other line.
    pub(super) fn prefilter_homography(
        &self,
        h: &Matrix3<f64>,
        inverse: &Matrix3<f64>,
        tolerances: [f64; 2],
        visit: impl FnMut(usize),
    ) {
        let most2 = tolerances.map(|tolerance| tolerance * tolerance * ROOM);
        self.visit(
            |words| Arch::new().dispatch(ByHomography { arrays: self, maps: [h, inverse], most2, words }),
            visit,
        );
    }

    fn visit(&self, pass: impl FnOnce(&mut [u64]), mut visit: impl FnMut(usize)) {
        let mut words = vec![0u64; self.length2.len() / WORD];
        pass(&mut words);
        for (w, word) in words.into_iter().enumerate() {
            ones_of(word).for_each(|k| visit(w * WORD + k));
        }
    }
}

/// Pass of [`LineArrays::nearest`].
struct Nearest<'a> {
    arrays: &'a LineArrays,
    points: [(Homogeneous, f64); 2],
    except: [usize; 2],
}

impl WithSimd for Nearest<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<usize> {
        let Self { arrays, points, except } = self;
        let mut distances = vec![0.0; arrays.length2.len()];
        let sums = S::as_mut_simd_f64s(&mut distances).0;
        for (lines, (point, scale)) in arrays.lines.iter().zip(points) {
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

/// Pass of [`LineArrays::prefilter_area`].
struct ByArea<'a> {
    arrays: &'a LineArrays,
    f: &'a Matrix3<f64>,
    most2: f64,
    words: &'a mut [u64],
}

impl WithSimd for ByArea<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { arrays, f, most2, words } = self;
        let n = words.len() * WORD;
        let [a, b] = [0, 1].map(|view| arrays.ends[view].each_ref().map(|part| &part[..n]));
        let length2 = &arrays.length2[..n];
        for (w, word) in words.iter_mut().enumerate() {
            let mut bytes = [0u8; WORD];
            for (k, byte) in bytes.iter_mut().enumerate() {
                let i = w * WORD + k;
                let (ax, ay) = (0.5 * (a[0][i] + a[2][i]), 0.5 * (a[1][i] + a[3][i]));
                let (bx, by) = (0.5 * (b[0][i] + b[2][i]), 0.5 * (b[1][i] + b[3][i]));
                let x = f.m11 * ax + f.m12 * ay + f.m13;
                let y = f.m21 * ax + f.m22 * ay + f.m23;
                let z = f.m31 * ax + f.m32 * ay + f.m33;
                let algebraic = x * bx + y * by + z;
                *byte = u8::from(algebraic * algebraic * length2[i] <= most2 * (x * x + y * y));
            }
            *word = word_of(&bytes);
        }
    }
}

/// Pass of [`LineArrays::prefilter_homography`].
struct ByHomography<'a> {
    arrays: &'a LineArrays,
    /// Their transposes take lines of B to A, and lines of A to B.
    maps: [&'a Matrix3<f64>; 2],
    most2: [f64; 2],
    words: &'a mut [u64],
}

impl WithSimd for ByHomography<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { arrays, maps, most2, words } = self;
        let n = words.len() * WORD;
        for (w, word) in words.iter_mut().enumerate() {
            *word = u64::MAX;
            for view in 0..2 {
                let [lx, ly, lz] = arrays.lines[1 - view].each_ref().map(|part| &part[..n]);
                let [x0, y0, x1, y1] = arrays.ends[view].each_ref().map(|part| &part[..n]);
                let (m, most2) = (maps[view], most2[view]);
                let mut bytes = [0u8; WORD];
                for (k, byte) in bytes.iter_mut().enumerate() {
                    let i = w * WORD + k;
                    let x = m.m11 * lx[i] + m.m21 * ly[i] + m.m31 * lz[i];
                    let y = m.m12 * lx[i] + m.m22 * ly[i] + m.m32 * lz[i];
                    let z = m.m13 * lx[i] + m.m23 * ly[i] + m.m33 * lz[i];
                    let (p, q) = (x * x0[i] + y * y0[i] + z, x * x1[i] + y * y1[i] + z);
                    let most = most2 * (x * x + y * y);
                    *byte = u8::from(p * p <= most) & u8::from(q * q <= most);
                }
                *word &= word_of(&bytes);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use rand::RngExt;

    use super::*;
    use crate::geometry::LinePair;
    use crate::image::{ImageSize, Line};
    use crate::random::generator;

    /// Lines of B that are those of A by a map, a little displaced.
    fn candidates(map: &Matrix3<f64>) -> Vec<Candidate> {
        let mut random = generator(2, 0);
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        (0..300)
            .map(|k| {
                let segment_a = Segment {
                    x0: 0.0,
                    y0: between(0.0, 479.0),
                    x1: between(9.0, 639.0),
                    y1: between(0.0, 479.0),
                };
                let off = 2.0 * f64::from(k % 11);
                let mut moved = |x: f64, y: f64| {
                    let p = map * Vector3::new(x, y, 1.0);
                    [p.x / p.z + between(-off, off), p.y / p.z + between(-off, off)]
                };
                let ([x0, y0], [x1, y1]) =
                    (moved(segment_a.x0, segment_a.y0), moved(segment_a.x1, segment_a.y1));
                let segment_b = Segment { x0, y0, x1, y1 };
                let lines = LinePair { a: segment_a.line().unwrap(), b: segment_b.line().unwrap() };
                Candidate { lines, segment_a, segment_b, correlation: 0.5 }
            })
            .collect()
    }

    fn map() -> Matrix3<f64> {
        Matrix3::new(0.9, 0.2, 30.0, -0.1, 1.1, -20.0, 1e-4, -2e-4, 1.0)
    }

    #[test]
    fn both_ends_fit_in_both_views() {
        let (h, candidates) = (map(), candidates(&map()));
        let inverse = h.try_inverse().unwrap();
        let off = |line: Homogeneous, s: &Segment| {
            let line = Line::from_homogeneous(&line).unwrap();
            line.signed_distance(s.x0, s.y0).abs().max(line.signed_distance(s.x1, s.y1).abs())
        };
        let fits = |i: &usize| {
            let c = &candidates[*i];
            off(h.transpose() * c.lines.b.homogeneous(), &c.segment_a) <= 8.0
                && off(inverse.transpose() * c.lines.a.homogeneous(), &c.segment_b) <= 12.0
        };
        let mut passed = Vec::new();
        LineArrays::new(&candidates).prefilter_homography(&h, &inverse, [8.0, 12.0], |i| passed.push(i));
        assert_eq!(passed, (0..300).filter(fits).collect::<Vec<_>>());
        assert!(passed.len() > 100 && passed.len() < 250, "{}", passed.len());
    }

    #[test]
    fn what_passes_by_area_is_near_in_the_middle() {
        let (h, candidates) = (map(), candidates(&map()));
        let arrays = LineArrays::new(&candidates);
        let size = ImageSize::new(640, 480).unwrap();
        let mut sums = [0; 2];
        for k in 0..20 {
            // Lines through an epipole in B and the images of points of A.
            let epipole = Vector3::new(-400.0 + 60.0 * f64::from(k), 100.0 + 20.0 * f64::from(k % 5), 1.0);
            let Some(f) = Fundamental::from_matrix(&(epipole.cross_matrix() * h), size, size) else {
                continue;
            };
            let near = |i: &usize| {
                let c = &candidates[*i];
                let ([ax, ay], [bx, by]) = (c.segment_a.midpoint(), c.segment_b.midpoint());
                let line = Line::from_homogeneous(&f.line_in_b(&Vector3::new(ax, ay, 1.0))).unwrap();
                line.signed_distance(bx, by).abs() * c.segment_b.length() <= WIDTHS * 300.0
            };
            let mut passed = Vec::new();
            arrays.prefilter_area(&f, 300.0, |i| passed.push(i));
            assert_eq!(passed, (0..300).filter(near).collect::<Vec<_>>());
            sums[0] += passed.len();
            sums[1] += 300 - passed.len();
        }
        assert!(sums[0] > 500 && sums[1] > 500, "{sums:?}");
    }

    #[test]
    fn the_nearest_is_neither_of_two() {
        let candidates = candidates(&map());
        let arrays = LineArrays::new(&candidates);
        let (e, f) = (Vector3::new(300.0, 200.0, 1.0), Vector3::new(310.0, 220.0, 1.0));
        for except in [[0, 1], [7, 250], [299, 14]] {
            let distance = |i: usize| {
                let LinePair { a, b } = candidates[i].lines;
                (a.homogeneous().dot(&e) * 0.7).abs() + (b.homogeneous().dot(&f) * 1.3).abs()
            };
            let others = (0..300).filter(|i| !except.contains(i));
            let expected = others.min_by(|&i, &j| distance(i).total_cmp(&distance(j)));
            assert_eq!(arrays.nearest([(e, 0.7), (f, 1.3)], except), expected);
            assert_eq!(arrays.nearest([(e, 0.7), (f, 1.3)], [expected.unwrap(), except[1]]), {
                let others = (0..300).filter(|i| ![expected.unwrap(), except[1]].contains(i));
                others.min_by(|&i, &j| distance(i).total_cmp(&distance(j)))
            });
        }
        assert_eq!(LineArrays::new(&candidates[..2]).nearest([(e, 1.0), (f, 1.0)], [0, 1]), None);
    }
}
