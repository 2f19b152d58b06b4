//! Two cameras, lines only: `cargo bench --bench matching`. 2,000 × 2,000 barcodes of 800 frames.

#![allow(missing_docs, reason = "criterion_group! makes a public function")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::masks::Random;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use epibar::Barcodes;
use epibar::internals::mutual_matches;

const LINES: usize = 2000;
const FRAMES: usize = 800;

/// Barcodes with ones in runs, as passages make them.
fn barcodes(seed: u64) -> Barcodes {
    let mut random = Random(seed);
    let mut moving = false;
    Barcodes::from_fn(LINES, FRAMES, |_, frame| {
        moving = frame > 0 && moving;
        moving ^= random.below(12) == 0;
        moving
    })
}

fn matching(criterion: &mut Criterion) {
    let (a, b) = (barcodes(1), barcodes(2));
    let mut group = criterion.benchmark_group("matching");
    group.sample_size(20);
    group.throughput(Throughput::Elements((LINES * LINES) as u64));
    for mutual in [3, 10] {
        group.bench_function(format!("mutual top {mutual}"), |bencher| {
            bencher.iter(|| mutual_matches(black_box(&a), black_box(&b), mutual).unwrap());
        });
    }
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    group.bench_function("mutual top 3, one thread", |bencher| {
        bencher.iter(|| one.install(|| mutual_matches(black_box(&a), black_box(&b), 3).unwrap()));
    });
    group.finish();
}

criterion_group!(benches, matching);
criterion_main!(benches);
