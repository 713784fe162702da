//! Speed limits along the path: feed, curvature and corners.

use glam::DVec3;

use super::MotionSettings;
use crate::placement::Placement;
use crate::program::{Curve, Move};

/// Ratio of neighbouring speed levels on curves of changing curvature. Finer levels follow the curvature more closely,
/// but the acceleration returns to zero at each change of level.
const LEVEL_RATIO: f64 = 1.25;

/// Samples for the curvature per smooth part of a NURBS.
const SAMPLES: u32 = 64;

/// Lowest speed that a curvature can require, mm/s: a cusp is passed at this speed.
const SLOWEST: f64 = 0.1;

/// A stretch of the path with one speed limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Section {
    /// mm.
    pub(super) length: f64,
    /// mm/s.
    pub(super) ceiling: f64,
    /// Highest speed at the end of the section because of a corner or a full stop, mm/s.
    pub(super) end_limit: f64,
}

/// Largest rotation of the rotary axes between two samples of the axes' speeds, degrees, and most samples in one move.
const SAMPLE_EVERY_DEG: f64 = 2.0;
const MOST_SAMPLES: f64 = 64.0;

/// Appends the sections of one move of the given length (mm).
///
/// v = min(feed, √(a_n ρ)), ρ the radius of curvature. A NURBS is sampled: each interval gets the lower of its ends' speeds,
/// rounded down to a level feed / 1.25^n, and intervals of one level form one section. Moves that turn rotary axes are treated
/// likewise, with the speeds that the axes themselves permit.
pub(super) fn add_sections(
    element: &Move,
    length: f64,
    settings: &MotionSettings,
    machine: Option<&Placement>,
    sections: &mut Vec<Section>,
) {
    let feed = settings.speed(element);
    let limit = |u: f64| {
        let curvature = element.curve.curvature(u);
        (settings.normal_acceleration_mm_per_s2 / curvature).sqrt().max(SLOWEST.min(feed)).min(feed)
    };
    let first = sections.len();
    let mut add = |length: f64, ceiling: f64| match sections.get_mut(first..).and_then(<[Section]>::last_mut) {
        Some(section) if section.ceiling == ceiling => section.length += length,
        _ => sections.push(Section { length, ceiling, end_limit: f64::INFINITY }),
    };
    let level = |lowest: f64| {
        let level = (libm::log(feed / lowest) / libm::log(LEVEL_RATIO) - 1.0e-9).ceil().max(0.0);
        feed / libm::pow(LEVEL_RATIO, level)
    };
    if let Some(machine) = machine
        && element.turn.angle() > 0.0
    {
        let (first, last) = element.curve.domain();
        let samples = (element.turn.angle() / SAMPLE_EVERY_DEG).clamp(1.0, MOST_SAMPLES).ceil();
        let step = (last - first) / samples;
        let permitted = |u: f64| {
            let across = if element.curve.length() > 0.0 && !element.in_degrees() { limit(u) } else { feed };
            across.min(axes_speed(element, machine, settings, u)).max(SLOWEST.min(feed))
        };
        for i in 0..samples as u32 {
            let a = first + f64::from(i) * step;
            add(length / samples, level(permitted(a).min(permitted(a + 0.5 * step)).min(permitted(a + step))));
        }
        return;
    }
    match &element.curve {
        Curve::Line { .. } => add(length, feed),
        // The curvature of an arc or helix changes only by the permitted mismatch of its radii.
        Curve::Arc { .. } => add(length, limit(0.0).min(limit(1.0))),
        Curve::Nurbs { .. } => {
            for piece in element.curve.breaks().windows(2) {
                let step = (piece[1] - piece[0]) / f64::from(SAMPLES);
                let inside = 1.0e-9 * step;
                for i in 0..SAMPLES {
                    let a = piece[0] + f64::from(i) * step;
                    let b = if i + 1 == SAMPLES { piece[1] } else { a + step };
                    let lowest = limit(a).min(limit(0.5 * (a + b))).min(limit(b - inside));
                    add(element.curve.length_between(a, b), level(lowest));
                }
            }
        }
    }
}

/// Speed along a turning move at which no axis exceeds its highest feed, and X, Y, Z, following the tool centre point, stay
/// within the permitted acceleration across the path.
fn axes_speed(element: &Move, machine: &Placement, settings: &MotionSettings, u: f64) -> f64 {
    let rates = machine.rates(element, u);
    let own = rates.linear.to_array().into_iter().chain(rates.rotary.to_array());
    let speeds = own.zip(machine.max_feed_per_s()).map(|(rate, feed)| feed / rate.abs());
    speeds.fold((settings.normal_acceleration_mm_per_s2 / rates.bend.length()).sqrt(), f64::min)
}

/// [`corner_speed`] for the axes: neither the velocity of X, Y, Z (mm/s) nor that of A, B, C (deg/s) steps by more.
pub(super) fn corner_speed_of_axes(before: &Move, after: &Move, machine: &Placement, step_per_s: f64) -> f64 {
    let (leaving, entering) =
        (machine.rates(before, before.curve.domain().1), machine.rates(after, after.curve.domain().0));
    if leaving.linear.dot(entering.linear) + leaving.rotary.dot(entering.rotary) < -1.0e-9 {
        return 0.0;
    }
    let change = (entering.linear - leaving.linear).length().max((entering.rotary - leaving.rotary).length());
    if change > 0.0 { step_per_s / change } else { f64::INFINITY }
}

/// Highest speed from one move to the next: the step of the velocity vector v |t₁ − t₀| stays within the permitted one; a turn
/// of more than 90° requires a full stop.
pub(super) fn corner_speed(before: &Curve, after: &Curve, step_mm_per_s: f64) -> f64 {
    let (leaving, entering) = (tangent(before, before.domain().1), tangent(after, after.domain().0));
    if leaving.dot(entering) < -1.0e-9 {
        return 0.0;
    }
    let change = (entering - leaving).length();
    if change > 0.0 { step_mm_per_s / change } else { f64::INFINITY }
}

/// Unit tangent; zero where the derivative vanishes.
fn tangent(curve: &Curve, u: f64) -> DVec3 {
    curve.vectors(u).1.normalize_or_zero()
}
