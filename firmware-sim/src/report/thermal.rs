//! A warming: its tables, the figures of its page, its record.

use maud::{Markup, html};
use trueaxis_evaluation::shown::{Cell, Shown, Table};
use trueaxis_report::number::{count, quantity, significant};
use trueaxis_report::{Figure, Scale, Stroke, colour};
use trueaxis_sim::warming::{Outcome, SENSORS, Warming};

/// The record in the format that `trueaxis thermal fit` reads; sensors T1 to T9 in the order of [`SENSORS`].
#[must_use]
pub fn record(outcome: &Outcome) -> String {
    trueaxis_sim::warming::csv(&outcome.record)
}

/// The page as one HTML document that is also well-formed XML.
#[must_use]
pub fn page(outcome: &Outcome, shown: &Shown) -> String {
    let judged = html! { @for axis in 0..3 { (axis_figure(outcome, axis)) } };
    shown.page("", [("The judged shift", judged), ("Temperatures", temperatures(outcome))])
}

/// Sensors and spindle with their lags, s.
pub fn lags(outcome: &Outcome) -> impl Iterator<Item = (&str, f64)> {
    let model = &outcome.found.model;
    let sensors = model.sensors.iter().map(|sensor| (sensor.name.as_str(), sensor.lag_s));
    sensors.chain(model.spindle.iter().map(|spindle| ("spindle", spindle.lag_s)))
}

/// Drift and its remainder, lags, and the corrections in the step.
#[must_use]
pub fn shown(warming: &Warming, outcome: &Outcome) -> Shown {
    let row = |name: String, [drift, left]: [f64; 2]| {
        let [um, left_um] = [drift, left].map(|mm| Cell::number(1e3 * mm, 3));
        vec![name.into(), um, left_um, Cell::percent(left / drift.max(f64::MIN_POSITIVE))]
    };
    let held_out = outcome.recorded.iter().filter(|own| own.held_out);
    let held_out =
        held_out.map(|own| row(format!("E{0}{0}, held-out shift", own.axis.letter()), [own.drift_mm, own.left_mm]));
    let judged = outcome.axes_mm.iter().zip(['X', 'Y', 'Z']);
    let judged = judged.map(|(drift, axis)| row(format!("E{axis}{axis}, judged shift"), *drift));
    let rows = held_out.chain(judged).chain([row("RMS, judged shift".into(), outcome.rms_mm)]);
    let um = |mm: f64| quantity(1e3 * mm, "µm");
    let [largest, left] = outcome.largest_mm.map(um);
    let out = outcome.found.left_out.iter().map(|out| format!("left out: {}", out.name));
    let failed = outcome.failed.map(|failed| {
        let share = if outcome.reported { "reported, its share frozen" } else { "it has no share" };
        format!("{failed} failed half-way: {share}")
    });
    let step = [
        ("largest step of a correction in a cycle, µm", Cell::number(1e3 * outcome.largest_step_mm, 3)),
        ("of the limiter's limits, %", Cell::fixed(1e2 * outcome.of_limits, 0)),
        ("always settled", if outcome.unsettled { "no" } else { "yes" }.into()),
    ];
    let lags = lags(outcome).map(|(name, lag_s)| vec![name.into(), Cell::fixed(lag_s, 0)]);
    Shown {
        title: "A machine that warms".into(),
        summary: vec![
            warming.machine.settings.name.as_str().into(),
            format!("{} shifts and {} rows recorded", warming.shifts, count(outcome.record.samples.len() as u64)),
            format!("probe {} µm", warming.noise_um),
            format!("seed {}", warming.seed),
        ],
        result: format!(
            "In a shift of another kind, {} % of the largest drift remains: {left} instead of {largest}.",
            significant(1e2 * outcome.left_share(), 3)
        ),
        notes: [
            "bodies are lumped masses of two nodes; the fitted form is none of theirs",
            "speeds, periods and positions of the judged shift were not in the record; the task's lines went through the step \
             and its limiter",
        ]
        .map(String::from)
        .into_iter()
        .chain(out)
        .chain(failed)
        .collect(),
        tables: vec![
            Table::new("Largest drift and what is left of it", ["", "drift, µm", "left, µm", "left, %"], rows),
            Table::new("Lags", ["sensor", "lag, s"], lags),
            Table::figures("Corrections in the step", step),
        ],
        ..Shown::default()
    }
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
        let colours = [colour::UNCOMPENSATED, colour::COMPENSATED, colour::FULL, colour::FOURTH, colour::GREY];
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
