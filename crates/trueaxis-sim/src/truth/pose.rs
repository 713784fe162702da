//! True error of tip and direction for a program with rotary axes, in workpiece coordinates.

use crate::placement::{Place, Placement};
use crate::program::{Curve, Move, Program};
use glam::DVec3;

/// Length (mm or degrees) around the reference in which the foot is searched.
const WINDOW: f64 = 1.0;
/// Samples over the window that provide the start of the search where the tip's path is curved.
const SAMPLES: usize = 8;
/// A tip that moves less than this per degree of the rotary axes counts as at rest, mm.
const AT_REST_MM_PER_DEG: f64 = 0.02;
/// For a tip at rest, direction counts like the tip at this distance from the pivot, mm.
const LEVER_MM: f64 = 50.0;
/// Halvings (by 0.618) of the golden section.
const SECTIONS: u32 = 45;

/// Deviation of a tool from the programmed path.
#[derive(Clone, Copy, Debug)]
pub struct PoseDeviation {
    /// Vector from the foot to the actual tip, mm in workpiece coordinates.
    pub tip: DVec3,
    /// Angle between the actual direction of the tool and the programmed one at the foot, rad.
    pub angle: f64,
    /// The tip is at rest there: only the direction determines where on the path the tool is.
    at_rest: bool,
}

impl PoseDeviation {
    fn new(actual: &Place, nominal: &Place, at_rest: bool) -> PoseDeviation {
        let (a, b) = (actual.direction, nominal.direction);
        // acos would not resolve angles below 1e-8 rad.
        PoseDeviation { tip: actual.tip - nominal.tip, angle: libm::atan2(a.cross(b).length(), a.dot(b)), at_rest }
    }

    /// Square of tip and direction error combined, mm².
    fn whole(&self) -> f64 {
        self.tip.length_squared() + (LEVER_MM * self.angle) * (LEVER_MM * self.angle)
    }

    fn is_nearer(&self, other: &PoseDeviation) -> bool {
        if self.at_rest || other.at_rest {
            self.whole() < other.whole()
        } else {
            self.tip.length_squared() < other.tip.length_squared()
        }
    }
}

/// Deviation of `actual` from the path near the reference: the interpolator's move and parameter.
///
/// The foot is the nearest point of the tip's path p(u); where rotary axes turn and the tip is at rest, the nearest direction.
/// Moves within a millimetre (degree) before and after the reference's count too.
pub fn deviation(program: &Program, machine: &Placement, (index, u): (usize, f64), actual: &Place) -> PoseDeviation {
    let nothing = PoseDeviation { tip: DVec3::INFINITY, angle: f64::NAN, at_rest: false };
    let Some(here) = program.moves.get(index) else { return nothing };
    let mut best = foot(here, machine, u, actual);
    let mut consider = |step: &Move, u: f64| {
        let found = foot(step, machine, u, actual);
        if found.is_nearer(&best) {
            best = found;
        }
    };
    let share = here.share(u);
    let mut way = share * here.length();
    for step in program.moves.iter().take(index).rev() {
        if way >= WINDOW {
            break;
        }
        consider(step, step.curve.domain().1);
        way += step.length();
    }
    let mut way = (1.0 - share) * here.length();
    for step in program.moves.iter().skip(index + 1) {
        if way >= WINDOW {
            break;
        }
        consider(step, step.curve.domain().0);
        way += step.length();
    }
    best
}

/// The foot on one move near parameter `u`.
fn foot(step: &Move, machine: &Placement, u: f64, actual: &Place) -> PoseDeviation {
    let (first, last) = step.curve.domain();
    let reach = (last - first) * (WINDOW / step.length()).min(1.0);
    let (low, high) = ((u - reach).max(first), (u + reach).min(last));
    let at = |u: f64, at_rest| PoseDeviation::new(actual, &machine.place(step, u), at_rest);
    let speed = machine.tip_velocity(step, u).length() * (last - first);
    if speed < AT_REST_MM_PER_DEG * step.turn.angle() {
        return at(golden(low, high, |u| at(u, true).whole()), true);
    }
    if let (Curve::Line { .. }, true) = (&step.curve, step.keeps_its_curve()) {
        let [a, b] = [first, last].map(|u| machine.place(step, u).tip);
        let t = (actual.tip - a).dot(b - a) / (b - a).length_squared();
        return at(first + (last - first) * t.clamp(0.0, 1.0), false);
    }
    at(bent_foot(step, machine, [low, high], u, actual.tip), false)
}

/// Newton's method on (p(u) − actual)·p'(u) from the best of some samples; derivatives by central differences.
fn bent_foot(step: &Move, machine: &Placement, [low, high]: [f64; 2], u: f64, actual: DVec3) -> f64 {
    let offset = |u: f64| machine.place(step, u).tip - actual;
    let samples = (0..=SAMPLES).map(|i| low + (high - low) * i as f64 / SAMPLES as f64).chain([u]);
    let distances = samples.map(|u| (u, offset(u).length_squared()));
    let start = distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(u, |(u, _)| u);
    let (first, last) = step.curve.domain();
    let h = 1.0e-4 * (last - first);
    let mut at = start;
    for _ in 0..12 {
        let (before, here, after) = (offset(at - h), offset(at), offset(at + h));
        let (d1, d2) = ((after - before) / (2.0 * h), (before - 2.0 * here + after) / (h * h));
        let curvature = d1.length_squared() + here.dot(d2);
        // Where the distance is not convex, a step with the tangent's slope alone still descends.
        let slope = if curvature > 0.1 * d1.length_squared() { curvature } else { d1.length_squared() };
        let next = (at - here.dot(d1) / slope).clamp(low, high);
        let small = (next - at).abs() < 1e-12 * (last - first);
        at = next;
        if small {
            break;
        }
    }
    if offset(at).length_squared() <= offset(start).length_squared() { at } else { start }
}

/// Argument of the minimum of `f` between `low` and `high`.
fn golden(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_left, mut at_right) = (f(left), f(right));
    for _ in 0..SECTIONS {
        if at_left < at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - ratio * (high - low);
            at_left = f(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + ratio * (high - low);
            at_right = f(right);
        }
    }
    0.5 * (low + high)
}
