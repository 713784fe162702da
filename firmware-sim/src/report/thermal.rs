//! The HTML report of a warming.

use super::write_page;
use maud::{Markup, html};
use std::fmt::Write;
use std::io;
use std::path::{Path, PathBuf};
use trueaxis_report::number::{quantity, significant};
use trueaxis_report::{Figure, Page, Row, Scale, Stroke, Table, colour, emphasised};
use trueaxis_sim::warming::{Outcome, SENSORS, Warming};

/// Writes the page to `thermal.html` in `directory`, and the record as `record.csv`; creates the folder if needed.
///
/// # Errors
/// The file system's error if the page cannot be written. A failure leaves no file behind.
pub fn write(warming: &Warming, outcome: &Outcome, directory: &Path) -> io::Result<PathBuf> {
    write_page(directory, "thermal.html", &render(warming, outcome), vec![("record.csv".into(), record(outcome))])
}

/// The record in the format that `trueaxis thermal fit` reads; sensors T1 to T9 in the order of [`SENSORS`].
fn record(outcome: &Outcome) -> String {
    let mut text = String::from("t_s,cycle,spindle_rpm,x_mm,y_mm,z_mm,tool_mm,ex_um,ey_um,ez_um");
    for (number, _) in (1..).zip(SENSORS) {
        let _ = write!(text, ",T{number}_c");
    }
    text.push('\n');
    for sample in &outcome.record.samples {
        let [x, y, z] = sample.position_mm;
        let _ = write!(text, "{},{},{},{x},{y},{z},{}", sample.t_s, sample.cycle, sample.spindle_rpm, sample.tool_mm);
        for error in &sample.error_mm {
            let _ = write!(text, ",{:.3}", 1e3 * error);
        }
        for temperature in &sample.temperatures_c {
            let _ = write!(text, ",{temperature}");
        }
        text.push('\n');
    }
    text
}

/// The page as one HTML document that is also well-formed XML.
#[must_use]
pub fn render(warming: &Warming, outcome: &Outcome) -> String {
    let settings = &warming.machine.settings;
    Page::new("A machine that warms")
        .top(html! {
            (trueaxis_report::summary([
                emphasised("machine", &settings.name),
                html! { (warming.shifts) " shifts recorded" },
                html! { "probe " (quantity(warming.noise_um, "µm")) },
                html! { "seed " (warming.seed) },
            ]))
            p.result {
                "In a shift of another kind, " strong { (significant(1e2 * outcome.left_share(), 2)) " %" }
                " of the largest drift remains: " strong { (quantity(1e3 * outcome.largest_mm[1], "µm")) } " instead of "
                strong { (quantity(1e3 * outcome.largest_mm[0], "µm")) } "."
            }
            p {
                "Bodies are lumped masses of two nodes; the fitted form is none of theirs. Speeds, periods and positions of the \
                 judged shift were not in the record; the task's lines went through the step and its limiter."
            }
        })
        .section("The judged shift", html! { @for axis in 0..3 { (axis_figure(outcome, axis)) } (table(outcome)) })
        .section("Temperatures", temperatures(outcome))
        .document()
}

fn table(outcome: &Outcome) -> Table {
    let um = |mm: f64| significant(1e3 * mm, 3);
    let share = |drift: f64, left: f64| format!("{} %", significant(1e2 * left / drift.max(f64::MIN_POSITIVE), 2));
    let held_out = outcome.recorded.iter().filter(|own| own.held_out).map(|own| {
        let name = format!("E{0}{0}, held-out shift", own.axis.letter());
        Row::new(name, [um(own.drift_mm), um(own.left_mm), share(own.drift_mm, own.left_mm)])
    });
    let judged = outcome.axes_mm.iter().zip(['X', 'Y', 'Z']).map(|([drift, left], axis)| {
        Row::new(format!("E{axis}{axis}, judged shift"), [um(*drift), um(*left), share(*drift, *left)])
    });
    Table::new(["largest", "drift, µm", "left, µm", "left"], held_out.chain(judged))
}

fn axis_figure(outcome: &Outcome, axis: usize) -> Figure {
    let letter = ['X', 'Y', 'Z'][axis];
    // The position with the largest drift.
    let most = |place: &usize| {
        outcome.moments.iter().map(|moment| moment.places[*place].drift_mm[axis].abs()).fold(0.0, f64::max)
    };
    let places = outcome.moments.first().map_or(0, |moment| moment.places.len());
    let place = (0..places).max_by(|one, other| most(one).total_cmp(&most(other))).unwrap_or(0);
    let hours = |take: &dyn Fn(&trueaxis_sim::warming::PointError) -> f64| -> Vec<[f64; 2]> {
        outcome.moments.iter().map(|moment| [moment.t_s / 3600.0, 1e3 * take(&moment.places[place])]).collect()
    };
    let (drift, left) = (hours(&|of| of.drift_mm[axis]), hours(&|of| of.left_mm[axis]));
    let x = Scale::linear("hours", drift.iter().map(|point| point[0]));
    let values: Vec<f64> = drift.iter().chain(&left).map(|point| point[1]).chain([0.0]).collect();
    let mut figure = Figure::full(&format!("drift of {letter}"), 210, x, Scale::linear("µm", values).margin(0.05));
    figure
        .curve("without the task", drift, Stroke::new(colour::UNCOMPENSATED, 1.4))
        .curve("with it", left, Stroke::new(colour::COMPENSATED, 1.4))
        .caption(format!("E{letter}{letter} where it drifts most."));
    figure
}

fn temperatures(outcome: &Outcome) -> Markup {
    let figure = |names: &[&str]| {
        let at = |name: &str| SENSORS.iter().position(|sensor| *sensor == name).unwrap_or(0);
        let curve = |name: &str| -> Vec<[f64; 2]> {
            let sensor = at(name);
            outcome.moments.iter().map(|moment| [moment.t_s / 3600.0, moment.temperatures_c[sensor]]).collect()
        };
        let curves: Vec<Vec<[f64; 2]>> = names.iter().map(|name| curve(name)).collect();
        let all: Vec<[f64; 2]> = curves.iter().flatten().copied().collect();
        let x = Scale::linear("hours", all.iter().map(|point| point[0]));
        let y = Scale::linear("°C", all.iter().map(|point| point[1]).collect::<Vec<_>>()).margin(0.05);
        let colours = [colour::UNCOMPENSATED, colour::COMPENSATED, colour::SERVO, colour::FOURTH, colour::GREY];
        let mut figure = Figure::full(&format!("temperatures: {}", names.join(", ")), 200, x, y);
        for ((name, curve), colour) in names.iter().zip(curves).zip(colours) {
            figure.curve(*name, curve, Stroke::new(colour, 1.2));
        }
        figure
    };
    html! {
        (figure(&["nose", "head", "screw", "coolant", "air"]))
        (figure(&["column_front", "column_back", "bed", "table"]))
    }
}
