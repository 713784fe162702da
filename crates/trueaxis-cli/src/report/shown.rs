//! The page of a result.

use anyhow::Result;
use maud::{Markup, html};
use std::path::Path;
use trueaxis_evaluation::shown::{Look, Plot, Shown};
use trueaxis_report::{Page, side_by_side, summary};
use trueaxis_tables::output::Outputs;

/// Stages the page of a result from the file `record`, with [`page`]'s figures.
pub(crate) fn stage<H: AsRef<str>>(
    outputs: &mut Outputs,
    to: (&Path, &str),
    record: &Path,
    shown: &Shown,
    figures: impl IntoIterator<Item = (H, Markup)>,
) -> Result<()> {
    let source = record.file_name().unwrap_or_default().to_string_lossy();
    super::write(outputs, &page(&source, shown, figures), to.0, to.1)
}

/// No sections of the result's own.
pub(crate) const NO_FIGURES: [(&str, Markup); 0] = [];

/// The whole page. `source` is the name of the record, "" for none; `figures` are sections of the result's own, after the plots.
pub(crate) fn page<H: AsRef<str>>(
    source: &str,
    shown: &Shown,
    figures: impl IntoIterator<Item = (H, Markup)>,
) -> String {
    let parts = std::iter::once(source).filter(|source| !source.is_empty());
    let parts = parts.chain(shown.summary.iter().map(String::as_str));
    let mut page =
        Page::new(&shown.title).top(summary(parts.map(|part| html! { (part) }))).top(super::warnings(&shown.notes));
    let mut tables = shown.tables.iter().filter(|table| !table.rows.is_empty());
    if let Some(own) = tables.next() {
        page = page.top(trueaxis_report::Table::from(own).caption(&own.caption));
    }
    for plots in shown.plots.chunk_by(|one, next| one.section == next.section) {
        page = page.section(plots[0].section, plotted(plots));
    }
    if let Some(map) = &shown.map {
        page = page.section("Residuals over X and Y", map.figure());
    }
    for (heading, figure) in figures {
        page = page.section(heading.as_ref(), figure);
    }
    for own in tables {
        page = page.section(&own.caption, trueaxis_report::Table::from(own));
    }
    page.document()
}

/// Plots of one part: points alone side by side, curves one below the other.
fn plotted(plots: &[Plot]) -> Markup {
    let half = plots.len() > 1 && plots.iter().all(|plot| plot.look == Look::Points);
    let figures = plots.iter().map(|plot| plot.figure(half));
    if half {
        side_by_side(figures)
    } else {
        html! { @for figure in figures { (figure) } }
    }
}
