//! A figure's frame and layers as SVG.

use crate::{
    Figure, Mark, Scale, Stroke, colour,
    colour::Colour,
    figure::Layer,
    mark,
    size::{BOTTOM, HALF_PX, LEFT, RIGHT, TOP, inside},
    svg::{self, Drawn, FINENESS, Root, rgb, style},
};
use maud::Markup;
use plotters::{
    coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter},
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};
use std::ops::Range;

const TICK_TEXT: i32 = 11;
const LABEL_TEXT: i32 = 12;
/// The drawing library writes a font of size s as s/1.24.
const FONT_FACTOR: f64 = 1.24;
/// Height of one row of labels above the plot.
const ROW: i32 = 15;
/// Space above the plot for labels without a separate row.
const HEAD: i32 = 12;

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;

/// The figure's plot as an `<svg>` element.
pub(crate) fn plot(figure: &Figure) -> Markup {
    let [width, height] = figure.size;
    let rows = mark::rows(&figure.marks, &figure.x, inside(width, height)[0], TICK_TEXT);
    let head = if figure.above.is_empty() { 0 } else { HEAD } + ROW * rows.iter().map(|row| row + 1).max().unwrap_or(0);
    svg::element([width, height + head], None, Some(&figure.description), |root| {
        let mut chart = frame(figure, root, TOP + head)?;
        for (mark, row) in figure.marks.iter().zip(rows) {
            draw_mark(root, &chart, figure, mark, (TOP - 4 + ROW * row) * FINENESS)?;
        }
        for (x, text) in &figure.above {
            let ends = vec![[*x, figure.y.low], [*x, figure.y.high]];
            line(&mut chart, &ends, Stroke::new(colour::EDGE, 0.6).opacity(0.4))?;
            write(root, &chart, [*x, figure.y.high], text, VPos::Bottom, 3)?;
        }
        figure.layers.iter().try_for_each(|layer| draw_layer(root, &mut chart, layer))
    })
}

/// Axes with ticks and captions.
fn frame<'a, 'b>(figure: &Figure, root: &'a Root<'b>, top: i32) -> Result<Chart<'a, 'b>, DrawError> {
    let mut builder = ChartBuilder::on(root);
    if figure.axes {
        builder
            .margin_top(top * FINENESS)
            .margin_right(RIGHT * FINENESS)
            .margin_left(4 * FINENESS)
            .x_label_area_size(BOTTOM * FINENESS)
            .y_label_area_size((LEFT - 4) * FINENESS);
    }
    let across = if figure.size[0] > HALF_PX { 12 } else { 8 };
    let mut chart = builder.build_cartesian_2d(Axis::of(&figure.x, across), Axis::of(&figure.y, 6))?;
    if figure.axes {
        chart
            .configure_mesh()
            .bold_line_style(style(Stroke::new(colour::MESH, 0.8)))
            .light_line_style(TRANSPARENT)
            .axis_style(style(Stroke::new(colour::EDGE, 1.0)))
            .set_all_tick_mark_size(4 * FINENESS)
            .label_style(text_style(TICK_TEXT, colour::TEXT))
            .axis_desc_style(text_style(LABEL_TEXT, colour::TEXT))
            .x_desc(&figure.x.caption)
            .y_desc(&figure.y.caption)
            .draw()?;
    }
    Ok(chart)
}

type DrawError = DrawingAreaErrorKind<std::io::Error>;

fn draw_layer<'b>(root: &Root<'b>, chart: &mut Chart<'_, 'b>, layer: &Layer) -> Drawn {
    match layer {
        Layer::Line { points, stroke } => line(chart, points, *stroke),
        Layer::Dot { at: [x, y], radius, colour } => {
            let px = (radius * f64::from(FINENESS)).round() as i32;
            chart.draw_series([Circle::new((*x, *y), px, rgb(*colour).filled())]).map(|_| ())
        }
        Layer::Area { from, to, colour, opacity } => {
            let corners = [(from[0], from[1]), (to[0], to[1])];
            chart.draw_series([Rectangle::new(corners, rgb(*colour).mix(*opacity).filled())]).map(|_| ())
        }
        Layer::Text { at, text, above: true } => write(root, chart, *at, text, VPos::Bottom, 5),
        Layer::Text { at, text, above: false } => write(root, chart, *at, text, VPos::Center, 0),
    }
}

fn line(chart: &mut Chart<'_, '_>, points: &[[f64; 2]], stroke: Stroke) -> Drawn {
    let points: Vec<(f64, f64)> = points.iter().map(|[x, y]| (*x, *y)).collect();
    if stroke.dashed {
        chart.draw_series(DashedLineSeries::new(points, 7 * FINENESS, 4 * FINENESS, style(stroke))).map(|_| ())
    } else {
        chart.draw_series([PathElement::new(points, style(stroke))]).map(|_| ())
    }
}

/// Writes text centred about a point, or `rise` px above it.
fn write(root: &Root<'_>, chart: &Chart<'_, '_>, at: [f64; 2], text: &str, anchor: VPos, rise: i32) -> Drawn {
    let (x, y) = chart.backend_coord(&(at[0], at[1]));
    let style = text_style(TICK_TEXT, colour::TEXT).pos(Pos::new(HPos::Center, anchor));
    root.draw(&Text::new(text.to_owned(), (x, y - rise * FINENESS), style))
}

fn draw_mark(root: &Root<'_>, chart: &Chart<'_, '_>, figure: &Figure, mark: &Mark, label_top: i32) -> Drawn {
    let (x, bottom) = chart.backend_coord(&(mark.x, figure.y.low));
    let style = style(Stroke::new(mark.colour, 1.3));
    let (dash, gap) = if mark.dashed { (6 * FINENESS, 4 * FINENESS) } else { (bottom - label_top, 1) };
    for start in (label_top..bottom).step_by((dash + gap).unsigned_abs() as usize) {
        root.draw(&PathElement::new([(x, start), (x, (start + dash).min(bottom))], style))?;
    }
    let text = text_style(TICK_TEXT, mark.colour).pos(Pos::new(HPos::Left, VPos::Top));
    root.draw(&Text::new(mark.text.clone(), (x + 4 * FINENESS, label_top), text))
}

fn text_style(size: i32, colour: Colour) -> TextStyle<'static> {
    let font = ("sans-serif", f64::from(size * FINENESS) * FONT_FACTOR);
    TextStyle { color: rgb(colour).to_backend_color(), ..font.into() }
}

/// A scale with its ticks, as the drawing library reads it.
struct Axis {
    scale: Scale,
    ticks: Vec<(f64, String)>,
}

impl Axis {
    fn of(scale: &Scale, count: u32) -> Axis {
        Axis { scale: scale.clone(), ticks: scale.labels(count) }
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        (f64::from(first) + self.scale.share(*value) * f64::from(last - first)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.iter().map(|tick| tick.0).collect() }
    }

    fn range(&self) -> Range<f64> {
        self.scale.low..self.scale.high
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        self.ticks.iter().find(|tick| tick.0 == *value).map_or_else(String::new, |tick| tick.1.clone())
    }
}
