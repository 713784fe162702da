//! The true contour error: distance of a point from the programmed path, found without the plugin.
//!
//! Straight projections on lines and circles, Newton steps with a sampled start on everything else, on the program's own
//! curves. Slow and plain: it is what the plugin's search is judged by. Programs with rotary axes: [`pose`].

pub mod pose;

use crate::program::{Curve, Program};
use glam::DVec3;

/// Arc length around the reference in which the foot is looked for, mm; the lag of the servo is far below it.
const WINDOW_MM: f64 = 1.0;
/// Samples over the window that start the search on a free-form curve.
const SAMPLES: usize = 16;

/// Vector from the nearest point of the path, near the reference, to `point`.
///
/// `reference` is the move and its parameter that the interpolator is at; neighbouring moves count as far as the window
/// reaches, so that a tool behind a corner is not measured against the wrong side of it.
pub fn deviation(program: &Program, origin: DVec3, (index, u): (usize, f64), point: DVec3) -> DVec3 {
    let point = point - origin;
    let mut best = DVec3::INFINITY;
    let mut consider = |index: usize, u: f64| {
        let Some(step) = program.moves.get(index) else { return };
        let found = point - foot(&step.curve, u, point);
        if found.length_squared() < best.length_squared() {
            best = found;
        }
    };
    consider(index, u);
    let Some(step) = program.moves.get(index) else { return best };
    let here = DVec3::from(step.curve.position(u));
    let (first, last) = step.curve.domain();
    if here.distance(DVec3::from(step.curve.position(first))) < WINDOW_MM
        && let Some(before) = index.checked_sub(1)
    {
        let end = program.moves.get(before).map_or(0.0, |m| m.curve.domain().1);
        consider(before, end);
    }
    if here.distance(DVec3::from(step.curve.position(last))) < WINDOW_MM {
        let start = program.moves.get(index + 1).map_or(0.0, |m| m.curve.domain().0);
        consider(index + 1, start);
    }
    best
}

/// Nearest point of one curve near parameter `u`.
fn foot(curve: &Curve, u: f64, point: DVec3) -> DVec3 {
    let (first, last) = curve.domain();
    if let Curve::Line { start, end } = curve {
        let (a, b) = (DVec3::from(*start), DVec3::from(*end));
        let t = (point - a).dot(b - a) / (b - a).length_squared();
        return a + (b - a) * t.clamp(0.0, 1.0);
    }
    let speed = curve.speed(u).max(1e-9);
    let reach = (WINDOW_MM / speed).min(last - first);
    let distance = |u: f64| (DVec3::from(curve.position(u)) - point).length_squared();
    let samples = (0..=SAMPLES).map(|i| (u - reach + 2.0 * reach * i as f64 / SAMPLES as f64).clamp(first, last));
    // Around a point near a circle there is one minimum only; a spline can have several in the window.
    let start = match curve {
        Curve::Arc { .. } => u,
        _ => samples.chain([u]).min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap_or(u),
    };
    let mut at = start;
    for _ in 0..30 {
        let here = curve.derivatives(at);
        let offset = DVec3::from(here.position) - point;
        let (d1, d2) = (DVec3::from(here.first), DVec3::from(here.second));
        let curvature = d1.length_squared() + offset.dot(d2);
        // Where the distance is not convex, the tangent's own projection still goes downhill.
        let slope = if curvature > 0.1 * d1.length_squared() { curvature } else { d1.length_squared() };
        let next = (at - offset.dot(d1) / slope).clamp(first, last);
        let small = (next - at).abs() * speed < 1e-12;
        at = next;
        if small {
            break;
        }
    }
    if distance(at) <= distance(start) { DVec3::from(curve.position(at)) } else { DVec3::from(curve.position(start)) }
}
