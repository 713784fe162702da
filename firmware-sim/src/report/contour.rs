//! Contour error over the path length.

use super::{Report, Section};
use maud::{Markup, html};
use trueaxis_report::{Colour, Figure, Scale, Stroke, colour, decimate, missing, number::significant};
use trueaxis_sim::run::Kind;

/// A second figure shows the small curves alone if their maximum is below this share of the largest.
const ENLARGE_BELOW: f64 = 0.4;
/// Buckets of a curve.
pub(super) const BUCKETS: usize = 700;

struct Curve {
    name: &'static str,
    colour: Colour,
    points: Vec<[f64; 2]>,
    largest: [f64; 2],
}

impl Curve {
    fn new(name: &'static str, colour: Colour, series: &[[f64; 2]]) -> Option<Curve> {
        let magnitudes: Vec<[f64; 2]> = series.iter().map(|[length, error]| [*length, error.abs()]).collect();
        let points = decimate(&magnitudes, BUCKETS);
        let largest = points.iter().copied().max_by(|a, b| a[1].total_cmp(&b[1]))?;
        Some(Curve { name, colour, points, largest })
    }
}

pub(super) fn section(report: &Report) -> Option<Section> {
    let series = &report.contour;
    let curves: Vec<Curve> = [
        Curve::new(Kind::Uncompensated.words(), colour::UNCOMPENSATED, &series.uncompensated),
        Curve::new(Kind::Compensated.words(), colour::COMPENSATED, &series.compensated),
        Curve::new(Kind::ServoOnly.words(), colour::SERVO, &series.servo_only),
        Curve::new(Kind::Full.words(), colour::FULL, &series.full),
    ]
    .into_iter()
    .flatten()
    .collect();
    let content = if curves.is_empty() { missing("No contour error was recorded.") } else { figures(report, &curves) };
    Some(Section { heading: "Contour error over the path", content })
}

fn figures(report: &Report, curves: &[Curve]) -> Markup {
    let all: Vec<&Curve> = curves.iter().collect();
    let largest = curves.iter().map(|curve| curve.largest[1]).fold(0.0, f64::max);
    let small: Vec<&Curve> = curves.iter().filter(|curve| curve.largest[1] < ENLARGE_BELOW * largest).collect();
    let caption = "Magnitude of the distance from the true tool tip to the programmed path. The dots mark the largest \
                   error of each run; the numbers above are program lines.";
    html! {
        (figure(report, &all, &all, caption))
        @if !small.is_empty() { (figure(report, &small, &all, "The small errors of the figure above, enlarged.")) }
    }
}

/// One figure of `curves`; its path-length axis spans `all`, so that stacked figures line up.
fn figure(report: &Report, curves: &[&Curve], all: &[&Curve], caption: &str) -> Figure {
    let lengths = all.iter().flat_map(|curve| curve.points.iter().map(|point| point[0]));
    let x = Scale::linear("path length in mm", lengths);
    let y = Scale::from_zero("contour error in µm", curves.iter().map(|curve| curve.largest[1]));
    let names: Vec<&str> = curves.iter().map(|curve| curve.name).collect();
    let mut figure = Figure::full(&format!("{caption} Curves: {}", names.join(", ")), 270, x, y);
    figure.labels_above(report.contour.program_lines.iter().map(|(length, line)| (*length, line.to_string())));
    // The corrected run precedes the servo alone in the legend, but is drawn on top of it.
    for curve in curves.iter().rev() {
        let stroke = Stroke::new(curve.colour, 1.2).opacity(0.85);
        figure.interrupted(&curve.points, &report.contour.breaks, stroke);
    }
    for curve in curves {
        let [length, error] = curve.largest;
        let text = format!("{}: largest {} µm at {} mm", curve.name, significant(error, 3), significant(length, 4));
        figure.highlight(curve.largest, curve.colour).key(text, Stroke::new(curve.colour, 1.2));
    }
    figure.caption(caption);
    figure
}
