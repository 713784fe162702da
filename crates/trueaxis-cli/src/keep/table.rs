//! A look and a history as text.

use crate::output::{json, print};
use anyhow::Result;
use std::fmt::Write;
use trueaxis_evaluation::keep::{Deed, Document, History};
use trueaxis_report::number::significant;

/// Prints a look.
pub(super) fn put(document: &Document, as_json: bool) -> Result<()> {
    if as_json { json(document) } else { print(&table(document)?) }
}

fn table(d: &Document) -> Result<String> {
    let mut text =
        format!("{}: entry {}, {} touches, {} µm each\n\n", d.machine, d.entry, d.touches, significant(d.sigma_um, 2));
    writeln!(text, "{:<14} {:>22}   {:>10} {:>10}", "", "left by the tables", "in all", "then")?;
    for term in &d.terms {
        let found = format!("{} ± {}", significant(term.value, 3), significant(term.standard_error, 2));
        let (from, to) = (significant(term.from, 3), significant(term.to, 3));
        writeln!(text, "{:<14} {found:>17} {:<5} {from:>10} {to:>10}   {}", term.name, term.unit, term.verdict)?;
        if let Some(reason) = &term.reason {
            writeln!(text, "{:<14} {reason}", "")?;
        }
    }
    text.push('\n');
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

/// The history, one entry a line.
pub(super) fn entries(history: &History) -> Result<String> {
    let mut text = String::new();
    let now = history.in_effect();
    for entry in &history.entries {
        let what = match entry.deed {
            Deed::Begin => "begin".to_owned(),
            Deed::Look => "look, nothing to change".into(),
            Deed::Update if now.contains(&entry.entry) => "update".into(),
            Deed::Update => "update, taken back".into(),
            Deed::Undo => format!("undo, as before entry {}", entry.undone.unwrap_or_default()),
        };
        let time = entry.time.as_deref().unwrap_or("");
        let parts = entry.parts.map_or(String::new(), |parts| format!("part {parts}"));
        writeln!(text, "{:>4}  {time:<20} {parts:<10} {what}", entry.entry)?;
        for own in entry.measured.iter().filter(|own| own.from != own.to) {
            let (from, to) = (significant(own.from, 3), significant(own.to, 3));
            writeln!(
                text,
                "      {:<14} {from} -> {to} {} (± {})",
                own.term,
                own.unit,
                significant(own.standard_error, 2)
            )?;
        }
    }
    Ok(text)
}
