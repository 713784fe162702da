//! Correction of each axis over time and its slope, with their limits.

use super::{
    AxisReport, Report, Section, decimate,
    figure::{Figure, Key, Scale, Stroke, colour, framed, plottable, plottable_points},
    number::{escape, significant},
};

/// A limit is drawn when it is at most this many times the largest value; further away it would flatten the curve.
const WITHIN: f64 = 2.5;

pub(super) fn section(report: &Report) -> Option<Section> {
    if report.axes.is_empty() {
        return None;
    }
    let html = report.axes.iter().map(axis).collect();
    Some(Section { heading: "Correction of each axis", html })
}

fn axis(axis: &AxisReport) -> String {
    let [magnitude, slope] = if axis.rotary { ["µrad", "mrad/s"] } else { ["µm", "mm/s"] };
    format!(
        "<div class=\"figures\">\n{}{}</div>\n",
        over_time(&axis.name, "correction", magnitude, &axis.correction, axis.magnitude_limit),
        over_time(&axis.name, "slope", slope, &axis.slope, axis.slope_limit)
    )
}

fn over_time(axis: &str, what: &str, unit: &str, series: &[[f64; 2]], limit: f64) -> String {
    let points = decimate(&plottable_points(series), 420);
    if points.is_empty() {
        return format!("<p class=\"empty\">{}: no {what} was recorded.</p>\n", escape(axis));
    }
    let values = || points.iter().map(|point| point[1]);
    let largest = values().map(f64::abs).fold(0.0, f64::max);
    let drawn = plottable(limit) && limit > 0.0 && limit <= WITHIN * largest;
    let both = [-limit, limit];
    let limits = if drawn { both.as_slice() } else { &[] };
    let figure = Figure {
        description: format!("{what} of {axis} over time"),
        width: 550,
        height: 230,
        x: Scale::linear("time in s", points.iter().map(|point| point[0]), 0.0, 8),
        y: Scale::linear(
            &format!("{axis} {what} in {unit}"),
            values().chain(limits.iter().copied()).chain([0.0]),
            0.06,
            6,
        ),
        head: 0,
        marks: Vec::new(),
    };
    let svg = figure.draw(|plot| {
        for &limit in limits {
            plot.across(limit, Stroke::new(colour::LIMIT, 1.2))?;
        }
        plot.line(points.iter().copied(), Stroke::new(colour::NEUTRAL, 1.3))
    });
    let name = format!("{axis} {what}");
    let mut keys = vec![Key { colour: colour::NEUTRAL, dashed: false, text: &name }];
    let limit_text = format!("limit ±{} {unit}", significant(limit, 3));
    if drawn {
        keys.push(Key { colour: colour::LIMIT, dashed: true, text: &limit_text });
    }
    let caption = format!(
        "Largest {} {unit}; {}.",
        significant(largest, 3),
        if !limit.is_finite() {
            "no limit".to_owned()
        } else if drawn {
            limit_text.clone()
        } else {
            format!("{limit_text}, outside the figure")
        }
    );
    framed("half", &keys, &svg, &caption)
}
