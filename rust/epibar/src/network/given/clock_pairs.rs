//! Which pairs of cameras are asked for the offset between their clocks.

use super::pair_choice::{ALL_PAIRS, all_pairs};
use crate::network::thresholds as limits;

/// What the barcodes of a pair say of its clocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairOffset {
    /// Index of camera A.
    pub a: usize,
    /// Index of camera B.
    pub b: usize,
    /// What is at `t` seconds in A, since its first frame, is at about `t + seconds` in B.
    pub seconds: f64,
    /// How well the best pairs of lines agree there.
    pub score: f64,
    /// How well they agree without an offset; −∞ where too few frames are common then.
    pub unshifted: f64,
    /// Score of the best other offset as a share of the best.
    pub runner_up: f64,
}

/// Neighbours that each of more cameras is asked with first.
const NEIGHBOURS: usize = 3;
/// So many triangles vouch for a camera: one may add up to nought by chance.
const VOUCHED: usize = 2;
/// More pairs that are asked for, at the most, for each camera where too little vouches for some.
const MOST_BEYOND: usize = 15;

/// Pairs of `count` cameras whose offsets are asked for first: all of few cameras, neighbours in the list of more.
pub fn asked(count: usize) -> Vec<(usize, usize)> {
    all_pairs(count).filter(|&(a, b)| count <= ALL_PAIRS || apart(count, a, b) <= NEIGHBOURS).collect()
}

/// How far apart two cameras `a < b` are in the list, which ends where it begins.
fn apart(count: usize, a: usize, b: usize) -> usize {
    (b - a).min(count - (b - a))
}

/// More pairs to ask for, of cameras that too little vouches for by what was found of neighbours in the list, or that triangles do not join:
/// neighbours in the list need not be neighbours in space. The nearest first, and not more than so many for each camera. Asked in one go, as the
/// more is asked the more triangles add up to nought by chance.
pub fn asked_beyond(count: usize, found: &[PairOffset]) -> Vec<(usize, usize)> {
    if count <= ALL_PAIRS {
        return Vec::new();
    }
    let (triangles, group) = vouched(count, found);
    let is_open = |&(a, b): &(usize, usize)| group[a] != group[b] || triangles[a].min(triangles[b]) < VOUCHED;
    let further = |&(a, b): &(usize, usize)| apart(count, a, b) > NEIGHBOURS;
    let mut beyond: Vec<(usize, usize)> =
        all_pairs(count).filter(|pair| further(pair) && is_open(pair)).collect();
    beyond.sort_by_key(|&(a, b)| apart(count, a, b));
    beyond.truncate(MOST_BEYOND * count);
    beyond
}

/// Which of the pairs that were asked no triangles vouch for, of few cameras.
pub fn unvouched(count: usize, found: &[PairOffset]) -> Vec<usize> {
    if count > ALL_PAIRS {
        return Vec::new();
    }
    let (_, group) = vouched(count, found);
    (0..found.len()).filter(|&i| group[found[i].a] != group[found[i].b]).collect()
}

/// How many triangles each camera is in whose offsets add up to nought, and a group for all that such triangles join.
fn vouched(count: usize, found: &[PairOffset]) -> (Vec<usize>, Vec<usize>) {
    let mut between = vec![f64::NAN; count * count];
    for p in found {
        between[p.a * count + p.b] = p.seconds;
    }
    let (mut triangles, mut group) = (vec![0; count], (0..count).collect::<Vec<_>>());
    for p in found {
        for c in p.b + 1..count {
            let round = p.seconds + between[p.b * count + c] - between[p.a * count + c];
            if round.abs() < limits::OFFSETS_AGREE {
                for camera in [p.a, p.b, c] {
                    triangles[camera] += 1;
                    let (one, other) = (group[p.a], group[camera]);
                    group.iter_mut().filter(|g| **g == other).for_each(|g| *g = one);
                }
            }
        }
    }
    (triangles, group)
}

#[cfg(test)]
mod tests {
    use super::super::clocks::agreed;
    use super::super::clocks::tests::offsets;
    use super::*;

    /// What is found of a pair of cameras along a corridor, in which each sees what two on either side see; others have any offset.
    fn along_a_corridor(
        truth: &[f64],
        place: &[usize],
        (a, b): (usize, usize),
        draw: &mut u64,
    ) -> PairOffset {
        *draw = draw.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let chance = 42.0 * ((*draw >> 33) as f64 / f64::from(1_u32 << 31) - 0.5);
        let sees = place[a].abs_diff(place[b]) <= 2;
        PairOffset {
            a,
            b,
            seconds: if sees { truth[b] - truth[a] } else { chance },
            score: 5.0,
            unshifted: 1.0,
            runner_up: if sees { 0.6 } else { 0.9 },
        }
    }

    #[test]
    fn cameras_need_not_be_listed_in_the_order_in_which_they_stand() {
        for (count, seed) in [(8, 1), (12, 2), (20, 3), (30, 4)] {
            let truth: Vec<f64> = (0..count).map(|c| (f64::from(c) * 7.3) % 19.0 - 9.0).collect();
            let count = count as usize;
            // A step that has nothing in common with the count: neighbours in the list are far from each other.
            let step =
                [5, 7, 11, 13].into_iter().find(|s| !count.is_multiple_of(*s) && 2 * s < count + 6).unwrap();
            let place: Vec<usize> = (0..count).map(|c| c * step % count).collect();
            let mut draw = seed;
            let mut ask = |pairs: Vec<(usize, usize)>| -> Vec<PairOffset> {
                pairs.into_iter().map(|pair| along_a_corridor(&truth, &place, pair, &mut draw)).collect()
            };
            let mut found = ask(asked(count));
            found.extend(ask(asked_beyond(count, &found)));
            let seconds = agreed(count, &found).seconds;
            let right = |c: &usize| (seconds[*c] - (truth[*c] - truth[0])).abs() < 0.3;
            assert_eq!((0..count).filter(right).count(), count, "{count}: {seconds:?} {truth:?}");
        }
    }

    #[test]
    fn no_more_is_asked_where_triangles_join_all() {
        let truth: Vec<f64> = (0..20).map(|c| f64::from(c) * 0.7).collect();
        let found = offsets(&truth, &[]);
        assert_eq!(asked_beyond(20, &found), []);
        assert_eq!(asked_beyond(6, &[]), []);
        // One that nothing vouches for is asked with those further off.
        let without: Vec<PairOffset> = found.into_iter().filter(|p| p.a != 4 && p.b != 4).collect();
        let beyond = asked_beyond(20, &without);
        assert_eq!((beyond.len(), &beyond[..2]), (13, &[(0, 4), (4, 8)][..]));
    }
}
