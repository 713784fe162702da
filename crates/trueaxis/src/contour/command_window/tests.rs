#![allow(clippy::indexing_slicing)]

use super::*;
use crate::contour::{ContourError, Flags};
use crate::position::Nanometres;
use crate::testing::noise::Noise;
use crate::testing::share::share;
use std::vec::Vec;

type V = [f64; 3];

/// Feeds in commands and the positions that follow them; returns contour errors.
struct Bench<R, P> {
    commanded: CommandWindow<R, P, 128>,
}

impl<R: Real, P: Position> Bench<R, P> {
    fn new(spacing_mm: f64) -> Self {
        Bench { commanded: CommandWindow::new([0.0, 0.0, 1.0], spacing_mm).unwrap() }
    }

    fn cycle(&mut self, command: V, actual: V) -> ContourError<R> {
        self.commanded.append(command.map(P::of));
        self.commanded.contour_error(actual.map(P::of))
    }
}

/// Largest differences from the truth, nm, over a circle at `way` mm a cycle, followed `lag` mm behind on a radius larger by
/// `radial`.
fn circle<R: Real, P: Position>(radius: f64, way: f64, lag: f64, radial: f64) -> [f64; 3] {
    let mut bench = Bench::<R, P>::new(0.005);
    let at = |r: f64, angle: f64| [200.0 + r * angle.cos(), -70.0 + r * angle.sin(), 30.0];
    let mut worst = [0.0f64; 3];
    let cycles = ((lag + 3.0 * radius) / way) as u32;
    for i in 0..cycles {
        let angle = way * f64::from(i) / radius;
        let e = bench.cycle(at(radius, angle), at(radius + radial, (angle - lag / radius).max(0.0)));
        if way * f64::from(i) > 2.0 * lag + 4.0 * way {
            assert!(e.is_measured() && e.flags.has(Flags::BRACKETED), "cycle {i}: {e:?}");
            let off = |found: R, truth: f64| (found.to_f64() - truth).abs() * 1e6;
            worst[0] = worst[0].max(off(e.error, radial.abs()));
            worst[1] = worst[1].max(off(e.normal, -radial));
            worst[2] = worst[2].max(off(e.lag, lag));
        }
    }
    worst
}

#[test]
fn on_a_circle_radial_error_and_lag_are_those_that_were_put_in() {
    // Radius, travel per cycle (500 mm/s, 100 mm/s, 10 mm/s, 1 mm/s at 1 kHz), lag, radial error; mm.
    for (radius, way, lag, radial) in [
        (5.0, 0.5, 2.0, 0.01),
        (5.0, 0.5, 0.3, -0.02),
        (5.0, 0.1, 1.0, 0.003),
        (50.0, 0.1, 1.0, -0.003),
        (50.0, 0.01, 0.2, 0.001),
        (5.0, 0.001, 0.05, 0.002),
        (0.5, 0.02, 0.1, -0.002),
    ] {
        let double = circle::<f64, f64>(radius, way, lag, radial);
        let single = circle::<f32, Nanometres>(radius, way, lag, radial);
        std::println!("R {radius} way {way}: error, normal, lag off by f64 {double:.6?} nm, f32 {single:.3?} nm");
        // 0.1 rad per span: a tenth of a picometre, and Simpson's arc length is off by 1e-7 of a span.
        assert!(double[0] < 1e-3 && double[1] < 1e-3 && double[2] < 0.5, "{radius} {way}: {double:?}");
        // Points in whole nanometres.
        assert!(single[0] < 2.0 && single[1] < 2.0 && single[2] < 3.0, "{radius} {way}: {single:?}");
    }
}

#[test]
fn where_a_line_meets_an_arc_what_remains_is_as_stated() {
    let (radius, way) = (5.0, 0.1);
    // Tangentially from a line onto an arc, with the border anywhere between two commands.
    let mut worst = 0.0f64;
    for phase in [0.0, 0.25, 0.5, 0.75] {
        let at = |s: f64| {
            let s = s + phase * way;
            let angle: f64 = s / radius;
            if s < 0.0 { [s, 0.0, 0.0] } else { [radius * angle.sin(), radius * (1.0 - angle.cos()), 0.0] }
        };
        let mut bench = Bench::<f64, f64>::new(0.005);
        for i in -100..100 {
            let s = way * f64::from(i);
            let e = bench.cycle(at(s), at((s - 0.53).max(-10.0)));
            worst = worst.max(e.error);
        }
    }
    let stated = way * way / (27.0 * radius);
    assert!(worst < stated && worst > 0.3 * stated, "{} nm against {}", worst * 1e6, stated * 1e6);
}

#[test]
fn on_a_line_in_space_nothing_is_lost() {
    for way in [0.5, 0.02, 0.0007] {
        let mut bench = Bench::<f64, f64>::new(0.005);
        let mut single = Bench::<f32, Nanometres>::new(0.005);
        let t = [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0];
        let at = |s: f64, left: f64| {
            [300.0 + s * t[0] + left / 5f64.sqrt(), 1.0 + s * t[1] + 2.0 * left / 5f64.sqrt(), s * t[2]]
        };
        for i in 0..4000 {
            let s = way * f64::from(i);
            let lag = 10.0 * way;
            let e = bench.cycle(at(s, 0.0), at((s - lag).max(0.0), 0.004));
            let f = single.cycle(at(s, 0.0), at((s - lag).max(0.0), 0.004));
            if i > 12 {
                assert!((e.error - 0.004).abs() < 1e-9 && (e.normal - 0.004).abs() < 1e-9, "{i}: {e:?}");
                assert!((e.lag - lag).abs() < 1e-9, "{i}: {e:?}");
                assert!((f.normal - 0.004).abs() < 2e-6 && (f64::from(f.lag) - lag).abs() < 3e-6, "{i}: {f:?}");
            }
        }
    }
}

/// A move along a polyline with a machine's acceleration: commands at 1 kHz.
fn ramped(points: &[V], feed: f64, acceleration: f64) -> Vec<V> {
    let mut commands = Vec::new();
    for leg in points.windows(2) {
        let way: V = core::array::from_fn(|k| leg[1][k] - leg[0][k]);
        let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (mut s, mut v, step) = (0.0f64, 0.0f64, 1e-3);
        while s < length {
            let braking = (2.0 * acceleration * (length - s)).sqrt();
            v = (v + acceleration * step).min(feed).min(braking).max(acceleration * step * 0.25);
            s = (s + v * step).min(length);
            commands.push(core::array::from_fn(|k| leg[0][k] + way[k] * s / length));
        }
    }
    commands
}

fn distance_to_polyline(points: &[V], p: V) -> f64 {
    let leg = |a: V, b: V| {
        let (d, q): (V, V) = (core::array::from_fn(|k| b[k] - a[k]), core::array::from_fn(|k| p[k] - a[k]));
        let (dd, dq) = (d.iter().map(|x| x * x).sum::<f64>(), (0..3).map(|k| d[k] * q[k]).sum::<f64>());
        let t = (dq / dd).clamp(0.0, 1.0);
        (0..3).map(|k| (q[k] - t * d[k]).powi(2)).sum::<f64>().sqrt()
    };
    points.windows(2).map(|w| leg(w[0], w[1])).fold(f64::MAX, f64::min)
}

#[test]
fn corners_and_reversals_with_exact_stop_are_cut_by_no_more_than_stated() {
    let shapes: [&[V]; 4] = [
        &[[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [8.0, 8.0, 0.0], [2.0, 3.0, 1.0]],
        &[[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [2.0, 0.0, 0.0], [9.0, 0.0, 0.0]],
        &[[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [1.0, 0.3, 0.0], [9.0, 0.6, 0.0]],
        &[[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [15.0, 3.0, 0.0], [19.0, 3.0, 0.5]],
    ];
    for (spacing, shape) in [0.005, 0.05].into_iter().flat_map(|s| shapes.map(|shape| (s, shape))) {
        for (feed, acceleration) in [(100.0, 1000.0), (20.0, 10_000.0), (1.0, 200.0), (0.2, 20.0)] {
            let scale = (feed / 100.0f64).max(0.02);
            let points: Vec<V> = shape.iter().map(|p| p.map(|x| x * scale)).collect();
            let mut commanded = CommandWindow::<f64, f64, 64>::new([0.0, 0.0, 1.0], spacing).unwrap();
            let mut worst = 0.0f64;
            for command in ramped(&points, feed, acceleration) {
                commanded.append(command);
                let path = commanded.path();
                let newest = path.spans.len().saturating_sub(2);
                for t in [0.0, 0.3, 0.6, 1.0] {
                    worst = worst.max(distance_to_polyline(&points, path.spans[newest].position(t)));
                }
            }
            assert!(worst < spacing / 200.0, "spacing {spacing} feed {feed}: {} nm", worst * 1e6);
        }
    }
}

#[test]
fn round_a_corner_and_back_the_contour_error_is_that_of_the_legs() {
    let points = [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [5.0, 5.0, 0.0], [5.0, 1.0, 0.0]];
    let commands = ramped(&points, 50.0, 1000.0);
    let mut bench = Bench::<f64, f64>::new(0.005);
    // The tool follows with a first-order lag of eight cycles; at the corner it is still arriving while the command
    // rests.
    let (mut actual, mut largest) = (commands[0], 0.0f64);
    for (i, command) in commands.iter().enumerate() {
        for k in 0..3 {
            actual[k] += 0.125 * (command[k] - actual[k]);
        }
        let e = bench.cycle(*command, actual);
        let seen = commands[..=i].windows(2).map(|w| distance_to_polyline(w, actual)).fold(f64::MAX, f64::min);
        if i > 1 {
            assert!((e.error - seen).abs() < 3e-5, "{i}: {seen} against {e:?}");
            largest = largest.max(seen);
        }
    }
    assert!(largest > 1e-3, "the corner was not rounded: {largest}");
}

#[test]
fn at_standstill_nothing_is_appended_and_the_error_is_the_distance() {
    let mut bench = Bench::<f64, f64>::new(0.005);
    let here = [10.0, 20.0, 30.0];
    for _ in 0..100 {
        let e = bench.cycle(here, [10.0, 20.003, 30.004]);
        assert!((e.error - 0.005).abs() < 1e-12, "{e:?}");
    }
    assert_eq!(bench.commanded.path().spans.len(), 1);
    for i in 0..50 {
        bench.cycle([10.0 + 0.1 * f64::from(i), 20.0, 30.0], [10.0 + 0.1 * f64::from(i), 20.0, 30.0]);
    }
    let (count, reference) = (bench.commanded.path().spans.len(), bench.commanded.reference());
    for i in 0..1000 {
        // Jitter of the command below the shortest span.
        let jitter = 1e-6 * f64::from(i % 7);
        let e = bench.cycle([14.9 + jitter, 20.0, 30.0], [14.9, 20.002, 30.0]);
        assert!((e.error - 0.002).abs() < 1e-6, "{i}: {e:?}");
    }
    assert_eq!((bench.commanded.path().spans.len(), bench.commanded.reference()), (count, reference));
}

#[test]
fn a_tool_behind_the_window_is_said_to_be_so_also_where_a_command_comes_back() {
    let mut commanded = CommandWindow::<f64, f64, 16>::new([0.0, 0.0, 1.0], 0.005).unwrap();
    let flags = |commanded: &CommandWindow<f64, f64, 16>| commanded.contour_error([0.0, 0.01, 0.0]).flags;
    (0..200).for_each(|i| commanded.append([0.02 * f64::from(i), 0.0, 0.0]));
    assert!(!flags(&commanded).has(Flags::BRACKETED));
    // After a span is begun and withdrawn, the window is shorter by it and begins no earlier.
    for x in [3.9801, 3.98] {
        commanded.append([x, 0.0, 0.0]);
        assert!(!flags(&commanded).has(Flags::BRACKETED), "at {x}");
    }
    commanded.restart();
    (0..3).for_each(|i| commanded.append([0.02 * f64::from(i), 0.0, 0.0]));
    assert!(flags(&commanded).has(Flags::BRACKETED));
}

#[test]
fn after_a_jump_or_a_restart_the_window_starts_over_and_the_search_finds_it() {
    let mut bench = Bench::<f64, f64>::new(0.005);
    let run = |bench: &mut Bench<f64, f64>, from: f64| {
        let mut e = ContourError::none();
        for i in 0..100 {
            let s = from + 0.05 * f64::from(i);
            e = bench.cycle([s, 0.0, 0.0], [s - 0.1, 0.001, 0.0]);
        }
        assert!((e.error - 0.001).abs() < 1e-9 && e.flags.has(Flags::BRACKETED), "{e:?}");
    };
    run(&mut bench, 0.0);
    let before = bench.commanded.reference();
    run(&mut bench, 100.0);
    assert!(bench.commanded.reference().span > before.span);
    assert!(bench.commanded.path().spans.iter().all(|s| s.position(0.5)[0] > 99.0));
    bench.commanded.restart();
    assert_eq!(bench.commanded.path().spans.len(), 0);
    assert!(!bench.commanded.contour_error([0.0; 3]).is_measured());
    run(&mut bench, 107.0);
    bench.commanded.append([f64::NAN, 0.0, 0.0]);
    bench.commanded.append([0.0, f64::INFINITY, 0.0]);
    run(&mut bench, 112.0);
}

fn random_walk<R: Real, P: Position, const K: usize>(seed: u64, rounds: usize) {
    let mut noise = Noise::new(seed);
    let mut commanded = CommandWindow::<R, P, K>::new([0.0, 0.3, 1.0], 0.005).unwrap();
    let (mut at, mut velocity) = ([0.0f64; 3], [0.0f64; 3]);
    for i in 0..rounds {
        let size = 10f64.powf(-7.0 + 4.0 * noise.signed() + 3.0 * f64::from((i / 97) % 2 == 0));
        for k in 0..3 {
            velocity[k] = if noise.signed() > 0.9 { 0.0 } else { 0.9 * velocity[k] + size * noise.signed() };
            at[k] = (at[k] + velocity[k]) % 900.0;
        }
        commanded.append(at.map(P::of));
        let path = commanded.path();
        assert!(!path.spans.is_empty() && path.spans.len() <= K);
        let reference = commanded.reference();
        assert!(path.span(reference.span).is_some(), "seed {seed} round {i}");
        let end = path.spans[path.spans.len() - 1].position(R::ONE);
        for k in 0..3 {
            assert!((end[k].to_f64() - at[k]).abs() < 2.5e-5, "seed {seed} round {i}: the end is not the command");
        }
        for pair in path.spans[path.spans.len().saturating_sub(3)..].windows(2) {
            let (a, b) = (pair[0].position(R::ONE), pair[1].position(R::ZERO));
            // Micrometres in single precision keep 8 mm to a nanometre.
            let gap = (0..3).map(|k| (a[k].to_f64() - b[k].to_f64()).abs()).fold(0.0, f64::max);
            assert!(gap < 4e-6, "seed {seed} round {i}: gap of {gap}");
            assert!(pair.iter().all(|s| s.length().is_finite() && s.length() > R::ZERO && s.length() < R::of(20.0)));
        }
        let point = at.map(|x| P::of(x + 0.002 * noise.signed()));
        let e = commanded.contour_error(point);
        let sane = [e.error, e.normal, e.binormal, e.tangential, e.lag, e.t].iter().all(|x| x.is_finite());
        assert!(sane, "seed {seed} round {i}: {e:?}");
        if i % 64 == 0 {
            // No point of the window is nearer, and the vector leads to one.
            let aside = |span: &Span<R, P>, t: f64| {
                let on = span.position(R::of(t));
                (0..3).map(|k| (on[k].to_f64() - point[k].to_f64()).powi(2)).sum::<f64>().sqrt()
            };
            let places = path.spans.iter().flat_map(|s| (0..=32).map(move |j| (s, f64::from(j) / 32.0)));
            let far = (f64::MAX, R::ZERO);
            let (nearest, length) =
                places.map(|(s, t)| (aside(s, t), s.length())).fold(far, |a, b| if b.0 < a.0 { b } else { a });
            // The kernel's rounding over spans of 8 mm in single precision.
            let rounding = if R::EPSILON.to_f64() < 1e-10 { 1e-9 } else { 4e-6 };
            // Chords decide which span is nearest: off by the height of an arc of up to 40° over its chord.
            let height = 0.09 * length.max(path.span(e.span).unwrap().length()).to_f64();
            assert!(e.error.to_f64() < nearest + height + rounding, "seed {seed} round {i}: {nearest} {e:?}");
            let found = aside(path.span(e.span).unwrap(), e.t.to_f64());
            assert!((e.error.to_f64() - found).abs() < rounding, "seed {seed} round {i}: {found} {e:?}");
        }
    }
}

#[test]
fn a_million_random_appends_stay_finite_and_without_gaps() {
    for seed in 0..4 {
        random_walk::<f64, f64, 16>(seed, share(250_000));
        random_walk::<f32, Nanometres, 5>(seed + 100, share(250_000));
    }
}

#[test]
fn a_window_without_plane_or_with_a_strange_spacing_is_refused() {
    for (plane, spacing) in
        [([0.0; 3], 0.005), ([0.0, f64::NAN, 1.0], 0.005), ([0.0, 0.0, 1.0], 0.0), ([0.0, 0.0, 1.0], f64::NAN)]
    {
        assert!(CommandWindow::<f64, f64, 4>::new(plane, spacing).is_err());
    }
}
