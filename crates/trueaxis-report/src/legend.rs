//! A legend as a row above a figure, outside the plot, so that it never covers data.

use crate::{
    Colour, Stroke,
    svg::{self, FINENESS},
};
use maud::{Markup, html};
use plotters::prelude::*;

/// One entry of a legend.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Key {
    pub(crate) swatch: Swatch,
    pub(crate) text: String,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Swatch {
    Line(Stroke),
    Area(Colour),
}

pub(crate) fn legend(keys: &[Key]) -> Markup {
    html! {
        @if !keys.is_empty() {
            div.legend { @for key in keys { span.key { (swatch(key.swatch)) (key.text) } } }
        }
    }
}

fn swatch(swatch: Swatch) -> Markup {
    let at = |x: i32, y: i32| (x * FINENESS, y * FINENESS);
    svg::element([26, 8], Some("swatch"), None, |root| match swatch {
        Swatch::Area(colour) => root.draw(&Rectangle::new([at(3, 0), at(23, 8)], svg::rgb(colour).filled())),
        Swatch::Line(stroke) => {
            let style = svg::style(Stroke::new(stroke.colour, 2.5));
            let dashes: &[(i32, i32)] = if stroke.dashed { &[(1, 7), (10, 16), (19, 25)] } else { &[(1, 25)] };
            dashes.iter().try_for_each(|&(from, to)| root.draw(&PathElement::new([at(from, 4), at(to, 4)], style)))
        }
    })
}
