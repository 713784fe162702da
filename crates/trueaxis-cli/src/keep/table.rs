//! A re-probing and a history as text.

use crate::output::{json, print};
use anyhow::Result;
use std::fmt::Write;
use trueaxis_evaluation::keep::{Entry, ReprobingDocument, descriptions};
use trueaxis_report::number::significant;

/// Prints a re-probing.
pub(super) fn put(document: &ReprobingDocument, as_json: bool) -> Result<()> {
    if as_json { json(document) } else { print(&table(document)?) }
}

fn table(d: &ReprobingDocument) -> Result<String> {
    let mut text =
        format!("{}: entry {}, {} touches, {} µm each\n\n", d.machine, d.entry, d.touches, significant(d.sigma_um, 2));
    if !d.terms.is_empty() {
        writeln!(text, "{:<14} {:>22}   {:>10} {:>10}", "", "left by the tables", "in all", "then")?;
    }
    for term in &d.terms {
        let found = format!("{} ± {}", significant(term.value, 3), significant(term.standard_error, 2));
        let (from, to) = (significant(term.from, 3), significant(term.to, 3));
        writeln!(text, "{:<14} {found:>17} {:<5} {from:>10} {to:>10}   {}", term.name, term.unit, term.in_words())?;
    }
    if !d.terms.is_empty() {
        text.push('\n');
    }
    for ball in &d.balls {
        let [x, y, z] = ball.centre_mm;
        let error = ball.standard_error_um.iter().copied().fold(0.0, f64::max);
        writeln!(text, "{}: {x:.5} {y:.5} {z:.5} mm ± {} µm", ball.name, significant(error, 2))?;
    }
    for note in &d.notes {
        writeln!(text, "note: {note}")?;
    }
    Ok(text)
}

/// The history, one entry per line.
pub(super) fn entries(entries: &[Entry]) -> Result<String> {
    let mut text = String::new();
    for (entry, deed) in entries.iter().zip(descriptions(entries)) {
        let time = entry.time.as_deref().unwrap_or("");
        let parts = entry.parts.map_or(String::new(), |parts| format!("part {parts}"));
        writeln!(text, "{:>4}  {time:<20} {parts:<10} {deed}", entry.entry)?;
        for changed in entry.measured.iter().filter_map(|own| own.in_words()) {
            writeln!(text, "      {changed}")?;
        }
    }
    Ok(text)
}
