//! Presentation of a result: tables and plots, identical on the console, in a report and in the desk.
//!
//! An evaluation defines once the names, units, digits and uncertainties of its figures and the axes of its plots; the
//! console ([`Shown::text`]), the pages and the desk only render that definition.
//!
//! The number after ± is always an expanded uncertainty: half of the interval that contains the true value with 95 %.
//! [`Uncertainty`] is the only way to show one, and converts standard errors.

mod page;
mod plot;
mod quantity;
mod text;

pub use plot::{Around, Curve, Look, Map, Plot, Polar};
pub use quantity::{EXPANDED, Quantity, Uncertainty, half_width};

use serde::Serialize;
use trueaxis_report::number::{decimals, shortest, significant};

/// Everything shown of a result.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Shown {
    /// Name of the test.
    pub title: String,
    /// How the result was obtained, in parts.
    pub summary: Vec<String>,
    /// The most important figure in a sentence, or "".
    pub result: String,
    /// Remarks on the result, a sentence each.
    pub notes: Vec<String>,
    /// Tables, the most important first.
    pub tables: Vec<Table>,
    /// Plots in their order.
    pub plots: Vec<Plot>,
    /// Polar plots, after the others.
    pub polars: Vec<Polar>,
    /// A map, after all plots.
    pub map: Option<Map>,
}

/// A table; the first cell of every row is its name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table {
    /// Caption of the table.
    pub caption: String,
    /// Column headings.
    pub header: Vec<String>,
    /// Rows, a cell for every heading.
    pub rows: Vec<Vec<Cell>>,
    /// Column of percentages that are also drawn as bars.
    pub bars: Option<usize>,
}

/// A cell of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Cell {
    /// Text.
    Text(String),
    /// A number: as written, and at full precision.
    Number {
        /// The number as written.
        text: String,
        /// The number at full precision.
        value: f64,
    },
}

impl Table {
    /// A table with these column headings and rows.
    pub fn new(
        caption: impl Into<String>,
        header: impl IntoIterator<Item: Into<String>>,
        rows: impl IntoIterator<Item = Vec<Cell>>,
    ) -> Table {
        let header = header.into_iter().map(Into::into).collect();
        Table { caption: caption.into(), header, rows: rows.into_iter().collect(), bars: None }
    }

    /// A table of figures: name and value.
    pub fn figures<'n>(caption: &str, figures: impl IntoIterator<Item = (&'n str, Cell)>) -> Table {
        Table::new(caption, ["", "value"], figures.into_iter().map(|(name, value)| vec![name.into(), value]))
    }

    /// A table of quantities with their uncertainties, and their notes if there are any.
    pub fn quantities(caption: impl Into<String>, quantities: impl IntoIterator<Item = Quantity>) -> Table {
        let quantities: Vec<Quantity> = quantities.into_iter().collect();
        let noted = quantities.iter().any(|of| !of.note.is_empty());
        let rows = quantities.iter().map(|of| {
            let [value, uncertainty] = of.cells();
            let note = noted.then(|| of.note.as_str().into());
            [of.name().into(), value, uncertainty, of.unit.into()].into_iter().chain(note).collect()
        });
        let header = ["quantity", "value", EXPANDED, "unit"].into_iter().chain(noted.then_some("note"));
        Table::new(caption, header, rows)
    }

    /// Draws the percentages of a column as bars, too.
    #[must_use]
    pub fn bars(mut self, column: usize) -> Table {
        self.bars = Some(column);
        self
    }

    /// Whether a column, counted from 0, contains words rather than numbers.
    pub fn is_words(&self, column: usize) -> bool {
        self.rows.iter().all(|row| matches!(row.get(column), Some(Cell::Text(text)) if text != "–"))
    }
}

/// The table of a page, without its caption.
impl From<&Table> for trueaxis_report::Table {
    fn from(of: &Table) -> Self {
        let rows = of.rows.iter().map(|row| {
            let mut cells = row.iter().map(|cell| cell.text().to_owned());
            trueaxis_report::Row::new(cells.next().unwrap_or_default(), cells)
        });
        let words: Vec<usize> = (1..of.header.len()).filter(|column| of.is_words(*column)).collect();
        trueaxis_report::Table::new(of.header.iter().map(String::as_str), rows).words(&words)
    }
}

impl Cell {
    /// A number with `digits` significant digits; a dash for `None` or a number that is not finite.
    pub fn number(value: impl Into<Option<f64>>, digits: i32) -> Cell {
        Cell::written(value.into(), |value| significant(value, digits))
    }

    /// A number with `count` decimals.
    pub fn fixed(value: impl Into<Option<f64>>, count: i32) -> Cell {
        Cell::written(value.into(), |value| decimals(value, count))
    }

    /// A number as given: as many digits as it needs, at most six decimals.
    pub fn shortest(value: f64) -> Cell {
        Cell::written(Some(value), shortest)
    }

    /// A count.
    pub fn count(value: usize) -> Cell {
        Cell::fixed(value as f64, 0)
    }

    /// A share of the whole, 0 … 1, in percent.
    pub fn percent(share: f64) -> Cell {
        Cell::fixed(100.0 * share, 1)
    }

    fn written(value: Option<f64>, text: impl Fn(f64) -> String) -> Cell {
        match value.filter(|value| value.is_finite()) {
            Some(value) => Cell::Number { text: text(value), value },
            None => Cell::Text("–".into()),
        }
    }

    /// The cell as written.
    pub fn text(&self) -> &str {
        match self {
            Cell::Text(text) | Cell::Number { text, .. } => text,
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Cell {
        Cell::Text(text.into())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Cell {
        Cell::Text(text)
    }
}

/// A unit as written, from its name in a document.
pub fn unit(of: &str) -> &'static str {
    if of == "um" { "µm" } else { "µrad" }
}
