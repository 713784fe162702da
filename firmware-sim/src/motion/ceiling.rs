//! How fast each part of the path may be run: feed, curvature and corners.

use glam::DVec3;

use super::MotionSettings;
use crate::program::{Curve, Move};

/// Ratio of neighbouring speed levels on curves of changing curvature. Finer levels follow the curvature more closely,
/// but the acceleration returns to zero at each change of level.
const LEVEL_RATIO: f64 = 1.25;

/// Samples for the curvature per smooth piece of a NURBS.
const SAMPLES: u32 = 64;

/// Smallest speed a curvature can ask for, mm/s: a cusp is passed at this speed.
const SLOWEST: f64 = 0.1;

/// A stretch of the path with one speed limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Section {
    /// mm.
    pub(super) length: f64,
    /// mm/s.
    pub(super) ceiling: f64,
    /// Highest speed at its end because of a corner or a full stop, mm/s.
    pub(super) end_limit: f64,
}

/// Appends the sections of one move of the given length (mm).
///
/// v = min(feed, √(a_n ρ)), ρ the radius of curvature. On a NURBS it is taken at samples, each interval gets the lower
/// of its ends, rounded down to a level feed / 1.25^n, and intervals of one level are one section.
pub(super) fn add_sections(element: &Move, length: f64, settings: &MotionSettings, sections: &mut Vec<Section>) {
    let feed = if element.rapid { settings.rapid_mm_per_min } else { element.feed_mm_per_min } / 60.0;
    let limit = |u: f64| {
        let curvature = element.curve.curvature(u);
        (settings.normal_acceleration / curvature).sqrt().max(SLOWEST.min(feed)).min(feed)
    };
    let first = sections.len();
    let mut add = |length: f64, ceiling: f64| match sections.get_mut(first..).and_then(<[Section]>::last_mut) {
        Some(section) if section.ceiling == ceiling => section.length += length,
        _ => sections.push(Section { length, ceiling, end_limit: f64::INFINITY }),
    };
    match &element.curve {
        Curve::Line { .. } => add(length, feed),
        // The curvature of an arc or helix changes by the permitted mismatch of its radii only.
        Curve::Arc { .. } => add(length, limit(0.0).min(limit(1.0))),
        Curve::Nurbs { .. } => {
            for piece in element.curve.breaks().windows(2) {
                let step = (piece[1] - piece[0]) / f64::from(SAMPLES);
                let inside = 1.0e-9 * step;
                for i in 0..SAMPLES {
                    let a = piece[0] + f64::from(i) * step;
                    let b = if i + 1 == SAMPLES { piece[1] } else { a + step };
                    let lowest = limit(a).min(limit(0.5 * (a + b))).min(limit(b - inside));
                    let level = ((feed / lowest).ln() / LEVEL_RATIO.ln() - 1.0e-9).ceil().max(0.0);
                    add(element.curve.length_between(a, b), feed / LEVEL_RATIO.powf(level));
                }
            }
        }
    }
}

/// Highest speed from one move to the next: the step of the velocity vector v |t₁ − t₀| stays within the permitted
/// one; a turn of more than 90° is a full stop.
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
