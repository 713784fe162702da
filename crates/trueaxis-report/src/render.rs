//! Rendering of a figure as an element of the page.

use crate::{Figure, draw, figure::Layer, legend::legend};
use maud::{Markup, Render, html};

impl Figure {
    /// Renders the figure as HTML, for pages that are not a [`Page`](crate::Page).
    #[must_use]
    pub fn to_html(&self) -> String {
        self.render().into_string()
    }
}

impl Render for Figure {
    fn render(&self) -> Markup {
        let drawable = self.layers.iter().any(|layer| !matches!(layer, Layer::Text { .. }));
        html! {
            figure class=(self.class) {
                (legend(&self.keys))
                @if drawable { (draw::plot(self)) } @else { p.empty { "There is nothing to draw." } }
                figcaption { (self.caption) }
            }
            "\n"
        }
    }
}
