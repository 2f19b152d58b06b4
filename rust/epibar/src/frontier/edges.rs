//! Edges of all hulls of a view, laid out so that one pass finds on which side of each an epipole lies.
//!
//! A hull is touched where consecutive edges disagree ([`crate::geometry::epipolar_tangents`], the oracle). A
//! silhouette has a dozen or two edges: eight at a time without a branch are done before a search in their logarithm has
//! mispredicted its first comparison.

use crate::bits_of_bytes::gathered;
use crate::image::Homogeneous;

/// Edges of a hull are padded to a multiple of it.
const LANES: usize = 8;

/// `det(e, v, w) = e · (v_y − w_y, w_x − v_x, v_x w_y − v_y w_x)` for an edge from `v` to `w`.
#[derive(Debug, Clone, Default)]
pub(super) struct Edges {
    /// For each hull its first edge.
    start: Vec<u32>,
    x: Vec<f64>,
    y: Vec<f64>,
    w: Vec<f64>,
}

impl Edges {
    /// Most edges of a hull whose sides fit into one word.
    pub(super) const MOST: usize = 64;

    /// Adds a hull; its `i`-th edge leaves the `i`-th vertex.
    pub(super) fn push(&mut self, hull: &[[f64; 2]]) {
        self.start.push(self.x.len() as u32);
        let edges = || hull.iter().zip(hull.iter().skip(1).chain(hull.first()));
        self.x.extend(edges().map(|(v, w)| v[1] - w[1]));
        self.y.extend(edges().map(|(v, w)| w[0] - v[0]));
        self.w.extend(edges().map(|(v, w)| v[0] * w[1] - v[1] * w[0]));
        // Beyond the last stand edges of no length, with nothing on their positive side.
        let padded = self.x.len().next_multiple_of(LANES);
        for part in [&mut self.x, &mut self.y, &mut self.w] {
            part.resize(padded, 0.0);
        }
    }

    /// Adds a hull of others, of so many edges.
    pub(super) fn push_of(&mut self, others: &Self, hull: usize, count: usize) {
        self.start.push(self.x.len() as u32);
        let first = others.start[hull] as usize;
        let padded = first..first + count.next_multiple_of(LANES);
        self.x.extend_from_slice(&others.x[padded.clone()]);
        self.y.extend_from_slice(&others.y[padded.clone()]);
        self.w.extend_from_slice(&others.w[padded]);
    }

    /// For each edge 1 where the epipole is on its positive side.
    #[inline(always)]
    pub(super) fn facing(&self, epipole: &Homogeneous, sides: &mut Vec<u8>) {
        let n = self.x.len();
        sides.resize(n, 0);
        let (x, y, w, sides) = (&self.x[..n], &self.y[..n], &self.w[..n], &mut sides[..n]);
        let (ex, ey, ew) = (epipole.x, epipole.y, epipole.z);
        for i in 0..n {
            sides[i] = u8::from(ex * x[i] + ey * y[i] + ew * w[i] > 0.0);
        }
    }

    /// The vertices of a hull of `count` edges before which the sides turn positive and negative; `None` where they do
    /// not turn.
    #[inline(always)]
    pub(super) fn turns(&self, hull: usize, count: usize, sides: &[u8]) -> Option<[usize; 2]> {
        let start = self.start[hull] as usize;
        let mut out = 0u64;
        let (eights, _) = sides[start..start + count.next_multiple_of(LANES)].as_chunks::<LANES>();
        for (k, eight) in eights.iter().enumerate() {
            out |= gathered(u64::from_le_bytes(*eight)) << (k * LANES);
        }
        // The edge into a vertex is the one before the edge out of it.
        let into = out << 1 | out >> (count - 1);
        let all = u64::MAX >> (64 - count);
        let (rising, falling) = (out & !into & all, !out & into & all);
        let last = |bits: u64| 63 - bits.leading_zeros() as usize;
        (rising != 0 && falling != 0).then(|| [last(rising), last(falling)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::epipolar_tangents;
    use nalgebra::Vector3;

    #[test]
    fn tangents_are_those_of_the_oracle() {
        let polygon = |count: usize, turn: f64| -> Vec<[f64; 2]> {
            let angle = |i: usize| turn + i as f64 * std::f64::consts::TAU / count as f64;
            (0..count).map(|i| [50.0 + 20.0 * angle(i).cos(), 40.0 + 33.0 * angle(i).sin()]).collect()
        };
        let counts = [3, 4, 7, 8, 9, 16, 31, 63, 64];
        let mut edges = Edges::default();
        let hulls: Vec<_> = counts.iter().map(|&n| polygon(n, 0.1 * n as f64)).collect();
        for hull in &hulls {
            edges.push(hull);
        }
        let mut sides = Vec::new();
        let mut inside = 0;
        for k in 0..200 {
            let angle = 0.1 * f64::from(k);
            let distance = [3.0, 25.0, 90.0, 1e5][k as usize % 4];
            let e = Vector3::new(50.0 + distance * angle.cos(), 40.0 + distance * angle.sin(), 1.0);
            let e = if k % 3 == 0 { -e } else { e };
            edges.facing(&e, &mut sides);
            for (i, hull) in hulls.iter().enumerate() {
                let ours = edges.turns(i, hull.len(), &sides).map(|turns| turns.map(|v| hull[v]));
                let oracle = epipolar_tangents(hull, &e).map(|tangents| tangents.map(|t| t.point));
                assert_eq!(ours, oracle);
                inside += usize::from(oracle.is_none());
            }
        }
        assert!(inside > 100);
    }
}
