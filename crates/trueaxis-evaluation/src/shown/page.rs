//! A result as a page.

use super::{Look, Plot, Shown};
use maud::{Markup, html};
use trueaxis_report::{Page, Table, side_by_side, summary};

/// More plots than this are drawn side by side.
const MANY: usize = 3;

impl Shown {
    /// The whole page. `source` is the name of the record, "" for none; `figures` are further figures: before the plots of the
    /// section with their heading, or in a section after all plots.
    pub fn page<H: AsRef<str>>(&self, source: &str, figures: impl IntoIterator<Item = (H, Markup)>) -> String {
        let parts = std::iter::once(source).filter(|source| !source.is_empty());
        let parts = parts.chain(self.summary.iter().map(String::as_str));
        let mut page = Page::new(&self.title).top(summary(parts.map(|part| html! { (part) }))).top(html! {
            @if !self.result.is_empty() { p.result { (self.result) } }
            @if !self.notes.is_empty() { ul { @for note in &self.notes { li { (note) } } } }
        });
        let mut tables = self.tables.iter().filter(|table| !table.rows.is_empty());
        if let Some(own) = tables.next() {
            page = page.top(Table::from(own).caption(&own.caption));
        }
        let mut figures: Vec<(H, Markup)> = figures.into_iter().collect();
        for plots in self.plots.chunk_by(|one, next| one.section == next.section) {
            let section = plots[0].section;
            let before = figures.extract_if(.., |(heading, _)| heading.as_ref() == section).map(|(_, figure)| figure);
            page = page.section(section, html! { @for figure in before { (figure) } (plotted(plots)) });
        }
        for polars in self.polars.chunk_by(|one, next| one.section == next.section) {
            page = page.section(polars[0].section, html! { @for polar in polars { (polar.figure()) } });
        }
        if let Some(map) = &self.map {
            page = page.section("Residuals over X and Y", map.figure());
        }
        for (heading, figure) in figures {
            page = page.section(heading.as_ref(), figure);
        }
        for own in tables {
            page = page.section(&own.caption, Table::from(own));
        }
        page.document()
    }
}

/// Plots of one part: points alone, or many curves, side by side; few curves one below the other.
fn plotted(plots: &[Plot]) -> Markup {
    let narrow = |plot: &Plot| {
        plot.look == Look::Points || plots.len() > MANY && plot.curves.iter().all(|curve| curve.expanded.is_empty())
    };
    let half = plots.len() > 1 && plots.iter().all(narrow);
    let figures = plots.iter().map(|plot| plot.figure(half));
    if half {
        side_by_side(figures)
    } else {
        html! { @for figure in figures { (figure) } }
    }
}
