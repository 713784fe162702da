//! Instruction counts under callgrind: one call of each function with fixed input.
#![allow(missing_docs)]

use gungraun::prelude::*;
use gungraun::{Callgrind, EntryPoint};
use std::hint::black_box;
use trueaxis::compensation::{Direction, NineTerms, PoseError, Volumetric};
use trueaxis::contour::{ContourError, OrientationError};
use trueaxis_benches::Random;
use trueaxis_benches::contour::{Query, Shape, Track};
use trueaxis_benches::gauge::Gauge;
use trueaxis_benches::kinematics::Pose;
use trueaxis_benches::limiter::Limits;
use trueaxis_benches::step::{self, RunningLoop};
use trueaxis_benches::tables::{Grid, nine_terms as nine_terms_of, position, volumetric as volumetric_of};
use trueaxis_benches::tool::{self, ToolCycle};

struct Lookup(NineTerms<'static, f64, f64, 3>, [f64; 3]);

fn lookup(grid: Grid) -> &'static Lookup {
    let terms = nine_terms_of(grid);
    let at = terms.coordinates(&position(&mut Random(5)));
    Box::leak(Box::new(Lookup(terms, at)))
}

struct Poses<const N: usize>(Volumetric<'static, f64, f64, N>, [f64; N]);

fn poses<const N: usize>() -> &'static Poses<N> {
    let model = volumetric_of::<N>();
    let mut random = Random(5);
    let linear = position(&mut random);
    let at = model.coordinates(&std::array::from_fn(|i| linear.get(i).copied().unwrap_or(-35.0 - 17.3 * i as f64)));
    leak(Poses(model, at))
}

fn leak<T>(value: T) -> &'static mut T {
    Box::leak(Box::new(value))
}

fn middle(shape: Shape) -> &'static mut Query {
    let track = Track::new(shape);
    let query = track.middle(track.pieces() / 2);
    assert_eq!({ query }.run().evaluations, 2, "not the fast path");
    leak(query)
}

fn seeded(seed: u64) -> &'static mut Query {
    leak(Track::new(Shape::RationalCubic).query(seed))
}

fn free() -> &'static mut Limits {
    let limits = Limits::free();
    assert_eq!({ limits }.follow(), 0);
    leak(limits)
}

fn binding() -> &'static mut Limits {
    let limits = Limits::binding();
    assert_eq!({ limits }.follow(), 3);
    leak(limits)
}

// Overhead of a lookup: the call, and writing its result to memory.
#[library_benchmark(setup = lookup)]
#[bench::frame(Grid::Equidistant)]
fn nothing(lookup: &'static Lookup) -> [f64; 3] {
    black_box(lookup.1)
}

#[library_benchmark(setup = lookup)]
#[bench::equidistant(Grid::Equidistant)]
fn nine_terms(lookup: &'static Lookup) -> [f64; 3] {
    let mut held = 0;
    black_box(lookup.0.plain_terms(&lookup.1, &[Direction::POSITIVE; 3], &mut held))
}

#[library_benchmark(setup = lookup)]
#[bench::free(Grid::Free)]
fn nine_terms_free(lookup: &'static Lookup) -> [f64; 3] {
    let mut held = 0;
    black_box(lookup.0.linear_terms(&lookup.1, &[Direction::POSITIVE; 3], &mut held))
}

#[library_benchmark]
#[bench::three_axis(setup = poses::<3>)]
fn volumetric(poses: &'static Poses<3>) -> PoseError<f64> {
    let mut held = 0;
    black_box(poses.0.pose_error(
        &trueaxis::compensation::Query::at(&poses.1, &[Direction::POSITIVE; 3], &Default::default()),
        &mut held,
    ))
}

#[library_benchmark]
#[bench::five_axis(setup = poses::<5>)]
fn volumetric_rotary(poses: &'static Poses<5>) -> PoseError<f64> {
    let mut held = 0;
    black_box(poses.0.pose_error(
        &trueaxis::compensation::Query::at(&poses.1, &[Direction::POSITIVE; 5], &Default::default()),
        &mut held,
    ))
}

#[library_benchmark(setup = middle)]
#[bench::rational_cubic(Shape::RationalCubic)]
#[bench::polynomial_cubic(Shape::PolynomialCubic)]
fn contour(query: &'static mut Query) -> ContourError<f64> {
    black_box(query.run())
}

#[library_benchmark(
    setup = middle,
    config = LibraryBenchmarkConfig::default()
        .tool(Callgrind::default().entry_point(EntryPoint::Custom("trueaxis::contour::kernel::cubic*".to_owned())))
)]
#[bench::rational_cubic(Shape::RationalCubic)]
#[bench::polynomial_cubic(Shape::PolynomialCubic)]
fn kernel(query: &'static mut Query) -> ContourError<f64> {
    black_box(query.run())
}

#[library_benchmark(setup = seeded)]
#[bench::worst(565)]
fn contour_worst(query: &'static mut Query) -> ContourError<f64> {
    black_box(query.run())
}

#[library_benchmark]
#[bench::free(setup = free)]
#[bench::binding(setup = binding)]
fn limiter(limits: &'static mut Limits) -> u8 {
    black_box(limits.follow())
}

fn worst() -> &'static mut RunningLoop {
    leak(step::worst(20_000))
}

#[library_benchmark]
#[bench::worst(setup = worst)]
fn whole_step(cycle: &'static mut RunningLoop) -> trueaxis::Output<f64, f64, 3> {
    black_box(cycle.run())
}

fn five_axes() -> &'static mut ToolCycle {
    leak(tool::typical())
}

#[library_benchmark(setup = five_axes)]
#[bench::five_axis_tool()]
fn whole_step_tool(cycle: &'static mut ToolCycle) -> (trueaxis::Output<f64, f64, 5>, OrientationError<f64>) {
    black_box(cycle.run())
}

#[library_benchmark(setup = five_axes)]
#[bench::five_axis_tool()]
fn whole_step_rtcp(cycle: &'static mut ToolCycle) -> (trueaxis::Output<f64, f64, 5>, OrientationError<f64>) {
    black_box(cycle.run_rtcp())
}

fn sampling(passing: bool) -> &'static mut Gauge {
    leak(Gauge::sampling(passing))
}

fn revolution() -> &'static mut Gauge {
    leak(Gauge::whole_revolution())
}

#[library_benchmark(setup = sampling)]
#[bench::between_points(false)]
#[bench::at_a_point(true)]
fn gauge_sampling(gauge: &'static mut Gauge) -> u16 {
    black_box(gauge.sample())
}

#[library_benchmark]
#[bench::revolution(setup = revolution)]
fn gauge_transform(gauge: &'static mut Gauge) -> bool {
    black_box(gauge.transform())
}

fn with_pose(way: fn(&Pose)) -> (&'static Pose, fn(&Pose)) {
    (leak(Pose::trunnion()), way)
}

fn forward(pose: &Pose) {
    black_box(pose.forward());
}

// Both branches, and choosing the nearer one.
fn inverse(pose: &Pose) {
    black_box(pose.inverse()).expect("a pose within reach");
}

#[library_benchmark(setup = with_pose)]
#[bench::forward(forward)]
#[bench::inverse(inverse)]
fn kinematics((pose, way): (&'static Pose, fn(&Pose))) {
    way(pose);
}

library_benchmark_group!(
    name = counts,
    benchmarks = [
        nothing,
        nine_terms,
        nine_terms_free,
        volumetric,
        volumetric_rotary,
        contour,
        kernel,
        contour_worst,
        limiter,
        whole_step,
        whole_step_tool,
        whole_step_rtcp,
        gauge_sampling,
        gauge_transform,
        kinematics
    ]
);
main!(library_benchmark_groups = counts);
