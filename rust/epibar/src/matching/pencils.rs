//! How alike the barcodes of corresponding lines of two pencils are, of all lines and not of those that were drawn.
//!
//! People of one height who walk on a floor meet a line through the middles of their bodies at nearly the same moments in any view: the
//! lines of that plane are candidates wherever they lie, far more than the epipolar ones, and any point of them may gather more than the
//! epipole. But then only those lines of its pencil that happened to be drawn are alike. All lines of the right pencils are.

use rand::RngExt;

use super::correlation::correlation;
use super::hull_barcodes::{Hulls, TabulatedHulls};
use crate::geometry::Fundamental;
use crate::image::{Homogeneous, ImageSize, Line};
use crate::random::Stream;
use crate::recording::{Barcodes, FramePair, Recording};

/// Directions of lines that share a table of how far hulls reach. Thousands of pencils share them all.
const DIRECTIONS: usize = 128;

/// Barcodes of so many pairs of lines are compared before it is asked whether the others can still be alike enough.
const AT_ONCE: usize = 16;
/// What rounding may add to a mean of correlations.
const ROUNDING: f64 = 1e-9;

/// Silhouettes of two cameras at some common frames, and places where something moved.
pub struct Pencils {
    hulls: [TabulatedHulls; 2],
    places: [Vec<Homogeneous>; 2],
    sizes: [ImageSize; 2],
}

impl Pencils {
    /// Of some frames, and so many places of each camera, drawn by a seed, in its silhouettes.
    pub fn new(recordings: [&Recording; 2], frames: &[FramePair], places: usize, seed: u64) -> Self {
        let indices = FramePair::indices(frames);
        let hulls = [0, 1].map(|k| Hulls::new(&recordings[k].silhouettes, &indices[k]));
        let places = [0, 1].map(|k| {
            let mut random = Stream::Pencils.generator(seed, k as u64);
            let count = hulls[k].count();
            let drawn = if count == 0 { 0 } else { places };
            let mut place = || {
                let hull = random.random_range(0..count);
                hulls[k].inside(hull, |vertices| random.random_range(0..vertices))
            };
            (0..drawn).map(|_| place()).collect()
        });
        let hulls = hulls.map(|hulls| TabulatedHulls::new(hulls, frames.len(), DIRECTIONS));
        Self { hulls, places, sizes: recordings.map(|r| r.size) }
    }

    /// Mean correlation of the barcodes of the epipolar lines through all places, in both directions; that of a line which
    /// misses the other image, or that says nothing in either, is 0. `None` where the mean is less than `least`, which shows before all are compared.
    pub fn alike(&self, f: &Fundamental, least: f64) -> Option<f64> {
        let epipoles = [f.epipole_a(), f.epipole_b()];
        let mut lines: [Vec<Line>; 2] = [vec![], vec![]];
        for (from, epipole) in epipoles.into_iter().enumerate() {
            for place in &self.places[from] {
                let there = if from == 0 { f.line_in_b(place) } else { f.line_in_a(place) };
                let here = Line::from_homogeneous(&epipole.cross(place));
                let (Some(here), Some(there)) = (here, Line::from_homogeneous(&there)) else { continue };
                if there.clip(self.sizes[1 - from]).is_some() {
                    lines[from].push(here);
                    lines[1 - from].push(there);
                }
            }
        }
        let places = (self.places[0].len() + self.places[1].len()).max(1) as f64;
        let (mut sum, mut left) = (0.0, lines[0].len());
        for some in lines[0].chunks(AT_ONCE).zip(lines[1].chunks(AT_ONCE)) {
            if (sum + left as f64) / places < least - ROUNDING {
                return None;
            }
            let (a, b) = (self.hulls[0].barcodes(some.0), self.hulls[1].barcodes(some.1));
            sum = (0..some.0.len()).fold(sum, |sum, row| sum + correlation_of(&a, &b, row));
            left -= some.0.len();
        }
        let alike = sum / places;
        (alike >= least).then_some(alike)
    }
}

fn correlation_of(a: &Barcodes, b: &Barcodes, row: usize) -> f64 {
    let common: u32 = a.row(row).iter().zip(b.row(row)).map(|(p, q)| (p & q).count_ones()).sum();
    correlation(a.frames as u32, a.ones(row), b.ones(row), common)
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;
    use crate::random::generator;
    use crate::recording::{Recorder, RecorderOptions};

    /// Squares that jump about, seen by two cameras side by side: their rows are the epipolar lines.
    fn recorded(camera: usize) -> Recording {
        let size = ImageSize::new(120, 80).unwrap();
        let mut recorder = Recorder::new(size, RecorderOptions::new().lines(100)).unwrap();
        let mut random = generator(3, 0);
        for frame in 0..200 {
            let mut mask = vec![0; size.pixels()];
            for _ in 0..2 {
                let [x, y, near] = [80, 60, 20].map(|most| random.random_range(0..most));
                let x = if camera == 0 { x } else { x + near };
                (y..y + 9).for_each(|y| mask[y * 120 + x..y * 120 + x + 9].fill(1));
            }
            recorder.push(&mask, f64::from(frame)).unwrap();
        }
        recorder.finish().unwrap()
    }

    #[test]
    fn the_lines_of_the_right_pencils_are_alike() {
        let recordings = [recorded(0), recorded(1)];
        let frames: Vec<FramePair> = (0..200).map(|i| FramePair::new(i, i)).collect();
        let pencils = Pencils::new([&recordings[0], &recordings[1]], &frames, 60, 5);
        let size = recordings[0].size;
        let of = |rows: &Matrix3<f64>| {
            let f = Fundamental::from_matrix(rows, size, size).unwrap();
            let alike = pencils.alike(&f, f64::NEG_INFINITY).unwrap();
            // What is asked for at least changes nothing but whether there is an answer.
            for least in [0.0, 0.2, 0.5 * alike, alike, alike + 1e-6, 0.9, 1.1] {
                assert_eq!(pencils.alike(&f, least), (alike >= least).then_some(alike), "{least}");
            }
            alike
        };
        let right = of(&Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0));
        let a_row_off = of(&Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 12.0));
        let columns = of(&Matrix3::new(0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0));
        assert!(right > 0.97, "{right}");
        assert!(a_row_off < 0.4 && columns < 0.4, "{a_row_off} {columns}");
        let nothing = Pencils::new([&recordings[0], &recordings[1]], &[], 60, 5);
        let rows = Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0);
        let f = Fundamental::from_matrix(&rows, size, size).unwrap();
        assert_eq!(nothing.alike(&f, f64::NEG_INFINITY), Some(0.0));
    }
}
