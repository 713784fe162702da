//! A ball test: its tables, and the figures of its page.

use crate::ball_test::{AxisOutcome, BallCycle, Outcome, TipError};
use maud::{Markup, html};
use trueaxis_evaluation::shown::{Cell, Shown, Table, half_width};
use trueaxis_report::{
    BARS, Figure, Scale, Stroke, colour, error_bars,
    number::{quantity, significant},
    residuals,
};

/// The page as one HTML document that is also well-formed XML.
#[must_use]
pub fn page(test: &BallCycle, outcome: &Outcome, shown: &Shown) -> String {
    let axes = &outcome.axes;
    let sections = [
        ("True tip error over the angle", html! { @for of in axes { (tip_error(of)) } }),
        ("Identified errors", html! { @for of in axes { (identified(test, of)) } }),
        ("Residuals", html! { @for of in axes { (residuals_of(of)) } }),
    ];
    shown.page("", sections)
}

/// Tables of the test: the true tip error, and the fit of both axes.
#[must_use]
pub fn shown(test: &BallCycle, outcome: &Outcome) -> Shown {
    let settings = &test.machine.settings;
    let row = |name: String, before: TipError, after: TipError| {
        let um = [before.max, before.rms, after.max, after.rms].map(|um| Cell::number(um, 3));
        std::iter::once(name.into()).chain(um).chain([Cell::percent(after.rms / before.rms)]).collect()
    };
    let axes = outcome
        .axes
        .iter()
        .map(|of| row(format!("{} over {} stops", of.axis.letter(), of.stops_deg.len()), of.before, of.after));
    let rows: Vec<Vec<Cell>> = axes.chain([row("both".into(), outcome.before, outcome.after)]).collect();
    let fit = outcome.axes.iter().map(|of| {
        let found = &of.found;
        let sigma = Cell::number(1e3 * found.sigma_mm, 3);
        vec![of.axis.letter().to_string().into(), sigma, Cell::count(found.degrees_of_freedom)]
    });
    Shown {
        title: "Ball test of a five-axis head".into(),
        summary: vec![
            format!("{} ({})", settings.name, settings.chain),
            format!("gauge {} a reading", quantity(test.gauge_noise_um, "µm")),
            format!("seed {}", test.seed),
        ],
        result: format!(
            "Of the tip error that the rotary axes cause, {} % remains: {} RMS instead of {}.",
            significant(100.0 * outcome.after.rms / outcome.before.rms, 2),
            quantity(outcome.after.rms, "µm"),
            quantity(outcome.before.rms, "µm")
        ),
        notes: [
            "three set-ups of a ball for either axis, RTCP holding its centre; the linear axes are perfect",
            "the identified tables were compiled and used by the volumetric correction; the true tip error is judged at every \
             degree, not only at the stops of the gauge",
        ]
        .map(String::from)
        .into(),
        tables: vec![
            Table::new("True tip error, µm", ["", "before, max", "rms", "after, max", "rms", "left, rms, %"], rows),
            Table::new("Fit", ["axis", "sigma of a reading, µm", "degrees of freedom"], fit),
        ],
        ..Shown::default()
    }
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
    let freedom = of.found.degrees_of_freedom as f64;
    let figure = |first: usize, unit: &str, scale: f64| {
        let names = [0, 1, 2].map(|i| format!("E{}{letter}", ["X", "Y", "Z", "A", "B", "C"][first + i]));
        let curve = |i: usize| {
            let points = of.stops_deg.iter().zip(&of.found.angles).map(|(angle, found)| {
                [*angle, scale * found.errors[first + i], half_width(scale * found.standard_errors[first + i], freedom)]
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
