//! SVG elements inside a page.

use crate::number::printable;
use maud::{Markup, PreEscaped, html};
use plotters::{coord::Shift, prelude::*};

/// The drawing library rounds coordinates to whole units; at this multiple they are fine enough for curves.
pub(crate) const FINENESS: i32 = 4;

pub(crate) type Root<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(crate) type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// An `<svg>` element of this size in px: a picture with a description, or part of a text with a class.
pub(crate) fn element(
    size: [i32; 2],
    class: Option<&str>,
    description: Option<&str>,
    paint: impl FnOnce(&Root<'_>) -> Drawn,
) -> Markup {
    let [width, height] = size.map(|px| px * FINENESS);
    let mut svg = String::new();
    let drawn = {
        let root = SVGBackend::with_string(&mut svg, (width.unsigned_abs(), height.unsigned_abs())).into_drawing_area();
        paint(&root).and_then(|()| root.present())
    };
    if let Err(error) = drawn {
        return html! { p.empty { "The figure could not be drawn: " (error.to_string()) "." } };
    }
    // The drawing library's own root element has a size in px, which would keep the figure from scaling with the page.
    let inner = svg.split_once('>').and_then(|(_, rest)| rest.rsplit_once("</svg>")).map_or("", |(inner, _)| inner);
    let inner = printable(&inner.replace('\n', ""));
    html! {
        svg class=[class] viewBox={ "0 0 " (width) " " (height) } role=[description.map(|_| "img")]
            aria-label=[description.map(printable)] aria-hidden=[description.is_none().then_some("true")] xmlns="http://www.w3.org/2000/svg" { (PreEscaped(inner)) }
    }
}

/// Line style for the drawing library.
pub(crate) fn style(stroke: crate::Stroke) -> ShapeStyle {
    let width = (stroke.width * f64::from(FINENESS)).round().max(1.0) as u32;
    ShapeStyle { color: rgb(stroke.colour).mix(stroke.opacity), filled: false, stroke_width: width }
}

/// A colour for the drawing library.
pub(crate) fn rgb(colour: crate::Colour) -> RGBColor {
    RGBColor(colour.0, colour.1, colour.2)
}
