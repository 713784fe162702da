//! Random paths of all kinds of spans against dense sampling, which uses only the spans' points.

use crate::contour::{ContourSearch, Flags, Method, NearFoot, Path, Reference, Segment, Span, convert};
use crate::position::{Nanometres, Position};
use crate::real::Real;
use crate::testing::noise::Noise;
use crate::testing::share::share;
use glam::DVec3;
use std::{vec, vec::Vec};

const Z: [f64; 3] = [0.0, 0.0, 1.0];
const SAMPLES: i32 = 24;

fn away(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

fn anywhere(random: &mut Noise, size: f64) -> DVec3 {
    DVec3::new(size * random.signed(), size * random.signed(), 0.4 * size * random.signed())
}

fn add(spans: &mut Vec<Span<f64, f64>>, segment: &Segment<'_>) {
    convert(segment, spans.len() as u32, Z, |span| {
        spans.push(span);
        Ok(())
    })
    .unwrap();
}

/// A spline from `from`, of any degree, rational or not; every third one turns back on itself or has a cusp.
fn add_spline(spans: &mut Vec<Span<f64, f64>>, random: &mut Noise, from: DVec3) -> DVec3 {
    let degree = 1 + (random.unit() * 5.0) as usize;
    let count = degree + 1 + (random.unit() * 4.0) as usize;
    let mut points = vec![from];
    let kind = (random.unit() * 3.0) as u32;
    for i in 1..count {
        let step = anywhere(random, 8.0);
        let back = if kind == 0 && i % 2 == 0 { points[i - 1] - points[i.saturating_sub(2)] } else { DVec3::ZERO };
        points.push(points[i - 1] - 0.98 * back + if kind == 0 { 0.05 * step } else { step });
    }
    let mut knots = vec![0.0; degree + 1];
    knots.extend((1..count - degree).map(|i| i as f64));
    knots.extend(vec![(count - degree) as f64; degree + 1]);
    let rational = random.unit() < 0.5;
    let weights: Vec<f64> = if rational { (0..count).map(|_| 0.3 + 3.0 * random.unit()).collect() } else { Vec::new() };
    let before = spans.len();
    add(spans, &Segment::Nurbs { degree, knots: &knots, points: &points, weights: &weights });
    if spans.len() == before { from } else { points[count - 1] }
}

/// Lines, arcs, helices, splines, hairpins, cusps and spans without length, one after the other.
fn path(random: &mut Noise) -> Vec<Span<f64, f64>> {
    let mut spans = Vec::new();
    let mut at = anywhere(random, 50.0);
    for _ in 0..1 + (random.unit() * 5.0) as u32 {
        match (random.unit() * 6.0) as u32 {
            0 => {
                let end = at + anywhere(random, 30.0);
                add(&mut spans, &Segment::Line { start: at, end });
                at = end;
            }
            1 => {
                // There and back, side by side.
                let way = anywhere(random, 20.0);
                let end = at + DVec3::new(1e-3 * random.signed(), 0.01, 0.0);
                add(&mut spans, &Segment::Line { start: at, end: at + way });
                add(&mut spans, &Segment::Line { start: at + way, end });
                at = end;
            }
            2 | 3 => {
                let radius = [0.05, 3.0, 40.0][(random.unit() * 3.0) as usize] * (0.5 + random.unit());
                let center = at - DVec3::X * radius;
                let (sine, cosine) = (7.0 * random.unit()).sin_cos();
                let end = center + radius * DVec3::new(cosine, sine, 0.0) + DVec3::Z * (6.0 * random.unit());
                add(&mut spans, &Segment::Arc { start: at, end, center, normal: DVec3::Z, turns: 0 });
                at = end;
            }
            4 => {
                add(&mut spans, &Segment::Turning { point: at });
                let end = at + anywhere(random, 5.0);
                add(&mut spans, &Segment::Line { start: at, end });
                at = end;
            }
            _ => at = add_spline(&mut spans, random, at),
        }
    }
    spans
}

/// A point beside the path, near it, among its spans, far from it, or on it.
fn point(random: &mut Noise, spans: &[Span<f64, f64>]) -> [f64; 3] {
    let span = &spans[((random.unit() * spans.len() as f64) as usize).min(spans.len() - 1)];
    let size = [0.0, 1e-5, 0.02, 1.0, 20.0, 1e4][(random.unit() * 6.0) as usize];
    let t = [0.0, 1.0, random.unit(), random.unit(), random.unit()][(random.unit() * 5.0) as usize];
    (DVec3::from(span.position(t)) + anywhere(random, size)).to_array()
}

/// Smallest distance: samples, and golden sections between the neighbours of those that may be nearest.
fn truth(spans: &[Span<f64, f64>], point: [f64; 3]) -> f64 {
    let at = |span: &Span<f64, f64>, t: f64| away(span.position(t), point);
    let mut samples = Vec::new();
    for (number, span) in spans.iter().enumerate() {
        samples.extend((0..=SAMPLES).map(|i| (at(span, f64::from(i) / f64::from(SAMPLES)), number, i)));
    }
    let least = samples.iter().map(|s| s.0).fold(f64::MAX, f64::min);
    let mut best = least;
    for (distance, number, i) in samples {
        // The path between two samples is at most twice as long as their spacing at the mean speed.
        let span = &spans[number];
        if distance - 2.0 * span.length() / f64::from(SAMPLES) > least {
            continue;
        }
        let [mut low, mut high] = [i - 1, i + 1].map(|i| f64::from(i.clamp(0, SAMPLES)) / f64::from(SAMPLES));
        for _ in 0..60 {
            let (left, right) = (high - 0.618_033_988_75 * (high - low), low + 0.618_033_988_75 * (high - low));
            if at(span, left) < at(span, right) { high = right } else { low = left }
        }
        best = best.min(at(span, 0.5 * (low + high))).min(at(span, low)).min(at(span, high));
    }
    best
}

#[test]
fn ten_thousand_points_about_random_paths_have_no_nearer_one() {
    let mut random = Noise::new(1405);
    let mut far_off = 0;
    for round in 0..share(1000) {
        let spans = path(&mut random);
        let closed = round % 7 == 0;
        let path = Path::new(&spans, 3, closed);
        let rounded: Vec<Span<f32, Nanometres>> = spans.iter().map(Span::rounded).collect();
        for _ in 0..10 {
            let point = point(&mut random, &spans);
            let truth = truth(&spans, point);
            let found = path.nearest(point);
            let slack = 1e-9 + 1e-12 * truth;
            assert!((found.error - truth).abs() < slack, "round {round}, {point:?}: {found:?}, truth {truth}");
            let foot = path.span(found.span).unwrap().position(found.t);
            assert!((away(foot, point) - found.error).abs() < slack, "round {round}: {found:?}");
            assert!([found.normal, found.binormal, found.tangential].iter().all(|c| c.is_finite()), "{found:?}");
            // Single precision, within the range of the integers.
            let integers: [Nanometres; 3] = point.map(Position::of);
            if integers.iter().all(|x| x.is_usable()) && truth < 50.0 {
                let single = Path::new(&rounded, 3, closed).nearest(integers).error.to_f64();
                far_off += u32::from((single - truth).abs() > 5e-6 + 1e-6 * truth);
                assert!((single - truth).abs() < 2e-5 + 1e-5 * truth, "round {round}: {single}, truth {truth}");
            }
        }
    }
    assert!(far_off <= 100, "{far_off} of 10000 in single precision");
}

#[test]
fn a_window_about_the_nearest_foot_finds_it_again() {
    let mut random = Noise::new(8);
    for round in 0..400 {
        let spans = path(&mut random);
        let path = Path::new(&spans, 0, false);
        for _ in 0..5 {
            let point = point(&mut random, &spans);
            let whole = path.nearest(point);
            for method in [Method::Guarded, Method::Bisection] {
                let search = ContourSearch::new(5.0, method).unwrap();
                let found = search.nearest(&path, Reference { span: whole.span, t: whole.t }, point);
                let slack = 1e-9 + 1e-12 * whole.error;
                assert!((found.error - whole.error).abs() < slack, "round {round}: {found:?}, {whole:?}");
            }
        }
    }
}

/// The point `by` further along the path, across borders.
fn along(spans: &[Span<f64, f64>], mut span: usize, t: f64, by: f64) -> Reference<f64> {
    let mut place = spans[span].arc_length(t) + by;
    while place > spans[span].length() && span + 1 < spans.len() {
        place -= spans[span].length();
        span += 1;
    }
    while place < 0.0 && span > 0 {
        span -= 1;
        place += spans[span].length();
    }
    Reference { span: span as u32, t: spans[span].t_at(place) }
}

#[test]
fn a_foot_near_a_guess_is_the_nearest_from_a_millimetre_off_too() {
    let spans = super::tests::butterfly();
    let path = Path::new(&spans, 0, true);
    let search = ContourSearch::new(2.0, Method::Guarded).unwrap();
    let mut random = Noise::new(55);
    for i in 0..share(10_000) {
        let number = ((random.unit() * spans.len() as f64) as usize).min(spans.len() - 1);
        let t = random.unit();
        let point = (DVec3::from(spans[number].position(t)) + anywhere(&mut random, 0.02)).to_array();
        for off in [0.0, 0.02, -0.1, 1.0, -1.0] {
            let guess = along(&spans, number, t, off);
            let found = search.foot_near(&path, guess, &point).expect("a foot");
            let whole = path.nearest(point).error;
            assert!((found.distance() - whole).abs() < 1e-9, "{i}, {off}: {found:?}, truth {whole}");
            assert!(found.flags.has(Flags::BRACKETED));
            let foot = path.span(found.at.span).unwrap().position(found.at.t);
            assert!((away(foot, point) - found.distance()).abs() < 1e-9);
        }
    }
}

#[test]
fn there_is_no_foot_near_what_is_no_place_or_no_point() {
    let spans = super::tests::butterfly();
    let path = Path::new(&spans, 0, false);
    for method in [Method::Guarded, Method::Bisection] {
        let search = ContourSearch::new(2.0, method).unwrap();
        let near = |span: u32, t: f64, x: f64| -> Option<NearFoot<f64>> {
            search.foot_near(&path, Reference { span, t }, &[x, 0.0, 0.0])
        };
        assert!(near(9999, 0.5, 0.0).is_none());
        assert!(near(3, f64::NAN, 0.0).is_none() && near(3, f64::INFINITY, 0.0).is_none());
        assert!(near(3, 0.5, f64::NAN).is_none() && near(3, 0.5, f64::INFINITY).is_none());
        assert!(near(3, 0.5, 1e8).is_some_and(|foot| foot.distance() > 9e7));
    }
}
