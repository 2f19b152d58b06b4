//! What this machine can do, and what the stages of a recording take of it: `cargo bench --bench stages`.
//!
//! `make bench` runs it as `stages MASKS WIDTH HEIGHT LINES`, where the file `MASKS` holds row-major masks one after the
//! other. Without arguments twenty squares bounce through 800 frames of 768 × 576 pixels. Prints one JSON object:
//! seconds for each stage (the least of several runs), bytes read and words counted per second.

use std::hint::black_box;
use std::time::Instant;

use epibar::internals::{BLOCK_FRAMES, Components, PixelBlock, border_segments, convex_hull};
use epibar::{ImageSize, Recorder, RecorderOptions};
use rayon::prelude::*;

const RUNS: usize = 5;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let (masks, size, lines) = if let [path, width, height, lines] = arguments.as_slice() {
        let number = |text: &str| text.parse().expect("a number");
        let size = ImageSize::new(number(width), number(height)).expect("a size");
        (std::fs::read(path).expect("a file of masks"), size, number(lines))
    } else {
        let size = ImageSize::new(768, 576).expect("a size");
        ((0..800).flat_map(|frame| squares(frame, size)).collect(), size, 10_000)
    };
    let frames: Vec<&[u8]> = masks.chunks_exact(size.pixels()).collect();
    let segments = border_segments(size, lines, 0);
    let mut found = Components::new();
    let mut hulls = Vec::new();
    let mut block = PixelBlock::new(size);
    let components = least(|| frames.iter().for_each(|mask| found.find(mask, size)));
    let with_hulls = least(|| {
        for mask in &frames {
            found.find(mask, size);
            hulls.clear();
            found.components().iter().for_each(|c| convex_hull(found.runs_of(c), &mut hulls));
        }
    });
    let packing = least(|| {
        for masks in masks.chunks(BLOCK_FRAMES * size.pixels()) {
            block.clear();
            block.set_frames(masks);
        }
    });
    let blocks = frames.len().div_ceil(BLOCK_FRAMES) as f64;
    let barcodes = blocks * least(|| drop(black_box(block.unions(&segments))));
    let pixels: usize =
        segments.iter().map(|s| (s.x1 - s.x0).abs().max((s.y1 - s.y0).abs()) as usize + 1).sum();
    let recorder = least(|| {
        let options = RecorderOptions::new().lines(lines);
        let mut recorder = Recorder::new(size, options).expect("a size");
        for (frame, mask) in frames.iter().enumerate() {
            recorder.push(mask, frame as f64).expect("a mask");
        }
        black_box(recorder.finish().expect("frames"));
    });
    let reading = least(|| read(&masks));
    let large: Vec<u8> = vec![1; 256 << 20];
    let bandwidth = large.len() as f64 / least(|| read(&large));
    let popcount = popcount_rate();
    println!(
        "{{\"threads\": {}, \"components\": {components}, \"hulls\": {}, \"packing\": {packing}, \
         \"reading\": {reading}, \"barcodes\": {barcodes}, \"line_pixels\": {}, \"recorder\": {recorder}, \
         \"bytes_per_second\": {bandwidth}, \"words_per_second\": {popcount}}}",
        rayon::current_num_threads(),
        (with_hulls - components).max(0.0),
        pixels as f64 * blocks,
    );
}

/// Least seconds of several runs: whatever else the machine does only adds.
fn least(mut work: impl FnMut()) -> f64 {
    let seconds = (0..RUNS).map(|_| {
        let started = Instant::now();
        work();
        started.elapsed().as_secs_f64()
    });
    seconds.fold(f64::INFINITY, f64::min)
}

/// Reads all bytes once, on all cores.
fn read(bytes: &[u8]) {
    let sum: u64 = bytes
        .par_chunks(1 << 20)
        .map(|part| {
            part.chunks_exact(8)
                .map(|w| u64::from_ne_bytes(w.try_into().expect("eight")))
                .fold(0, |s, w| s ^ w)
        })
        .reduce(|| 0, |s, w| s ^ w);
    black_box(sum);
}

/// Words of 64 bits that all cores together can AND, count and add per second, from the first-level cache.
fn popcount_rate() -> f64 {
    const ROUNDS: usize = 100_000;
    let words = [Line([0x5555_aaaa_3333_cccc; 8]); 128];
    let threads = rayon::current_num_threads();
    let work = || rayon::broadcast(|_| (0..ROUNDS).map(|i| count(black_box(&words), i as u64)).sum::<u64>());
    (threads * ROUNDS * words.len() * 8) as f64 / least(|| drop(black_box(work())))
}

/// A cache line of words.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Line([u64; 8]);

fn count(words: &[Line], mask: u64) -> u64 {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vpopcntdq") {
            // SAFETY: the features were detected.
            return unsafe { x86::count_avx512(words, mask) };
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("popcnt") {
            // SAFETY: the features were detected.
            return unsafe { x86::count_avx2(words, mask) };
        }
    }
    count_plain(words, mask)
}

#[inline(always)]
#[allow(clippy::inline_always, reason = "the body must be compiled under each target feature")]
fn count_plain(words: &[Line], mask: u64) -> u64 {
    let mut counts = [[0u64; 8]; 4];
    for lines in words.chunks_exact(4) {
        for (counts, line) in counts.iter_mut().zip(lines) {
            for (count, word) in counts.iter_mut().zip(line.0) {
                *count += u64::from((word & mask).count_ones());
            }
        }
    }
    counts.iter().flatten().sum()
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Line, count_plain};
    use std::arch::x86_64::{
        _mm512_add_epi64, _mm512_and_si512, _mm512_load_si512, _mm512_popcnt_epi64, _mm512_reduce_add_epi64,
        _mm512_set1_epi64, _mm512_setzero_si512,
    };

    #[target_feature(enable = "avx512f,avx512vpopcntdq")]
    pub fn count_avx512(words: &[Line], mask: u64) -> u64 {
        let mask = _mm512_set1_epi64(mask as i64);
        let mut counts = [_mm512_setzero_si512(); 4];
        for lines in words.chunks_exact(4) {
            for (count, line) in counts.iter_mut().zip(lines) {
                // SAFETY: eight aligned words.
                let words = unsafe { _mm512_load_si512(line.0.as_ptr().cast()) };
                *count = _mm512_add_epi64(*count, _mm512_popcnt_epi64(_mm512_and_si512(words, mask)));
            }
        }
        counts.into_iter().map(|count| _mm512_reduce_add_epi64(count) as u64).sum()
    }

    #[target_feature(enable = "avx2,popcnt")]
    pub fn count_avx2(words: &[Line], mask: u64) -> u64 {
        count_plain(words, mask)
    }
}

/// Twenty squares of 40 × 40 pixels on straight paths that bounce.
fn squares(frame: usize, size: ImageSize) -> Vec<u8> {
    let bounce = |position: usize, room: usize| room - (position % (2 * room)).abs_diff(room);
    let mut mask = vec![0; size.pixels()];
    for i in 0..20 {
        let x = bounce(i * 97 + frame * (1 + i % 5), size.width() - 40);
        let y = bounce(i * 61 + frame * (1 + i % 3), size.height() - 40);
        for y in y..y + 40 {
            mask[y * size.width() + x..y * size.width() + x + 40].fill(1);
        }
    }
    mask
}
