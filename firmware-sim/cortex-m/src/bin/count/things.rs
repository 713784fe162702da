//! Parts of the step in isolation, with the same inputs as the host's counts.

use crate::arena::Arena;
use core::hint::black_box;
use cortex_m_semihosting::hprintln;
use trueaxis::compensation::Query;
use trueaxis::compensation::{Direction, NineTerms, ThermalLine, Volumetric};
use trueaxis::contour::{ContourSearch, ContourState, Method, Path, Reference, Segment, Span, convert};
use trueaxis::glam::DVec3;
use trueaxis::limiter::{Limiter, LimiterState};
use trueaxis::machine::Rows;
use trueaxis::machine::{AxisOrder, AxisSettings, ErrorModel, MachineSettings};
use trueaxis::{Axis, Position, Real, Row};
use trueaxis_cortex_m::settings;
use trueaxis_cortex_m::timer::{Tally, timed};

/// Points of a table.
const POINTS: usize = 128;

/// A table with errors of some 10 µm and some 10 µrad, with equal or unequal spacing.
struct Table {
    axis: Axis,
    free: bool,
}

impl Rows for Table {
    fn len(&self) -> usize {
        POINTS
    }

    fn row(&self, index: usize) -> Option<Row> {
        let cell = if self.axis.is_rotary() { 360.0 / (POINTS - 1) as f64 } else { 5.0 };
        let stray = if self.free && index > 0 { 0.4 * (self.scatter(index, 9) - 0.5) } else { 0.0 };
        let first = if self.axis.is_rotary() { 0.0 } else { -300.0 };
        // The table of a rotary axis closes.
        let place = if self.axis.is_rotary() && index == POINTS - 1 { 0 } else { index };
        let mut errors = [0.0; 6];
        for (k, error) in errors.iter_mut().enumerate() {
            let slow = (place.min(POINTS - place) as f64) / POINTS as f64;
            *error = if k < 3 { 1e-3 } else { 1e-6 } * (20.0 * slow + self.scatter(place, k));
        }
        Some(Row { position: first + cell * (index as f64 + stray), forward: errors, reverse: errors })
    }
}

impl Table {
    /// A pseudo-random number from 0 to 1, determined by the indices.
    fn scatter(&self, place: usize, k: usize) -> f64 {
        let mixed = ((place * 31 + k * 7 + self.axis.index() * 101 + 1) as u32).wrapping_mul(2_654_435_761);
        f64::from(mixed >> 8) / f64::from(1u32 << 24)
    }
}

fn tables(free: bool) -> [Table; 6] {
    [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C].map(|axis| Table { axis, free })
}

fn machine(five: bool, model: ErrorModel) -> MachineSettings {
    let axes = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::C].into_iter().take(if five { 5 } else { 3 });
    let axes = axes.map(|axis| {
        let settings = AxisSettings::with_defaults(axis, axis.is_rotary());
        let linear = AxisSettings { travel: [-290.0, 325.0], joint: [-290.1, 325.1], ..settings };
        if axis.is_rotary() { settings } else { linear }
    });
    settings::machine([0.0, 0.0, -120.0], model, axes)
}

fn nine<R: Real, P: Position>(free: bool, arena: &mut Arena) -> &'static NineTerms<'static, R, P, 3> {
    let machine = machine(false, ErrorModel::Nine);
    let tables = tables(free);
    let rows = |axis: Axis| tables.get(axis.index());
    let memory = arena.slice(NineTerms::<R, P, 3>::requirement(&machine, rows), R::ZERO);
    match AxisOrder::of(&machine).and_then(|order| NineTerms::build(&order, &machine, rows, memory)) {
        Ok(nine) => arena.keep(nine),
        Err(error) => panic!("{}", error),
    }
}

fn volumetric<R: Real, P: Position, const N: usize>(arena: &mut Arena) -> &'static Volumetric<'static, R, P, N> {
    let machine = machine(N == 5, ErrorModel::Volumetric);
    let tables = tables(false);
    let rows = |axis: Axis| tables.get(axis.index());
    let memory = arena.slice(Volumetric::<R, P, N>::requirement(&machine, rows), R::ZERO);
    match AxisOrder::of(&machine).and_then(|order| Volumetric::build(&order, &machine, rows, memory)) {
        Ok(volumetric) => arena.keep(volumetric),
        Err(error) => panic!("{}", error),
    }
}

/// Makes the compiler compute a value that is not used.
fn sink<T>(value: T) -> u32 {
    black_box(&value);
    0
}

struct Nine<R: Real, P: Position>(&'static NineTerms<'static, R, P, 3>, [R; 3]);

#[inline(never)]
fn frame<R: Real, P: Position>(of: &Nine<R, P>) -> u32 {
    sink(of.1)
}

#[inline(never)]
fn equidistant<R: Real, P: Position>(of: &Nine<R, P>) -> u32 {
    sink(of.0.plain_terms(&of.1, &[Direction::POSITIVE; 3], &mut 0))
}

#[inline(never)]
fn free<R: Real, P: Position>(of: &Nine<R, P>) -> u32 {
    sink(of.0.linear_terms(&of.1, &[Direction::POSITIVE; 3], &mut 0))
}

struct Pose<R: Real, P: Position, const N: usize>(&'static Volumetric<'static, R, P, N>, [R; N]);

#[inline(never)]
fn pose<R: Real, P: Position, const N: usize>(of: &Pose<R, P, N>) -> u32 {
    sink(of.0.pose_error(&Query::at(&of.1, &[Direction::POSITIVE; N], &[ThermalLine::default(); N]), &mut 0))
}

/// A foot search: span, point and initial guess.
struct Near<R: Real, P: Position> {
    span: Span<R, P>,
    point: [P; 3],
    guess: R,
}

#[inline(never)]
fn no_kernel<R: Real, P: Position>(near: &Near<R, P>) -> u32 {
    sink((near.guess, [near.guess; 3]))
}

#[inline(never)]
fn kernel<R: Real, P: Position>(near: &Near<R, P>) -> u32 {
    sink(near.span.foot_near(&near.point, near.guess))
}

struct Limits<R: Real>([Limiter<R>; 3], core::cell::RefCell<[LimiterState<R>; 3]>, core::cell::Cell<[R; 3]>);

#[inline(never)]
fn no_limit<R: Real>(limits: &Limits<R>) -> u32 {
    black_box(&mut *limits.1.borrow_mut());
    sink(limits.2.get())
}

#[inline(never)]
fn follow<R: Real>(limits: &Limits<R>) -> u32 {
    let mut limited = 0;
    for ((limiter, state), wanted) in limits.0.iter().zip(&mut *limits.1.borrow_mut()).zip(limits.2.get()) {
        limited += u32::from(limiter.follow(state, wanted));
    }
    limited
}

fn limiter<R: Real>(scalar: &str) {
    let limits = AxisSettings::with_defaults(Axis::X, false).limits;
    let Ok(limiter) = Limiter::new(&limits, 1e-4) else { panic!("limits") };
    let limits = Limits([limiter; 3], Default::default(), Default::default());
    let frame = timed(no_limit, &limits).0;
    for cycle in 0..100 {
        limits.2.set([1e-7, -1e-7, 2e-7].map(|rise| R::of(rise * f64::from(cycle))));
        follow(&limits);
    }
    limits.2.set(limits.2.get().map(|w| w * R::of(1.01)));
    let (free, limited) = timed(follow, &limits);
    assert!(limited == 0, "a limit binds");
    hprintln!("{} limiter_free worst {}", scalar, free - frame);
    limits.2.set([0.08, -0.08, 0.07].map(R::of));
    let mut binding = Tally::default();
    for _ in 0..400 {
        let (taken, limited) = timed(follow, &limits);
        if limited == 3 {
            binding.add(taken - frame);
        }
    }
    hprintln!("{} limiter_binding {}", scalar, binding);
}

/// The butterfly's rational cubic between two of its points, and the same curve without weights.
fn cubic(weights: [f64; 4]) -> Segment<'static> {
    static POINTS: [DVec3; 4] =
        [DVec3::ZERO, DVec3::new(1.1, 3.4, 0.0), DVec3::new(3.9, 4.4, 0.0), DVec3::new(6.0, 2.1, 0.0)];
    static KNOTS: [f64; 8] = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    static RATIONAL: [f64; 4] = [1.0, 1.2, 1.0, 2.0];
    let rational = weights != [1.0; 4];
    Segment::Nurbs { degree: 3, knots: &KNOTS, points: &POINTS, weights: if rational { &RATIONAL } else { &[] } }
}

fn contour<R: Real, P: Position>(scalar: &str, name: &str, weights: [f64; 4], arena: &mut Arena) {
    let mut spans = heapless::Vec::<Span<R, P>, 16>::new();
    let converted = convert(&cubic(weights), 0, [0.0, 0.0, 1.0], |span| {
        let _ = spans.push(span);
        Ok(())
    });
    assert!(converted.is_ok(), "a path");
    let spans: &'static [Span<R, P>] = arena.collect(spans.into_iter());
    let mut kernels = Tally::default();
    for (number, span) in spans.iter().enumerate() {
        for place in 1..20 {
            let t = R::of(f64::from(place) / 20.0);
            let [x, y, z] = span.position(t);
            let side = 0.002 * f64::from((place * 7 + number as i32) % 11 - 5);
            let point = [x.plus(R::of(side)), y.plus(R::of(-side)), z.plus(R::of(0.003))];
            let near = Near { span: *span, point, guess: t + R::of(0.004) };
            let frame = timed(no_kernel, &near).0;
            if near.span.foot_near(&near.point, near.guess).is_some() {
                kernels.add(timed(kernel, &near).0 - frame);
            }
        }
    }
    hprintln!("{} kernel_{} {}", scalar, name, kernels);
    searches(scalar, name, spans);
}

/// A warm search: the reference moves up to 50 µm along the path, the tool is up to 35 µm beside it.
struct Search<R: Real, P: Position> {
    search: ContourSearch<R>,
    path: Path<'static, R, P>,
    state: core::cell::Cell<ContourState<R>>,
    reference: Reference<R>,
    point: [P; 3],
}

#[inline(never)]
fn no_update<R: Real, P: Position>(search: &Search<R, P>) -> u32 {
    let state = search.state.get();
    search.state.set(black_box(state));
    0
}

#[inline(never)]
fn update<R: Real, P: Position>(search: &Search<R, P>) -> u32 {
    let mut state = search.state.get();
    let found = search.search.update(&mut state, &search.path, search.reference, search.point);
    search.state.set(state);
    u32::from(black_box(found).evaluations)
}

fn searches<R: Real, P: Position>(scalar: &str, name: &str, spans: &'static [Span<R, P>]) {
    let Ok(searcher) = ContourSearch::new(1.0, Method::Guarded) else { panic!("a lag") };
    let (mut fast, mut all) = (Tally::default(), Tally::default());
    let mut mixed = 1u32;
    let mut unit = || {
        mixed = mixed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(mixed >> 8) / f64::from(1u32 << 24)
    };
    for _ in 0..2000 {
        let number = ((unit() * spans.len() as f64) as usize).min(spans.len() - 1);
        let t = R::of(unit());
        let mut search = Search {
            search: searcher,
            path: Path::new(spans, 0, false),
            state: Default::default(),
            reference: Reference { span: number as u32, t },
            point: spans[number].position(t),
        };
        for _ in 0..60 {
            update(&search);
        }
        let next = spans[number].arc_length(t) + R::of(0.05 * unit());
        search.reference.t = spans[number].t_at(next);
        let [x, y, z] = spans[number].position(search.reference.t);
        let mut stray = || R::of(0.04 * (unit() - 0.5));
        search.point = [x.plus(stray()), y.plus(stray()), z.plus(stray())];
        let frame = timed(no_update, &search).0;
        let (taken, evaluations) = timed(update, &search);
        all.add(taken - frame);
        if evaluations == 2 {
            fast.add(taken - frame);
        }
    }
    hprintln!("{} contour_{} {}", scalar, name, fast);
    hprintln!("{} contour_any_{} {}", scalar, name, all);
}

/// Checks that the processor's square root equals the correctly rounded root of libm.
fn roots() {
    for i in 1..2000u32 {
        let single = f32::from_bits(i * 1_048_583 % 0x7f80_0000);
        let double = f64::from_bits(u64::from(i) * 4_503_599_627_370_449 % 0x7ff0_0000_0000_0000);
        assert!(Real::sqrt(single) == libm::sqrtf(single), "root of {single}");
        assert!(Real::sqrt(double) == libm::sqrt(double), "root of {double}");
    }
}

/// Counts all parts.
pub fn all<R: Real, P: Position>(scalar: &str, arena: &mut Arena) {
    let place = [P::of(-123.4), P::of(56.7), P::of(301.2)];
    let even = nine::<R, P>(false, arena);
    let of = Nine(even, even.coordinates(&place));
    let nothing = timed(frame, &of).0;
    hprintln!("{} nine_terms worst {}", scalar, timed(equidistant, &of).0 - nothing);
    let uneven = nine::<R, P>(true, arena);
    let mut looked_up = Tally::default();
    for step in 0..200 {
        let x = -290.0 + 3.0 * f64::from(step);
        let of = Nine(uneven, uneven.coordinates(&[P::of(x), P::of(-0.9 * x), P::of(0.5 * x)]));
        looked_up.add(timed(free, &of).0 - nothing);
    }
    hprintln!("{} nine_terms_free {}", scalar, looked_up);
    let three = volumetric::<R, P, 3>(arena);
    hprintln!("{} volumetric_3 worst {}", scalar, timed(pose, &Pose(three, three.coordinates(&place))).0 - nothing);
    let five = volumetric::<R, P, 5>(arena);
    let [x, y, z] = place;
    let at = five.coordinates(&[x, y, z, P::of(-35.0), P::of(48.3)]);
    hprintln!("{} volumetric_5 worst {}", scalar, timed(pose, &Pose(five, at)).0 - nothing);
    contour::<R, P>(scalar, "rational", [1.0, 1.2, 1.0, 2.0], arena);
    contour::<R, P>(scalar, "polynomial", [1.0; 4], arena);
    limiter::<R>(scalar);
    roots();
}
