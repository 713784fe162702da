use maud::{Markup, Render, html};

/// A table; the first cell of every row is its name.
#[derive(Clone, Debug, Default)]
pub struct Table {
    caption: Option<String>,
    head: Vec<String>,
    rows: Vec<Row>,
    words: Vec<usize>,
}

/// A row of a [`Table`].
#[derive(Clone, Debug)]
pub struct Row {
    name: String,
    cells: Vec<String>,
    /// Whether one cell of text replaces all others.
    whole: bool,
}

impl Row {
    /// A name and a cell for each further column.
    pub fn new(name: impl Into<String>, cells: impl IntoIterator<Item = String>) -> Row {
        Row { name: name.into(), cells: cells.into_iter().collect(), whole: false }
    }

    /// A name and text across all other columns.
    pub fn whole(name: impl Into<String>, words: impl Into<String>) -> Row {
        Row { name: name.into(), cells: vec![words.into()], whole: true }
    }
}

impl Table {
    /// A table with these column headings and rows.
    #[must_use]
    pub fn new<'t>(head: impl IntoIterator<Item = &'t str>, rows: impl IntoIterator<Item = Row>) -> Table {
        Table { head: head.into_iter().map(Into::into).collect(), rows: rows.into_iter().collect(), ..Table::default() }
    }

    /// Sets the caption.
    #[must_use]
    pub fn caption(mut self, caption: &str) -> Table {
        self.caption = Some(caption.into());
        self
    }

    /// Marks these columns, counted from 0, as text instead of numbers.
    #[must_use]
    pub fn words(mut self, columns: &[usize]) -> Table {
        self.words = columns.to_vec();
        self
    }

    fn class(&self, column: usize) -> Option<&'static str> {
        self.words.contains(&column).then_some("words")
    }
}

impl Render for Table {
    fn render(&self) -> Markup {
        html! {
            table {
                @if let Some(caption) = &self.caption { caption { (caption) } }
                thead { tr { @for (i, head) in self.head.iter().enumerate() { th class=[self.class(i)] { (head) } } } }
                tbody {
                    @for row in &self.rows {
                        tr {
                            th { (row.name) }
                            @if row.whole {
                                td.words colspan=(self.head.len().saturating_sub(1)) { @for cell in &row.cells { (cell) } }
                            } @else {
                                @for (i, cell) in row.cells.iter().enumerate() {
                                    td class=[self.class(i + 1)] { (cell) }
                                }
                            }
                        }
                        "\n"
                    }
                }
            }
            "\n"
        }
    }
}
