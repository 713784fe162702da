//! The HTML report of simulated calibrations.

use maud::html;
use trueaxis_evaluation::simulated::calibration::{Machines, Outcome, Summary};
use trueaxis_report::number::significant;
use trueaxis_report::{Figure, Page, Row, Scale, Stroke, Table, colour};

/// Renders the whole page.
pub fn page(all: &Machines, found: &Summary) -> String {
    let (three, five) = (&all.three_axes, &all.five_axes);
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let um = |value: f64| significant(value, 3);
    let table = Table::new(
        ["", ""],
        [
            Row::new("three-axis machines", [found.machines.to_string()]),
            Row::new("machines refused", [found.refused.to_string()]),
            Row::new("volumetric error removed, median", [percent(found.median_removed)]),
            Row::new("least", [percent(found.least_removed)]),
            Row::new("made worse", [found.made_worse.to_string()]),
            Row::new("five-axis machines", [five.len().to_string()]),
            Row::new("centre lines within, µm", [um(found.worst_place_um)]),
            Row::new("tilts within, µrad", [um(found.worst_tilt_urad)]),
        ],
    );
    let mut sorted: Vec<&Outcome> = three.iter().collect();
    sorted.sort_by(|one, other| one.before_um.rms.total_cmp(&other.before_um.rms));
    let curve = |take: fn(&Outcome) -> f64| (1..).zip(&sorted).map(move |(k, one)| [f64::from(k), take(one)]);
    let y = Scale::from_zero("RMS error over the volume, µm", three.iter().map(|one| one.before_um.rms));
    let x = Scale::linear("machines, by their error before", [1.0, sorted.len().max(2) as f64]);
    let mut figure = Figure::full("Volumetric error before and after", 320, x, y);
    figure.curve("before", curve(|one| one.before_um.rms), Stroke::new(colour::UNCOMPENSATED, 1.6));
    figure.curve("after", curve(|one| one.after_um.rms), Stroke::new(colour::COMPENSATED, 1.6));
    figure.caption("Root mean square of the tip's error over the volume, its best rigid motion taken out.");
    let refused = html! { @for one in &all.refused { p { (one) } } };
    Page::new("Calibration of simulated machines")
        .top(table)
        .section("Machines", html! { (figure) (refused) })
        .document()
}
