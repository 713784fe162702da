//! Tables of a re-probing and of a history.

use super::document::ReprobingDocument;
use super::entry::Entry;
use super::words::descriptions;
use crate::shown::{Cell, EXPANDED, Shown, Table, Uncertainty};
use trueaxis_report::number::significant;

impl ReprobingDocument {
    /// Tables of the document: terms with their verdicts, balls.
    pub fn shown(&self) -> Shown {
        let known = |standard_error: f64| Uncertainty::of(standard_error, self.degrees_of_freedom);
        let terms = self.terms.iter().map(|term| {
            let uncertainty = known(term.standard_error);
            let numbers = [term.significance, term.from, term.to, term.largest_update, term.largest_total];
            [term.name.as_str().into(), uncertainty.value(term.value), uncertainty.cell()]
                .into_iter()
                .chain(numbers.map(|number| Cell::number(number, 3)))
                .chain([term.unit.into(), term.in_words().into()])
                .collect()
        });
        let head = [
            "term",
            "left by the tables",
            EXPANDED,
            "significance",
            "updates in all",
            "then",
            "at most at once",
            "at most in all",
            "unit",
            "verdict",
        ];
        let balls = self.balls.iter().map(|ball| {
            let error = ball.standard_error_um.into_iter().fold(0.0, f64::max);
            let centre = ball.centre_mm.map(|mm| Cell::fixed(mm, 5));
            std::iter::once(ball.name.as_str().into()).chain(centre).chain([known(error).cell()]).collect()
        });
        let balls_head = ["ball", "X, mm", "Y, mm", "Z, mm", &format!("{EXPANDED}, µm")];
        let balls = Table::new("Positions of the balls", balls_head, balls);
        Shown {
            title: "Re-probing".into(),
            summary: vec![
                format!("{} touches on {}", self.touches, self.machine),
                format!("entry {}", self.entry),
                format!("{} µm a touch", significant(self.sigma_um, 2)),
            ],
            notes: self.notes.clone(),
            tables: vec![Table::new("Verdicts", head, terms), balls],
            ..Shown::default()
        }
    }
}

/// The entries of a history.
pub fn listed(entries: &[Entry]) -> Table {
    let rows = entries.iter().zip(descriptions(entries)).map(|(entry, deed)| {
        let changed: Vec<String> = entry.measured.iter().filter_map(|own| own.in_words()).collect();
        let parts = entry.parts.map_or(String::new(), |parts| parts.to_string());
        let number = Cell::count(entry.entry as usize);
        vec![
            number,
            entry.time.clone().unwrap_or_default().into(),
            parts.into(),
            deed.into(),
            changed.join("; ").into(),
        ]
    });
    Table::new("Entries", ["entry", "time", "parts", "what was done", "changed"], rows)
}
