//! Figures of a circular test.

use super::Test;
use trueaxis_report::{Figure, PolarTrace, colour, polar_traces};

const WAYS: [(bool, &str, trueaxis_report::Colour); 2] =
    [(true, "counterclockwise", colour::COMPENSATED), (false, "clockwise", colour::UNCOMPENSATED)];

/// Deviation of the radius about the centre that was found, both directions.
pub fn polar(test: &Test) -> Figure {
    traces(test, 0, "Deviation of the radius, seen from the circle's centre.")
}

/// What the causes leave.
pub fn left(test: &Test) -> Figure {
    traces(test, 1, "What the causes leave of it.")
}

fn traces(test: &Test, part: usize, caption: &str) -> Figure {
    let traces: Vec<PolarTrace<'_>> = WAYS
        .into_iter()
        .map(|(counterclockwise, name, colour)| {
            let own = test.readings.iter().zip(&test.found.centred);
            let own = own.filter(|(reading, _)| reading.counterclockwise == counterclockwise);
            let points = own.map(|(reading, deviation)| [reading.angle_rad, 1e3 * deviation[part]]).collect();
            PolarTrace { name, colour, points }
        })
        .filter(|trace| !trace.points.is_empty())
        .collect();
    polar_traces("Polar plot of the circular test", &traces, caption)
}
