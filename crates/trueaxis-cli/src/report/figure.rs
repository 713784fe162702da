//! One figure: a frame with or without axes, drawn to SVG that stands inside the page.

use super::text::{escape, tick};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// The drawing library rounds coordinates to whole units; drawn at this multiple they are fine enough for curves.
const FINENESS: i32 = 4;
/// Text height, px; the library writes a font of size s as s/1.24.
const TEXT_PX: f64 = 11.0 * 1.24;

const TEXT: RGBColor = RGBColor(51, 56, 64);
const MESH: RGBColor = RGBColor(228, 231, 235);
const EDGE: RGBColor = RGBColor(120, 126, 135);

/// Colours that stay apart for colour-blind readers and in grey print.
pub(super) mod colour {
    use plotters::style::RGBColor;
    /// What was measured.
    pub(crate) const PROFILE: RGBColor = RGBColor(31, 36, 48);
    /// Least squares, direction X.
    pub(crate) const BLUE: RGBColor = RGBColor(0, 90, 170);
    /// Minimum zone, direction Y.
    pub(crate) const ORANGE: RGBColor = RGBColor(213, 94, 0);
    /// Minimum circumscribed.
    pub(crate) const GREEN: RGBColor = RGBColor(0, 140, 100);
    /// Maximum inscribed.
    pub(crate) const PURPLE: RGBColor = RGBColor(130, 70, 160);
    /// Limits, what was left out.
    pub(crate) const RED: RGBColor = RGBColor(160, 20, 40);
    /// Scales and single revolutions.
    pub(crate) const GREY: RGBColor = RGBColor(150, 156, 165);
}

pub(super) type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;
type Coordinates = Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>;

/// A line's look; width in px.
#[derive(Clone, Copy)]
pub(super) struct Stroke {
    pub(super) colour: RGBColor,
    pub(super) width: f64,
    pub(super) opacity: f64,
}

impl Stroke {
    pub(super) const fn new(colour: RGBColor, width: f64) -> Stroke {
        Stroke { colour, width, opacity: 1.0 }
    }

    fn style(self) -> ShapeStyle {
        let width = (self.width * f64::from(FINENESS)).round().max(1.0) as u32;
        ShapeStyle { color: self.colour.mix(self.opacity), filled: false, stroke_width: width }
    }
}

/// Captions of a figure's axes.
pub(super) struct Axes<'t> {
    pub(super) x: &'t str,
    pub(super) y: &'t str,
    /// The vertical axis holds decimal logarithms.
    pub(super) logarithmic: bool,
}

/// Size and ranges of a figure.
pub(super) struct Figure<'t> {
    /// What it shows, for readers who cannot see it.
    pub(super) description: &'t str,
    /// Width and height, px.
    pub(super) size: [i32; 2],
    pub(super) x: Range<f64>,
    pub(super) y: Range<f64>,
    /// None: no axes, the whole figure is the plot.
    pub(super) axes: Option<Axes<'t>>,
}

impl Figure<'_> {
    /// Draws the frame, then what `paint` adds; returns an `<svg>` element.
    pub(super) fn draw(&self, paint: impl FnOnce(&mut Plot<'_, '_>) -> Drawn) -> String {
        let [width, height] = self.size.map(|size| size * FINENESS);
        let mut svg = String::new();
        if let Err(error) = self.draw_into(&mut svg, [width, height], paint) {
            return format!("<p class=\"empty\">The figure could not be drawn: {}.</p>", escape(&error.to_string()));
        }
        let head = format!(
            "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\" xmlns=\"http://www.w3.org/2000/svg\">",
            escape(self.description)
        );
        svg.split_once('>').map_or_else(String::new, |(_, body)| head + body.trim_end())
    }

    fn draw_into(
        &self,
        svg: &mut String,
        [width, height]: [i32; 2],
        paint: impl FnOnce(&mut Plot<'_, '_>) -> Drawn,
    ) -> Drawn {
        let root = SVGBackend::with_string(svg, (width.unsigned_abs(), height.unsigned_abs())).into_drawing_area();
        let mut builder = ChartBuilder::on(&root);
        if self.axes.is_some() {
            builder.margin(10 * FINENESS).x_label_area_size(38 * FINENESS).y_label_area_size(56 * FINENESS);
        }
        let mut chart = builder.build_cartesian_2d(self.x.clone(), self.y.clone())?;
        if let Some(axes) = &self.axes {
            let vertical = |value: &f64| if axes.logarithmic { tick(10_f64.powf(*value)) } else { tick(*value) };
            let whole = ((self.y.end - self.y.start).floor() as usize + 1).max(2);
            chart
                .configure_mesh()
                .bold_line_style(Stroke::new(MESH, 0.8).style())
                .light_line_style(TRANSPARENT)
                .axis_style(Stroke::new(EDGE, 1.0).style())
                .set_all_tick_mark_size(4 * FINENESS)
                .label_style(text_style(TEXT))
                .axis_desc_style(text_style(TEXT))
                .x_desc(axes.x)
                .y_desc(axes.y)
                .x_label_formatter(&|value| tick(*value))
                .y_label_formatter(&vertical)
                .y_labels(if axes.logarithmic { whole } else { 7 })
                .draw()?;
        }
        paint(&mut Plot { chart, root: &root })?;
        root.present()
    }
}

fn text_style(colour: RGBColor) -> TextStyle<'static> {
    TextStyle { color: colour.to_backend_color(), ..("sans-serif", TEXT_PX * f64::from(FINENESS)).into() }
}

/// The inside of a figure, in its own coordinates.
pub(super) struct Plot<'a, 'b> {
    chart: ChartContext<'a, SVGBackend<'b>, Coordinates>,
    root: &'a DrawingArea<SVGBackend<'b>, plotters::coord::Shift>,
}

impl Plot<'_, '_> {
    /// A curve through the points.
    pub(super) fn line(&mut self, points: impl IntoIterator<Item = [f64; 2]>, stroke: Stroke) -> Drawn {
        let points: Vec<(f64, f64)> = points.into_iter().map(|[x, y]| (x, y)).collect();
        self.chart.draw_series([PathElement::new(points, stroke.style())]).map(|_| ())
    }

    /// A bold curve that stays visible on top of many others.
    pub(super) fn bold(&mut self, points: Vec<[f64; 2]>, colour: RGBColor) -> Drawn {
        self.line(points.iter().copied(), Stroke::new(WHITE, 4.5))?;
        self.line(points, Stroke::new(colour, 2.2))
    }

    /// A dashed curve through the points.
    pub(super) fn dashed(&mut self, points: impl IntoIterator<Item = [f64; 2]>, stroke: Stroke) -> Drawn {
        let points: Vec<(f64, f64)> = points.into_iter().map(|[x, y]| (x, y)).collect();
        let dashes = DashedLineSeries::new(points, 7 * FINENESS, 4 * FINENESS, stroke.style());
        self.chart.draw_series(dashes).map(|_| ())
    }

    /// A filled box.
    pub(super) fn fill(&mut self, from: [f64; 2], to: [f64; 2], colour: RGBColor, opacity: f64) -> Drawn {
        let corners = [(from[0], from[1]), (to[0], to[1])];
        self.chart.draw_series([Rectangle::new(corners, colour.mix(opacity).filled())]).map(|_| ())
    }

    /// A dot.
    pub(super) fn dot(&mut self, [x, y]: [f64; 2], colour: RGBColor) -> Drawn {
        self.chart.draw_series([Circle::new((x, y), 3 * FINENESS, colour.filled())]).map(|_| ())
    }

    /// Text centred about a point.
    pub(super) fn text(&mut self, [x, y]: [f64; 2], text: &str) -> Drawn {
        let at = self.chart.backend_coord(&(x, y));
        let style = text_style(TEXT).pos(Pos::new(HPos::Center, VPos::Center));
        self.root.draw(&Text::new(text.to_owned(), at, style))
    }
}

/// One entry of a legend.
pub(super) struct Key<'t> {
    pub(super) colour: RGBColor,
    pub(super) dashed: bool,
    pub(super) text: &'t str,
}

/// A figure element: legend, drawing and caption; `class` sets its width.
pub(super) fn framed(class: &str, keys: &[Key<'_>], svg: &str, caption: &str) -> String {
    let entry = |key: &Key<'_>| {
        let RGBColor(red, green, blue) = key.colour;
        let dashes = if key.dashed { " stroke-dasharray=\"6 3\"" } else { "" };
        format!(
            "<span class=\"key\"><svg class=\"swatch\" viewBox=\"0 0 26 8\" xmlns=\"http://www.w3.org/2000/svg\">\
             <path d=\"M1 4H25\" stroke=\"#{red:02x}{green:02x}{blue:02x}\" stroke-width=\"2.5\"{dashes}/></svg>{}</span>",
            escape(key.text)
        )
    };
    let legend: String = keys.iter().map(entry).collect();
    format!(
        "<figure class=\"{class}\"><div class=\"legend\">{legend}</div>{svg}<figcaption>{}</figcaption></figure>\n",
        escape(caption)
    )
}
