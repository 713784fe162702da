use crate::{colour, number::printable};
use maud::{Markup, PreEscaped, Render, html};

const STYLE: &str = include_str!("style.css");
/// For readers who prefer a dark page; on paper it stays light.
const DARK: &str = "@media screen and (prefers-color-scheme: dark) {
  :root { color-scheme: dark; --ink: #e6e8eb; --paper: #14171b; --quiet: #a4abb5; --rule: #3b424b; --mesh: #2c323a; }
";
/// Elements are closed, so that any XML reader can read the page.
const HEAD: &str = r#"<meta charset="utf-8"/><meta name="viewport" content="width=device-width, initial-scale=1"/>"#;

/// A self-contained HTML page that is also well-formed XML: inline style, no address, no script. It is dark for readers who
/// prefer that, and light on paper.
#[derive(Clone, Debug)]
pub struct Page {
    title: String,
    style: &'static str,
    parts: Vec<Markup>,
}

impl Page {
    /// A page with this heading.
    #[must_use]
    pub fn new(title: impl Into<String>) -> Page {
        Page { title: title.into(), style: "", parts: Vec::new() }
    }

    /// Sets additional CSS for the page.
    #[must_use]
    pub fn style(mut self, css: &'static str) -> Page {
        self.style = css;
        self
    }

    /// Adds content before the first section.
    #[must_use]
    pub fn top(mut self, content: impl Render) -> Page {
        self.parts.push(content.render());
        self
    }

    /// Adds a section.
    #[must_use]
    pub fn section(mut self, heading: &str, content: impl Render) -> Page {
        self.parts.push(html! { section { h2 { (heading) } "\n" (content) } "\n" });
        self
    }

    /// The document. Characters that XML does not permit become spaces.
    #[must_use]
    pub fn document(&self) -> String {
        let body = html! { body { main { h1 { (self.title) } "\n" @for part in &self.parts { (part) } } } };
        let dark = format!("{DARK}{}}}\n", colour::on_dark(&body.0));
        let style = html! { style { (PreEscaped(STYLE)) (PreEscaped(dark)) (PreEscaped(self.style)) } };
        let page = html! {
            (PreEscaped("<!DOCTYPE html>\n"))
            html lang="en-GB" {
                head { (PreEscaped(HEAD)) title { (self.title) } (style) }
                "\n"
                (body)
            }
            "\n"
        };
        printable(&page.into_string())
    }
}

/// The line below the heading: how the result was obtained, in parts.
pub fn summary(parts: impl IntoIterator<Item = Markup>) -> Markup {
    html! {
        p.run { @for (i, part) in parts.into_iter().enumerate() { @if i > 0 { " · " } (part) } }
        "\n"
    }
}

/// A remark in place of a figure.
pub fn missing(text: impl Render) -> Markup {
    html! { p.empty { (text) } "\n" }
}

/// Figures side by side, two in a row if the page is wide enough.
pub fn side_by_side<T: Render>(figures: impl IntoIterator<Item = T>) -> Markup {
    html! { div.figures { @for figure in figures { (figure) } } "\n" }
}
