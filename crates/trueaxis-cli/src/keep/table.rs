//! A re-probing and a history as text and as a page.

use crate::output::{json, print};
use anyhow::Result;
use maud::html;
use trueaxis_evaluation::keep::{Entry, ReprobingDocument, figures, listed};
use trueaxis_evaluation::shown::Shown;

/// Prints a re-probing.
pub(super) fn put(document: &ReprobingDocument, as_json: bool) -> Result<()> {
    if as_json { json(document) } else { print(&document.shown().text()) }
}

/// The page of the latest re-probing, if any, and of all entries.
pub(super) fn page(machine: &str, entries: &[Entry], document: Option<&ReprobingDocument>) -> String {
    let count = if entries.len() == 1 { "1 entry".to_owned() } else { format!("{} entries", entries.len()) };
    let latest = document.map(ReprobingDocument::shown);
    let shown = Shown {
        title: "A machine that keeps itself true".into(),
        summary: vec![count],
        notes: latest.as_ref().map(|shown| shown.notes.clone()).unwrap_or_default(),
        tables: latest.into_iter().flat_map(|shown| shown.tables).chain([listed(entries)]).collect(),
        ..Shown::default()
    };
    let all = figures(entries);
    let history = (!all.is_empty()).then(|| ("History", html! { @for figure in all { (figure) } }));
    shown.page(machine, history)
}
