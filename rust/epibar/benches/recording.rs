//! One camera: `cargo bench --bench recording`. A block of 256 frames of 320 × 240 pixels under 20,000 lines.

#![allow(missing_docs, reason = "criterion_group! makes a public function")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::flying::Scene;
use criterion::{Criterion, criterion_group, criterion_main};
use epibar::internals::{BLOCK_FRAMES, Components, PixelBlock, border_segments, convex_hull};
use epibar::{Recorder, RecorderOptions, Recording};

fn record(scene: &Scene, masks: &[Vec<u8>]) -> Recording {
    let mut recorder = Recorder::new(scene.cameras[0].size, RecorderOptions::default()).unwrap();
    for (frame, mask) in masks.iter().enumerate() {
        recorder.push(mask, frame as f64).unwrap();
    }
    recorder.finish().unwrap()
}

fn recording(criterion: &mut Criterion) {
    let scene = Scene::new(10, BLOCK_FRAMES, 1);
    let size = scene.cameras[0].size;
    let masks: Vec<Vec<u8>> = (0..scene.frames).map(|frame| scene.mask(0, frame)).collect();
    let mut group = criterion.benchmark_group("recording");
    group.sample_size(20);

    let mut found = Components::new();
    group.bench_function("components of 256 masks", |bencher| {
        bencher.iter(|| {
            for mask in &masks {
                found.find(black_box(mask), size);
            }
        });
    });

    let mut hulls = Vec::new();
    group.bench_function("components and hulls of 256 masks", |bencher| {
        bencher.iter(|| {
            hulls.clear();
            for mask in &masks {
                found.find(black_box(mask), size);
                found.components().iter().for_each(|c| convex_hull(found.runs_of(c), &mut hulls));
            }
            hulls.len()
        });
    });

    let mut block = PixelBlock::new(size);
    let whole = masks.concat();
    group.bench_function("packing", |bencher| {
        bencher.iter(|| {
            block.clear();
            block.set_frames(black_box(&whole));
        });
    });

    let segments = border_segments(size, 20_000, 0);
    group.bench_function("20,000 lines over a block", |bencher| {
        bencher.iter(|| black_box(block.unions(black_box(&segments))));
    });
    group.bench_function("whole recording", |bencher| {
        bencher.iter(|| black_box(record(&scene, &masks)));
    });
    group.finish();
}

criterion_group!(benches, recording);
criterion_main!(benches);
