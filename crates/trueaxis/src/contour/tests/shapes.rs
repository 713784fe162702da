//! Corners, hairpins, ends, maxima.

use super::*;
use crate::testing::share::share;

#[test]
fn a_corner_is_the_answer_outside_and_has_two_minima_inside() {
    // A right angle: along x, then up y.
    let all = spans::<f64, f64>(&[
        Segment::Line { start: [0.0; 3].into(), end: DVec3::new(10.0, 0.0, 0.0) },
        Segment::Line { start: DVec3::new(10.0, 0.0, 0.0), end: DVec3::new(10.0, 10.0, 0.0) },
    ]);
    let path = Path::new(&all, 0, false);
    let reference = Reference { span: 0, t: 1.0 };
    let outside = search(Method::Guarded).nearest(&path, reference, [10.003, -0.004, 0.0]);
    assert!((outside.error - 0.005).abs() < 1e-15);
    assert!(outside.flags.has(Flags::AT_CORNER) && outside.flags.has(Flags::BRACKETED));
    let inside = search(Method::Guarded).nearest(&path, reference, [9.997, 0.002, 0.0]);
    assert!((inside.error - 0.002).abs() < 1e-15);
    assert!(inside.flags.has(Flags::SECOND_MINIMUM) && !inside.flags.has(Flags::AT_CORNER));
    // Warm: round the corner with a lag, outside and inside.
    for side in [1.0, -1.0] {
        follow(
            &all,
            false,
            1e-3,
            5e-3,
            |_| [2e-3 * side, -2e-3 * side, 0.0],
            Method::Guarded,
            |r, p, s| {
                if s < 0.2 {
                    return;
                }
                assert!(r.evaluations <= 8);
                // Every cycle near the corner; elsewhere brute force is slow.
                if (s - 10.0).abs() < 0.1 || s % 0.05 < 1e-3 {
                    let truth = brute(&all, 0, p);
                    assert!((r.error - truth).abs() < 1e-9, "side {side} at {s}: {r:?} {truth}");
                }
            },
        );
    }
}

#[test]
fn behind_a_hairpin_the_true_error_is_found_where_the_published_rule_loses_it() {
    // Two lines joined by half a circle of 0.02 mm; the tool is 3 µm beside the first line, the reference past the bend.
    let r = 0.02;
    let all = spans::<f64, f64>(&[
        Segment::Line { start: [0.0; 3].into(), end: DVec3::new(5.0, 0.0, 0.0) },
        Segment::Arc {
            start: DVec3::new(5.0, 0.0, 0.0),
            end: DVec3::new(5.0, 2.0 * r, 0.0),
            center: DVec3::new(5.0, r, 0.0),
            normal: Z.into(),
            turns: 0,
        },
        Segment::Line { start: DVec3::new(5.0, 2.0 * r, 0.0), end: DVec3::new(0.0, 2.0 * r, 0.0) },
    ]);
    let mut seen = 0;
    follow(
        &all,
        false,
        5e-4,
        0.05,
        |_| [0.0, 3e-3, 0.0],
        Method::Guarded,
        |result, p, s| {
            // The reference is just past the bend, the tool still on the first line.
            if s > 5.0628 && s < 5.07 {
                seen += 1;
                assert!((result.error - brute(&all, 0, p)).abs() < 1e-9 && result.error < 4e-3, "{s}: {result:?}");
            }
            assert!(result.evaluations <= 12);
        },
    );
    assert!(seen > 5);
}

#[test]
fn closed_paths_wrap_and_open_ones_end() {
    let circle = Segment::Arc {
        start: DVec3::new(10.0, 0.0, 0.0),
        end: DVec3::new(10.0, 0.0, 0.0),
        center: [0.0; 3].into(),
        normal: Z.into(),
        turns: 0,
    };
    let all = spans::<f64, f64>(&[circle]);
    let closed = Path::new(&all, 0, true);
    let open = Path::new(&all, 0, false);
    let behind = [10.004 * (-0.01_f64).cos(), 10.004 * (-0.01_f64).sin(), 0.0];
    let reference = Reference { span: 0, t: 0.001 };
    let on = search(Method::Guarded).nearest(&closed, reference, behind);
    assert!((on.error - 0.004).abs() < 1e-12 && !on.flags.has(Flags::AT_END), "{on:?}");
    assert_eq!(on.span as usize, all.len() - 1);
    assert!((on.normal + 0.004).abs() < 1e-9, "outside a counterclockwise circle is right: {}", on.normal);
    let end = search(Method::Guarded).nearest(&open, reference, behind);
    assert!(end.flags.has(Flags::AT_END) && end.flags.has(Flags::BRACKETED));
    assert!((end.error - norm(sub(behind, [10.0, 0.0, 0.0]))).abs() < 1e-12);
    let mut last = 0.0;
    follow(
        &all,
        true,
        5e-3,
        0.02,
        |_| [0.0, 0.0, 2e-3],
        Method::Guarded,
        |r, _, s| {
            if s > 0.5 {
                assert!((r.error - 2e-3).abs() < 1e-9 && (r.binormal.abs() - 2e-3).abs() < 1e-9);
                assert!((r.lag - 0.02).abs() < 2e-4, "{}", r.lag);
            }
            last = s;
        },
    );
    assert!(last > 60.0);
}

#[test]
fn the_tool_on_the_path_and_far_from_it() {
    let all = spans::<f64, f64>(&[Segment::Line { start: [0.0; 3].into(), end: DVec3::new(100.0, 0.0, 0.0) }]);
    let path = Path::new(&all, 0, false);
    let reference = Reference { span: 3, t: 0.5 };
    let x = all[3].position(0.5)[0];
    for method in [Method::Guarded, Method::Bisection] {
        let on = search(method).nearest(&path, reference, [x - 0.02, 0.0, 0.0]);
        assert!(on.error < 1e-9 && on.flags.has(Flags::BRACKETED) && (on.lag - 0.02).abs() < 1e-6);
        let left = search(method).nearest(&path, reference, [x, 0.03, 0.04]);
        assert!((left.error - 0.05).abs() < 1e-9);
        assert!((left.normal - 0.03).abs() < 1e-9 && (left.binormal - 0.04).abs() < 1e-9, "{left:?}");
        // Without a foot in the window, the nearest sample is returned, not bracketed.
        let far = search(method).nearest(&path, reference, [x + 5.0, 0.0, 0.0]);
        assert!(!far.flags.has(Flags::BRACKETED) && (far.error - 4.0).abs() < 1e-9, "{far:?}");
    }
    // The normal is machine X where the path runs along the plane's normal.
    let up = spans::<f64, f64>(&[Segment::Line { start: [0.0; 3].into(), end: DVec3::new(0.0, 0.0, 10.0) }]);
    let r =
        search(Method::Guarded).nearest(&Path::new(&up, 0, false), Reference { span: 0, t: 0.5 }, [-0.01, 0.0, 5.0]);
    assert!((r.normal + 0.01).abs() < 1e-12, "{r:?}");
    let none = search(Method::Guarded).nearest(&Path::new(&all, 0, false), Reference { span: 77, t: 0.5 }, [0.0; 3]);
    assert!(!none.is_measured());
}

#[test]
fn a_maximum_is_never_taken() {
    // Inside a circle, beyond its centre, the near side of the window is a maximum of the distance.
    let all = spans::<f64, f64>(&[Segment::Arc {
        start: DVec3::new(1.0, 0.0, 0.0),
        end: DVec3::new(0.0, 1.0, 0.0),
        center: [0.0; 3].into(),
        normal: Z.into(),
        turns: 0,
    }]);
    let path = Path::new(&all, 0, false);
    for method in [Method::Guarded, Method::Bisection] {
        let r = search(method).nearest(&path, Reference { span: 1, t: 0.5 }, [-0.3, -0.3, 0.0]);
        let end = norm([1.3, 0.3, 0.0]);
        assert!((r.error - end).abs() < 1e-9, "{r:?}");
    }
}

#[test]
fn offline_search_agrees_with_brute_force_on_random_splines_by_both_methods() {
    let mut random = Noise::new(21);
    for round in 0..share(40) {
        let spline =
            if round == 0 { Spline::butterfly() } else { Spline::random(&mut random, 1 + round % 5, round % 3 != 0) };
        let all = spans::<f64, f64>(&[spline.segment()]);
        let path = Path::new(&all, 0, false);
        for _ in 0..60 {
            let number = (random.unit() * all.len() as f64) as u32;
            let t = random.unit();
            let p = add(
                all[number as usize].position(t),
                [random.signed(), random.signed(), random.signed()].map(|x| 0.02 * x),
            );
            // The reference is up to 0.1 mm ahead.
            let reference = way::advance_far(&path, Reference { span: number, t }, 0.1 * random.unit());
            let truth = brute(&all, number, p);
            let guarded = search(Method::Guarded).nearest(&path, reference, p);
            let plain = search(Method::Bisection).nearest(&path, reference, p);
            for found in [guarded, plain] {
                assert!((found.error - truth).abs() < 1e-8, "round {round}: {found:?}, truth {truth}");
                assert!(found.flags.has(Flags::BRACKETED), "{found:?}");
            }
        }
    }
}
