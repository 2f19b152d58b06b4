//! One hypothesis: `cargo bench --bench frontier`. Five boxes in 80 and in 240 frames.

#![allow(missing_docs, reason = "criterion_group! makes a public function")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::cameras::fundamental;
use common::flying::Scene;
use common::pairs;
use criterion::{Criterion, criterion_group, criterion_main};
use epibar::internals::{Views, busy_frames, frontier_score, refine};

fn frontier(criterion: &mut Criterion) {
    let scene = Scene::new(5, 300, 1);
    let [a, b] = scene.recordings(1);
    let f = fundamental(&scene.cameras[0], &scene.cameras[1]);
    let pairs = pairs(300);
    let mut group = criterion.benchmark_group("frontier");
    for frames in [80, 240] {
        let views = Views::new(&a, &b, &busy_frames(&a, &b, &pairs, Some(frames)));
        group.bench_function(format!("score, {frames} frames"), |bencher| {
            bencher.iter(|| frontier_score(black_box(&views), black_box(&f), 3.0));
        });
    }
    let views = Views::new(&a, &b, &pairs);
    group.sample_size(20);
    group.bench_function("refine, 300 frames", |bencher| {
        bencher.iter(|| refine(black_box(&views), black_box(&f), &[8.0, 4.0], 2));
    });
    group.finish();
}

criterion_group!(benches, frontier);
criterion_main!(benches);
