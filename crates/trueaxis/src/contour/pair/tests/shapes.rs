//! Corners, hairpins, cusps, closed paths, a reference that goes back, and arbitrary input.

use super::*;
use proptest::prelude::*;

fn line(a: V, b: V) -> Segment<'static> {
    Segment::Line { start: a.into(), end: b.into() }
}

#[test]
fn outside_a_corner_both_feet_are_the_corner() {
    let all = spans(&[line([0.0; 3], [10.0, 0.0, 0.0]), line([10.0, 0.0, 0.0], [10.0, 10.0, 0.0])]);
    let mut walk = Walk::new(&all, false);
    let before = all.iter().filter(|span| span.segment() == 0).count() as u32 - 1;
    walk.warm(Reference { span: before, t: 0.99 });
    for (tip, encoder) in
        [([10.003, -0.004, 0.0], [10.0006, -0.0008, 0.0]), ([10.02, -0.02, 0.01], [10.03, -0.01, 0.0])]
    {
        let [at_tip, at_encoder] = walk.step(Reference { span: before, t: 1.0 }, tip, encoder);
        for (found, p) in [(at_tip, tip), (at_encoder, encoder)] {
            assert!((found.error - norm(sub(p, [10.0, 0.0, 0.0]))).abs() < 1e-12, "{found:?}");
            assert!(found.flags.has(Flags::AT_CORNER) && found.flags.has(Flags::BRACKETED), "{found:?}");
        }
    }
}

#[test]
fn inside_a_corner_both_see_a_second_minimum() {
    let all = spans(&[line([0.0; 3], [10.0, 0.0, 0.0]), line([10.0, 0.0, 0.0], [10.0, 10.0, 0.0])]);
    let mut walk = Walk::new(&all, false);
    let before = all.iter().filter(|span| span.segment() == 0).count() as u32 - 1;
    walk.warm(Reference { span: before, t: 0.99 });
    let [tip, encoder] = walk.step(Reference { span: before, t: 1.0 }, [9.997, 0.002, 0.0], [9.999, 0.003, 0.0]);
    assert!((tip.error - 0.002).abs() < 1e-12 && (encoder.error - 0.001).abs() < 1e-12, "{tip:?} {encoder:?}");
    assert_eq!((tip.span, encoder.span), (before, before + 1));
    for found in [tip, encoder] {
        assert!(found.flags.has(Flags::SECOND_MINIMUM) && found.flags.has(Flags::BRACKETED));
    }
}

#[test]
fn in_a_hairpin_both_feet_are_on_one_leg() {
    let r = 0.02;
    let all = spans(&[
        line([0.0; 3], [5.0, 0.0, 0.0]),
        Segment::Arc {
            start: DVec3::new(5.0, 0.0, 0.0),
            end: DVec3::new(5.0, 2.0 * r, 0.0),
            center: DVec3::new(5.0, r, 0.0),
            normal: Z.into(),
            turns: 0,
        },
        line([5.0, 2.0 * r, 0.0], [0.0, 2.0 * r, 0.0]),
    ]);
    let mut walk = Walk::new(&all, false);
    walk.warm(place(&all, 0.95));
    for step in 0..8190 {
        let s = 0.95 + 5e-4 * f64::from(step);
        let x = s - 0.05_f64.min(5e-4 * f64::from(step));
        // The encoder is nearer to the way back: its foot stays with the tip's.
        let [tip, encoder] = walk.step(place(&all, s), [x, 3e-3, 0.0], [x, 0.03, 0.0]);
        assert!((tip.error - 3e-3).abs() < 1e-12 && (encoder.error - 0.03).abs() < 1e-12, "{s}: {tip:?} {encoder:?}");
        assert!((encoder.normal - 0.03).abs() < 1e-12);
    }
}

/// At cusps the feet are never lost for long, and no foot is worse than the reference itself.
#[test]
fn through_a_cusp_the_search_stays_warm() {
    let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    for cross in [1.0, 1.05, 0.95, 1.3] {
        let points = [[0.0; 3], [cross * 6.0, 6.0, 0.0], [6.0 - cross * 6.0, 6.0, 0.0], [6.0, 0.0, 0.0]];
        let points = points.map(DVec3::from_array);
        let all = spans(&[Segment::Nurbs { degree: 3, knots: &knots, points: &points, weights: &[] }]);
        let total: f64 = all.iter().map(Span::length).sum();
        let mut walk = Walk::new(&all, false);
        let mut random = Noise::new(3);
        walk.warm(place(&all, 0.5));
        let (mut s, mut cold, mut cycles) = (0.5, 0, 0);
        while s < total - 0.5 {
            s += 0.005;
            let at = position(&all, s - 0.004);
            let encoder = add(at, random.vector(0.003));
            let [tip, encoder] = walk.step(place(&all, s), add(at, random.vector(0.003)), encoder);
            cycles += 1;
            cold += u32::from(tip.flags.has(Flags::COLD));
            assert!(tip.error < 0.013 && encoder.error < 0.02, "{cross} at {s}: {tip:?} {encoder:?}");
        }
        assert!(cold * 20 < cycles, "{cross}: {cold} of {cycles} cold");
    }
}

#[test]
fn closed_paths_wrap_and_references_go_back() {
    let circle = spans(&[Segment::Arc {
        start: DVec3::new(10.0, 0.0, 0.0),
        end: DVec3::new(10.0, 0.0, 0.0),
        center: DVec3::ZERO,
        normal: Z.into(),
        turns: 0,
    }]);
    let total: f64 = circle.iter().map(Span::length).sum();
    let at = |s: f64, r: f64, z: f64| [r * (s / 10.0).cos(), r * (s / 10.0).sin(), z];
    let mut walk = Walk::new(&circle, true);
    walk.warm(place(&circle, 1.0));
    let mut s = 1.0_f64;
    // Twice round, then back over the start, reversing now and then.
    for step in 0..30_000 {
        s += if step < 20_000 || step % 700 > 500 { 0.008 } else { -0.009 };
        let reference = place(&circle, s.rem_euclid(total));
        let [tip, encoder] = walk.step(reference, at(s - 0.02, 10.004, 0.003), at(s - 0.025, 9.996, -0.002));
        assert!((tip.error - 0.005).abs() < 1e-9 && (encoder.error - 20e-6_f64.sqrt()).abs() < 1e-9, "{step}: {tip:?}");
        assert!((tip.normal + 0.004).abs() < 1e-9 && (tip.binormal - 0.003).abs() < 1e-9, "{step}: {tip:?}");
        assert!((encoder.normal - 0.004).abs() < 1e-9 && (encoder.binormal + 0.002).abs() < 1e-9, "{encoder:?}");
        assert!((tip.lag - 0.02).abs() < 1e-3 && (encoder.lag - 0.025).abs() < 1e-3, "{step}: {tip:?} {encoder:?}");
        assert!(tip.flags == Flags::BRACKETED && encoder.flags == Flags::BRACKETED);
    }
}

#[test]
fn the_end_of_an_open_path_is_the_foot_of_both() {
    let all = spans(&[line([0.0; 3], [5.0, 0.0, 0.0])]);
    let last = all.len() as u32 - 1;
    let mut walk = Walk::new(&all, false);
    walk.warm(Reference { span: last, t: 0.999 });
    let [tip, encoder] = walk.step(Reference { span: last, t: 1.0 }, [5.003, 0.004, 0.0], [5.006, 0.0, 0.008]);
    assert!((tip.error - 0.005).abs() < 1e-12 && (encoder.error - 0.01).abs() < 1e-12);
    assert!((tip.tangential - 0.003).abs() < 1e-12 && (encoder.tangential - 0.006).abs() < 1e-12);
    for found in [tip, encoder] {
        assert!(found.flags.has(Flags::AT_END) && found.flags.has(Flags::BRACKETED) && found.t == 1.0, "{found:?}");
    }
}

#[test]
fn a_reference_off_its_span_is_taken_at_the_end_and_said() {
    let all = spans(&[line([0.0; 3], [5.0, 0.0, 0.0])]);
    let mut walk = Walk::new(&all, false);
    walk.warm(Reference { span: 0, t: 0.5 });
    for found in walk.step(Reference { span: 0, t: 1.5 }, [0.5, 0.1, 0.0], [0.5, 0.1, 0.0]) {
        assert!(found.flags.has(Flags::REFERENCE) && found.is_measured());
    }
    for found in walk.step(Reference { span: 0, t: f64::NAN }, [0.5, 0.1, 0.0], [0.5, 0.1, 0.0]) {
        assert!(found.flags.has(Flags::REFERENCE) && !found.is_measured());
    }
    for found in walk.step(Reference { span: 77, t: 0.5 }, [0.5, 0.1, 0.0], [0.5, 0.1, 0.0]) {
        assert!(!found.is_measured());
    }
}

#[test]
fn plain_bisection_measures_both() {
    let all = spans(&[Spline::butterfly().segment()]);
    let search = ContourSearch::new(1.0, Method::Bisection).unwrap();
    let mut state = PairState::default();
    let mut guarded = Walk::new(&all, false);
    let mut random = Noise::new(2);
    for step in 0..400 {
        let s = 3.0 + if step < 60 { 0.0 } else { 0.01 * f64::from(step - 60) };
        let tip = add(position(&all, s - 0.01), random.vector(0.002));
        let encoder = add(position(&all, s - 0.012), random.vector(0.002));
        let on = guarded.path.on(place(&all, s));
        let [mut a, mut b] = [ContourError::none(); 2];
        search.update_pair(&mut state, &on, &encoder, &sub(tip, encoder), &mut a, &mut b);
        let [at_tip, at_encoder] = guarded.step(place(&all, s), tip, encoder);
        if step >= 60 {
            assert!((a.error - at_tip.error).abs() < 1e-8 && (b.error - at_encoder.error).abs() < 1e-8, "{step}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: crate::testing::share::share(5_000) as u32, ..ProptestConfig::default() })]

    /// No points, reference or state that floats can represent cause a panic, a result that is not finite, or more than eight
    /// evaluations.
    #[test]
    fn any_query_is_answered_with_finite_numbers(
        points in prop::collection::vec((-1e9..1e9f64, -1e9..1e9f64, -9.0..9.0f64, any::<u32>(), any::<f64>(), -1.0..1.0f64), 6),
        near in any::<bool>(),
    ) {
        let all = spans(&[Spline::butterfly().segment()]);
        let mut walk = Walk::new(&all, near);
        if near {
            walk.warm(Reference { span: 5, t: 0.5 });
        }
        for (x, y, z, span, t, d) in points {
            let p = if near { [x * 3e-8, y * 3e-8, z] } else { [x, y, z] };
            let t = if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.5 };
            for r in walk.step(Reference { span: span % 60, t }, p, add(p, [d, -d, d * d])) {
                let [vx, vy, vz] = r.vector.to_array();
                let all = [r.error, r.normal, r.binormal, r.tangential, r.lag, r.width, r.t, vx, vy, vz];
                prop_assert!(all.iter().all(|x| x.is_finite()), "{r:?}");
            }
        }
    }
}
