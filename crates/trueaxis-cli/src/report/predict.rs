//! A predicted part as a picture, and its deviations and intervals beside the tolerances.

use maud::{Markup, Render};
use trueaxis_evaluation::predict::{PredictDocument, Predicted, Shape};
use trueaxis_report::{Colour, Edge, Figure, Scale, Stroke, colour, isometric};

/// Half of a tolerance's width, and how far uncorrected and corrected points are from its middle.
const HALF: f64 = 0.4;
const BESIDE: f64 = 0.14;
const PART: &str = "Part with its deviations";
const HEADING: &str = "Deviations and tolerances";

/// The picture: every feature in the colour of its verdict, with the deviations of the corrected part, or of that with
/// everything on.
pub(crate) fn picture(shapes: &[Shape]) -> (&'static str, Markup) {
    let edge = |shape: &Shape| {
        let (colour, sign, dashed) = look(shape.verdict);
        let closed = if shape.closed { shape.points_mm.len() } else { 0 }.min(1);
        let around = |points: &[[f64; 3]]| points.iter().chain(&points[..closed]).copied().collect();
        Edge {
            label: format!("{} {sign}", shape.feature).trim_end().to_owned(),
            name: shape.verdict.unwrap_or("no verdict"),
            colour,
            dashed,
            points_mm: around(&shape.points_mm),
            deviation_um: around(shape.everything_um.as_ref().unwrap_or(&shape.corrected_um)),
        }
    };
    let edges: Vec<Edge<'_>> = shapes.iter().map(edge).collect();
    let has_servo = shapes.iter().any(|shape| shape.everything_um.is_some());
    let caption = if has_servo { "Part with everything on" } else { "Corrected part" };
    (PART, isometric("The part with its features in the colour of their verdict", caption, &edges).render())
}

/// Colour, sign and dashes of a verdict: it can be told without colour.
fn look(verdict: Option<&str>) -> (Colour, &'static str, bool) {
    match verdict {
        Some("conforms") => (colour::COMPENSATED, "✓", false),
        Some("undecided") => (colour::UNCOMPENSATED, "?", true),
        Some(_) => (colour::LIMIT, "✗", false),
        None => (colour::NOMINAL, "", false),
    }
}

/// The figure: every value as a share of its tolerance, in the order of the part.
pub(crate) fn margins(document: &PredictDocument) -> (&'static str, Markup) {
    let features = || (1..).map(f64::from).zip(&document.features);
    let known = || features().filter_map(|(x, of)| Some((x, of, of.known.as_ref()?.interval_um)));
    let uncorrected = || features().map(|(x, of)| [x - BESIDE, share(of, of.uncorrected_um)]);
    // With the servo the intervals are those of everything on.
    let corrected = || features().map(|(x, of)| [x + BESIDE, share(of, of.everything_um.unwrap_or(of.corrected_um))]);
    let name = if document.servo.is_some() { "everything on" } else { "corrected" };
    let intervals = || known().map(|(x, of, found)| [found.low, found.high].map(|um| [x + BESIDE, share(of, um)]));
    let values = uncorrected().chain(corrected()).chain(intervals().flatten()).map(|[_, y]| y);
    let values = values.chain(features().map(|(_, of)| lowest(of))).chain([100.0]);
    let x = Scale::exact("tolerances in the order of the table", 0.5, document.features.len() as f64 + 0.5);
    let mut figure = Figure::full(HEADING, 320, x, Scale::linear("share of the tolerance in %", values).margin(0.06));
    for (x, of) in features() {
        figure.area([x - HALF, lowest(of)], [x + HALF, 100.0], colour::FULL, 0.15);
    }
    let line = Stroke::new(colour::COMPENSATED, 2.0);
    for interval in intervals() {
        figure.line(interval, line);
    }
    figure
        .dots(uncorrected(), colour::UNCOMPENSATED)
        .dots(corrected(), colour::COMPENSATED)
        .area_key("tolerance", colour::FULL)
        .area_key("uncorrected", colour::UNCOMPENSATED)
        .area_key(name, colour::COMPENSATED);
    if known().next().is_some() {
        figure.key("95 % of draws", line);
    }
    figure.labels_above(features().map(|(x, of)| (x, of.feature.clone()))).caption(
        "A zone is 0 to 100 %, a pair of limits −100 to 100 %. A feature conforms if its whole line is within the tolerance.",
    );
    (HEADING, figure.render())
}

/// The lower end of a tolerance, %.
fn lowest(of: &Predicted) -> f64 {
    if of.limits_um[0].is_some() { -100.0 } else { 0.0 }
}

/// A value as a share of the tolerance, %: of a zone's width, or from the middle of two limits to one of them.
fn share(of: &Predicted, um: f64) -> f64 {
    match of.limits_um {
        [Some(low), Some(high)] => 200.0 * (um - 0.5 * (low + high)) / (high - low),
        [_, Some(width)] => 100.0 * um / width,
        [_, None] => f64::NAN,
    }
}
