//! The pages of `trueaxis evaluate`.

use maud::{Markup, html};
use trueaxis_evaluation::shown::{Cell, Look, Plot, Shown, Table};
use trueaxis_report::{Page, Row, side_by_side, summary};

/// The whole page; `source` is the name of the record.
pub(crate) fn page(source: &str, shown: &Shown) -> String {
    let parts = std::iter::once(source).chain(shown.summary.iter().map(String::as_str));
    let mut page =
        Page::new(shown.title).top(summary(parts.map(|part| html! { (part) }))).top(super::warnings(&shown.notes));
    let (first, others) = shown.tables.split_at(shown.tables.len().min(1));
    for own in first {
        page = page.top(table(own));
    }
    for plots in shown.plots.chunk_by(|one, next| one.section == next.section) {
        page = page.section(plots[0].section, figures(plots));
    }
    if let Some(map) = &shown.map {
        page = page.section("Residuals over X and Y", map.figure());
    }
    for own in others {
        page = page.section(own.caption, table(own));
    }
    page.document()
}

/// Plots of one part: points alone side by side, curves one below the other.
fn figures(plots: &[Plot]) -> Markup {
    let half = plots.len() > 1 && plots.iter().all(|plot| plot.look == Look::Points);
    let figures = plots.iter().map(|plot| plot.figure(half));
    if half {
        side_by_side(figures)
    } else {
        html! { @for figure in figures { (figure) } }
    }
}

fn table(of: &Table) -> trueaxis_report::Table {
    let rows = of.rows.iter().map(|row| {
        let mut cells = row.iter().map(|cell| cell.text().to_owned());
        Row::new(cells.next().unwrap_or_default(), cells)
    });
    let words = (1..of.header.len())
        .filter(|column| of.rows.iter().all(|row| matches!(row.get(*column), Some(Cell::Text(text)) if text != "–")));
    trueaxis_report::Table::new(of.header.iter().copied(), rows).words(&words.collect::<Vec<_>>())
}
