//! Figures of the history.

use super::entry::{Entry, EntryKind};
use trueaxis_report::{BARS, Figure, Scale, Stroke, colour};

/// One figure per term since the last beginning: the value found by every probing, with its expanded uncertainty to either side,
/// and the sum of the updates.
pub fn figures(entries: &[Entry]) -> Vec<Figure> {
    let begun = entries.iter().rposition(|entry| entry.kind == EntryKind::Begin).unwrap_or(0);
    let entries = entries.get(begun..).unwrap_or_default();
    let mut names: Vec<(&str, &str)> = Vec::new();
    for measured in entries.iter().flat_map(|entry| &entry.measured) {
        if names.iter().all(|(name, _)| *name != measured.term) {
            names.push((&measured.term, &measured.unit));
        }
    }
    names.into_iter().map(|(name, unit)| figure(entries, name, unit)).collect()
}

fn figure(entries: &[Entry], name: &str, unit: &str) -> Figure {
    let found: Vec<[f64; 3]> = entries
        .iter()
        .flat_map(|entry| entry.measured.iter().map(move |measured| (entry, measured)))
        .filter(|(_, measured)| measured.term == name)
        .map(|(entry, measured)| [f64::from(entry.entry), measured.value, measured.half_width()])
        .collect();
    let mut totals: Vec<[f64; 2]> = Vec::new();
    for entry in entries {
        let total = entry.totals.get(name).copied().unwrap_or(0.0);
        if let Some([_, before]) = totals.last().copied() {
            totals.push([f64::from(entry.entry), before]);
        }
        totals.push([f64::from(entry.entry), total]);
    }
    let numbers = || entries.iter().map(|entry| f64::from(entry.entry));
    let ends = found.iter().flat_map(|[_, value, bar]| [value - bar, value + bar]);
    let values: Vec<f64> = ends.chain(totals.iter().map(|point| point[1])).chain([0.0]).collect();
    let x = Scale::linear("entry", numbers());
    let mut figure =
        Figure::full(&format!("{name} over the entries"), 200, x, Scale::linear(unit, values).margin(0.06));
    figure.curve("sum of the updates", totals, Stroke::new(colour::COMPENSATED, 1.6));
    let bar = Stroke::new(colour::UNCOMPENSATED, 1.0);
    for &[at, value, half] in &found {
        figure.line([[at, value - half], [at, value + half]], bar);
    }
    figure.dots(found.iter().map(|[at, value, _]| [*at, *value]), colour::UNCOMPENSATED);
    figure.key("error found by a re-probing, with the tables active", bar);
    figure.caption(format!("{name}. {BARS}"));
    figure
}
