//! The plugin's dynamic correction at a reversal, and its effect on the contour error.

use super::{Report, ReversalReport, Section};
use maud::html;
use trueaxis_report::{
    Colour, Figure, Mark, Scale, Stroke, colour, decimate,
    number::{decimals, quantity},
    side_by_side,
};
use trueaxis_sim::run::Kind;

/// Buckets of a curve over half the page.
const BUCKETS: usize = 420;

/// Legend text, colour, points.
type Curve = (&'static str, Colour, Vec<[f64; 2]>);

pub(super) fn section(report: &Report) -> Option<Section> {
    if report.reversals.is_empty() {
        return None;
    }
    let figures = report.reversals.iter().flat_map(|reversal| [parts(reversal), errors(reversal)]);
    let content = html! {
        p {
            "For each axis, the reversal with the largest contour error of the corrected run. Left: the dynamic correction \
             that is added to the command with everything on. Right: its effect on the contour error."
        }
        (side_by_side(figures))
    };
    Some(Section { heading: "Dynamic correction at reversals", content })
}

fn parts(reversal: &ReversalReport) -> Figure {
    let unit = if reversal.rotary { "µrad" } else { "µm" };
    let curves = [
        ("sent", colour::NEUTRAL, &reversal.sent),
        ("friction, lag, acceleration", colour::UNCOMPENSATED, &reversal.feed_forward),
        ("contour feedback", colour::FULL, &reversal.feedback),
        ("cross-talk", colour::LIMIT, &reversal.crosstalk),
    ];
    // Leaves out a part that the machine does not have.
    let acts = |points: &[[f64; 2]]| points.iter().any(|point| point[1] != 0.0);
    let curves = curves.map(|(name, colour, points)| {
        (name, colour, if acts(points) { decimate(points, BUCKETS) } else { Vec::new() })
    });
    let name = format!("{} dynamic correction in {unit}", reversal.axis);
    figure(reversal, &name, curves.into())
}

fn errors(reversal: &ReversalReport) -> Figure {
    let curves = vec![
        (Kind::Compensated.words(), colour::COMPENSATED, decimate(&reversal.compensated_um, BUCKETS)),
        (Kind::Full.words(), colour::FULL, decimate(&reversal.full_um, BUCKETS)),
    ];
    figure(reversal, "contour error in µm", curves)
}

fn figure(reversal: &ReversalReport, name: &str, curves: Vec<Curve>) -> Figure {
    let points = || curves.iter().flat_map(|(.., points)| points);
    let x = Scale::linear("time after the reversal in ms", points().map(|point| point[0]));
    let y = Scale::linear(name, points().map(|point| point[1]).chain([0.0])).margin(0.06);
    let largest = points().map(|point| point[1].abs()).fold(0.0, f64::max);
    let mut figure = Figure::half(&format!("{name} around a reversal of {}", reversal.axis), 250, x, y);
    figure.mark(Mark { x: 0.0, text: format!("{} turns", reversal.axis), colour: colour::NOMINAL, dashed: true });
    for (name, colour, points) in curves.into_iter().filter(|(.., points)| !points.is_empty()) {
        figure.curve(name, points, Stroke::new(colour, 1.3));
    }
    let unit = if reversal.rotary && name.contains("µrad") { "µrad" } else { "µm" };
    let time = decimals(if reversal.time_s.is_finite() { reversal.time_s } else { 0.0 }, 3);
    figure.caption(format!(
        "{} turns at {time} s, program line {}; largest {}.",
        reversal.axis,
        reversal.line,
        quantity(largest, unit)
    ));
    figure
}
