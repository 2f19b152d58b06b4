//! What a disc or a square covers that is moved along runs of a mask, one bit a pixel.

use crate::image::ImageSize;
use crate::recording::components::Run;

/// A mask of one bit a pixel; each row begins with a word.
pub(super) struct Bits {
    size: ImageSize,
    row_words: usize,
    words: Vec<u64>,
}

impl Bits {
    pub fn new(size: ImageSize) -> Self {
        let row_words = size.width.div_ceil(64);
        Self { size, row_words, words: vec![0; row_words * size.height] }
    }

    /// Sets what a disc, or a square, covers whose middle is anywhere on the runs: `disc` is how far it reaches to either side, row by row.
    pub fn cover(&mut self, runs: &[Run], disc: &[usize]) {
        let radius = disc.len() / 2;
        for run in runs {
            let y = usize::from(run.y);
            for (k, &reach) in disc.iter().enumerate() {
                if (radius..self.size.height + radius).contains(&(y + k)) {
                    let first = usize::from(run.x_first).saturating_sub(reach);
                    let last = (usize::from(run.x_last) + reach).min(self.size.width - 1);
                    self.set(y + k - radius, first, last);
                }
            }
        }
    }

    /// Sets the columns of a row from `first` to `last`.
    fn set(&mut self, y: usize, first: usize, last: usize) {
        let row = &mut self.words[y * self.row_words..(y + 1) * self.row_words];
        let (low, high) = (u64::MAX << (first % 64), u64::MAX >> (63 - last % 64));
        if first / 64 == last / 64 {
            row[first / 64] |= low & high;
        } else {
            row[first / 64] |= low;
            row[first / 64 + 1..last / 64].fill(u64::MAX);
            row[last / 64] |= high;
        }
    }

    /// Runs of what is set, in raster order.
    pub fn runs(&self) -> Vec<Run> {
        self.runs_where(0)
    }

    /// Runs of what is not set, in raster order.
    pub fn gaps(&self) -> Vec<Run> {
        self.runs_where(u64::MAX)
    }

    /// Runs of the columns whose bits are 1 after those of `flip` are turned.
    fn runs_where(&self, flip: u64) -> Vec<Run> {
        let mut runs = Vec::new();
        for (y, row) in self.words.chunks_exact(self.row_words).enumerate() {
            let mut x = 0;
            loop {
                let first = next(row, x, flip);
                if first >= self.size.width {
                    break;
                }
                x = next(row, first, !flip).min(self.size.width);
                runs.push(Run { y: y as u16, x_first: first as u16, x_last: (x - 1) as u16 });
            }
        }
        runs
    }
}

/// The next column from `x` on whose bit is 1 after those of `flip` are turned; beyond the last word if there is none.
fn next(row: &[u64], x: usize, flip: u64) -> usize {
    let mut from = u64::MAX << (x % 64);
    for (k, word) in row.iter().enumerate().skip(x / 64) {
        let word = (word ^ flip) & from;
        if word != 0 {
            return 64 * k + word.trailing_zeros() as usize;
        }
        from = u64::MAX;
    }
    64 * row.len()
}
