//! 8-connected components of a mask, by union-find over the runs of its rows.
//!
//! Only runs are ever touched: a frame with a few walkers in it has a few hundred of them, and
//! finding them is one pass over the bytes.

use crate::image::ImageSize;

/// Bytes looked at together when searching for the end of a run; a multiple of every vector width.
const STRIDE: usize = 32;

/// Consecutive moving pixels of one row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Row.
    pub y: u16,
    /// First column.
    pub x_first: u16,
    /// Last column, which is part of the run.
    pub x_last: u16,
}

impl Run {
    /// Number of pixels.
    pub fn pixels(self) -> usize {
        usize::from(self.x_last - self.x_first) + 1
    }
}

/// A set of moving pixels that are connected through sides or corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Component {
    /// Number of pixels.
    pub area: u32,
    /// Left-most column.
    pub x_min: u16,
    /// Right-most column.
    pub x_max: u16,
    /// Top row.
    pub y_min: u16,
    /// Bottom row.
    pub y_max: u16,
    /// Where its runs start among the grouped ones, and how many it has.
    runs: (u32, u32),
}

/// The runs and components of one mask; memory is kept from mask to mask.
#[derive(Debug, Clone, Default)]
pub struct Components {
    /// All runs, in raster order.
    runs: Vec<Run>,
    /// Union-find over runs: a parent is never behind its child, a root is its own parent.
    parents: Vec<u32>,
    found: Vec<Component>,
    /// All runs, component by component, in raster order within each.
    grouped: Vec<Run>,
}

impl Components {
    /// No components yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Finds the runs and components of a row-major mask, in place of those of the mask before.
    ///
    /// The components are in raster order of their first pixels.
    ///
    /// # Panics
    /// If the image is more than 65,536 pixels wide or high, which [`ImageSize::new`] excludes.
    pub fn find(&mut self, mask: &[u8], size: ImageSize) {
        assert!(size.width <= 1 << 16 && size.height <= 1 << 16);
        self.runs.clear();
        self.parents.clear();
        let mut above = 0;
        for (y, row) in mask.chunks_exact(size.width).take(size.height).enumerate() {
            let start = self.runs.len();
            find_runs(row, y as u16, &mut self.runs);
            self.parents.extend(start as u32..self.runs.len() as u32);
            self.join_rows(above, start);
            above = start;
        }
        self.group();
    }

    /// All runs of the mask, in raster order.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// The components.
    pub fn components(&self) -> &[Component] {
        &self.found
    }

    /// The runs of a component of this mask, in raster order.
    pub fn runs_of(&self, component: &Component) -> &[Run] {
        let (start, count) = component.runs;
        &self.grouped[start as usize..(start + count) as usize]
    }

    /// Clears the components of a row-major mask that have fewer than `min_area` pixels; [`Components::components`]
    /// still has them.
    ///
    /// # Panics
    /// If the mask is smaller than the size says, or the image is more than 65,536 pixels wide or high.
    pub fn remove_small(&mut self, mask: &mut [u8], size: ImageSize, min_area: usize) {
        self.find(mask, size);
        for component in self.found.iter().filter(|component| (component.area as usize) < min_area) {
            for run in self.runs_of(component) {
                let row = usize::from(run.y) * size.width;
                mask[row + usize::from(run.x_first)..=row + usize::from(run.x_last)].fill(0);
            }
        }
    }

    /// Unites the runs from `start` on, which are those of one row, with the touching ones from
    /// `above` on, which may be those of the row above.
    fn join_rows(&mut self, above: usize, start: usize) {
        let (mut i, mut j) = (above, start);
        while i < start && j < self.runs.len() {
            let (p, q) = (self.runs[i], self.runs[j]);
            if p.y + 1 != q.y {
                return;
            }
            // Diagonal neighbours touch, hence the column more.
            let (p_last, q_last) = (u32::from(p.x_last), u32::from(q.x_last));
            if u32::from(q.x_first) <= p_last + 1 && u32::from(p.x_first) <= q_last + 1 {
                self.unite(i as u32, j as u32);
            }
            if p_last < q_last {
                i += 1;
            } else {
                j += 1;
            }
        }
    }

    fn unite(&mut self, i: u32, j: u32) {
        let (p, q) = (self.root(i), self.root(j));
        self.parents[p.max(q) as usize] = p.min(q);
    }

    fn root(&mut self, mut i: u32) -> u32 {
        while self.parents[i as usize] != i {
            let grandparent = self.parents[self.parents[i as usize] as usize];
            self.parents[i as usize] = grandparent;
            i = grandparent;
        }
        i
    }

    /// Measures the components and groups the runs by them.
    fn group(&mut self) {
        self.found.clear();
        // Parents stand before their children, so one pass turns them into component numbers.
        for (i, run) in self.runs.iter().enumerate() {
            let parent = self.parents[i] as usize;
            let component = if parent == i {
                self.found.push(Component {
                    area: 0,
                    x_min: run.x_first,
                    x_max: run.x_last,
                    y_min: run.y,
                    y_max: run.y,
                    runs: (0, 0),
                });
                self.found.len() - 1
            } else {
                self.parents[parent] as usize
            };
            self.parents[i] = component as u32;
            let component = &mut self.found[component];
            component.area += run.pixels() as u32;
            component.x_min = component.x_min.min(run.x_first);
            component.x_max = component.x_max.max(run.x_last);
            component.y_max = run.y;
            component.runs.1 += 1;
        }
        let mut start = 0;
        for component in &mut self.found {
            let count = component.runs.1;
            component.runs = (start, 0);
            start += count;
        }
        self.grouped.clone_from(&self.runs);
        for (run, &component) in self.runs.iter().zip(&self.parents) {
            let (start, filled) = &mut self.found[component as usize].runs;
            self.grouped[(*start + *filled) as usize] = *run;
            *filled += 1;
        }
    }
}

/// Adds the runs of non-zero pixels of a row.
pub(crate) fn find_runs(row: &[u8], y: u16, runs: &mut Vec<Run>) {
    let mut x = 0;
    loop {
        x = skip(row, x, |v| v == 0);
        if x == row.len() {
            return;
        }
        let x_first = x as u16;
        x = skip(row, x, |v| v != 0);
        runs.push(Run { y, x_first, x_last: (x - 1) as u16 });
    }
}

/// The first position from `x` on where the predicate fails.
#[inline]
fn skip(row: &[u8], mut x: usize, predicate: impl Fn(u8) -> bool) -> usize {
    let all = |bytes: &[u8]| bytes.iter().fold(true, |all, &v| all & predicate(v));
    while x + STRIDE <= row.len() && all(&row[x..x + STRIDE]) {
        x += STRIDE;
    }
    let rest = row[x..].iter().position(|&v| !predicate(v));
    rest.map_or(row.len(), |rest| x + rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn find(rows: &[&str]) -> Components {
        let size = ImageSize::new(rows[0].len(), rows.len()).unwrap();
        let mask: Vec<u8> = rows.concat().bytes().map(|c| u8::from(c == b'#')).collect();
        let mut components = Components::new();
        components.find(&mask, size);
        components
    }

    #[test]
    fn corners_connect_and_arms_join_late() {
        let found = find(&[
            "#...#....#", //
            "#...#...#.",
            "#...#.....",
            "#####..##.",
        ]);
        let summary: Vec<_> =
            found.components().iter().map(|c| (c.area, [c.x_min, c.x_max, c.y_min, c.y_max])).collect();
        assert_eq!(summary, [(11, [0, 4, 0, 3]), (2, [8, 9, 0, 1]), (2, [7, 8, 3, 3])]);
        let joined = found.runs_of(&found.components()[0]);
        assert_eq!(joined.len(), 7);
        assert!(joined.is_sorted_by_key(|run| (run.y, run.x_first)));
        assert_eq!(found.runs().len(), 10);
    }

    #[test]
    fn small_ones_are_removed() {
        let rows = ["##...#", "..#..#", "......", "#....#"];
        let size = ImageSize::new(6, 4).unwrap();
        let left = |min_area| {
            let mut mask: Vec<u8> = rows.concat().bytes().map(|c| 7 * u8::from(c == b'#')).collect();
            Components::new().remove_small(&mut mask, size, min_area);
            let drawn =
                mask.chunks(6).map(|row| row.iter().map(|&v| if v == 7 { '#' } else { '.' }).collect());
            drawn.collect::<Vec<String>>()
        };
        assert_eq!(left(0), rows);
        assert_eq!(left(1), rows);
        assert_eq!(left(2), ["##...#", "..#..#", "......", "......"]);
        assert_eq!(left(3), ["##....", "..#...", "......", "......"]);
        assert_eq!(left(4), ["......"; 4]);
    }

    #[test]
    fn rows_apart_do_not_connect() {
        let found = find(&["......", ".###..", "......", ".###..", "......"]);
        assert_eq!(found.components().len(), 2);
    }

    #[test]
    fn memory_of_the_mask_before_is_gone() {
        let size = ImageSize::new(70, 3).unwrap();
        let mut components = Components::new();
        components.find(&[1; 210], size);
        assert_eq!(components.components()[0].area, 210);
        components.find(&[0; 210], size);
        assert!(components.components().is_empty() && components.runs().is_empty());
    }
}
