//! The HTML report of a shift.

use maud::html;
use trueaxis_evaluation::simulated::keeping::{Outcome, Part};
use trueaxis_report::number::{quantity, significant};
use trueaxis_report::{Figure, Page, Row, Scale, Stroke, Table, colour, summary};
use trueaxis_tables::text::counted;

/// Renders the whole page.
pub fn page(outcome: &Outcome) -> String {
    let um = |value: f64| quantity(value, "µm");
    let reprobings = outcome.reprobings.iter().map(|reprobing| {
        let what = match (&reprobing.log_refused, reprobing.refused.as_slice()) {
            (Some(reason), _) => reason.clone(),
            (None, []) if reprobing.updates == 0 => "nothing to change".into(),
            (None, []) => counted(reprobing.updates, "term"),
            (None, reasons) => format!("refused: {}", reasons.join("; ")),
        };
        let [difference, step, limits] = reprobing.exchanged.map_or([const { String::new() }; 3], |own| {
            [
                significant(1e3 * own.difference, 3),
                significant(1e3 * own.largest_step, 3),
                format!("{:.0} %", 1e2 * own.of_limits),
            ]
        });
        Row::new(format!("after part {}", reprobing.parts), [what, difference, step, limits])
    });
    let head = ["re-probing", "updated", "new − old tables, µm", "largest step in a cycle, µm", "of the limits"];
    Page::new("A machine that keeps itself true")
        .top(summary([
            html! { (outcome.machine) },
            html! { (counted(outcome.parts.len(), "part")) },
            html! { (counted(outcome.updates, "update")) ", " (counted(outcome.refusals, "refusal")) },
        ]))
        .top(html! {
            p.result {
                "Over the shift and the volume the error of the tip is " strong { (um(outcome.rms_um[1])) } " RMS instead of "
                strong { (um(outcome.rms_um[0])) } ", at most by " (um(outcome.largest_um[1])) " instead of "
                (um(outcome.largest_um[0])) "."
            }
        })
        .section(
            "Error of the tip",
            html! { (figure(outcome, 0, "RMS over the volume")) (figure(outcome, 1, "largest in the volume")) },
        )
        .section("Re-probings", Table::new(head, reprobings).words(&[1]))
        .document()
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
