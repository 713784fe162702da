//! Circles that a program approximates by chords.

use super::circle::Circle;
use glam::{DVec2, DVec3};
use trueaxis_metrology::circles::least_squares;

/// Largest angle of a chord, rad, and largest distance between it and its arc, mm: a polygon turns more or is farther away.
pub(super) const MOST_TURN: f64 = 0.53;
const MOST_HEIGHT: f64 = 0.1;
/// Fewest ends of chords: three are on a circle wherever they are.
pub(super) const FEWEST: usize = 5;

/// The circle on which the ends of chords are, and the angle that they cover, rad.
pub(super) struct Chords {
    pub(super) circle: Circle,
    pub(super) angle: f64,
}

/// The circle of chords with these ends, in the order of the program, if all are within `near` of it and of one level.
pub(super) fn circle_of_chords(ends: &[DVec3], normal: DVec3, near: f64) -> Option<Chords> {
    let first = *ends.first().filter(|_| ends.len() >= FEWEST)?;
    let along = normal.any_orthonormal_vector();
    let across = normal.cross(along);
    if ends.iter().any(|end| (*end - first).dot(normal).abs() > near) {
        return None;
    }
    let flat = |end: &DVec3| DVec2::new((*end - first).dot(along), (*end - first).dot(across));
    let flat: Vec<DVec2> = ends.iter().map(flat).collect();
    // The last end of a full turn is the first.
    let once = if flat[0].distance(flat[flat.len() - 1]) <= near { &flat[1..] } else { &flat[..] };
    let circle = least_squares(&once.iter().map(|end| end.to_array()).collect::<Vec<_>>()).ok()?;
    let (centre, radius) = (DVec2::from(circle.centre), circle.radius);
    if circle.outer - radius > near || radius - circle.inner > near {
        return None;
    }
    let turns: Vec<f64> = flat.windows(2).map(|pair| (pair[0] - centre).angle_to(pair[1] - centre)).collect();
    let is_chord = |turn: &f64| {
        turn.abs() <= MOST_TURN && turn * turns[0] > 0.0 && radius * (1.0 - (0.5 * turn).cos()) <= MOST_HEIGHT
    };
    let centre = first + centre.x * along + centre.y * across;
    turns
        .iter()
        .all(is_chord)
        .then(|| Chords { circle: Circle { centre, radius }, angle: turns.iter().sum::<f64>().abs() })
}
