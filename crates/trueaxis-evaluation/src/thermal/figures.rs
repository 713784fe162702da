//! Figures of a fit: measured drift, drift computed by the task, and residual.

use super::FittedRecording;
use trueaxis::Axis;
use trueaxis_metrology::thermal::Series;
use trueaxis_report::{Figure, Scale, Stroke, colour};

/// The series of an axis in the held-out cycles at the measuring point that drifts most.
pub fn worst(found: &FittedRecording, axis: Axis) -> Option<&Series> {
    let own = found.series.iter().filter(|own| own.axis == axis && found.fit.held_out.contains(&own.cycle));
    let most = |rows: &[[f64; 3]]| rows.iter().fold(0.0_f64, |most, row| most.max(row[1].abs()));
    own.max_by(|one, other| most(&one.rows).total_cmp(&most(&other.rows)))
}

/// Drift of that series, measured and computed by the task.
pub fn figure(found: &FittedRecording, axis: Axis) -> Option<Figure> {
    let series = worst(found, axis)?;
    let hours = |take: fn(&[f64; 3]) -> f64| -> Vec<[f64; 2]> {
        series.rows.iter().map(|row| [row[0] / 3600.0, 1e3 * take(row)]).collect()
    };
    let (measured, said, left) = (hours(|row| row[1]), hours(|row| row[2]), hours(|row| row[1] - row[2]));
    let values = measured.iter().chain(&said).chain(&left).map(|point| point[1]);
    let x = Scale::linear("hours since the cycle began", measured.iter().map(|point| point[0]));
    let y = Scale::linear("drift in µm", values.chain([0.0]).collect::<Vec<_>>()).margin(0.05);
    let [px, py, pz, tool] = series.point_mm;
    let letter = axis.letter();
    let mut figure = Figure::full(&format!("drift of {letter} in a held-out cycle"), 240, x, y);
    figure
        .curve("measured", measured, Stroke::new(colour::UNCOMPENSATED, 1.4))
        .curve("by the task", said, Stroke::new(colour::COMPENSATED, 1.4))
        .curve("left", left, Stroke::new(colour::SERVO, 1.2))
        .caption(format!(
            "E{letter} in cycle {}, which took no part in the fit, at X {px}, Y {py}, Z {pz}, tool {tool} mm.",
            series.cycle
        ));
    Some(figure)
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
        .dots(held_out, colour::SERVO)
        .caption(format!("Residuals of E{letter} at every measuring point; green: held-out cycles."));
    figure
}
