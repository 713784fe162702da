//! The HTML report of a ball test.

use super::write_page;
use crate::ball_test::{AxisOutcome, BallCycle, Outcome, TipError};
use maud::{Markup, html};
use std::{
    io,
    path::{Path, PathBuf},
};
use trueaxis_evaluation::uncertainty::band_factor;
use trueaxis_report::{
    BARS, Figure, Page, Row, Scale, Stroke, Table, colour, emphasised, error_bars,
    number::{quantity, significant},
    residuals,
};

/// Writes the page to `rtcp.html` in `directory`, with the readings and the tables; creates the folder if needed.
///
/// # Errors
/// The file system's error if the page cannot be written. A failure leaves no file behind.
pub fn write(test: &BallCycle, outcome: &Outcome, directory: &Path) -> io::Result<PathBuf> {
    write_page(directory, "rtcp.html", &render(test, outcome), outcome.files())
}

/// The page as one HTML document that is also well-formed XML.
#[must_use]
pub fn render(test: &BallCycle, outcome: &Outcome) -> String {
    let axes = &outcome.axes;
    Page::new("Ball test of a five-axis head")
        .top(summary(test, outcome))
        .section("True tip error over the angle", html! { @for of in axes { (tip_error(of)) } })
        .section("Identified errors", html! { @for of in axes { (identified(test, of)) } })
        .section("Residuals", html! { @for of in axes { (residuals_of(of)) } })
        .document()
}

fn summary(test: &BallCycle, outcome: &Outcome) -> Markup {
    let settings = &test.machine.settings;
    let left = |before: TipError, after: TipError| format!("{} %", significant(100.0 * after.rms / before.rms, 2));
    html! {
        (trueaxis_report::summary([
            emphasised("machine", &settings.name),
            emphasised("chain", &settings.chain),
            html! { "gauge " (quantity(test.gauge_noise_um, "µm")) " a reading" },
            html! { "seed " (test.seed) },
        ]))
        p.result {
            "Of the tip error that the rotary axes cause, " strong { (left(outcome.before, outcome.after)) } " remains: "
            strong { (quantity(outcome.after.rms, "µm")) } " rms instead of "
            strong { (quantity(outcome.before.rms, "µm")) } "."
        }
        p {
            "Three set-ups of a ball for either axis, RTCP holding its centre; linear axes are perfect. The identified \
             tables were compiled and used by the volumetric correction; the true tip error is judged at every degree, \
             not only at the stops of the gauge."
        }
        (table(outcome, left))
    }
}

fn table(outcome: &Outcome, left: impl Fn(TipError, TipError) -> String) -> Table {
    let row = |name: String, before: TipError, after: TipError| {
        let [a, b, c, d] = [before.max, before.rms, after.max, after.rms].map(|um| significant(um, 3));
        Row::new(name, [a, b, c, d, left(before, after)])
    };
    let axes = outcome.axes.iter().map(|of| row(format!("axis {}", of.axis.letter()), of.before, of.after));
    let rows = axes.chain([row("both".into(), outcome.before, outcome.after)]);
    Table::new(["", "before, max", "rms", "after, max", "rms", "left, rms"], rows).caption("True tip error in µm")
}

fn angle_scale(of: &AxisOutcome) -> Scale {
    let angles = of.over_angle.iter().map(|stop| stop.angle_deg);
    Scale::linear(&format!("{} in degrees", of.axis.letter()), angles).margin(0.02)
}

fn tip_error(of: &AxisOutcome) -> Figure {
    let before: Vec<[f64; 2]> = of.over_angle.iter().map(|stop| [stop.angle_deg, stop.before_um]).collect();
    let after: Vec<[f64; 2]> = of.over_angle.iter().map(|stop| [stop.angle_deg, stop.after_um]).collect();
    let values = before.iter().chain(&after).map(|point| point[1]).chain([0.0]);
    let y = Scale::linear("tip error in µm", values).margin(0.04);
    let description = format!("true tip error over the angle of {}", of.axis.letter());
    let mut figure = Figure::full(&description, 250, angle_scale(of), y);
    figure
        .curve("before", before, Stroke::new(colour::UNCOMPENSATED, 1.4))
        .curve("with the identified tables", after, Stroke::new(colour::COMPENSATED, 1.4))
        .caption(format!("Axis {}: root mean square over the three set-ups.", of.axis.letter()));
    figure
}

fn identified(test: &BallCycle, of: &AxisOutcome) -> Markup {
    let letter = of.axis.letter();
    let caption = format!(
        "Axis {letter} of {}, as read. {BARS} Sigma {}, {} degrees of freedom.",
        test.machine.settings.name,
        quantity(1e3 * of.found.sigma_mm, "µm"),
        of.found.degrees_of_freedom
    );
    let factor = band_factor(of.found.degrees_of_freedom as f64);
    let figure = |first: usize, unit: &str, scale: f64| {
        let names = [0, 1, 2].map(|i| format!("E{}{letter}", ["X", "Y", "Z", "A", "B", "C"][first + i]));
        let curve = |i: usize| {
            let points = of.stops_deg.iter().zip(&of.found.angles).map(|(angle, found)| {
                [*angle, scale * found.errors[first + i], scale * factor * found.standard_errors[first + i]]
            });
            (names[i].as_str(), points.collect())
        };
        let description = format!("identified errors of {letter} in {unit}");
        let mut figure = error_bars(&description, angle_scale(of), unit, &[0, 1, 2].map(curve));
        figure.caption(&caption);
        figure
    };
    html! { (figure(0, "µm", 1e3)) (figure(3, "µrad", 1e6)) }
}

fn residuals_of(of: &AxisOutcome) -> Figure {
    let stops = of.stops_deg.iter().zip(&of.found.angles);
    let points: Vec<[f64; 2]> = stops.map(|(&angle, found)| [angle, 1e3 * found.residual_mm]).collect();
    let description = format!("residuals of {}", of.axis.letter());
    let mut figure = residuals(&description, angle_scale(of), &points, 1e3 * of.found.sigma_mm);
    figure.caption(format!("Axis {}.", of.axis.letter()));
    figure
}
