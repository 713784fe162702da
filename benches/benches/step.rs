//! Wall time of the whole step and its parts.
#![allow(missing_docs)]

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trueaxis::compensation::Direction;
use trueaxis_benches::Random;
use trueaxis_benches::contour::{Query, Shape, Track};
use trueaxis_benches::gauge::Gauge;
use trueaxis_benches::limiter::Limits;
use trueaxis_benches::step;
use trueaxis_benches::tables::{Grid, nine_terms, position};

fn look_up(c: &mut Criterion) {
    let mut group = c.benchmark_group("nine terms");
    let places = [0; 256].map(|_| ()).iter().scan(Random(3), |r, ()| Some(position(r))).collect::<Vec<_>>();
    for (name, grid) in [("equidistant", Grid::Equidistant), ("free", Grid::Free)] {
        let terms = nine_terms(grid);
        let mut next = places.iter().cycle();
        group.bench_function(name, |b| {
            b.iter(|| {
                let at = terms.coordinates(black_box(next.next().unwrap_or(&[0.0; 3])));
                terms.errors(
                    &trueaxis::compensation::Query::at(&at, &[Direction::POSITIVE; 3], &Default::default()),
                    &mut 0,
                )
            })
        });
    }
    group.finish();
}

fn contour(c: &mut Criterion) {
    let mut group = c.benchmark_group("contour, warm");
    for (name, shape) in [
        ("rational cubic", Shape::RationalCubic),
        ("polynomial cubic", Shape::PolynomialCubic),
        ("arc", Shape::Arc),
        ("line", Shape::Line),
    ] {
        let track = Track::new(shape);
        let inside = |q: &Query| { *q }.run().evaluations == 2;
        let queries: Vec<Query> = (0..4096).map(|seed| track.query(seed)).filter(inside).take(256).collect();
        let mut next = queries.iter().cycle();
        group.bench_function(name, |b| b.iter(|| next.next().map(|query| black_box(query).repeat())));
    }
    group.finish();
}

fn limiter(c: &mut Criterion) {
    let mut group = c.benchmark_group("limiter, three axes");
    for (name, limits) in [("nothing binding", Limits::free()), ("all binding", Limits::binding())] {
        group.bench_function(name, |b| b.iter(|| { black_box(limits) }.follow()));
    }
    group.finish();
}

fn whole_step(c: &mut Criterion) {
    let mut group = c.benchmark_group("three-axis step");
    let mut cycles = Vec::new();
    step::walk(2600, |_, cycle, _| cycles.push(*cycle));
    let mut next = cycles.iter().skip(2000).cycle();
    group.bench_function("butterfly", |b| b.iter(|| next.next().map(|cycle| { black_box(*cycle) }.run())));
    group.finish();
}

fn gauge(c: &mut Criterion) {
    let mut group = c.benchmark_group("gauge, 1024 points");
    for (name, passing) in [("sampling between points", false), ("sampling at a point", true)] {
        let mut gauge = Gauge::sampling(passing);
        group.bench_function(name, |b| b.iter(|| black_box(&mut gauge).sample()));
    }
    let before = Gauge::whole_revolution();
    group.bench_function("work on a revolution", |b| {
        b.iter_batched_ref(|| before.clone(), |gauge| black_box(gauge).work(), BatchSize::LargeInput)
    });
    group.finish();
}

criterion_group!(parts, look_up, contour, limiter, whole_step, gauge);
criterion_main!(parts);
