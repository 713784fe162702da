//! The figure of the residuals of a fit.

use super::FittedRecording;
use trueaxis::Axis;
use trueaxis_metrology::thermal::Series;
use trueaxis_report::{Figure, Scale, colour};

/// The series of an axis in the held-out cycles at the measuring point that drifts most.
pub(super) fn worst(found: &FittedRecording, axis: Axis) -> Option<&Series> {
    let own = found.series.iter().filter(|own| own.axis == axis && found.fit.held_out.contains(&own.cycle));
    let most = |rows: &[[f64; 3]]| rows.iter().fold(0.0_f64, |most, row| most.max(row[1].abs()));
    own.max_by(|one, other| most(&one.rows).total_cmp(&most(&other.rows)))
}

/// Residuals of an axis at all measuring points of all cycles, over the time of the cycle.
pub fn residuals(found: &FittedRecording, axis: Axis) -> Figure {
    let points = |held_out: bool| -> Vec<[f64; 2]> {
        let own = found.series.iter();
        let own = own.filter(|own| own.axis == axis && found.fit.held_out.contains(&own.cycle) == held_out);
        own.flat_map(|own| &own.rows).map(|row| [row[0] / 3600.0, 1e3 * (row[1] - row[2])]).collect()
    };
    let (fitted, held_out) = (points(false), points(true));
    let all = || fitted.iter().chain(&held_out);
    let x = Scale::linear("hours since the cycle began", all().map(|point| point[0]));
    let y = Scale::symmetric("left in µm", all().map(|point| point[1]));
    let letter = axis.letter();
    let mut figure = Figure::full(&format!("residuals of {letter}"), 200, x, y);
    figure
        .dots(fitted, colour::GREY)
        .dots(held_out, colour::FULL)
        .area_key("cycles of the fit", colour::GREY)
        .area_key("held-out cycles", colour::FULL)
        .caption(format!("Residuals of E{letter} at every measuring point."));
    figure
}
