//! Two cameras, lines only: correlation, mutual matches, motion lines, candidates, each against plain code.

mod common;

use common::masks::Random;
use epibar::internals::{
    Candidate, CandidateOptions, Candidates, FramePair, Match, MotionLineOptions, correlation,
    find_candidates, motion_lines, mutual_matches,
};
use epibar::{Barcodes, Error, ImageSize, Line, Recording, RecordingParts, Segment};

fn bit(barcodes: &Barcodes, row: usize, frame: usize) -> f64 {
    f64::from((barcodes.row(row)[frame / 64] >> (frame % 64) & 1) as u32)
}

/// Paper eq. 1: the centred barcodes' scalar product over the product of their norms; 0 where one is constant.
fn by_definition(a: &Barcodes, i: usize, b: &Barcodes, j: usize) -> f64 {
    let centred = |barcodes: &Barcodes, row: usize| -> Vec<f64> {
        let bits: Vec<f64> = (0..barcodes.frames()).map(|frame| bit(barcodes, row, frame)).collect();
        let mean = bits.iter().sum::<f64>() / bits.len() as f64;
        bits.iter().map(|v| v - mean).collect()
    };
    let (p, q) = (centred(a, i), centred(b, j));
    let dot = |p: &[f64], q: &[f64]| p.iter().zip(q).map(|(x, y)| x * y).sum::<f64>();
    let norms = (dot(&p, &p) * dot(&q, &q)).sqrt();
    if norms < 1e-9 { 0.0 } else { dot(&p, &q) / norms }
}

/// Random barcodes of many densities; every fifth is constant, zeros and ones in turn.
fn random_barcodes(count: usize, frames: usize, random: &mut Random) -> Barcodes {
    let percents: Vec<usize> = (0..count)
        .map(|row| match row % 10 {
            4 => 0,
            9 => 100,
            _ => 10 + random.below(80),
        })
        .collect();
    Barcodes::from_fn(count, frames, |row, _| random.below(100) < percents[row])
}

/// Rows of `a` in another order with some bits changed, and random ones.
fn noisy_copies(a: &Barcodes, count: usize, random: &mut Random) -> Barcodes {
    copies(a, count, 10, random)
}

/// Rows of `a` in another order with one bit in `errors` drawn anew, and random ones.
fn copies(a: &Barcodes, count: usize, errors: usize, random: &mut Random) -> Barcodes {
    let b = random_barcodes(count, a.frames(), random);
    let of: Vec<usize> = (0..count).map(|_| random.below(a.count())).collect();
    Barcodes::from_fn(count, a.frames(), |row, frame| {
        let copied = row % 3 == 0 && random.below(errors) > 0;
        if copied { bit(a, of[row], frame) > 0.5 } else { bit(&b, row, frame) > 0.5 }
    })
}

#[test]
fn correlation_is_that_of_the_definition() {
    let mut random = Random(21);
    for frames in [2, 63, 64, 65, 200] {
        let a = random_barcodes(30, frames, &mut random);
        let b = noisy_copies(&a, 30, &mut random);
        for i in 0..30 {
            for j in 0..30 {
                let common = a.row(i).iter().zip(b.row(j)).map(|(x, y)| (x & y).count_ones()).sum();
                let r = correlation(frames as u32, a.ones(i), b.ones(j), common);
                assert!((r - by_definition(&a, i, &b, j)).abs() < 1e-12);
                assert!((-1.0 - 1e-12..=1.0 + 1e-12).contains(&r));
            }
        }
    }
    assert!((correlation(10, 4, 4, 4) - 1.0).abs() < 1e-12);
    assert!((correlation(10, 4, 6, 0) + 1.0).abs() < 1e-12);
    assert!(correlation(10, 0, 5, 0).abs() < 1e-12 && correlation(10, 10, 5, 5).abs() < 1e-12);
}

/// What may differ between the kernel's single precision and the oracle.
const ROUNDING: f64 = 1e-5;

#[test]
fn mutual_matches_are_those_of_the_whole_matrix() {
    let mut random = Random(22);
    for (count_a, count_b, frames, mutual) in
        [(150, 400, 200, 3), (70, 20, 64, 1), (300, 300, 130, 5), (5, 600, 777, 2), (65, 257, 512, 3)]
    {
        let a = random_barcodes(count_a, frames, &mut random);
        let b = noisy_copies(&a, count_b, &mut random);
        let matches = mutual_matches(&a, &b, mutual).unwrap();
        let matrix: Vec<Vec<f64>> =
            (0..count_a).map(|i| (0..count_b).map(|j| by_definition(&a, i, &b, j)).collect()).collect();
        // How many others of the row and of the column beat a pair by more than `margin`.
        let place = |i: usize, j: usize, margin: f64| {
            let least = matrix[i][j] + margin;
            let in_row = (0..count_b).filter(|&k| k != j && matrix[i][k] > least).count();
            let in_column = (0..count_a).filter(|&k| k != i && matrix[k][j] > least).count();
            in_row.max(in_column)
        };
        let mut found = vec![vec![false; count_b]; count_a];
        for m in &matches {
            let (i, j) = (m.a as usize, m.b as usize);
            assert!(!std::mem::replace(&mut found[i][j], true), "a pair twice");
            assert!((f64::from(m.correlation) - matrix[i][j]).abs() < ROUNDING);
            assert!(m.correlation > 0.0 && (m.rank as usize) < mutual);
            assert!(place(i, j, ROUNDING) <= m.rank as usize, "{m:?} is not in the top");
            assert!(place(i, j, -ROUNDING) >= m.rank as usize, "{m:?} is better than that");
        }
        for i in 0..count_a {
            for j in 0..count_b {
                let certain = matrix[i][j] > ROUNDING && place(i, j, -ROUNDING) < mutual;
                assert!(found[i][j] || !certain, "{i} {j} is missing");
            }
        }
        assert!(matches.len() > 3, "{} matches say little", matches.len());
    }
}

fn matches_of(a: &Barcodes, b: &Barcodes, mutual: usize) -> Vec<Match> {
    mutual_matches(a, b, mutual).unwrap()
}

#[test]
fn best_first_and_never_constant() {
    let mut random = Random(23);
    let a = random_barcodes(200, 150, &mut random);
    let b = noisy_copies(&a, 300, &mut random);
    let all = matches_of(&a, &b, 3);
    assert!(all.is_sorted_by(|p, q| {
        p.correlation > q.correlation || (p.correlation == q.correlation && (p.a, p.b) < (q.a, q.b))
    }));
    let varies = |barcodes: &Barcodes, row: u32| (1..150).contains(&barcodes.ones(row as usize));
    assert!(all.iter().all(|m| varies(&a, m.a) && varies(&b, m.b)));
    // Barcodes against their opposites correlate with −1: never a match.
    let one = Barcodes::from_fn(1, 70, |_, frame| frame % 3 == 0);
    let opposite = Barcodes::from_fn(1, 70, |_, frame| frame % 3 != 0);
    assert!(matches_of(&one, &opposite, 3).is_empty());
    assert_eq!(matches_of(&one, &one, 3), [Match { a: 0, b: 0, correlation: 1.0, rank: 0 }]);
}

#[test]
fn ties_go_to_the_lower_rows() {
    let mut random = Random(24);
    let row = random_barcodes(1, 100, &mut random);
    let (a, b) = (row.select_rows(&[0; 500]), row.select_rows(&[0; 300]));
    let pairs: Vec<(u32, u32, u32)> = matches_of(&a, &b, 2).iter().map(|m| (m.a, m.b, m.rank)).collect();
    assert_eq!(pairs, [(0, 0, 0), (0, 1, 1), (1, 0, 1), (1, 1, 1)]);
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let mut random = Random(25);
    // Few frames and many rows make many ties.
    for frames in [20, 150] {
        let a = random_barcodes(700, frames, &mut random);
        let b = noisy_copies(&a, 500, &mut random);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| matches_of(&a, &b, 3))
        };
        let one = with(1);
        for threads in [2, 3, 7] {
            assert_eq!(one, with(threads), "{threads} threads");
        }
        assert!(one.len() > 50);
    }
}

#[test]
fn what_cannot_be_matched() {
    let (a, b) = (Barcodes::zeros(3, 100), Barcodes::zeros(3, 101));
    assert!(matches!(mutual_matches(&a, &b, 3), Err(Error::Length { left: 100, right: 101, .. })));
    assert!(matches!(mutual_matches(&a, &a, 0), Err(Error::Argument { name: "mutual", .. })));
    assert!(matches_of(&a, &a, 3).is_empty());
    assert!(matches_of(&a, &Barcodes::zeros(0, 100), 3).is_empty());
    assert!(matches_of(&Barcodes::zeros(0, 100), &a, 3).is_empty());
    assert!(matches_of(&Barcodes::zeros(4, 0), &Barcodes::zeros(5, 0), 3).is_empty());
}

/// A recording whose heat map is given pixel by pixel, with lines and their barcodes; nothing else of it is of use.
fn recording(
    size: ImageSize,
    heat: impl Fn(f64, f64) -> u32,
    segments: Vec<Segment>,
    barcodes: &Barcodes,
) -> Recording {
    let at = |pixel: usize| ((pixel % size.width()) as f64, (pixel / size.width()) as f64);
    let heat: Vec<u32> = (0..size.pixels()).map(at).map(|(x, y)| heat(x, y)).collect();
    // As many frames as it takes for pixels that move so often.
    let frames = barcodes.frames();
    let total: u64 = heat.iter().map(|&h| u64::from(h)).sum();
    let share = |k: u64| (total * (k + 1) / frames as u64 - total * k / frames as u64) as u32;
    let mut parts =
        RecordingParts::new([size.width(), size.height()], (0..frames).map(|k| k as f64).collect());
    parts.segments = segments;
    parts.barcodes = barcodes.words().to_vec();
    parts.heat = heat;
    parts.moving_pixels = (0..frames as u64).map(share).collect();
    parts.try_into().unwrap()
}

/// A recording whose heat map is given pixel by pixel.
fn heated(size: ImageSize, heat: impl Fn(f64, f64) -> u32) -> Recording {
    recording(size, heat, Vec::new(), &Barcodes::zeros(0, 600))
}

/// Largest distance of a line from the ends of a segment, pixels.
fn distance(line: &Line, segment: &Segment) -> f64 {
    let end = |x, y| line.signed_distance(x, y).abs();
    end(segment.x0, segment.y0).max(end(segment.x1, segment.y1))
}

#[test]
fn straight_paths_are_found() {
    let size = ImageSize::new(400, 240).unwrap();
    let paths = [
        Segment { x0: 10.0, y0: 200.0, x1: 380.0, y1: 60.0 },
        Segment { x0: 60.0, y0: 5.0, x1: 110.0, y1: 235.0 },
        Segment { x0: 0.0, y0: 120.0, x1: 399.0, y1: 120.0 },
        Segment { x0: 300.0, y0: 0.0, x1: 300.0, y1: 239.0 },
    ];
    for path in &paths {
        let line = path.line().unwrap();
        let hot = |x, y| line.signed_distance(x, y).abs() < 4.0;
        let recording = heated(size, |x, y| if hot(x, y) { 60 } else { 1 });
        let found = motion_lines(&recording, &MotionLineOptions::default());
        assert_eq!(found.len(), 1, "{path:?}");
        assert!(distance(&found[0], path) < 2.0, "{path:?} {:?}", found[0]);
    }
    // Two at once, the stronger first.
    let lines = [paths[0].line().unwrap(), paths[1].line().unwrap()];
    let recording = heated(size, |x, y| {
        let hot = |line: &Line| u32::from(line.signed_distance(x, y).abs() < 4.0);
        30 * hot(&lines[0]) + 80 * hot(&lines[1])
    });
    let found = motion_lines(&recording, &MotionLineOptions::default());
    assert_eq!(found.len(), 2);
    assert!(distance(&found[0], &paths[1]) < 4.0 && distance(&found[1], &paths[0]) < 4.0);
    let one = motion_lines(&recording, &MotionLineOptions { limit: 1, ..Default::default() });
    assert_eq!(one, found[..1]);
}

#[test]
fn scattered_motion_has_no_paths() {
    let size = ImageSize::new(400, 240).unwrap();
    let none = |recording: &Recording| motion_lines(recording, &MotionLineOptions::default()).is_empty();
    assert!(none(&heated(size, |_, _| 0)));
    assert!(none(&heated(size, |_, _| 9)));
    assert!(none(&heated(size, |x, y| (7.0 * x + 13.0 * y) as u32 % 50)));
    // A man at a desk is hot and narrow, but leads nowhere.
    assert!(none(&heated(size, |x, y| if (x - 200.0).hypot(y - 100.0) < 12.0 { 500 } else { 1 })));
    // A broad band is not a line.
    assert!(none(&heated(size, |_, y| if (y - 120.0).abs() < 60.0 { 50 } else { 1 })));
}

/// Two recordings whose line `i` has the same barcode in both, with a path in either heat map. Of the lines, 0 to 9 lie on
/// the paths of both, 10 to 19 on that of A, 20 to 29 on that of B, the others on none.
fn with_paths() -> [Recording; 2] {
    let mut random = Random(26);
    let sizes = [ImageSize::new(400, 240).unwrap(), ImageSize::new(300, 280).unwrap()];
    let paths = [
        Segment { x0: 0.0, y0: 200.0, x1: 399.0, y1: 60.0 },
        Segment { x0: 60.0, y0: 0.0, x1: 110.0, y1: 279.0 },
    ];
    let barcodes = Barcodes::from_fn(60, 200, |_, _| random.below(100) < 40);
    [0, 1].map(|camera| {
        let (size, path) = (sizes[camera], paths[camera]);
        let line = path.line().unwrap();
        let segment = |i: i32| {
            let shift = f64::from(i) * 0.1;
            let (x, y) = (size.x_max(), size.y_max());
            if i < 10 || (10 * (camera as i32 + 1)..10 * (camera as i32 + 2)).contains(&i) {
                Segment { x1: path.x1 - shift, ..path }
            } else {
                Segment { x0: shift, y0: 0.0, x1: x - shift, y1: y }
            }
        };
        let heat = |x, y| if line.signed_distance(x, y).abs() < 4.0 { 60 } else { 1 };
        recording(size, heat, (0..60).map(segment).collect(), &barcodes)
    })
}

/// Which line of each recording a candidate is.
fn rows(c: &Candidate, a: &Recording, b: &Recording) -> (usize, usize) {
    let row =
        |recording: &Recording, segment| recording.segments().iter().position(|s| s == segment).unwrap();
    (row(a, &c.segment_a), row(b, &c.segment_b))
}

#[test]
fn candidates_on_the_paths_of_both_views_are_removed() {
    let [a, b] = with_paths();
    let pairs = common::pairs(200);
    let found_rows = |found: &Candidates| {
        let mut rows: Vec<_> = found.best().iter().map(|c| rows(c, &a, &b)).collect();
        rows.sort_unstable();
        rows
    };
    let same = |range: std::ops::Range<usize>| range.map(|i| (i, i)).collect::<Vec<_>>();
    let only_first = CandidateOptions { mutual: 1, mutual_reserve: 1, ..Default::default() };
    let found = find_candidates(&a, &b, &pairs, &pairs, &only_first).unwrap();
    assert_eq!((found.informative_a, found.informative_b), (60, 60));
    assert_eq!(found.on_motion_lines, 10);
    assert!(found.pairs.iter().all(|c| (c.correlation - 1.0).abs() < 1e-6));
    assert_eq!(found_rows(&found), same(10..60));
    for c in &found.pairs {
        assert!(distance(&c.lines.a, &c.segment_a) < 1e-9 && distance(&c.lines.b, &c.segment_b) < 1e-9);
    }
    let all = CandidateOptions { motion_lines: None, ..only_first };
    let found = find_candidates(&a, &b, &pairs, &pairs, &all).unwrap();
    assert_eq!((found.on_motion_lines, found_rows(&found)), (0, same(0..60)));
}

#[test]
fn candidates_follow_the_frame_pairs_and_the_limits() {
    let [a, b] = with_paths();
    // B started seven frames late: its frame i is A's frame i + 7.
    let barcodes = a.barcodes().select_frames(&(7..200).collect::<Vec<u32>>());
    let b = recording(b.size(), |_, _| 0, b.segments().to_vec(), &barcodes);
    let options = CandidateOptions { motion_lines: None, ..Default::default() };
    let late: Vec<FramePair> = (0..193).map(|i| FramePair::new(i + 7, i)).collect();
    let found = find_candidates(&a, &b, &late, &late, &options).unwrap();
    let (same, others) = found.pairs.split_at(60);
    let is_same = |c: &Candidate| {
        let (in_a, in_b) = rows(c, &a, &b);
        in_a == in_b
    };
    assert!(same.iter().all(|c| is_same(c) && (c.correlation - 1.0).abs() < 1e-6));
    assert!(others.iter().all(|c| !is_same(c) && c.correlation < 0.5));
    let wrong = common::pairs(193);
    let wrong = find_candidates(&a, &b, &wrong, &wrong, &options).unwrap();
    assert!(wrong.pairs.iter().all(|c| c.correlation < 0.5));

    // The candidates of the paper come first, the reserve behind them.
    let whole = found.best().len();
    assert!(whole > 60 && found.pairs.len() > whole, "{whole} {}", found.pairs.len());
    assert!(found.best().is_sorted_by(|p, q| p.correlation >= q.correlation));
    let few = CandidateOptions { limit: 20, reserve: 30, ..options };
    let few = find_candidates(&a, &b, &late, &late, &few).unwrap();
    assert_eq!((few.best().len(), few.pairs.len()), (20, 30));
    assert_eq!(few.pairs, found.pairs[..30]);
}
