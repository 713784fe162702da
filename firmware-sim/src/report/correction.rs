//! Correction of each axis and its slope over time, with their limits.

use super::{AxisReport, Report, Section};
use maud::{Markup, Render, html};
use trueaxis_report::{
    Figure, Scale, Stroke, colour, decimate, missing,
    number::{drawable, quantity},
    side_by_side,
};

/// A limit is drawn only if it is at most this many times the largest value; a larger one would flatten the curve.
const WITHIN: f64 = 2.5;
/// Buckets of a curve over half the page.
const BUCKETS: usize = 420;

pub(super) fn section(report: &Report) -> Option<Section> {
    if report.axes.is_empty() {
        return None;
    }
    let content = html! { @for axis in &report.axes { (figures(axis)) } };
    Some(Section { heading: "Correction of each axis", content })
}

fn figures(axis: &AxisReport) -> Markup {
    let [magnitude, slope] = if axis.rotary { ["µrad", "mrad/s"] } else { ["µm", "mm/s"] };
    side_by_side([
        over_time(&axis.name, "correction", magnitude, &axis.correction, axis.magnitude_limit),
        over_time(&axis.name, "slope", slope, &axis.slope, axis.slope_limit),
    ])
}

fn over_time(axis: &str, quantity_name: &str, unit: &str, series: &[[f64; 2]], limit: f64) -> Markup {
    let points = decimate(series, BUCKETS);
    if points.is_empty() {
        return missing(format!("{axis}: no {quantity_name} was recorded."));
    }
    let values = || points.iter().map(|point| point[1]);
    let largest = values().map(f64::abs).fold(0.0, f64::max);
    let drawn = drawable(limit) && limit > 0.0 && limit <= WITHIN * largest;
    let limits = if drawn { vec![-limit, limit] } else { Vec::new() };
    let x = Scale::linear("time in s", points.iter().map(|point| point[0]));
    let caption = format!("{axis} {quantity_name} in {unit}");
    let y = Scale::linear(&caption, values().chain(limits.iter().copied()).chain([0.0])).margin(0.06);
    let mut figure = Figure::half(&format!("{quantity_name} of {axis} over time"), 230, x, y);
    for limit in limits {
        figure.across(limit, colour::LIMIT);
    }
    figure.curve(format!("{axis} {quantity_name}"), points.iter().copied(), Stroke::new(colour::NEUTRAL, 1.3));
    let limit_text = format!("limit ±{}", quantity(limit, unit));
    if drawn {
        figure.key(&limit_text, Stroke::new(colour::LIMIT, 1.2).dashed());
    }
    let stated = if !limit.is_finite() {
        "no limit".to_owned()
    } else if drawn {
        limit_text
    } else {
        format!("{limit_text}, outside the figure")
    };
    figure.caption(format!("Largest {}; {stated}.", quantity(largest, unit)));
    figure.render()
}
