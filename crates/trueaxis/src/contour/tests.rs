use super::kernel::foot;
use super::*;
use crate::position::{Nanometres, Position};
use crate::testing::noise::Noise;
use glam::DVec3;
use proptest::prelude::*;
use std::{vec, vec::Vec};

type V = [f64; 3];
const Z: V = [0.0, 0.0, 1.0];

fn sub(a: V, b: V) -> V {
    core::array::from_fn(|k| a[k] - b[k])
}
fn add(a: V, b: V) -> V {
    core::array::from_fn(|k| a[k] + b[k])
}
fn norm(a: V) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn spans<R: Real, P: Position>(segments: &[Segment<'_>]) -> Vec<Span<R, P>> {
    let mut all = Vec::new();
    for (number, segment) in segments.iter().enumerate() {
        convert(segment, number as u32, Z, |span| {
            all.push(span);
            Ok(())
        })
        .unwrap();
    }
    all
}

/// de Boor's algorithm, written apart from the conversion.
fn de_boor(degree: usize, knots: &[f64], points: &[DVec3], weights: &[f64], u: f64) -> V {
    let n = points.len();
    let mut i = degree;
    while i + 1 < n && knots[i + 1] <= u {
        i += 1;
    }
    let mut d: Vec<[f64; 4]> = (0..=degree)
        .map(|j| {
            let (p, w) = (points[i - degree + j].to_array(), weights[i - degree + j]);
            [p[0] * w, p[1] * w, p[2] * w, w]
        })
        .collect();
    for r in 1..=degree {
        for j in (r..=degree).rev() {
            let a = (u - knots[i - degree + j]) / (knots[i + 1 + j - r] - knots[i - degree + j]);
            d[j] = core::array::from_fn(|k| (1.0 - a) * d[j - 1][k] + a * d[j][k]);
        }
    }
    [d[degree][0] / d[degree][3], d[degree][1] / d[degree][3], d[degree][2] / d[degree][3]]
}

struct Spline {
    degree: usize,
    knots: Vec<f64>,
    points: Vec<DVec3>,
    weights: Vec<f64>,
}

impl Spline {
    fn butterfly() -> Spline {
        let text = include_str!("../../tests/data/butterfly.csv");
        let numbers = |line: &str| line.split(',').map(|x| x.parse().unwrap()).collect::<Vec<f64>>();
        let (mut knots, mut points, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        for line in text.lines().filter(|l| !l.is_empty() && !l.starts_with('#')) {
            match numbers(line)[..] {
                [knot] => knots.push(knot),
                [x, y, w] => {
                    points.push(DVec3::new(x, y, 0.0));
                    weights.push(w);
                }
                _ => panic!("{line}"),
            }
        }
        Spline { degree: 3, knots, points, weights }
    }

    fn random(random: &mut Noise, degree: usize, rational: bool) -> Spline {
        let count = degree + 3 + (random.unit() * 6.0) as usize;
        let inner = count - degree;
        let mut knots = vec![0.0; degree + 1];
        let mut u = 0.0;
        for _ in 1..inner {
            u += 0.2 + random.unit();
            knots.push(u);
        }
        knots.extend(vec![u + 0.5; degree + 1]);
        let points = (0..count)
            .map(|i| DVec3::new(9.0 * i as f64 + 6.0 * random.signed(), 12.0 * random.signed(), 5.0 * random.signed()))
            .collect();
        let weights = (0..count).map(|_| if rational { 0.5 + 2.0 * random.unit() } else { 1.0 }).collect();
        Spline { degree, knots, points, weights }
    }

    fn segment(&self) -> Segment<'_> {
        Segment::Nurbs { degree: self.degree, knots: &self.knots, points: &self.points, weights: &self.weights }
    }

    fn at(&self, u: f64) -> V {
        de_boor(self.degree, &self.knots, &self.points, &self.weights, u)
    }

    fn domain(&self) -> [f64; 2] {
        [self.knots[self.degree], self.knots[self.points.len()]]
    }
}

fn point<R: Real>(span: &Span<R, f64>, t: f64) -> V {
    span.position(R::of(t))
}

#[test]
fn splines_of_every_degree_agree_with_de_boor_and_keep_their_bounds() {
    let mut random = Noise::new(11);
    for round in 0..120 {
        let spline =
            if round == 0 { Spline::butterfly() } else { Spline::random(&mut random, 1 + round % 5, round % 2 == 0) };
        let all = spans::<f64, f64>(&[spline.segment()]);
        let mut last = None::<V>;
        for span in &all {
            for i in 0..=10 {
                let t = f64::from(i) / 10.0;
                let truth = spline.at(span.u_of(t).min(spline.domain()[1] - 1e-13));
                assert!(norm(sub(point(span, t), truth)) < 1e-10, "degree {}: {t}", spline.degree);
                assert!(norm(span.local(t)) <= 8.0 + 1e-9);
                assert!((span.t_of(span.u_of(t)) - t).abs() < 1e-12);
            }
            if let Some(last) = last {
                assert!(norm(sub(last, point(span, 0.0))) < 1e-11, "gap");
            }
            last = Some(point(span, 1.0));
        }
    }
}

#[test]
fn the_butterfly_has_its_published_length() {
    let all = spans::<f64, f64>(&[Spline::butterfly().segment()]);
    let length: f64 = all.iter().map(Span::length).sum();
    assert!((length - 382.86).abs() < 0.005, "{length}");
}

#[test]
fn arcs_and_helices_are_exact_in_any_plane() {
    let mut random = Noise::new(3);
    for round in 0..300 {
        let n = [random.signed(), random.signed(), random.signed()];
        let n = n.map(|x| x / norm(n));
        let side = if n[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let cross = |a: V, b: V| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let e1 = cross(n, side);
        let e1 = e1.map(|x| x / norm(e1));
        let e2 = cross(n, e1);
        let radius = 10f64.powf(-1.5 + 4.0 * random.unit());
        let angle = 0.05 + 6.2 * random.unit();
        let turns = if round % 3 == 0 { 2 } else { 0 };
        let rise = if round % 2 == 0 { 0.0 } else { 20.0 * random.signed() };
        let center = [100.0 * random.signed(), 50.0, -30.0];
        let at = |angle: f64, rise: f64| -> V {
            core::array::from_fn(|k| center[k] + radius * (angle.cos() * e1[k] + angle.sin() * e2[k]) + rise * n[k])
        };
        let whole = angle + core::f64::consts::TAU * f64::from(turns);
        let segment = Segment::Arc {
            start: at(0.0, 0.0).into(),
            end: at(angle, rise).into(),
            center: center.into(),
            normal: n.map(|x| 3.0 * x).into(),
            turns,
        };
        let all = spans::<f64, f64>(&[segment]);
        let mut length = 0.0;
        for span in &all {
            for i in 0..=8 {
                let t = f64::from(i) / 8.0;
                let u = span.u_of(t);
                let truth = at(whole * u, rise * u);
                assert!(norm(sub(point(span, t), truth)) < 3e-10, "radius {radius}, rise {rise}");
                assert!((span.t_of(u) - t).abs() < 1e-12);
            }
            length += span.length();
        }
        assert!((length / (radius * whole).hypot(rise) - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_rounded_programs_radius_changes_linearly_with_the_angle() {
    let (r0, r1, angle) = (10.0, 10.004, 2.0_f64);
    let all = spans::<f64, f64>(&[Segment::Arc {
        start: DVec3::new(r0, 0.0, 0.0),
        end: DVec3::new(r1 * angle.cos(), r1 * angle.sin(), 0.0),
        center: [0.0; 3].into(),
        normal: Z.into(),
        turns: 0,
    }]);
    for span in &all {
        for i in 0..=8 {
            let u = span.u_of(f64::from(i) / 8.0);
            let r = r0 + u * (r1 - r0);
            let truth = [r * (u * angle).cos(), r * (u * angle).sin(), 0.0];
            // 4 µm of growth times k⁷ = 5e-7.
            assert!(norm(sub(point(span, f64::from(i) / 8.0), truth)) < 1e-8);
        }
    }
}

#[test]
fn segments_that_are_no_path_are_refused() {
    let refused = |segment: Segment<'_>| convert::<f64, f64>(&segment, 0, Z, |_| Ok(())).unwrap_err();
    let o = [0.0; 3];
    let e = refused(Segment::Line { start: o.into(), end: o.into() });
    assert_eq!((e.field, e.found), ("end", 0.0));
    assert_eq!(refused(Segment::Line { start: DVec3::new(f64::NAN, 0.0, 0.0), end: o.into() }).field, "start");
    let arc = |start, end, center, normal| Segment::Arc { start, end, center, normal, turns: 0 };
    assert_eq!(refused(arc([1.0, 0.0, 0.0].into(), [0.0, 1.1, 0.0].into(), o.into(), Z.into())).field, "end");
    assert_eq!(refused(arc(o.into(), [0.0, 1.0, 0.0].into(), o.into(), Z.into())).field, "center");
    assert_eq!(refused(arc([1.0, 0.0, 0.0].into(), [0.0, 1.0, 0.0].into(), o.into(), o.into())).field, "normal");
    let p = [o, [1.0, 0.0, 0.0], [2.0, 1.0, 0.0]].map(DVec3::from_array);
    let nurbs = |degree, knots, weights| Segment::Nurbs { degree, knots, points: &p, weights };
    assert_eq!(refused(nurbs(6, &[0.0; 10], &[])).field, "degree");
    assert_eq!(refused(nurbs(3, &[0.0; 7], &[])).field, "points");
    assert_eq!(refused(nurbs(1, &[0.0, 0.0, 1.0, 1.0], &[])).field, "knots");
    assert_eq!(refused(nurbs(1, &[0.0, 0.0, 2.0, 1.0, 1.0], &[])).index, Some(3));
    assert_eq!(refused(nurbs(1, &[0.0, 0.0, 0.5, 1.0, 1.0], &[1.0, 0.0, 1.0])).index, Some(1));
    assert_eq!(refused(nurbs(1, &[0.0, 0.0, f64::INFINITY, 1.0, 1.0], &[])).field, "knots");
    assert_eq!(refused(nurbs(1, &[0.0, 0.0, 0.5, 1.0, 1.0], &[1.0])).field, "weights");
}

/// Wherever the kernel trusts itself, its distance is right to 1e-6 nm; compared with bisection of the same span.
#[test]
fn the_kernel_is_exact_wherever_it_trusts_itself() {
    let mut random = Noise::new(5);
    let (mut trusted, mut all_queries, mut worst) = (0, 0, 0.0_f64);
    let mut singles = Vec::new();
    for round in 0..60 {
        let spline =
            if round == 0 { Spline::butterfly() } else { Spline::random(&mut random, 2 + round % 4, round % 2 == 0) };
        let double = spans::<f64, f64>(&[spline.segment()]);
        let single = spans::<f32, Nanometres>(&[spline.segment()]);
        for (span, small) in double.iter().zip(&single) {
            for _ in 0..30 {
                let t = 0.05 + 0.9 * random.unit();
                let e = kernel::evaluate(span, &[0.0; 3], t);
                let speed = e.straight.sqrt();
                // 10 µm beside the path, started 5 to 20 µm along it.
                let beside = [random.signed(), random.signed(), random.signed()].map(|x| 0.01 * x);
                let p = add(point(span, t), beside);
                let guess = t + 0.02 * random.signed() / speed;
                let local = span.relative(&p);
                let found = foot(span, &local, guess);
                all_queries += 1;
                if found.trusted {
                    trusted += 1;
                    let (mut low, mut high) = ((found.t - 1e-3).max(0.0), (found.t + 1e-3).min(1.0));
                    if kernel::evaluate(span, &local, low).g < 0.0 && kernel::evaluate(span, &local, high).g > 0.0 {
                        for _ in 0..80 {
                            let middle = 0.5 * (low + high);
                            if kernel::evaluate(span, &local, middle).g < 0.0 { low = middle } else { high = middle }
                        }
                        let truth = norm(kernel::evaluate(span, &local, 0.5 * (low + high)).vector);
                        worst = worst.max((norm(found.vector) - truth).abs());
                        let p = p.map(Nanometres::of);
                        let rounded = norm(
                            kernel::evaluate(span, &span.relative(&p.map(|x| x.to_f64())), 0.5 * (low + high)).vector,
                        );
                        let f = foot(small, &small.relative(&p), guess as f32);
                        if f.trusted {
                            singles.push((norm(f.vector.map(f64::from)) - rounded).abs());
                        }
                    }
                }
            }
        }
    }
    assert!(f64::from(trusted) > 0.94 * f64::from(all_queries), "{trusted} of {all_queries}");
    assert!(worst < 1e-12, "{worst:e} mm");
    singles.sort_by(f64::total_cmp);
    let p999 = singles[singles.len() * 999 / 1000];
    assert!(p999 < 2e-6, "f32: {p999:e} mm");
}

fn search(method: Method) -> ContourSearch<f64> {
    ContourSearch::new(1.0, method).unwrap()
}

/// Follows a path with a tool that lags and strays; yields every cycle's report and the true tool position.
fn follow(
    all: &[Span<f64, f64>],
    closed: bool,
    feed: f64,
    lag: f64,
    stray: impl Fn(f64) -> V,
    method: Method,
    mut check: impl FnMut(ContourError<f64>, V, f64),
) {
    let path = Path::new(all, 0, closed);
    let search = search(method);
    let mut state = ContourState::default();
    let total: f64 = all.iter().map(Span::length).sum();
    let mut s = lag;
    while s < total {
        let place = |s: f64| search::advance(&path, Reference { span: 0, t: 0.0 }, 0.0_f64.max(s));
        // advance() goes over 64 spans at most: walk.
        let walk = |mut s: f64| {
            for (i, span) in all.iter().enumerate() {
                if s <= span.length() {
                    return Reference { span: i as u32, t: s / span.length() };
                }
                s -= span.length();
            }
            place(total)
        };
        let reference = walk(s);
        let tool = walk(s - lag);
        let p = add(all[tool.span as usize].position(tool.t), stray(s));
        let result = search.update(&mut state, &path, reference, p);
        check(result, p, s);
        s += feed;
    }
}

/// Nearest point by brute force over all spans near a position.
fn brute(all: &[Span<f64, f64>], near: u32, p: V) -> f64 {
    let from = (near as usize).saturating_sub(6);
    let mut best = f64::MAX;
    for span in &all[from..(near as usize + 7).min(all.len())] {
        let distance = |t: f64| norm(sub(point(span, t), p));
        let mut i =
            (0..=64).min_by(|a, b| distance(f64::from(*a) / 64.0).total_cmp(&distance(f64::from(*b) / 64.0))).unwrap();
        i = i.clamp(1, 63);
        // Golden section, then parabola-free trust in its own precision of 1e-8.
        let (mut a, mut b) = (f64::from(i - 1) / 64.0, f64::from(i + 1) / 64.0);
        for _ in 0..80 {
            let (c, d) = (b - 0.618_033_988_75 * (b - a), a + 0.618_033_988_75 * (b - a));
            if distance(c) < distance(d) { b = d } else { a = c }
        }
        best = best.min(distance(0.5 * (a + b))).min(distance(0.0)).min(distance(1.0));
    }
    best
}

#[test]
fn follows_the_butterfly_like_brute_force() {
    let all = spans::<f64, f64>(&[Spline::butterfly().segment()]);
    let stray = |s: f64| [3e-3 * (7.0 * s).sin(), 3e-3 * (5.0 * s).cos(), 1e-3 * (3.0 * s).sin()];
    let (mut cycles, mut off, mut most, mut fast) = (0, 0, 0, 0);
    follow(&all, false, 2.5e-3, 15e-3, stray, Method::Guarded, |result, p, s| {
        if s < 0.2 || s % 0.05 > 2.5e-3 {
            // Once warm, every cycle counts for the evaluations; brute force is slow.
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
                let truth = brute(&all, 0, p);
                assert!((r.error - truth).abs() < 1e-9, "side {side} at {s}: {r:?} {truth}");
                assert!(r.evaluations <= 8);
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
        // Beyond the window there is no foot: the nearest sample, not bracketed.
        let far = search(method).nearest(&path, reference, [x + 5.0, 0.0, 0.0]);
        assert!(!far.flags.has(Flags::BRACKETED) && (far.error - 4.0).abs() < 1e-9, "{far:?}");
    }
    // The machine's X is the normal where the path runs along the plane's.
    let up = spans::<f64, f64>(&[Segment::Line { start: [0.0; 3].into(), end: DVec3::new(0.0, 0.0, 10.0) }]);
    let r =
        search(Method::Guarded).nearest(&Path::new(&up, 0, false), Reference { span: 0, t: 0.5 }, [-0.01, 0.0, 5.0]);
    assert!((r.normal + 0.01).abs() < 1e-12, "{r:?}");
    let none = search(Method::Guarded).nearest(&Path::new(&all, 0, false), Reference { span: 77, t: 0.5 }, [0.0; 3]);
    assert!(!none.is_measured());
}

#[test]
fn a_maximum_is_never_taken() {
    // Inside a circle beyond its centre the near side of the window is a maximum of the distance.
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
    for round in 0..40 {
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
            let reference = search::advance(&path, Reference { span: number, t }, 0.1 * random.unit());
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

/// A million warm queries on the butterfly, worst evaluations bounded; the cold start too.
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
    for n in 0..1_000_000 {
        if n % 500 == 0 {
            feed = 5e-3 * random.unit();
        }
        let before = reference;
        reference = search::advance(&path, reference, feed);
        if reference == before {
            (reference, state) = (Reference { span: 0, t: 0.0 }, ContourState::default());
        }
        let tool = search::advance(&path, reference, -0.01);
        let stray = [random.signed(), random.signed(), random.signed()].map(|x| 2e-3 * x);
        let r = search.update(&mut state, &path, reference, add(all[tool.span as usize].position(tool.t), stray));
        most = most.max(r.evaluations);
        lost += u32::from(!r.flags.has(Flags::BRACKETED) && !r.flags.has(Flags::COLD));
        assert!(r.error.is_finite() && r.lag.is_finite());
    }
    assert!(most <= 8, "{most}");
    assert!(lost < 100, "{lost} of a million lost");
}

/// Fast over spans of some hundredths of a millimetre: feet just past a border, many times. None may send the search
/// cold, and all but a few beside a second minimum are the nearest that
/// plain search over the same spans finds.
#[test]
fn short_pieces_at_high_feed_leave_the_search_warm() {
    let polynomial = Spline { weights: vec![1.0; Spline::butterfly().points.len()], ..Spline::butterfly() };
    let all = spans::<f64, f64>(&[polynomial.segment()]);
    let path = Path::new(&all, 0, false);
    let (search, shortest) = (search(Method::Guarded), all.iter().map(Span::length).fold(f64::MAX, f64::min));
    assert!(shortest < 0.035, "{shortest}");
    let (mut cold, mut wrong, mut open, mut cycles, mut most) = (0, 0, 0, 0, 0);
    let mut random = Noise::new(5);
    for round in 0..60 {
        let (feed, lag, height) = match round {
            0 => (0.038, 0.0, 0.0),
            _ => (0.030 + 0.02 * random.unit(), 0.03 * random.unit(), 0.02 * random.unit()),
        };
        let phase = [random.unit(), random.unit(), random.unit()].map(|x| 40.0 * x);
        let mut state = ContourState::default();
        let mut reference = search::advance(&path, Reference { span: 0, t: 0.0 }, 0.5 + feed * random.unit());
        // Standing, until the search is warm.
        for _ in 0..100 {
            search.update(&mut state, &path, reference, all[reference.span as usize].position(reference.t));
        }
        for n in 0.. {
            let before = reference;
            reference = search::advance(&path, reference, feed);
            if search::way(&path, before, reference, 1.0) < 0.9 * feed {
                break;
            }
            let tool = search::advance(&path, reference, -lag);
            let s = feed * f64::from(n);
            let stray = phase.map(|phase| height * (3.0 * s + phase).sin());
            let p = add(all[tool.span as usize].position(tool.t), stray);
            let r = search.update(&mut state, &path, reference, p);
            cycles += 1;
            most = most.max(r.evaluations);
            cold += u32::from(r.flags.has(Flags::COLD));
            open += u32::from(!r.flags.has(Flags::BRACKETED));
            // At those that cost evaluations, and at a few others.
            if (n % 61 == 0 || r.evaluations >= 5) && r.flags.has(Flags::BRACKETED) {
                wrong += u32::from((r.error - brute(&all, r.span, p)).abs() > 1e-8 + r.width);
            }
        }
    }
    assert!(most <= 6, "{most} evaluations");
    assert_eq!(cold, 0, "of {cycles} cycles");
    // Of two minima the one that the tool came along with need not be the nearer.
    assert!(wrong <= 2, "{wrong} feet that are not the nearest");
    assert!(open < cycles / 10_000, "{open} of {cycles} cycles without a bracket");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

    /// No point, reference or state that floats can make gives a panic or a result that is not finite.
    #[test]
    fn any_query_is_answered_with_finite_numbers(
        points in prop::collection::vec((-1e9..1e9f64, -1e9..1e9f64, -100.0..100.0f64, any::<u32>(), any::<f64>()), 6),
        near in any::<bool>(),
    ) {
        let spline = Spline::butterfly();
        let all = spans::<f64, f64>(&[spline.segment()]);
        let path = Path::new(&all, 5, near);
        let search = search(Method::Guarded);
        let mut state = ContourState::default();
        for (x, y, z, span, t) in points {
            let p = if near { [x * 1e-7, y * 1e-7, z] } else { [x, y, z] };
            let t = if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.5 };
            let r = search.update(&mut state, &path, Reference { span: 5 + span % 60, t }, p);
            let all = [r.error, r.normal, r.binormal, r.tangential, r.lag, r.width, r.t, r.vector[0], r.vector[1], r.vector[2]];
            prop_assert!(all.iter().all(|x| x.is_finite()), "{r:?}");
        }
    }
}

/// Every span within 8 mm of its middle, also where a spline's speed is concentrated; and as many as were announced.
#[test]
fn no_span_reaches_farther_than_it_should() {
    let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let far = [[0.0; 3], [0.0, 1.0, 0.0], [2e6, 1.0, 0.0], [2e6, 0.0, 0.0]].map(DVec3::from_array);
    let near = [[0.0; 3], [1e3, 0.0, 0.0], [1e3, 1e3, 0.0], [0.0, 1e3, 5.0]].map(DVec3::from_array);
    let heavy = [1.0, 1e7, 1e-7, 1.0];
    let cases = [
        Segment::Nurbs { degree: 3, knots: &knots, points: &far, weights: &[] },
        Segment::Nurbs { degree: 3, knots: &knots, points: &near, weights: &heavy },
        Segment::Line { start: [0.0; 3].into(), end: DVec3::new(1e3, 7.0, 0.0) },
        Segment::Arc {
            start: DVec3::new(300.0, 0.0, 0.0),
            end: DVec3::new(300.0, 0.0, 9.0),
            center: [0.0; 3].into(),
            normal: Z.into(),
            turns: 3,
        },
        Segment::Turning { point: [1.0; 3].into() },
    ];
    for segment in &cases {
        let made: Vec<Span<f64, f64>> = spans(std::slice::from_ref(segment));
        assert_eq!(made.len() as u32, span_count(segment).unwrap(), "{segment:?}");
        for span in &made {
            // The middle of a line and of a spline is that of its chord; of an arc that on the arc.
            let ends = add(span.position(0.0), span.position(1.0)).map(|x| 0.5 * x);
            let middle = if matches!(segment, Segment::Arc { .. }) { span.position(0.5) } else { ends };
            for i in 0..=16 {
                let reach = norm(sub(span.position(f64::from(i) / 16.0), middle));
                assert!(reach <= 8.0 + 1e-6, "{segment:?}: {reach}");
            }
        }
    }
}

/// Too many spans are refused by their number, before any is made.
#[test]
fn segments_without_end_are_refused_before_a_span_is_made() {
    let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let far = [[0.0; 3], [9e8, 0.0, 0.0], [9e8, 9e8, 0.0]].map(DVec3::from_array);
    let peak = [[0.0; 3], [9e8, 0.0, 0.0], [1.0, 0.0, 0.0]].map(DVec3::from_array);
    for segment in [
        Segment::Line { start: [0.0; 3].into(), end: DVec3::new(1e8, 0.0, 0.0) },
        Segment::Arc {
            start: DVec3::new(1e6, 0.0, 0.0),
            end: DVec3::new(1e6, 0.0, 0.0),
            center: [0.0; 3].into(),
            normal: Z.into(),
            turns: 9999,
        },
        Segment::Nurbs { degree: 2, knots: &knots, points: &far, weights: &[] },
        Segment::Nurbs { degree: 2, knots: &knots, points: &peak, weights: &[] },
    ] {
        assert!(span_count(&segment).is_err(), "{segment:?}");
        let mut made = 0;
        let refused = convert::<f64, f64>(&segment, 0, Z, |_| {
            made += 1;
            Ok(())
        });
        assert!(refused.is_err() && made <= 1_000_000, "{segment:?}: {made}");
    }
}

#[test]
fn a_segment_and_its_parameter_are_a_place_on_the_path() {
    let [a, b, c] = [[0.0; 3], [10.0, 0.0, 0.0], [10.0, 10.0, 0.0]];
    // Segments 4, 5 and 7: 6 is not there. The window begins at span 100.
    let segments = [
        (4, Segment::Line { start: a.into(), end: b.into() }),
        (
            5,
            Segment::Arc {
                start: b.into(),
                end: c.into(),
                center: DVec3::new(10.0, 5.0, 0.0),
                normal: Z.into(),
                turns: 0,
            },
        ),
        (7, Segment::Line { start: c.into(), end: a.into() }),
    ];
    let mut all: Vec<Span<f64, f64>> = Vec::new();
    for (number, segment) in &segments {
        convert(segment, *number, Z, |span| {
            all.push(span);
            Ok(())
        })
        .unwrap();
    }
    let path = Path::new(&all, 100, false);
    let at = |segment, u| {
        let on = path.at(segment, u);
        path.span(on.reference.span).unwrap().position(on.reference.t)
    };
    for i in 0..=100 {
        let u = f64::from(i) / 100.0;
        let angle = core::f64::consts::PI * (u - 0.5);
        for (segment, truth) in [
            (4, [10.0 * u, 0.0, 0.0]),
            (5, [10.0 + 5.0 * angle.cos(), 5.0 + 5.0 * angle.sin(), 0.0]),
            (7, [10.0 - 10.0 * u, 10.0 - 10.0 * u, 0.0]),
        ] {
            assert!(norm(sub(at(segment, u), truth)) < 1e-9, "{segment} at {u}: {:?}", at(segment, u));
        }
    }
    // Beyond the ends of a segment: its end.
    for (segment, [start, end]) in [(4, [a, b]), (5, [b, c]), (7, [c, a])] {
        assert!(norm(sub(at(segment, -0.5), start)) < 1e-9, "{segment}");
        assert!(norm(sub(at(segment, 1.5), end)) < 1e-9, "{segment}");
    }

    let search = ContourSearch::<f64>::new(1.0, Method::Guarded).unwrap();
    let empty = Path::new(&[], 0, false);
    for on in [path.at(3, 0.5), path.at(6, 0.5), path.at(8, 0.0), path.at(5, f64::NAN), empty.at(4, 0.5)] {
        let mut state = ContourState::default();
        let error = search.update(&mut state, &on.path, on.reference, [5.0, 0.1, 0.0]);
        assert!(!error.is_measured() && error.flags.has(Flags::REFERENCE), "{on:?}: {error:?}");
    }
    let on = path.at(4, 0.5);
    let error = search.update(&mut ContourState::default(), &on.path, on.reference, [5.0, 0.1, 0.0]);
    assert!(error.is_measured() && (error.normal - 0.1).abs() < 1e-9, "{error:?}");
}
