//! A result as text for the console.

use super::{Shown, Table};
use std::fmt;
use trueaxis_tables::text::aligned;

impl Shown {
    /// The result as text: summary, sentence, tables with rows, notes; no plots.
    pub fn text(&self) -> String {
        let mut text = format!("{}: {}\n", self.title, self.summary.join(", "));
        if !self.result.is_empty() {
            text += &format!("\n{}\n", self.result);
        }
        for table in self.tables.iter().filter(|table| !table.rows.is_empty()) {
            text += &format!("\n{table}");
        }
        if !self.notes.is_empty() {
            text.push('\n');
        }
        for note in &self.notes {
            text += &format!("note: {note}\n");
        }
        text
    }
}

/// Caption, headings and rows, a line each; numbers are aligned to the right.
impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let header: Vec<&str> = self.header.iter().map(String::as_str).collect();
        let rows = self.rows.iter().map(|row| row.iter().map(|cell| cell.text()).collect());
        let lines: Vec<Vec<&str>> = std::iter::once(header).chain(rows).collect();
        writeln!(f, "{}", self.caption)?;
        aligned(&lines, |column| self.is_words(column)).lines().try_for_each(|line| writeln!(f, "  {line}"))
    }
}

#[cfg(test)]
mod tests {
    use crate::shown::{Cell, Quantity, Shown, Table, Uncertainty};

    #[test]
    fn tables_are_aligned() {
        let terms = [
            Quantity::new("squareness C0Y", "µrad", 50.04, Uncertainty::Expanded(0.31)),
            Quantity::new("play", "µm", 3.0, Uncertainty::Held("held")).noted("of the machine"),
        ];
        let shown = Shown {
            title: "Test".into(),
            summary: vec!["3 readings".into(), "rank 2".into()],
            notes: vec!["no more".into()],
            tables: vec![
                Table::quantities("Terms", terms),
                Table::figures("Fit", [("left, µm", Cell::number(0.5, 2))]),
            ],
            ..Shown::default()
        };
        let needed = "\
Test: 3 readings, rank 2

Terms
  quantity        value  ± 95 %  unit  note
  squareness C0Y  50.04    0.31  µrad
  play            3.000    held  µm    of the machine

Fit
            value
  left, µm   0.50

note: no more
";
        assert_eq!(shown.text(), needed);
    }
}
