//! Line hypotheses: `cargo bench --bench hypotheses`. One matrix against 1,000 pairs of lines.

#![allow(missing_docs, reason = "criterion_group! makes a public function")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::cameras::fundamental;
use common::flying::Scene;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use epibar::internals::{Candidate, Estimator, LineModel, LinePair, border_segments, generator};

fn line_scores(criterion: &mut Criterion) {
    let scene = Scene::new(5, 2, 1);
    let sizes = [scene.cameras[0].size, scene.cameras[1].size];
    let f = fundamental(&scene.cameras[0], &scene.cameras[1]);
    let pairs = border_segments(sizes[0], 1000, 1).into_iter().zip(border_segments(sizes[1], 1000, 2));
    let candidates: Vec<Candidate> = pairs
        .map(|(segment_a, segment_b)| Candidate {
            lines: LinePair { a: segment_a.line().unwrap(), b: segment_b.line().unwrap() },
            segment_a,
            segment_b,
            correlation: 0.5,
        })
        .collect();
    let model = LineModel::new(&candidates, sizes);
    let mut group = criterion.benchmark_group("hypotheses");
    group.throughput(Throughput::Elements(1000));
    group.bench_function("line score of 1,000 candidates", |bencher| {
        bencher.iter(|| model.score(black_box(&f)));
    });
    group.bench_function("hypothesis from two pairs of 1,000", |bencher| {
        let mut index = 0;
        bencher.iter(|| {
            index += 1;
            model.generate(index, &mut generator(1, index as u64))
        });
    });
    group.finish();
}

criterion_group!(benches, line_scores);
criterion_main!(benches);
