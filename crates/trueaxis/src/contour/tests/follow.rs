//! A tool followed along whole paths.

use super::*;
use crate::testing::share::share;

#[test]
fn follows_the_butterfly_like_brute_force() {
    let all = spans::<f64, f64>(&[Spline::butterfly().segment()]);
    let stray = |s: f64| [3e-3 * (7.0 * s).sin(), 3e-3 * (5.0 * s).cos(), 1e-3 * (3.0 * s).sin()];
    let (mut cycles, mut off, mut most, mut fast) = (0, 0, 0, 0);
    // Brute force is slow.
    let compared = 0.5 / share(10) as f64;
    follow(&all, false, 2.5e-3, 15e-3, stray, Method::Guarded, |result, p, s| {
        if s < 0.2 || s % compared > 2.5e-3 {
            // Once the search is warm, the evaluations of every cycle count.
            if s > 0.2 {
                most = most.max(result.evaluations);
                fast += u32::from(result.evaluations == 2);
                cycles += 1;
            }
            return;
        }
        assert!(result.flags.has(Flags::BRACKETED), "at {s}: {result:?}");
        let truth = brute(&all, result.span, p);
        if (result.error - truth).abs() > 1e-8 {
            off += 1;
            assert!(result.error - truth < 2e-3, "at {s}: {} {truth}", result.error);
        }
    });
    assert!(most <= 8, "{most} evaluations");
    assert!(off <= 2, "{off} feet that are not the nearest");
    assert!(f64::from(fast) > 0.85 * f64::from(cycles), "{fast} of {cycles} in one kernel call");
}

#[test]
fn plain_bisection_in_the_step_agrees_with_the_guarded_search() {
    let all = spans::<f64, f64>(&[Spline::butterfly().segment()]);
    let stray = |s: f64| [2e-3 * (7.0 * s).sin(), 2e-3 * (5.0 * s).cos(), 0.0];
    let mut plain = Vec::new();
    follow(&all[..40], false, 0.02, 0.01, stray, Method::Bisection, |r, _, _| plain.push(r.error));
    let mut n = 0;
    let mut differ = 0;
    follow(&all[..40], false, 0.02, 0.01, stray, Method::Guarded, |r, _, _| {
        if n > 60 && (r.error - plain[n]).abs() > 1e-8 {
            differ += 1;
        }
        n += 1;
    });
    assert!(n > 500 && differ <= n / 200, "{differ} of {n}");
}

/// A million warm queries on the butterfly, with bounded evaluations; the cold start too.
#[test]
fn a_million_queries_stay_within_eight_evaluations() {
    let all = spans::<f64, f64>(&[Spline::butterfly().segment()]);
    let path = Path::new(&all, 0, false);
    let search = search(Method::Guarded);
    let mut random = Noise::new(99);
    let mut state = ContourState::default();
    let mut reference = Reference { span: 0, t: 0.0 };
    let (mut most, mut lost) = (0, 0);
    let mut feed = 1e-3;
    for n in 0..share(1_000_000) {
        if n % 500 == 0 {
            feed = 5e-3 * random.unit();
        }
        let before = reference;
        reference = way::advance_far(&path, reference, feed);
        if reference == before {
            (reference, state) = (Reference { span: 0, t: 0.0 }, ContourState::default());
        }
        let tool = way::advance_far(&path, reference, -0.01);
        let stray = [random.signed(), random.signed(), random.signed()].map(|x| 2e-3 * x);
        let r = search.update(&mut state, &path, reference, add(all[tool.span as usize].position(tool.t), stray));
        most = most.max(r.evaluations);
        lost += u32::from(!r.flags.has(Flags::BRACKETED) && !r.flags.has(Flags::COLD));
        assert!(r.error.is_finite() && r.lag.is_finite());
    }
    assert!(most <= 8, "{most}");
    assert!(lost < 100, "{lost} of a million lost");
}

/// High speed over spans of some hundredths of a millimetre: many feet just past a border. None may make the search cold, and
/// all but a few beside a second minimum are the nearest that plain search over the same spans finds.
#[test]
fn short_pieces_at_high_feed_leave_the_search_warm() {
    let polynomial = Spline { weights: vec![1.0; Spline::butterfly().points.len()], ..Spline::butterfly() };
    let all = spans::<f64, f64>(&[polynomial.segment()]);
    let path = Path::new(&all, 0, false);
    let (search, shortest) = (search(Method::Guarded), all.iter().map(Span::length).fold(f64::MAX, f64::min));
    assert!(shortest < 0.035, "{shortest}");
    let (mut cold, mut wrong, mut open, mut cycles, mut most) = (0, 0, 0, 0, 0);
    let mut random = Noise::new(5);
    for round in 0..share(60) {
        let (feed, lag, height) = match round {
            0 => (0.038, 0.0, 0.0),
            _ => (0.030 + 0.02 * random.unit(), 0.03 * random.unit(), 0.02 * random.unit()),
        };
        let phase = [random.unit(), random.unit(), random.unit()].map(|x| 40.0 * x);
        let mut state = ContourState::default();
        let mut reference = way::advance_far(&path, Reference { span: 0, t: 0.0 }, 0.5 + feed * random.unit());
        // Keeps the reference in place until the search is warm.
        for _ in 0..100 {
            search.update(&mut state, &path, reference, all[reference.span as usize].position(reference.t));
        }
        for n in 0.. {
            let before = reference;
            reference = way::advance_far(&path, reference, feed);
            if way::way(&path, before, reference).unwrap() < 0.9 * feed {
                break;
            }
            let tool = way::advance_far(&path, reference, -lag);
            let s = feed * f64::from(n);
            let stray = phase.map(|phase| height * (3.0 * s + phase).sin());
            let p = add(all[tool.span as usize].position(tool.t), stray);
            let r = search.update(&mut state, &path, reference, p);
            cycles += 1;
            most = most.max(r.evaluations);
            cold += u32::from(r.flags.has(Flags::COLD));
            open += u32::from(!r.flags.has(Flags::BRACKETED));
            // Checks cycles that cost evaluations, and a few others.
            if (n % 61 == 0 || r.evaluations >= 5) && r.flags.has(Flags::BRACKETED) {
                wrong += u32::from((r.error - brute(&all, r.span, p)).abs() > 1e-8 + r.width);
            }
        }
    }
    assert!(most <= 6, "{most} evaluations");
    assert_eq!(cold, 0, "of {cycles} cycles");
    // Of two minima, the one that the tool has followed need not be the nearer.
    assert!(wrong <= 2, "{wrong} feet that are not the nearest");
    assert!(open < cycles / 10_000, "{open} of {cycles} cycles without a bracket");
}
