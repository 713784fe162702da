//! The page of `trueaxis keep`.

use maud::html;
use trueaxis_evaluation::keep::{Entry, ReprobingDocument, descriptions, figures};
use trueaxis_report::number::significant;
use trueaxis_report::{Page, Row, Table, summary};

/// The whole page: the entries, and the latest re-probing.
pub(crate) fn page(machine: &str, entries: &[Entry], document: Option<&ReprobingDocument>) -> String {
    let count = if entries.len() == 1 { "1 entry".to_owned() } else { format!("{} entries", entries.len()) };
    let mut page = Page::new("A machine that keeps itself true").top(summary([html! { (machine) }, html! { (count) }]));
    if let Some(document) = document {
        let terms = document.terms.iter().map(|term| {
            let shown = |value: f64| significant(value, 3);
            let found = format!("{} ± {} {}", shown(term.value), significant(term.standard_error, 2), term.unit);
            let bounds = format!("{}, {}", shown(term.largest_update), shown(term.largest_total));
            Row::new(term.name.clone(), [found, shown(term.from), shown(term.to), bounds, term.in_words()])
        });
        let head = ["term", "left by the tables", "in all", "then", "at most at once, in all", "verdict"];
        page = page.top(super::warnings(&document.notes));
        if !document.terms.is_empty() {
            page = page.section("This re-probing", Table::new(head, terms));
        }
    }
    let all = figures(entries);
    if !all.is_empty() {
        page = page.section("History", html! { @for figure in all { (figure) } });
    }
    let rows = entries.iter().zip(descriptions(entries)).map(|(entry, deed)| {
        let changed: Vec<String> = entry.measured.iter().filter_map(|own| own.in_words()).collect();
        let parts = entry.parts.map_or(String::new(), |parts| parts.to_string());
        Row::new(entry.entry.to_string(), [entry.time.clone().unwrap_or_default(), parts, deed, changed.join("; ")])
    });
    page.section("Entries", Table::new(["entry", "time", "parts", "", "changed"], rows)).document()
}
