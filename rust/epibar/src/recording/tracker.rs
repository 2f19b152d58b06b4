//! Which silhouette of one frame is which of the next: the one tracker of the crate.
//!
//! A silhouette continues the one of the frame before to which it is most alike, if each is the most alike of the other
//! and the two are plausibly one object ([`predecessors`]). Where silhouettes merge or part there is no link: what is
//! followed is one object, or one group.
//!
//! What is alike is asked in two ways, as two things are wanted. A clock is measured from how silhouettes move, so a
//! wrong link costs more there than a lacking one: [`Links`] are of silhouettes that plainly are one object, near each
//! other and of the same widths. Tracks give hypotheses, of which most may be wrong, and should be long:
//! [`Outline::overlap`] bridges what a walker's swinging limbs change.

use super::recording::{LONG_STEP, Recording};

/// For each of the silhouettes of a frame the one of the frame before that it continues.
///
/// `likeness` is symmetric; of equally alike ones the first counts. `plausible` refuses the most alike.
pub fn predecessors<T>(
    before: &[T],
    now: &[T],
    likeness: impl Fn(&T, &T) -> f64,
    plausible: impl Fn(&T, &T, f64) -> bool,
) -> Vec<Option<usize>> {
    let most_alike = |of: &T, among: &[T]| {
        let alike = among.iter().map(|other| likeness(of, other)).enumerate();
        alike.max_by(|p, q| p.1.total_cmp(&q.1).then(q.0.cmp(&p.0)))
    };
    let mutual = |k: usize| {
        let (h, value) = most_alike(&now[k], before)?;
        let back = most_alike(&before[h], now)?.0;
        (back == k && plausible(&before[h], &now[k], value)).then_some(h)
    };
    (0..now.len()).map(mutual).collect()
}

/// Extent of a silhouette along x, y and both diagonals, pixels (diagonals times √2).
#[derive(Debug, Clone, Copy)]
pub struct Outline {
    low: [f64; 4],
    high: [f64; 4],
}

impl Outline {
    /// Of the vertices of a hull.
    pub fn of(hull: impl Iterator<Item = [f64; 2]>) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4]);
        for [x, y] in hull {
            for (k, value) in [x, y, x + y, x - y].into_iter().enumerate() {
                low[k] = low[k].min(value);
                high[k] = high[k].max(value);
            }
        }
        Self { low, high }
    }

    /// Pixels of the box around it; each vertex is a pixel wide.
    pub fn area(&self) -> f64 {
        area(&self.low, &self.high)
    }

    /// Intersection over union of the boxes around two.
    pub fn overlap(&self, other: &Self) -> f64 {
        let shared = area(
            &[self.low[0].max(other.low[0]), self.low[1].max(other.low[1])],
            &[self.high[0].min(other.high[0]), self.high[1].min(other.high[1])],
        );
        shared / (self.area() + other.area() - shared)
    }

    /// Squared distance of the centres of two; `None` where their widths differ, or they lie apart.
    fn distance(&self, other: &Self) -> Option<f64> {
        for k in 0..4 {
            let (width, theirs) = (self.high[k] - self.low[k], other.high[k] - other.low[k]);
            let allowed = WIDTH_PIXELS + WIDTH_SHARE * width.max(theirs);
            let overlap = self.high[k].min(other.high[k]) - self.low[k].max(other.low[k]);
            if (width - theirs).abs() > allowed || overlap < -WIDTH_PIXELS {
                return None;
            }
        }
        let middle = |e: &Self, k: usize| 0.5 * (e.low[k] + e.high[k]);
        Some((0..2).map(|k| (middle(self, k) - middle(other, k)).powi(2)).sum())
    }
}

/// Pixels of a box, none where it is empty.
fn area(low: &[f64], high: &[f64]) -> f64 {
    (0..2).map(|k| (high[k] - low[k] + 1.0).max(0.0)).product()
}

/// No hull.
const NONE: u32 = u32::MAX;
/// Widths in each direction may differ by this share, and by [`WIDTH_PIXELS`].
const WIDTH_SHARE: f64 = 0.2;
const WIDTH_PIXELS: f64 = 3.0;

/// For each hull of a recording the hull of the same object one frame later, and one earlier.
#[derive(Debug, Clone)]
pub struct Links {
    next: Vec<u32>,
    previous: Vec<u32>,
}

impl Links {
    /// Follows the silhouettes of a recording.
    pub fn new(recording: &Recording) -> Self {
        let silhouettes = &recording.silhouettes;
        let outlines: Vec<(Outline, bool)> = (0..silhouettes.len())
            .map(|h| {
                (Outline::of(silhouettes.hull(h).iter().map(|p| p.map(f64::from))), silhouettes.border[h])
            })
            .collect();
        // One that is cut where the view ends is not the one that was whole.
        let nearness = |(p, cut_p): &(Outline, bool), (q, cut_q): &(Outline, bool)| {
            let distance = if cut_p == cut_q { p.distance(q) } else { None };
            -distance.unwrap_or(f64::INFINITY)
        };
        let mut links = Self { next: vec![NONE; outlines.len()], previous: vec![NONE; outlines.len()] };
        let long = LONG_STEP * recording.frame_interval();
        for frame in 1..recording.frames() {
            if recording.times[frame] - recording.times[frame - 1] > long {
                continue;
            }
            let (before, now) = (silhouettes.hulls(frame - 1), silhouettes.hulls(frame));
            let found = predecessors(
                &outlines[before.clone()],
                &outlines[now.clone()],
                nearness,
                |_, _, nearness| nearness.is_finite(),
            );
            for (to, h) in now.zip(found) {
                if let Some(h) = h.map(|h| before.start + h) {
                    links.next[h] = to as u32;
                    links.previous[to] = h as u32;
                }
            }
        }
        links
    }

    /// The same object one frame later, as a hull of that frame.
    pub fn next(&self, hull: usize) -> Option<usize> {
        Some(self.next[hull]).filter(|&h| h != NONE).map(|h| h as usize)
    }

    /// The same object one frame earlier, as a hull of that frame.
    pub fn previous(&self, hull: usize) -> Option<usize> {
        Some(self.previous[hull]).filter(|&h| h != NONE).map(|h| h as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_the_most_alike_of_the_other() {
        let likeness = |p: &f64, q: &f64| -(p - q).abs();
        let found = |before: &[f64], now: &[f64]| predecessors(before, now, likeness, |_, _, d| d > -2.0);
        assert_eq!(found(&[1.0, 5.0], &[5.5, 0.5]), [Some(1), Some(0)]);
        // Two that part, two that merge, one that is too far.
        assert_eq!(found(&[5.0], &[4.5, 5.2]), [None, Some(0)]);
        assert_eq!(found(&[4.5, 5.2], &[5.0]), [Some(1)]);
        assert_eq!(found(&[5.0], &[8.0]), [None]);
        assert_eq!(found(&[], &[1.0]), [None]);
        // Of equally alike ones the first.
        assert_eq!(found(&[4.0, 6.0], &[5.0]), [Some(0)]);
    }
}
