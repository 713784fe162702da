//! Both feet from one frame: compared with bisection and with two searches, and across borders.

use super::*;
use crate::contour::refine::dot;
use crate::contour::tests::{Spline, V, Z, add, norm, spans, sub};
use crate::contour::{Flags, Segment, Span};
use crate::position::Nanometres;
use crate::testing::noise::Noise;
use glam::DVec3;
use std::vec::Vec;

mod exact;
mod follow;
mod legs;
mod shapes;

/// Both contour errors along a path, cycle by cycle.
struct Walk<'a> {
    search: ContourSearch<f64>,
    path: Path<'a, f64, f64>,
    state: PairState<f64>,
}

impl<'a> Walk<'a> {
    fn new(all: &'a [Span<f64, f64>], closed: bool) -> Self {
        let search = ContourSearch::new(1.0, Method::Guarded).unwrap();
        Walk { search, path: Path::new(all, 0, closed), state: PairState::default() }
    }

    /// One cycle: contour errors of tip and encoder at the given positions.
    fn step(&mut self, reference: Reference<f64>, tip: V, encoder: V) -> [ContourError<f64>; 2] {
        let mut found = [ContourError::none(); 2];
        let [at_tip, at_encoder] = &mut found;
        let on = self.path.on(reference);
        self.search.update_pair(&mut self.state, &on, &encoder, &sub(tip, encoder), at_tip, at_encoder);
        let spent = at_tip.evaluations + at_encoder.evaluations;
        assert!(spent <= 5, "{spent} evaluations: {found:?}");
        found
    }

    /// Keeps the reference still until the search is warm.
    fn warm(&mut self, reference: Reference<f64>) {
        let at = self.path.span(reference.span).unwrap().position(reference.t);
        for _ in 0..60 {
            self.step(reference, at, at);
        }
        assert!(self.state.swift);
    }
}

/// The point at an arc length from the start.
fn place(all: &[Span<f64, f64>], mut s: f64) -> Reference<f64> {
    for (number, span) in all.iter().enumerate() {
        if s <= span.length() || number + 1 == all.len() {
            return Reference { span: number as u32, t: span.t_at(s) };
        }
        s -= span.length();
    }
    Reference::default()
}

fn position(all: &[Span<f64, f64>], s: f64) -> V {
    let Reference { span, t } = place(all, s);
    all[span as usize].position(t)
}

/// Derivative of half the squared distance from `p`, and the distance, at t: computed from powers of t, without the kernel.
fn slope(span: &Span<f64, f64>, p: V, t: f64) -> (f64, f64) {
    let (mut x, mut v) = ([0.0; 4], [0.0; 4]);
    for (k, c) in span.coefficients.iter().enumerate() {
        for lane in 0..4 {
            x[lane] += c[lane] * t.powi(k as i32);
            v[lane] += if k == 0 { 0.0 } else { k as f64 * c[lane] * t.powi(k as i32 - 1) };
        }
    }
    let place: V = core::array::from_fn(|k| x[k] / x[3]);
    let rate: V = core::array::from_fn(|k| (v[k] - place[k] * v[3]) / x[3]);
    let local = sub(p, span.origin);
    let off = sub(place, local);
    (dot(&off, &rate), norm(off))
}

/// Distance from `p` at the minimum nearest to `t`, by bisection: the nearest change from − to +.
fn by_bisection(span: &Span<f64, f64>, p: V, t: f64) -> Option<f64> {
    let mut reach = 1e-7;
    while reach < 0.3 {
        let (mut low, mut high) = (t - reach, t + reach);
        if slope(span, p, low).0 < 0.0 && slope(span, p, high).0 > 0.0 {
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                if slope(span, p, middle).0 < 0.0 { low = middle } else { high = middle }
            }
            return Some(slope(span, p, 0.5 * (low + high)).1);
        }
        reach *= 2.0;
    }
    None
}

/// Magnitude between 10^low and 10^high mm, in any direction.
fn away(random: &mut Noise, low: f64, high: f64) -> V {
    let direction = random.vector(1.0);
    let size = 10f64.powf(random.range(low, high)) / norm(direction).max(1e-3);
    direction.map(|x| x * size)
}
