//! Shared by the tests of the contour error: spans, splines implemented separately from the conversion, plain search for the
//! truth.

use super::*;
use crate::position::Position;
use crate::testing::noise::Noise;
use glam::DVec3;
use std::{vec, vec::Vec};

mod finite;
mod follow;
mod kernel;
mod segments;
mod shapes;

std::thread_local! {
    /// Number of spans looked up on a path.
    pub(super) static LOOKED_AT: core::cell::Cell<u32> = const { core::cell::Cell::new(0) };
}

pub(super) type V = [f64; 3];
pub(super) const Z: V = [0.0, 0.0, 1.0];

pub(super) fn sub(a: V, b: V) -> V {
    core::array::from_fn(|k| a[k] - b[k])
}
pub(super) fn add(a: V, b: V) -> V {
    core::array::from_fn(|k| a[k] + b[k])
}
pub(super) fn norm(a: V) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

pub(super) fn spans<R: Real, P: Position>(segments: &[Segment<'_>]) -> Vec<Span<R, P>> {
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

/// de Boor's algorithm, implemented separately from the conversion.
pub(super) fn de_boor(degree: usize, knots: &[f64], points: &[DVec3], weights: &[f64], u: f64) -> V {
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

pub(super) struct Spline {
    pub(super) degree: usize,
    pub(super) knots: Vec<f64>,
    pub(super) points: Vec<DVec3>,
    pub(super) weights: Vec<f64>,
}

impl Spline {
    pub(super) fn butterfly() -> Spline {
        let text = include_str!("../../../tests/data/butterfly.csv");
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

    pub(super) fn random(random: &mut Noise, degree: usize, rational: bool) -> Spline {
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

    pub(super) fn segment(&self) -> Segment<'_> {
        Segment::Nurbs { degree: self.degree, knots: &self.knots, points: &self.points, weights: &self.weights }
    }

    pub(super) fn at(&self, u: f64) -> V {
        de_boor(self.degree, &self.knots, &self.points, &self.weights, u)
    }

    pub(super) fn domain(&self) -> [f64; 2] {
        [self.knots[self.degree], self.knots[self.points.len()]]
    }
}

pub(super) fn point<R: Real>(span: &Span<R, f64>, t: f64) -> V {
    span.position(R::of(t))
}

pub(super) fn search(method: Method) -> ContourSearch<f64> {
    ContourSearch::new(1.0, method).unwrap()
}

/// Follows a path with a tool that lags and strays; yields every cycle's report and the true tool position.
pub(super) fn follow(
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
        let place = |s: f64| way::advance_far(&path, Reference { span: 0, t: 0.0 }, 0.0_f64.max(s));
        // advance_far() crosses at most 64 spans: walk instead.
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
pub(super) fn brute(all: &[Span<f64, f64>], near: u32, p: V) -> f64 {
    let from = (near as usize).saturating_sub(6);
    let mut best = f64::MAX;
    for span in &all[from..(near as usize + 7).min(all.len())] {
        let distance = |t: f64| norm(sub(point(span, t), p));
        let mut i =
            (0..=64).min_by(|a, b| distance(f64::from(*a) / 64.0).total_cmp(&distance(f64::from(*b) / 64.0))).unwrap();
        i = i.clamp(1, 63);
        // Golden section; its precision is 1e-8, without a final parabola.
        let (mut a, mut b) = (f64::from(i - 1) / 64.0, f64::from(i + 1) / 64.0);
        for _ in 0..80 {
            let (c, d) = (b - 0.618_033_988_75 * (b - a), a + 0.618_033_988_75 * (b - a));
            if distance(c) < distance(d) { b = d } else { a = c }
        }
        best = best.min(distance(0.5 * (a + b))).min(distance(0.0)).min(distance(1.0));
    }
    best
}
