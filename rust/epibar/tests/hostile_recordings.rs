//! Recordings and numbers that no camera would give: whatever passes the reader's checks is worked through without a
//! panic, and without an end that does not come.
//!
//! `PROPTEST_CASES` says how many are tried.

use epibar::internals::{barcodes_of_segments, mutual_matches};
use epibar::nalgebra::Matrix3;
use epibar::{
    Barcodes, CalibrateOptions, CameraMatrices, ExamineOptions, Fundamental, ImageSize, Method, Recording,
    RecordingParts, Segment, TimeOffset, calibrate, examine,
};
use proptest::prelude::*;

/// Numbers at the ends of what is allowed, and beyond.
fn number() -> impl Strategy<Value = f64> + Clone {
    prop_oneof![
        8 => -100.0..200.0,
        2 => -1e8..1e8,
        1 => any::<f64>(),
        1 => prop::sample::select(vec![0.0, -0.0, 1e-300, 5e-324, f64::MAX, 536_870_911.0, f64::NAN, f64::INFINITY]),
    ]
}

fn times(frames: usize) -> impl Strategy<Value = Vec<f64>> {
    let step = prop_oneof![
        6 => Just(0.04),
        1 => 1e-12..1e3,
        1 => prop::sample::select(vec![1e-300, 1e-9, 1e9, 1e300]),
    ];
    (number(), step, prop::collection::vec(0.0..3.0, frames), prop::bool::weighted(0.7)).prop_map(
        |(start, step, jitter, even)| {
            let mut time = start;
            jitter
                .iter()
                .map(|share| {
                    let now = time;
                    time += if even { step } else { step * share };
                    now
                })
                .collect()
        },
    )
}

/// Silhouettes as rectangles, or as any points in any order.
fn hull(width: u16, height: u16) -> impl Strategy<Value = Vec<[u16; 2]>> {
    let any_points = prop::collection::vec((0..width, 0..height).prop_map(|(x, y)| [x, y]), 1..9);
    let rectangle = (0..width, 0..height, 0..width, 0..height).prop_map(|(x, y, u, v)| {
        let (x0, x1, y0, y1) = (x.min(u), x.max(u), y.min(v), y.max(v));
        vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
    });
    prop_oneof![3 => rectangle, 1 => any_points]
}

fn parts() -> impl Strategy<Value = RecordingParts> {
    (2usize..60, 2usize..50, 1usize..150, 0usize..120)
        .prop_flat_map(|(width, height, frames, lines)| {
            let hulls = prop::collection::vec(
                prop::collection::vec((hull(width as u16, height as u16), any::<bool>(), any::<u32>()), 0..3),
                frames,
            );
            let border = (0..4 * width.max(height), 0..4 * width.max(height)).prop_map(move |(p, q)| {
                let at = |p: usize| match p % 4 {
                    0 => (p % width, 0),
                    1 => (width - 1, p % height),
                    2 => (p % width, height - 1),
                    _ => (0, p % height),
                };
                let (from, to) = (at(p), at(q));
                Segment { x0: from.0 as f64, y0: from.1 as f64, x1: to.0 as f64, y1: to.1 as f64 }
            });
            let anywhere = (number(), number(), number(), number()).prop_map(|(x0, y0, x1, y1)| Segment {
                x0,
                y0,
                x1,
                y1,
            });
            let segments = prop::collection::vec(prop_oneof![9 => border, 1 => anywhere], lines);
            let words = prop::collection::vec(
                prop_oneof![Just(0u64), Just(u64::MAX), any::<u64>()],
                lines * frames.div_ceil(64),
            );
            let heat = prop::collection::vec(0..=frames as u32, width * height);
            (Just((width, height, frames)), times(frames), segments, words, hulls, heat, any::<u64>())
        })
        .prop_map(|((width, height, frames), times, segments, mut barcodes, hulls, mut heat, seed)| {
            let words = frames.div_ceil(64);
            if frames % 64 > 0 {
                barcodes
                    .iter_mut()
                    .skip(words - 1)
                    .step_by(words)
                    .for_each(|word| *word &= (1 << (frames % 64)) - 1);
            }
            // As many moving pixels in all frames as the heat map says.
            let mut moving = vec![0u32; frames];
            for (frame, heat) in heat.iter_mut().enumerate() {
                moving[frame % frames] += *heat;
            }
            let mut over = 0;
            for count in &mut moving {
                let most = (width * height) as u32;
                let all = *count + over;
                *count = all.min(most);
                over = all - *count;
            }
            for heat in &mut heat {
                let less = over.min(*heat);
                *heat -= less;
                over -= less;
            }
            let (mut frame_start, mut hull_start, mut hull_points) = (vec![0], vec![0], vec![]);
            let (mut hull_area, mut hull_border) = (vec![], vec![]);
            // Files of older versions have no outlines.
            let (mut outline_start, mut outline_points) = (vec![0], vec![]);
            let outlined = seed % 2 == 0;
            for frame in hulls {
                for (points, border, area) in frame {
                    if outlined {
                        outline_points.extend(points.iter().copied().step_by(2));
                        outline_start.push(outline_points.len() as u32);
                    }
                    hull_points.extend(points);
                    hull_start.push(hull_points.len() as u32);
                    hull_area.push(1 + area % (width * height) as u32);
                    hull_border.push(border);
                }
                frame_start.push(hull_area.len() as u32);
            }
            let mut parts = RecordingParts::new([width, height], times);
            (parts.segments, parts.barcodes) = (segments, barcodes);
            (parts.frame_start, parts.hull_start, parts.hull_points) = (frame_start, hull_start, hull_points);
            (parts.hull_area, parts.hull_border) = (hull_area, hull_border);
            (parts.outline_start, parts.outline_points) = (outline_start, outline_points);
            (parts.heat, parts.moving_pixels, parts.seed) = (heat, moving, seed);
            parts
        })
}

fn options() -> impl Strategy<Value = CalibrateOptions> {
    let offset = prop_oneof![
        4 => Just(TimeOffset::Known(0.0)),
        1 => number().prop_map(TimeOffset::Known),
        1 => number().prop_map(TimeOffset::About),
        2 => prop_oneof![0.01..30.0, number()].prop_map(|seconds| TimeOffset::Search { seconds }),
        1 => prop_oneof![0.01..30.0, number()].prop_map(|seconds| TimeOffset::Auto { seconds }),
    ];
    let matrix = (1e-3..1e6, 1e-3..1e6, number(), number())
        .prop_map(|(fx, fy, cx, cy)| Matrix3::new(fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0));
    let cameras = prop::option::of((matrix.clone(), matrix));
    (any::<bool>(), offset, any::<bool>(), cameras, 3usize..40, 1usize..60, any::<u64>(), number()).prop_map(
        |(lines, offset, upright, cameras, candidates, draws, seed, limit)| {
            let mut options = CalibrateOptions::new()
                .method(if lines { Method::Lines } else { Method::Frontier })
                .time_offset(offset)
                .upright(upright)
                .candidates(candidates)
                .draws(draws)
                .seed(seed)
                .max_expected_error(limit);
            options.cameras = cameras.and_then(|(a, b)| CameraMatrices::new(a, b).ok());
            options
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(32), max_global_rejects: 1 << 20, ..ProptestConfig::default() })]

    #[test]
    fn any_two_recordings_are_calibrated_or_refused(a in parts(), b in parts(), same in any::<bool>(), options in options()) {
        let a = Recording::try_from(a);
        let b = if same { a.clone() } else { Recording::try_from(b) };
        if let (Ok(a), Ok(b)) = (a, b)
            && let Ok(found) = calibrate(&a, &b, &options) {
            prop_assert!(!found.accepted() || found.fundamental.is_some());
            prop_assert!(found.fundamental.is_none_or(|f| f.matrix().iter().all(|v| v.is_finite())));
            prop_assert!(found.expected_error.is_none_or(|error| error >= 0.0));
        }
    }

    #[test]
    fn any_matrix_is_examined_or_refused(a in parts(), b in parts(), entries in prop::array::uniform9(number()), radius in number(), offset in number()) {
        if let (Ok(a), Ok(b)) = (Recording::try_from(a), Recording::try_from(b)) {
            let matrix = Matrix3::from_row_slice(&entries);
            for f in [Fundamental::from_rank_two(&matrix), Fundamental::from_matrix(&matrix, a.size(), b.size())].into_iter().flatten() {
                let _ = examine(&a, &b, &f, &ExamineOptions::new().radius(radius).time_offset(offset));
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(200), max_global_rejects: 1 << 20, ..ProptestConfig::default() })]

    #[test]
    fn any_parts_make_a_recording_or_an_error(mut parts in parts(), damage in any::<prop::sample::Index>(), value in any::<u64>()) {
        // One array too short, too long, or with another value.
        let short = value as u32;
        match damage.index(11) {
            0 => parts.size = [value as usize, 10],
            1 => { parts.times.pop(); }
            2 => parts.barcodes.push(value),
            3 => if let Some(at) = parts.frame_start.get_mut(value as usize % 7) { *at = short; },
            4 => if let Some(at) = parts.hull_start.last_mut() { *at = short; },
            5 => parts.hull_points.push([u16::MAX, 0]),
            6 => if let Some(at) = parts.heat.first_mut() { *at = short; },
            7 => parts.moving_pixels.clear(),
            8 => if let Some(at) = parts.outline_start.last_mut() { *at = short; },
            9 => parts.outline_points.push([short as u16, 0]),
            _ => parts.visible = Some(vec![1; value as usize % 3000]),
        }
        let _ = Recording::try_from(parts);
    }

    #[test]
    fn any_barcodes_are_matched(words_a in prop::collection::vec(any::<u64>(), 0..200), words_b in prop::collection::vec(any::<u64>(), 0..200),
                                frames in 0usize..200, mutual in 0usize..9) {
        let a = Barcodes::from_words(words_a.len() / frames.div_ceil(64).max(1), frames, words_a);
        let b = Barcodes::from_words(words_b.len() / frames.div_ceil(64).max(1), frames, words_b);
        if let (Ok(a), Ok(b)) = (a, b) {
            for found in mutual_matches(&a, &b, mutual).unwrap_or_default() {
                prop_assert!((found.a as usize) < a.count() && (found.b as usize) < b.count());
            }
        }
    }

    #[test]
    fn any_segments_have_barcodes(width in 0usize..40, height in 0usize..40, frames in 0usize..80, fill in any::<u8>(),
                                  ends in prop::collection::vec(prop::array::uniform4(number()), 0..20)) {
        let segments: Vec<Segment> = ends.iter().map(|&[x0, y0, x1, y1]| Segment { x0, y0, x1, y1 }).collect();
        if let Ok(size) = ImageSize::new(width, height) {
            let masks = vec![fill; frames * size.pixels()];
            if let Ok(found) = barcodes_of_segments(&masks, frames, size, &segments) {
                prop_assert_eq!(found.count(), segments.len());
            }
        }
    }
}

/// How many are tried: what `PROPTEST_CASES` says, or as many as usual.
fn cases(usual: u32) -> u32 {
    std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}
