//! A circle plotted as by a ballbar.

use super::{CircleReport, Report, Section};
use maud::html;
use trueaxis_report::{Colour, Figure, PolarTrace, colour, decimate, number::quantity, polar_traces, side_by_side};
use trueaxis_sim::run::Kind;

const AXES: [&str; 3] = ["X", "Y", "Z"];
/// Buckets of a curve around the circle.
const BUCKETS: usize = 700;

pub(super) fn section(report: &Report) -> Option<Section> {
    let circle = report.circle.as_ref()?;
    let before = curve(Kind::Uncompensated.words(), colour::UNCOMPENSATED, &circle.uncompensated);
    let compensated = curve(Kind::Compensated.words(), colour::COMPENSATED, &circle.compensated);
    let servo = curve(Kind::ServoOnly.words(), colour::SERVO, &circle.servo_only);
    let full = curve(Kind::Full.words(), colour::FULL, &circle.full);
    let after = if full.is_some() { [compensated.clone(), full.clone()] } else { [servo, compensated.clone()] };
    let figures = [
        figure(circle, "Uncorrected and at its best.", [before, full.or(compensated)]),
        figure(circle, "The small deviations, enlarged.", after),
    ];
    let content = html! { (side_by_side(figures.into_iter().flatten())) };
    Some(Section { heading: "Circle in polar coordinates", content })
}

fn curve<'t>(name: &'t str, colour: Colour, points: &[[f64; 2]]) -> Option<PolarTrace<'t>> {
    let points = decimate(points, BUCKETS);
    (!points.is_empty()).then_some(PolarTrace { name, colour, points })
}

fn figure<'t>(
    circle: &CircleReport,
    caption: &str,
    traces: impl IntoIterator<Item = Option<PolarTrace<'t>>>,
) -> Option<Figure> {
    let traces: Vec<PolarTrace<'_>> = traces.into_iter().flatten().collect();
    let [a, b] = circle.plane.map(|axis| AXES.get(axis).copied().unwrap_or_default());
    let caption = format!(
        "{caption} Departure of the true tip's radius on the circle of {} in the plane {a}{b}, program line {}; {a} to the \
         right.",
        quantity(circle.radius_mm, "mm"),
        circle.line
    );
    (!traces.is_empty()).then(|| polar_traces("Polar plot of a circle, as of a ballbar", &traces, &caption))
}
