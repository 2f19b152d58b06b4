//! Normalised correlation of packed barcodes and the mutual best pairs (paper §1.3 and §2).
//!
//! For two bit vectors of `N` frames with `a` and `b` ones of which `n₁₁` are common,
//! `r = (N·n₁₁ − a·b) / √(a(N−a)·b(N−b))`: three counts decide it, so the kernel is AND and popcount.
//! The `n₁ × n₂` matrix never exists: each row of A keeps the best few of B and, at the same time, offers itself to
//! the best few of each column.
//!
//! Rows are taken in the order of their counts of ones, because those bound a correlation: `r² ≤ a(N−b) / (b(N−a))` for
//! `a ≤ b`. Each row meets first the columns like it, and later skips those with which it cannot reach
//! what it and they already have. Where only the best pairs are asked for, rows meet columns in stages of that bound:
//! once all that can correlate by more than `r` have met, mutual pairs above `r` are certain, and if they are enough the
//! rest never meets. Where too many pairs are alike in their counts, all meet at once.
//!
//! A constant barcode has no variance; its correlation is defined as 0 and it is never matched.

use rayon::prelude::*;

use super::best::POSITIVE;
use super::columns::Columns;
use super::popcount::{Level, rounded_up};
use super::rows::{Rows, in_turns};
use crate::recording::Barcodes;
use crate::{Error, Result};

/// Where only the best are asked for, correlations below this are left out at first.
const GOOD: f32 = 0.6;
/// Pairs that can correlate by this much meet first then.
const FIRST_REACH: f32 = 0.99;
/// Share of pairs that may meet before it is cheaper to let all do so at once.
const MOST_MEET: f64 = 0.12;
/// How much further from 1 each stage reaches, at least and at most.
const FURTHER: [f32; 2] = [1.2, 3.0];

/// Correlation of two barcodes of `frames` frames from their counts.
pub fn correlation(frames: u32, ones_a: u32, ones_b: u32, common: u32) -> f64 {
    let n = f64::from(frames);
    let (a, b) = (f64::from(ones_a), f64::from(ones_b));
    let variance = a * (n - a) * b * (n - b);
    if variance <= 0.0 {
        return 0.0;
    }
    (n * f64::from(common) - a * b) / variance.sqrt()
}

/// Row index of A, row index of B and their correlation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// Row of A.
    pub a: u32,
    /// Row of B.
    pub b: u32,
    /// Normalised correlation, −1 to 1.
    pub correlation: f32,
    /// The pair is in the mutual top `rank + 1`: the worse of its two places, from 0.
    pub rank: u32,
}

/// Pairs that are in the mutual top `mutual` of each other, best correlation first, at most `limit`.
///
/// Only pairs with positive correlation count. Ties are broken by the lower row index, so the result does
/// not depend on the number of threads.
///
/// # Errors
/// [`Error::Length`] if the barcodes cover different numbers of frames, [`Error::Argument`] if `mutual` is 0.
pub fn mutual_matches(a: &Barcodes, b: &Barcodes, mutual: usize, limit: usize) -> Result<Vec<Match>> {
    if a.frames != b.frames {
        return Err(Error::Length {
            what: "frames of the two sets of barcodes",
            left: a.frames,
            right: b.frames,
        });
    }
    if mutual == 0 {
        return Err(Error::Argument { name: "mutual", value: "0".into(), expected: "at least 1" });
    }
    Ok(matches_at(Level::available()[0], a, b, mutual, limit))
}

fn matches_at(level: Level, a: &Barcodes, b: &Barcodes, mutual: usize, limit: usize) -> Vec<Match> {
    if limit == 0 {
        return Vec::new();
    }
    // No row has more partners than there are.
    let mutual = mutual.min(a.count.max(b.count)).max(1);
    let few = limit < mutual.saturating_mul(a.count.min(b.count));
    let mut columns = Columns::new(b, mutual, if few { GOOD } else { POSITIVE });
    if few {
        if let Some(best) = best_above(GOOD, level, a, &columns, mutual, limit) {
            return best;
        }
        columns.start_again(POSITIVE);
    }
    let mut tasks = in_turns(a, &columns, mutual, POSITIVE);
    tasks.par_iter_mut().for_each(|rows| {
        rows.widen(0.0);
        rows.meet(level);
    });
    best_first(&tasks, limit)
}

/// The best `limit`, if there are as many above the floor of the columns, and few pairs need to meet for them.
fn best_above(
    floor: f32,
    level: Level,
    a: &Barcodes,
    columns: &Columns,
    mutual: usize,
    limit: usize,
) -> Option<Vec<Match>> {
    let mut tasks = in_turns(a, columns, mutual, floor);
    let rounding = columns.most_rounding(&tasks);
    let most = MOST_MEET * (a.count * columns.groups().len()) as f64;
    let mut reach = FIRST_REACH;
    while reach > floor {
        let within: usize = tasks.par_iter_mut().map(|rows| rows.widen(reach)).sum();
        if within as f64 > most {
            return None;
        }
        tasks.par_iter_mut().for_each(|rows| rows.meet(level));
        let matches = best_first(&tasks, limit);
        // What is lacking can still come, and what is there can be surpassed by pairs that have not met.
        let least = matches.get(limit - 1).map_or(0.0, |worst| worst.correlation);
        if least > rounded_up(reach, rounding) {
            return Some(matches);
        }
        let [near, far] = FURTHER.map(|times| 1.0 - times * (1.0 - reach));
        reach = least.clamp(far, near);
    }
    None
}

/// Mutual pairs as far as rows have met, best first.
fn best_first(tasks: &[Rows], limit: usize) -> Vec<Match> {
    let mut matches: Vec<Match> = tasks.par_iter().flat_map_iter(Rows::mutual).collect();
    matches.par_sort_unstable_by(|p, q| {
        q.correlation.total_cmp(&p.correlation).then(p.a.cmp(&q.a)).then(p.b.cmp(&q.b))
    });
    matches.truncate(limit);
    matches
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_of_good_copies_need_few_meetings() {
        // Rows of all densities, and copies of them that lack some ones: their counts are not quite the same.
        let mut state = 7u64;
        let mut next = |n: u64| {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (state >> 33) % n
        };
        let (count, frames) = (3000, 400);
        let (mut a, mut b) = (Barcodes::zeros(count, frames), Barcodes::zeros(count, frames));
        for row in 0..count {
            for frame in 0..frames {
                let moving = next(100) < 4 + row as u64 % 92;
                let at = row * a.words_per + frame / 64;
                a.bits[at] |= u64::from(moving) << (frame % 64);
                b.bits[at] |= u64::from(moving && next(100) >= row as u64 % 9) << (frame % 64);
            }
        }
        let all = matches_at(Level::Plain, &a, &b, 3, usize::MAX);
        for (limit, staged) in [(1, true), (300, true), (1500, true), (all.len(), false)] {
            let best = best_above(GOOD, Level::Plain, &a, &Columns::new(&b, 3, GOOD), 3, limit);
            assert_eq!(best.is_some(), staged, "{limit} of {}, {}", all.len(), all[limit - 1].correlation);
            assert!(best.is_none_or(|best| best == all[..limit]));
        }
        assert!(all[1499].correlation < 0.97, "{}", all[1499].correlation);
    }

    #[test]
    fn every_level_finds_the_same() {
        let mut state = 3u64;
        let mut barcodes = |count| {
            let mut barcodes = Barcodes::zeros(count, 200);
            for row in 0..count {
                let mut moving = 0;
                for frame in 0..200 {
                    state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
                    moving ^= u64::from(state >> 60 == 0);
                    barcodes.bits[row * barcodes.words_per + frame / 64] |= moving << (frame % 64);
                }
            }
            barcodes
        };
        let (a, b) = (barcodes(700), barcodes(900));
        let levels = Level::available();
        for (limit, least) in [(usize::MAX, 100), (50, 50)] {
            let found = levels.iter().map(|&level| matches_at(level, &a, &b, 4, limit));
            let found: Vec<Vec<Match>> = found.collect();
            assert!(found[0].len() >= least);
            for (other, level) in found.iter().zip(&levels) {
                assert_eq!(*other, found[0], "{level:?} against {:?}", levels[0]);
            }
        }
    }
}
