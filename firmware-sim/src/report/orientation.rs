//! Orientation error and positions of the rotary axes over the path.

use super::{Report, Section, contour::BUCKETS};
use maud::html;
use trueaxis_report::{Colour, Figure, Scale, Stroke, colour, decimate, number::quantity};
use trueaxis_sim::run::Kind;

const LENGTH: &str = "path length in mm (in degrees where nothing but rotary axes moves)";

/// A curve: legend text, colour, points.
type Curve = (String, Colour, Vec<[f64; 2]>);

pub(super) fn section(report: &Report) -> Option<Section> {
    let series = &report.orientation;
    let runs = [
        (Kind::Uncompensated.words(), colour::UNCOMPENSATED, &series.uncompensated),
        (Kind::Compensated.words(), colour::COMPENSATED, &series.compensated),
        (Kind::ServoOnly.words(), colour::SERVO, &series.servo_only),
        (Kind::Full.words(), colour::FULL, &series.full),
    ];
    let error: Vec<Curve> = (runs.into_iter())
        .map(|(name, colour, points)| (name, colour, decimate(points, BUCKETS)))
        .filter(|(.., points)| !points.is_empty())
        .map(|(name, colour, points)| {
            let largest = points.iter().map(|point| point[1]).fold(0.0, f64::max);
            (format!("{name}: largest {}", quantity(largest, "µrad")), colour, points)
        })
        .collect();
    if error.is_empty() {
        return None;
    }
    let rotary: Vec<Curve> = (series.rotary.iter().zip(colour::ROTARY))
        .map(|((name, points), colour)| (name.clone(), colour, decimate(points, BUCKETS)))
        .filter(|(.., points)| !points.is_empty())
        .collect();
    let angle = Scale::from_zero("orientation error in µrad", values(&error));
    let caption = "Angle between the true tool direction and the programmed one at the foot point of the tip.";
    let position = Scale::linear("position in degrees", values(&rotary)).margin(0.04);
    let content = html! {
        (figure(report, &error, angle, caption))
        @if !rotary.is_empty() { (figure(report, &rotary, position, "Commanded positions of the rotary axes.")) }
    };
    Some(Section { heading: "Tool direction over the path", content })
}

fn values(curves: &[Curve]) -> impl Iterator<Item = f64> {
    curves.iter().flat_map(|(.., points)| points.iter().map(|point| point[1]))
}

fn figure(report: &Report, curves: &[Curve], y: Scale, caption: &str) -> Figure {
    let lengths = curves.iter().flat_map(|(.., points)| points.iter().map(|point| point[0]));
    let mut figure = Figure::full(caption, 230, Scale::linear(LENGTH, lengths), y);
    for (_, colour, points) in curves.iter().rev() {
        figure.interrupted(points, &report.contour.breaks, Stroke::new(*colour, 1.2).opacity(0.85));
    }
    for (text, colour, _) in curves {
        figure.key(text, Stroke::new(*colour, 1.2));
    }
    figure.caption(caption);
    figure
}
