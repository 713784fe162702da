//! The pair along whole paths, compared with a separate search for each point.

use super::*;
use crate::contour::ContourState;
use crate::contour::tests::LOOKED_AT;
use crate::testing::share::share;

/// Checks that feet and arc lengths of both ways agree; counts the cycles that differ and those that are not plain.
fn compare(all: &[Span<f64, f64>], feed: f64, lag: f64, mut points: impl FnMut(f64) -> [V; 2]) -> [u32; 3] {
    let mut walk = Walk::new(all, false);
    let total: f64 = all.iter().map(Span::length).sum();
    let (mut tip, mut encoder) = (ContourState::default(), ContourState::default());
    let [mut cycles, mut differ, mut slow] = [0; 3];
    let mut s = lag + 0.3;
    let mut at_rest = 400;
    while s < total - 0.3 {
        let reference = place(all, s);
        let at = position(all, s - lag);
        // At standstill nothing strays.
        let [off, d] = if at_rest > 0 { [[0.0; 3]; 2] } else { points(s) };
        let (at_tip, at_encoder) = (add(at, off), sub(add(at, off), d));
        let pair = walk.step(reference, at_tip, at_encoder);
        let alone = [
            walk.search.update(&mut tip, &walk.path, reference, at_tip),
            walk.search.update(&mut encoder, &walk.path, reference, at_encoder),
        ];
        at_rest -= i32::from(at_rest > 0);
        // Cold searches are not compared: in them too the pair's encoder follows the tip.
        if pair.iter().chain(&alone).any(|found| found.flags.has(Flags::COLD)) {
            assert!(at_rest > 0 || !pair[0].flags.has(Flags::COLD), "cold at {s}");
            s += if at_rest > 0 { 0.0 } else { feed };
            continue;
        }
        cycles += 1;
        slow += u32::from(pair[0].evaluations != 2 || pair[1].evaluations != 1);
        let same = |a: &ContourError<f64>, b: &ContourError<f64>| {
            (a.error - b.error).abs() < 2e-12
                && (a.normal - b.normal).abs() < 1e-9
                && (a.binormal - b.binormal).abs() < 1e-9
                && (a.lag - b.lag).abs() < 1e-6
                && (a.flags == b.flags)
        };
        if !(same(&pair[0], &alone[0]) && same(&pair[1], &alone[1])) {
            differ += 1;
        }
        s += feed;
    }
    [cycles, differ, slow]
}

#[test]
fn on_smooth_paths_the_pair_is_two_searches_and_nearly_always_plain() {
    let butterfly = spans(&[Spline::butterfly().segment()]);
    let arc = spans(&[Segment::Arc {
        start: DVec3::new(30.0, 0.0, 0.0),
        end: DVec3::new(-30.0, 0.0, 0.0),
        center: DVec3::ZERO,
        normal: Z.into(),
        turns: 0,
    }]);
    let mut random = Noise::new(8);
    for (name, all, most_slow) in [("butterfly", &butterfly, 0.15), ("arc", &arc, 0.02)] {
        for (feed, lag, size) in [(0.0025, 0.005, 0.003), (0.01, 0.015, 0.005), (0.01, 0.0, 0.01)] {
            let [cycles, differ, slow] = compare(all, feed, lag, |_| [random.vector(size), random.vector(size)]);
            // At the sharp tip, where spans are short, the evaluations of a cycle may not suffice for the encoder.
            assert!(f64::from(differ) < 0.004 * f64::from(cycles), "{name}: {differ} of {cycles} differ");
            assert!(f64::from(slow) < most_slow * f64::from(cycles), "{name}: {slow} of {cycles} out of line");
        }
    }
}

/// Both points on the path, their feet |d| apart: across every border, with the leading foot already in the next span.
#[test]
fn borders_between_two_points_on_the_path() {
    let line = |a: V, b: V| Segment::Line { start: a.into(), end: b.into() };
    let corner = [line([0.0; 3], [4.0, 0.0, 0.0]), line([4.0, 0.0, 0.0], [4.0, 4.0, 0.0])];
    let obtuse = [line([0.0; 3], [4.0, 0.0, 0.0]), line([4.0, 0.0, 0.0], [8.0, 2.0, 1.0])];
    for (name, all) in
        [("corner", spans(&corner)), ("obtuse", spans(&obtuse)), ("butterfly", spans(&[Spline::butterfly().segment()]))]
    {
        for apart in [0.3, -0.3, 0.05, -0.05, 0.003, -0.003] {
            let total: f64 = all.iter().map(Span::length).sum();
            let mut walk = Walk::new(&all, false);
            walk.warm(place(&all, 1.0));
            let (mut s, mut lost, mut cycles) = (1.0, 0, 0);
            while s < (total - 1.0).min(40.0) {
                s += 0.004;
                let (ahead, tip) = (position(&all, s + apart), position(&all, s));
                let [at_tip, at_encoder] = walk.step(place(&all, s), tip, ahead);
                cycles += 1;
                assert!(at_tip.error < 1e-9, "{name} at {s}, {apart}: {at_tip:?}");
                lost += u32::from(at_encoder.error > 1e-9);
                // Every foot that is not found is flagged.
                assert!(
                    at_encoder.error < 1e-9 || !at_encoder.flags.has(Flags::BRACKETED),
                    "{name} at {s}, {apart}: {at_encoder:?}"
                );
            }
            // Some spans of the butterfly are shorter than that.
            let most = if name == "butterfly" { 0.25 * apart.abs() + 0.005 } else { 0.0 };
            assert!(f64::from(lost) <= most * f64::from(cycles), "{name}, {apart}: {lost} of {cycles} lost");
        }
    }
}

/// Spans of 15 µm, with the reference jumping by up to 1 mm and the tool anywhere near: a cycle visits a bounded number of
/// spans.
#[test]
fn on_tiny_spans_a_cycle_looks_at_few_of_them() {
    let points: Vec<V> = (0..600).map(|i| [0.015 * f64::from(i), 0.002 * f64::from(i % 2), 0.0]).collect();
    let segments: Vec<Segment<'_>> =
        points.windows(2).map(|p| Segment::Line { start: p[0].into(), end: p[1].into() }).collect();
    let all = spans(&segments);
    let mut random = Noise::new(12);
    let (mut most, mut measured) = (0, 0);
    for closed in [false, true] {
        let mut walk = Walk::new(&all, closed);
        let mut s = 1.0;
        for step in 0..share(40_000) {
            let leap = match step % 50 {
                0 => 10f64.powf(random.range(-3.0, 0.0)) * random.signed(),
                _ => 0.02 * random.unit() - 0.005,
            };
            s = (s + leap).rem_euclid(8.0);
            let at = position(&all, s);
            let tip = add(at, random.vector(if step % 7 == 0 { 0.3 } else { 0.01 }));
            let encoder = add(tip, random.vector(0.05));
            let reference = place(&all, s);
            LOOKED_AT.with(|count| count.set(0));
            let [tip, _] = walk.step(reference, tip, encoder);
            most = most.max(LOOKED_AT.with(|count| count.get()));
            measured += u32::from(tip.is_measured());
        }
    }
    assert!(most <= 100, "{most} spans looked up in a cycle");
    // After a leap beyond the limit of spans the search samples the path for thirteen cycles.
    assert!(measured > 9 * share(40_000) as u32 * 2 / 10, "{measured}");
}

/// A cold search ends in time on the nearest point, with nothing measured before; the tip lags, strays, and moves on meanwhile.
#[test]
fn a_lost_foot_is_found_within_fifteen_cycles() {
    let all = spans(&[Spline::butterfly().segment()]);
    let total: f64 = all.iter().map(Span::length).sum();
    let mut random = Noise::new(39);
    let (mut latest, mut other) = (0, 0);
    for _ in 0..share(2_000) {
        let mut walk = Walk::new(&all, false);
        let (begin, lag) = (random.range(1.0, total - 1.0), random.range(0.0, 0.3));
        let stray = random.vector(0.005);
        for cycle in 1.. {
            let s = begin + 0.01 * f64::from(cycle);
            let tip = add(position(&all, s - lag), stray);
            let [found, encoder] = walk.step(place(&all, s), tip, add(tip, [2e-3, -1e-3, 1e-3]));
            if found.flags.has(Flags::SEARCHING) {
                assert!(!found.is_measured() || cycle > 13, "{cycle}: {found:?}");
                continue;
            }
            latest = latest.max(cycle);
            let nearest = walk.path.nearest(tip).error;
            other += u32::from((found.error - nearest).abs() > 1e-9);
            assert!(!encoder.is_measured() || (encoder.error - found.error).abs() < 3e-3, "{found:?} {encoder:?}");
            break;
        }
    }
    // At the sharp tip the minimum downhill from the nearest sample is not always the nearest one.
    assert!(latest <= 15 && other * 200 <= share(2_000) as u32, "{latest} cycles, {other} other feet");
}
