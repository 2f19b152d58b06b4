//! One hypothesis: `cargo bench --bench frontier`. Five boxes in 80 and in 240 frames.

#![allow(missing_docs, reason = "criterion_group! makes a public function")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::cameras::fundamental;
use common::flying::Scene;
use criterion::{Criterion, criterion_group, criterion_main};
use epibar::estimate::frontier::{FrontierOptions, frontier_score};
use epibar::estimate::refine::refine;
use epibar::estimate::views::{Views, busy_frames};

fn frontier(criterion: &mut Criterion) {
    let scene = Scene::new(5, 300, 1);
    let [a, b] = scene.recordings(1);
    let f = fundamental(&scene.cameras[0], &scene.cameras[1]);
    let pairs: Vec<(u32, u32)> = (0..300).map(|frame| (frame, frame)).collect();
    let options = FrontierOptions { radius: 3.0, upright: true, shift: 0 };
    let mut group = criterion.benchmark_group("frontier");
    for frames in [80, 240] {
        let views = Views::new(&a, &b, &busy_frames(&a, &b, &pairs, frames));
        group.bench_function(format!("score, {frames} frames"), |bencher| {
            bencher.iter(|| frontier_score(black_box(&views), black_box(&f), &options));
        });
    }
    let views = Views::new(&a, &b, &pairs);
    group.sample_size(20);
    group.bench_function("refine, 300 frames", |bencher| {
        bencher.iter(|| refine(black_box(&views), black_box(&f), &[8.0, 4.0], 2, true));
    });
    group.finish();
}

criterion_group!(benches, frontier);
criterion_main!(benches);
