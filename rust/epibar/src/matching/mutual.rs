//! Pairs of barcodes that are among the best partners of each other (paper §2).
//!
//! The `n₁ × n₂` matrix of correlations never exists: each row of A keeps the best few of B and, at the same time, offers
//! itself to the best few of each column.
//!
//! Rows are taken in the order of their counts of ones, because those bound a correlation: `r² ≤ a(N−b) / (b(N−a))` for
//! `a ≤ b`. Each row meets first the columns like it, and later skips those with which it cannot reach
//! what it and they already have.

use rayon::prelude::*;

use super::correlation::Match;
use super::kernel::columns::Columns;
use super::kernel::popcount::Level;
use super::kernel::rows::{Rows, in_turns};
use crate::error::{Error, Result};
use crate::recording::Barcodes;

/// Pairs that are in the mutual top `mutual` of each other, best correlation first.
///
/// Only pairs with positive correlation count. Ties are broken by the lower row index, so the result does
/// not depend on the number of threads.
///
/// # Errors
/// [`Error::Length`] if the barcodes cover different numbers of frames, [`Error::Argument`] if `mutual` is 0.
pub fn mutual_matches(a: &Barcodes, b: &Barcodes, mutual: usize) -> Result<Vec<Match>> {
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
    Ok(matches_at(Level::available()[0], a, b, mutual))
}

fn matches_at(level: Level, a: &Barcodes, b: &Barcodes, mutual: usize) -> Vec<Match> {
    // No row has more partners than there are.
    let mutual = mutual.min(a.count.max(b.count)).max(1);
    let columns = Columns::new(b, mutual);
    let mut tasks = in_turns(a, &columns, mutual);
    tasks.par_iter_mut().for_each(|rows| rows.meet(level));
    let mut matches: Vec<Match> = tasks.par_iter().flat_map_iter(Rows::mutual).collect();
    matches.par_sort_unstable_by(|p, q| {
        q.correlation.total_cmp(&p.correlation).then(p.a.cmp(&q.a)).then(p.b.cmp(&q.b))
    });
    matches
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let found: Vec<Vec<Match>> = levels.iter().map(|&level| matches_at(level, &a, &b, 4)).collect();
        assert!(found[0].len() >= 100);
        for (other, level) in found.iter().zip(&levels) {
            assert_eq!(*other, found[0], "{level:?} against {:?}", levels[0]);
        }
    }
}
