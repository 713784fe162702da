//! A shift of a machine that keeps itself true: its tables, and the figures of its page.

use maud::html;
use trueaxis_evaluation::shown::{Cell, Shown, Table};
use trueaxis_evaluation::simulated::keeping::{Evaluated, Outcome, Part};
use trueaxis_report::number::quantity;
use trueaxis_report::{Figure, Scale, Stroke, colour};
use trueaxis_sim::exchange::Exchanged;
use trueaxis_tables::text::counted;

/// The whole page.
#[must_use]
pub fn page(outcome: &Outcome, shown: &Shown) -> String {
    let figures = html! { (figure(outcome, 0, "RMS over the volume")) (figure(outcome, 1, "largest in the volume")) };
    shown.page("", [("Error of the tip", figures)])
}

/// The error of the tip, the re-probings, and the exchanges of tables.
#[must_use]
pub fn shown(outcome: &Outcome) -> Shown {
    let um = |value: f64| quantity(value, "µm");
    let row = |name: &str, of: [f64; 2]| {
        std::iter::once(name.into()).chain(of.map(|um| Cell::number(um, 3))).collect::<Vec<_>>()
    };
    let errors = [row("RMS", outcome.rms_um), row("largest", outcome.largest_um)];
    let exchanges = [
        ("new − old tables, at most, µm", Cell::number(outcome.largest_difference_um, 3)),
        ("largest step in a cycle, µm", Cell::number(outcome.largest_step_um, 3)),
        ("of the limits, %", Cell::fixed(1e2 * outcome.of_limits, 0)),
        ("fully applied within, s", outcome.longest_ramp_in_s.map_or("never".into(), |time| Cell::number(time, 3))),
    ];
    let head = ["re-probing", "updated", "new − old tables, µm", "largest step in a cycle, µm", "of the limits, %"];
    Shown {
        title: "A machine that keeps itself true".into(),
        summary: vec![
            outcome.machine.clone(),
            counted(outcome.parts.len(), "part"),
            format!("{} for a person", counted(outcome.refusals, "re-probing")),
            counted(outcome.updates, "update"),
        ],
        result: format!(
            "Over the shift and the volume the error of the tip is {} RMS instead of {}, at most {} instead of {}.",
            um(outcome.rms_um[1]),
            um(outcome.rms_um[0]),
            um(outcome.largest_um[1]),
            um(outcome.largest_um[0])
        ),
        tables: vec![
            Table::new("Error of the tip over volume and shift, µm", ["", "without", "with"], errors),
            Table::new("Re-probings", head, outcome.reprobings.iter().map(reprobing)),
            Table::figures("Exchanges in motion", exchanges),
        ],
        ..Shown::default()
    }
}

fn reprobing(of: &Evaluated) -> Vec<Cell> {
    let what = match (&of.log_refused, of.refused.as_slice()) {
        (Some(reason), _) => reason.clone(),
        (None, []) if of.updates == 0 => "nothing to change".into(),
        (None, []) => counted(of.updates, "term"),
        (None, reasons) => format!("refused: {}", reasons.join("; ")),
    };
    let exchanged = of.exchanged.as_ref();
    let um = |take: fn(&Exchanged) -> f64| Cell::number(exchanged.map(take), 3);
    vec![
        format!("after part {}", of.parts).into(),
        what.into(),
        um(|own| 1e3 * own.difference),
        um(|own| 1e3 * own.largest_step),
        Cell::fixed(exchanged.map(|own| 1e2 * own.of_limits), 0),
    ]
}

fn figure(outcome: &Outcome, which: usize, name: &str) -> Figure {
    let curve = |take: &dyn Fn(&Part) -> [f64; 2]| -> Vec<[f64; 2]> {
        outcome.parts.iter().map(|part| [f64::from(part.parts), take(part)[which]]).collect()
    };
    let (without, with) = (curve(&|part| part.without_um), curve(&|part| part.with_um));
    let x = Scale::linear("parts", without.iter().map(|point| point[0]));
    let y = Scale::from_zero(&format!("{name}, µm"), without.iter().chain(&with).map(|point| point[1]));
    let mut figure = Figure::full(&format!("Error of the tip, {name}"), 220, x, y);
    figure.curve("without the loop", without, Stroke::new(colour::UNCOMPENSATED, 1.4));
    figure.curve("with it", with, Stroke::new(colour::COMPENSATED, 1.6));
    let updated = outcome
        .reprobings
        .iter()
        .filter(|reprobing| reprobing.updates > 0)
        .map(|reprobing| [f64::from(reprobing.parts), 0.0]);
    let refused =
        outcome.reprobings.iter().filter(|reprobing| !reprobing.refused.is_empty() || reprobing.log_refused.is_some());
    figure
        .dots(updated, colour::COMPENSATED)
        .dots(refused.map(|reprobing| [f64::from(reprobing.parts), 0.0]), colour::LIMIT);
    figure.caption(
        "Just before a re-probing. Dots below: re-probings that updated the tables, and those that needed a person.",
    );
    figure
}
