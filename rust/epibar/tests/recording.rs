//! A recording against plain loops over its masks: barcodes, heat, components, hulls, silhouettes.

mod common;

use common::masks::{self, Mask, Random, blob, noise};
use epibar::internals::{Components, barcodes_of_segments, convex_hull, traversal};
use epibar::{Barcodes, ImageSize, Line, Recorder, RecorderOptions, Recording, RecordingParts, Segment};

/// The barcodes by definition: frame by frame, pixel by pixel.
fn naive_barcodes(masks: &[Mask], size: ImageSize, segments: &[Segment]) -> Barcodes {
    let pixels: Vec<_> = segments.iter().map(|segment| traversal::pixels(segment, size)).collect();
    Barcodes::from_fn(segments.len(), masks.len(), |i, frame| {
        pixels[i].iter().any(|(x, y)| masks[frame][y * size.width() + x] != 0)
    })
}

fn record(masks: &[Mask], size: ImageSize, options: RecorderOptions) -> Recording {
    let mut recorder = Recorder::new(size, options).unwrap();
    for (frame, mask) in masks.iter().enumerate() {
        recorder.push(mask, 0.04 * frame as f64).unwrap();
    }
    recorder.finish().unwrap()
}

fn options(lines: usize) -> RecorderOptions {
    RecorderOptions::new().lines(lines)
}

#[test]
fn packed_barcodes_are_the_naive_ones() {
    let mut random = Random(1);
    for (frames, width, height, density) in
        [(1, 31, 17, 20), (63, 17, 40, 10), (512, 20, 13, 5), (513, 23, 9, 8), (1030, 12, 19, 6)]
    {
        let size = ImageSize::new(width, height).unwrap();
        let masks: Vec<Mask> = (0..frames).map(|_| noise(size, density, &mut random)).collect();
        let recording = record(&masks, size, options(60));
        let expected = naive_barcodes(&masks, size, recording.segments());
        let ones: u32 = (0..60).map(|i| expected.ones(i)).sum();
        assert!(ones > 0 && (ones as usize) < 60 * frames, "both bits must occur");
        assert_eq!(*recording.barcodes(), expected, "{frames} frames");
        let whole = masks.concat();
        let again = barcodes_of_segments(&whole, frames, size, recording.segments()).unwrap();
        assert_eq!(again, expected, "{frames} frames");

        let heat = |pixel: usize| masks.iter().filter(|mask| mask[pixel] != 0).count() as u32;
        assert!((0..size.pixels()).map(heat).eq(recording.heat().iter().copied()));
        let moving = |mask: &Mask| mask.iter().filter(|&&v| v != 0).count() as u32;
        assert!(masks.iter().map(moving).eq(recording.moving_pixels().iter().copied()));
        let parts = RecordingParts::from(recording.clone());
        assert_eq!(Recording::try_from(parts).unwrap(), recording);
    }
}

#[test]
fn a_walk_is_exact_thin_and_symmetric() {
    let mut random = Random(2);
    let size = ImageSize::new(61, 38).unwrap();
    for _ in 0..3000 {
        let mut end = || [random.below(61) as i64, random.below(38) as i64];
        let ([x0, y0], [x1, y1]) = (end(), end());
        let between = |p: [i64; 2], q: [i64; 2]| Segment {
            x0: p[0] as f64,
            y0: p[1] as f64,
            x1: q[0] as f64,
            y1: q[1] as f64,
        };
        let walk = traversal::pixels(&between([x0, y0], [x1, y1]), size);
        assert_eq!(walk, traversal::pixels(&between([x1, y1], [x0, y0]), size));
        // One pixel per step along the major axis, ends included, each a neighbour of the one before.
        let major = (x1 - x0).abs().max((y1 - y0).abs());
        assert_eq!(walk.len() as i64, major + 1);
        let mut ends = [walk[0], walk[walk.len() - 1]].map(|(x, y)| [x as i64, y as i64]);
        if ends[0] != [x0, y0] {
            ends.reverse();
        }
        assert_eq!(ends, [[x0, y0], [x1, y1]]);
        for pair in walk.windows(2) {
            let (dx, dy) = (pair[0].0.abs_diff(pair[1].0), pair[0].1.abs_diff(pair[1].1));
            assert_eq!(dx.max(dy), 1);
        }
        // The distance along the minor axis is |cross| / major, so at most ½ exactly.
        for &(x, y) in &walk {
            let cross = (x as i64 - x0) * (y1 - y0) - (y as i64 - y0) * (x1 - x0);
            assert!(2 * cross.abs() <= major);
        }
    }
}

#[test]
fn components_equal_a_flood_fill() {
    let mut random = Random(3);
    let mut found = Components::new();
    for round in 0..300 {
        let size = ImageSize::new(2 + random.below(80), 2 + random.below(30)).unwrap();
        let mask = noise(size, 5 + 10 * (round % 8), &mut random);
        found.find(&mask, size);
        let mut ours: Vec<Vec<usize>> = Vec::new();
        for component in found.components() {
            let mut pixels = Vec::new();
            for run in found.runs_of(component) {
                let row = usize::from(run.y) * size.width();
                pixels.extend(row + usize::from(run.x_first)..=row + usize::from(run.x_last));
            }
            assert_eq!(pixels.len(), component.area as usize);
            let columns = || pixels.iter().map(|pixel| (pixel % size.width()) as u16);
            assert_eq!(columns().min(), Some(component.x_min));
            assert_eq!(columns().max(), Some(component.x_max));
            let row = |pixel: usize| (pixel / size.width()) as u16;
            assert_eq!(row(pixels[0]), component.y_min);
            assert_eq!(row(pixels[pixels.len() - 1]), component.y_max);
            ours.push(pixels);
        }
        assert_eq!(ours, masks::flood_fill(&mask, size));
    }
}

#[test]
fn hulls_equal_brute_force() {
    let mut random = Random(4);
    let size = ImageSize::new(14, 11).unwrap();
    let mut found = Components::new();
    for round in 0..200 {
        let mask = noise(size, 20 + 10 * (round % 5), &mut random);
        found.find(&mask, size);
        for component in found.components() {
            let mut hull = Vec::new();
            convex_hull(found.runs_of(component), &mut hull);
            let mut pixels = Vec::new();
            for run in found.runs_of(component) {
                pixels.extend((run.x_first..=run.x_last).map(|x| [x, run.y]));
            }
            // Every vertex is extreme and every extreme pixel a vertex, once.
            let mut expected = masks::extreme_points(&pixels);
            let mut vertices = hull.clone();
            expected.sort_unstable();
            vertices.sort_unstable();
            assert_eq!(vertices, expected);
            // Strictly clockwise on the screen, from the left end of the top row.
            assert_eq!(hull[0], pixels[0]);
            for i in 0..hull.len() {
                let [p, q, r] = [0, 1, 2].map(|k| hull[(i + k) % hull.len()]);
                assert!(hull.len() < 3 || masks::turn(p, q, r) > 0, "{hull:?}");
            }
        }
    }
}

/// The frames in which a hull comes within `half_width` pixels of the line, packed as in [`Barcodes`]. A negative half
/// width asks for a hull that reaches that far on both sides of the line.
fn barcode_of_line(recording: &Recording, line: &Line, half_width: f64) -> Vec<u64> {
    let silhouettes = recording.silhouettes();
    let meets = |hull: usize| {
        let distances = silhouettes.hull(hull).iter().map(|p| line.signed_distance(p[0].into(), p[1].into()));
        let (low, high) =
            distances.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), d| (l.min(d), h.max(d)));
        low <= half_width && high >= -half_width
    };
    let found = Barcodes::from_fn(1, recording.frames(), |_, frame| silhouettes.hulls(frame).any(meets));
    found.words().to_vec()
}

/// Traversal against hulls, both ways.
///
/// The ends of the lines are integer, so a traversed pixel is at most ½ px from its line: a set bit implies
/// a hull within ½ px. For the converse, let a 4-connected blob have pixels more than ½ px from the line on
/// both sides. Then they are beyond the traversed pixel of their column (row, for a steep line), and a path of
/// 4-neighbours joins them. A step within the column cannot jump that pixel, and a step to the next column changes
/// sides only where the line moves by two pixels per column, while it moves by one at most. So the bit is set.
#[test]
fn barcodes_from_pixels_and_from_hulls_agree() {
    let mut random = Random(5);
    let size = ImageSize::new(90, 70).unwrap();
    let masks: Vec<Mask> = (0..150).map(|_| blob(size, &mut random)).collect();
    let keep_all = options(800).min_component_area(1);
    let recording = record(&masks, size, keep_all);
    let (mut set, mut certain) = (0, 0);
    for (i, segment) in recording.segments().iter().enumerate() {
        let line = segment.line().unwrap();
        let near = barcode_of_line(&recording, &line, 0.5 + 1e-9);
        // A negative half width asks for that distance on both sides.
        let crossed = barcode_of_line(&recording, &line, -0.5 - 1e-9);
        for (word, traversed) in recording.barcodes().row(i).iter().enumerate() {
            assert_eq!(traversed & !near[word], 0, "a traversed pixel without a hull");
            assert_eq!(crossed[word] & !traversed, 0, "a hull across a line without a pixel");
            set += traversed.count_ones();
            certain += crossed[word].count_ones();
        }
    }
    // What the bounds leave open is when a line grazes: across a blob w pixels wide about w + 1 lines
    // set the bit and w − 1 are certain to, which for w around 10 is a fifth.
    assert!(certain > 10_000 && set - certain < set / 4, "{certain} of {set}");
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let mut random = Random(7);
    let size = ImageSize::new(70, 260).unwrap();
    let masks: Vec<Mask> = (0..600).map(|_| blob(size, &mut random)).collect();
    let whole = masks.concat();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let recording = record(&masks, size, options(1500));
            let again = barcodes_of_segments(&whole, masks.len(), size, recording.segments()).unwrap();
            assert_eq!(again, *recording.barcodes());
            recording
        })
    };
    let one = with(1);
    for threads in [2, 3, 7] {
        assert!(one == with(threads), "{threads} threads");
    }
}

#[test]
fn each_frame_stands_for_itself() {
    let mut random = Random(6);
    let size = ImageSize::new(40, 27).unwrap();
    let masks: Vec<Mask> = (0..600).map(|_| blob(size, &mut random)).collect();
    let forwards = record(&masks, size, options(200));
    let reversed: Vec<Mask> = masks.iter().rev().cloned().collect();
    let backwards = record(&reversed, size, options(200));
    let order: Vec<u32> = (0..600).rev().collect();
    assert_eq!(*backwards.barcodes(), forwards.barcodes().select_frames(&order));
    assert_ne!(backwards.barcodes(), forwards.barcodes());
    assert_eq!(backwards.heat(), forwards.heat());
    let hulls = |recording: &Recording, frame: usize| -> Vec<Vec<[u16; 2]>> {
        let hulls = recording.silhouettes().hulls(frame);
        hulls.map(|i| recording.silhouettes().hull(i).to_vec()).collect()
    };
    for frame in 0..600 {
        assert_eq!(hulls(&forwards, frame), hulls(&backwards, 599 - frame));
    }
    // More lines change nothing about the first ones, nor does how bright a mask is.
    let bright = |mask: &Mask| mask.iter().map(|v| v * 255).collect();
    let brighter: Vec<Mask> = masks.iter().map(bright).collect();
    let more = record(&brighter, size, options(300));
    let first: Vec<u32> = (0..200).collect();
    assert_eq!(more.barcodes().select_rows(&first), *forwards.barcodes());
}

#[test]
fn small_components_are_no_silhouettes_but_still_move() {
    let size = ImageSize::new(30, 20).unwrap();
    let mut mask = vec![0; 600];
    mask[5 * 30 + 5..5 * 30 + 16].fill(1);
    for (min_component_area, silhouettes) in [(12, 0), (11, 1), (1, 1), (0, 1)] {
        let options = options(400).min_component_area(min_component_area);
        let recording = record(std::slice::from_ref(&mask), size, options);
        assert_eq!(recording.silhouettes().len(), silhouettes);
        assert_eq!(recording.moving_pixels(), [11]);
        assert!((0..400).any(|i| recording.barcodes().ones(i) == 1));
    }
}

#[test]
fn frame_rate_is_from_the_median_step() {
    let size = ImageSize::new(8, 6).unwrap();
    let rate = |times: &[f64]| {
        let mut recorder = Recorder::new(size, options(1)).unwrap();
        for &time in times {
            recorder.push(&[0; 48], time).unwrap();
        }
        recorder.finish().unwrap().frame_rate()
    };
    assert!(rate(&[3.0]).is_nan());
    assert!((rate(&[3.0, 3.5]) - 2.0).abs() < 1e-12);
    assert!((rate(&[0.0, 0.1, 0.2, 0.3, 9.0]) - 10.0).abs() < 1e-9);
    assert!((rate(&[0.0, 1.0, 4.0]) - 0.5).abs() < 1e-12);
}
