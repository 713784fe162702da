//! Simulated calibrations: their tables, and the figure of their page.

use maud::Render;
use trueaxis_evaluation::shown::{Cell, Shown, Table};
use trueaxis_evaluation::simulated::calibration::{Machines, Outcome, Summary};
use trueaxis_report::number::significant;
use trueaxis_report::{Figure, Scale, Stroke, colour};
use trueaxis_tables::text::counted;

/// Number of machines listed.
const LISTED: usize = 20;

/// Error before and after, and the errors of the machines.
#[must_use]
pub fn shown(all: &Machines, found: &Summary) -> Shown {
    let um = |value: f64| Cell::number(value, 3);
    let summary = [
        ("volumetric error removed, median, %", Cell::percent(found.median_removed)),
        ("volumetric error removed, least, %", Cell::percent(found.least_removed)),
        ("machines made worse", Cell::count(found.made_worse)),
        ("centre lines, median, µm", um(found.median_place_um)),
        ("centre lines, worst, µm", um(found.worst_place_um)),
        ("tilts, median, µrad", um(found.median_tilt_urad)),
        ("tilts, worst, µrad", um(found.worst_tilt_urad)),
    ];
    let machines = all.three_axes.iter().take(LISTED).map(|one| {
        let errors = [one.before_um.rms, one.before_um.max, one.after_um.rms, one.after_um.max].map(um);
        std::iter::once(one.seed.to_string().into()).chain(errors).chain([Cell::percent(one.removed)]).collect()
    });
    let head = ["seed", "before, RMS, µm", "max, µm", "after, RMS, µm", "max, µm", "removed, %"];
    let caption = match all.three_axes.len() {
        ..=LISTED => "Three-axis machines".into(),
        many => format!("The first {LISTED} of {many} three-axis machines"),
    };
    Shown {
        title: "Calibration of simulated machines".into(),
        summary: vec![
            counted(found.machines, "three-axis machine"),
            counted(all.five_axes.len(), "five-axis machine"),
            format!("{} refused, which the figures do not include", counted(found.refused, "machine")),
        ],
        result: format!(
            "At the median {} % of the volumetric error is removed, at the least {} %.",
            significant(100.0 * found.median_removed, 3),
            significant(100.0 * found.least_removed, 3)
        ),
        notes: all.refused.iter().map(ToString::to_string).collect(),
        tables: vec![Table::figures("All machines", summary), Table::new(caption, head, machines)],
        ..Shown::default()
    }
}

/// The whole page.
#[must_use]
pub fn page(all: &Machines, shown: &Shown) -> String {
    let three = &all.three_axes;
    let mut sorted: Vec<&Outcome> = three.iter().collect();
    sorted.sort_by(|one, other| one.before_um.rms.total_cmp(&other.before_um.rms));
    let curve = |take: fn(&Outcome) -> f64| (1..).zip(&sorted).map(move |(k, one)| [f64::from(k), take(one)]);
    let y = Scale::from_zero("RMS error over the volume, µm", three.iter().map(|one| one.before_um.rms));
    let x = Scale::linear("machines, by their error before", [1.0, sorted.len().max(2) as f64]);
    let mut figure = Figure::full("Volumetric error before and after", 320, x, y);
    figure.curve("before", curve(|one| one.before_um.rms), Stroke::new(colour::UNCOMPENSATED, 1.6));
    figure.curve("after", curve(|one| one.after_um.rms), Stroke::new(colour::COMPENSATED, 1.6));
    figure.caption("Root mean square of the tip's error over the volume, its best rigid motion taken out.");
    shown.page("", [("Machines", figure.render())])
}
