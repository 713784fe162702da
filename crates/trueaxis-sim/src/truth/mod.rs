//! The true contour error: distance of a point from the programmed path, computed without the plugin.
//!
//! The curves are those of the program: direct projection on lines, Newton steps on arcs, and Newton steps from a sampled
//! start on all others. It is slow and simple, because it is the reference for the plugin's search. For programs with rotary
//! axes see [`pose`].

pub mod pose;

use crate::program::{Curve, Polar, Program};
use glam::DVec3;

/// Arc length around the reference in which the foot is searched, mm; far above the lag of the servo.
const WINDOW_MM: f64 = 1.0;
/// Samples over the window that provide the start of the search on a free-form curve.
const SAMPLES: usize = 16;

/// Computes deviations along a program; keeps data shared by the cycles of a move.
#[derive(Clone, Debug, Default)]
pub struct Truth {
    held: Option<Held>,
}

/// The move that the reference is on.
#[derive(Clone, Copy, Debug)]
struct Held {
    index: usize,
    polar: Option<Polar>,
    /// First and last point of the move.
    ends: [DVec3; 2],
}

impl Truth {
    /// Vector from the nearest point of the path, near the reference, to `point`.
    ///
    /// `reference` is the interpolator's move and parameter, `here` that point in the program's coordinates; neighbouring
    /// moves count as far as the window reaches, so that a tool behind a corner is not measured against the wrong side of it.
    pub fn deviation(
        &mut self,
        program: &Program,
        origin: DVec3,
        (index, u): (usize, f64),
        here: DVec3,
        point: DVec3,
    ) -> DVec3 {
        let point = point - origin;
        let mut best = DVec3::INFINITY;
        let Some(step) = program.moves.get(index) else { return best };
        let held = match self.held {
            Some(held) if held.index == index => held,
            _ => *self.held.insert(Held::new(index, &step.curve)),
        };
        let mut consider = |curve: &Curve, polar: Option<&Polar>, u: f64| {
            let found = point - foot(curve, polar, u, point);
            if found.length_squared() < best.length_squared() {
                best = found;
            }
        };
        consider(&step.curve, held.polar.as_ref(), u);
        let [first, last] = held.ends;
        if here.distance(first) < WINDOW_MM
            && let Some(before) = index.checked_sub(1).and_then(|before| program.moves.get(before))
        {
            consider(&before.curve, before.curve.polar().as_ref(), before.curve.domain().1);
        }
        if here.distance(last) < WINDOW_MM
            && let Some(after) = program.moves.get(index + 1)
        {
            consider(&after.curve, after.curve.polar().as_ref(), after.curve.domain().0);
        }
        best
    }
}

impl Held {
    fn new(index: usize, curve: &Curve) -> Held {
        let polar = curve.polar();
        let (first, last) = curve.domain();
        Held { index, polar, ends: [first, last].map(|u| curve.point_by(polar.as_ref(), u)) }
    }
}

/// Nearest point of one curve near parameter `u`.
fn foot(curve: &Curve, polar: Option<&Polar>, u: f64, point: DVec3) -> DVec3 {
    let (first, last) = curve.domain();
    if let Curve::Line { start, end } = curve {
        let (a, b) = (DVec3::from(*start), DVec3::from(*end));
        let t = (point - a).dot(b - a) / (b - a).length_squared();
        return a + (b - a) * t.clamp(0.0, 1.0);
    }
    let speed = curve.vectors_by(polar, u).1.length().max(1e-9);
    let reach = (WINDOW_MM / speed).min(last - first);
    let place = |u: f64| {
        let position = curve.point_by(polar, u);
        (u, position, (position - point).length_squared())
    };
    // The distance from an arc has only one minimum in the window; that from a spline can have several.
    let start = match curve {
        Curve::Arc { .. } => place(u),
        _ => {
            let parts = (0..=SAMPLES).map(|i| u - reach + 2.0 * reach * i as f64 / SAMPLES as f64);
            let samples = parts.map(|u| u.clamp(first, last)).chain([u]).map(place);
            samples.min_by(|a, b| a.2.total_cmp(&b.2)).unwrap_or_else(|| place(u))
        }
    };
    let mut at = start.0;
    for _ in 0..30 {
        let (position, d1, d2) = curve.vectors_by(polar, at);
        let offset = position - point;
        let curvature = d1.length_squared() + offset.dot(d2);
        // Where the distance is not convex, a step with the tangent's slope alone still descends.
        let slope = if curvature > 0.1 * d1.length_squared() { curvature } else { d1.length_squared() };
        let next = (at - offset.dot(d1) / slope).clamp(first, last);
        let small = (next - at).abs() * speed < 1e-12;
        at = next;
        if small {
            break;
        }
    }
    let end = place(at);
    if end.2 <= start.2 { end.1 } else { start.1 }
}
