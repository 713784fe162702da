//! One figure: a frame with scales, ticks and labels, drawn to SVG that stands inside the page.

use std::ops::Range;

use plotters::{
    coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter},
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use super::number::{PLOTTABLE, decimals, escape, printable};

/// The drawing library rounds coordinates to whole units; drawn at this multiple they are fine enough for curves.
const FINENESS: i32 = 4;
const TICK_TEXT: i32 = 11;
const LABEL_TEXT: i32 = 12;
/// The drawing library writes a font of size s as s/1.24.
const FONT_FACTOR: f64 = 1.24;
const LEFT: i32 = 62;
const BOTTOM: i32 = 40;
const RIGHT: i32 = 16;
const TOP: i32 = 10;
/// Height of one row of labels above the plot.
const ROW: i32 = 15;
/// Mean advance of a character in units of the text size; labels are spaced by it.
const ADVANCE: f64 = 0.56;

const TEXT: RGBColor = RGBColor(51, 56, 64);
const MESH: RGBColor = RGBColor(228, 231, 235);
const EDGE: RGBColor = RGBColor(120, 126, 135);

/// Colours, the same in every figure; chosen to stay apart for colour-blind readers and in grey print.
pub(super) mod colour {
    use plotters::style::RGBColor;
    /// The programmed path.
    pub(crate) const NOMINAL: RGBColor = RGBColor(107, 114, 128);
    /// Without compensation.
    pub(crate) const UNCOMPENSATED: RGBColor = RGBColor(213, 94, 0);
    /// With compensation.
    pub(crate) const COMPENSATED: RGBColor = RGBColor(0, 90, 170);
    /// The same servo on a geometrically perfect machine.
    pub(crate) const SERVO: RGBColor = RGBColor(0, 140, 100);
    /// Corrections, latencies: what is neither of the above.
    pub(crate) const NEUTRAL: RGBColor = RGBColor(92, 72, 150);
    /// Limits, budgets and periods.
    pub(crate) const LIMIT: RGBColor = RGBColor(160, 20, 40);
}

type DrawError = DrawingAreaErrorKind<std::io::Error>;
pub(super) type Drawn = Result<(), DrawError>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Scale, Scale>>;

/// Whether a value can be drawn.
pub(super) fn plottable(value: f64) -> bool {
    value.abs() <= PLOTTABLE
}

/// The points of a series that can be drawn.
pub(super) fn plottable_points(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    points.iter().copied().filter(|point| point.iter().all(|&value| plottable(value))).collect()
}

/// Range, ticks and caption of one axis of a figure.
#[derive(Debug, Clone)]
pub(super) struct Scale {
    pub(super) caption: String,
    pub(super) low: f64,
    pub(super) high: f64,
    ticks: Vec<(f64, String)>,
}

impl Scale {
    /// A linear scale over the values, `margin` of their span wider on either side, with about `count` ticks.
    pub(super) fn linear(caption: &str, values: impl IntoIterator<Item = f64>, margin: f64, count: u32) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.into_iter().filter(|&value| plottable(value)) {
            low = low.min(value);
            high = high.max(value);
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        // Identical values, or values that differ by rounding only, still need a span to be seen in.
        let size = low.abs().max(high.abs());
        if high - low <= 1e-9 * size || high == low {
            let half = if size > 0.0 { 0.05 * size } else { 0.5 };
            (low, high) = (low - half, high + half);
        }
        let extra = margin * (high - low);
        Self::exact(caption, low - extra, high + extra, count)
    }

    /// A linear scale from `low` to `high`.
    pub(super) fn exact(caption: &str, low: f64, high: f64, count: u32) -> Self {
        let rough = (high - low) / f64::from(count.max(1));
        let power = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power).into_iter().find(|step| *step >= 0.999 * rough);
        let step = step.unwrap_or(rough);
        let places = (-(step.log10() + 1e-9).floor() as i32).clamp(0, 9);
        let first = (low / step - 1e-9).ceil();
        let slack = 1e-6 * (high - low);
        let ticks = (0..64)
            .map(|k| (first + f64::from(k)) * step)
            .take_while(|tick| *tick <= high + slack)
            // Where the span is near the resolution of the numbers, the first multiple may round to below it.
            .filter(|tick| *tick >= low - slack)
            .map(|tick| (tick, decimals(tick, places)))
            .collect();
        Self { caption: printable(caption), low, high, ticks }
    }

    /// A scale in decimal logarithms: `low` and `high` are logarithms, labels are the numbers.
    pub(super) fn logarithmic(caption: &str, low: f64, high: f64, between: bool) -> Self {
        let digits: &[f64] = if between { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let decades = (low.floor() as i32)..=(high.ceil() as i32);
        let ticks = decades
            .flat_map(|decade| digits.iter().map(move |digit| digit * 10_f64.powi(decade)))
            .filter(|value| (low..=high).contains(&value.log10()))
            .map(|value| (value.log10(), decimals(value, (-(value.log10() + 1e-9).floor() as i32).clamp(0, 9))))
            .collect();
        Self { caption: printable(caption), low, high, ticks }
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        let share = (value - self.low) / (self.high - self.low);
        (f64::from(first) + share * f64::from(last - first)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.iter().map(|tick| tick.0).collect() }
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Scale {
    fn format_ext(&self, value: &f64) -> String {
        self.ticks.iter().find(|tick| tick.0 == *value).map_or_else(String::new, |tick| tick.1.clone())
    }
}

/// A vertical line with a label above the plot.
#[derive(Debug, Clone)]
pub(super) struct Mark {
    pub(super) x: f64,
    pub(super) text: String,
    pub(super) colour: RGBColor,
    pub(super) dashed: bool,
}

/// A line's look; width in px.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stroke {
    pub(super) colour: RGBColor,
    pub(super) width: f64,
    pub(super) opacity: f64,
}

impl Stroke {
    pub(super) const fn new(colour: RGBColor, width: f64) -> Self {
        Self { colour, width, opacity: 1.0 }
    }

    fn style(self) -> ShapeStyle {
        let width = (self.width * f64::from(FINENESS)).round().max(1.0) as u32;
        ShapeStyle { color: self.colour.mix(self.opacity), filled: false, stroke_width: width }
    }
}

/// Size and scales of a figure.
#[derive(Debug, Clone)]
pub(super) struct Figure {
    /// What the figure shows, for readers who cannot see it.
    pub(super) description: String,
    /// Width of the whole figure in px.
    pub(super) width: i32,
    /// Height of the whole figure in px, without what stands above the plot.
    pub(super) height: i32,
    /// Space above the plot for [`Plot::tick_above`], in px.
    pub(super) head: i32,
    pub(super) x: Scale,
    pub(super) y: Scale,
    pub(super) marks: Vec<Mark>,
}

impl Figure {
    /// Width and height of the area inside the axes of a figure of this size, in px.
    pub(super) const fn inside(width: i32, height: i32) -> [i32; 2] {
        [width - LEFT - RIGHT, height - TOP - BOTTOM]
    }

    /// Draws frame and marks, then what `paint` adds; returns an `<svg>` element.
    pub(super) fn draw(&self, paint: impl FnOnce(&mut Plot<'_, '_>) -> Drawn) -> String {
        let rows = self.mark_rows();
        let top = TOP + self.head + ROW * rows.iter().map(|row| row + 1).max().unwrap_or(0);
        let (width, height) = (self.width * FINENESS, (self.height + top - TOP) * FINENESS);
        let mut svg = String::new();
        let drawn = self.draw_into(&mut svg, width, height, top, &rows, paint);
        if let Err(error) = drawn {
            return format!("<p class=\"empty\">The figure could not be drawn: {}.</p>", escape(&error.to_string()));
        }
        let head = format!(
            "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\" xmlns=\"http://www.w3.org/2000/svg\">",
            escape(&self.description)
        );
        svg.split_once('>').map_or_else(String::new, |(_, body)| head + body.trim_end())
    }

    fn draw_into(
        &self,
        svg: &mut String,
        width: i32,
        height: i32,
        top: i32,
        rows: &[i32],
        paint: impl FnOnce(&mut Plot<'_, '_>) -> Drawn,
    ) -> Drawn {
        let root = SVGBackend::with_string(svg, (width.unsigned_abs(), height.unsigned_abs())).into_drawing_area();
        let mut chart = ChartBuilder::on(&root)
            .margin_top(top * FINENESS)
            .margin_right(RIGHT * FINENESS)
            .margin_left(4 * FINENESS)
            .x_label_area_size(BOTTOM * FINENESS)
            .y_label_area_size((LEFT - 4) * FINENESS)
            .build_cartesian_2d(self.x.clone(), self.y.clone())?;
        chart
            .configure_mesh()
            .bold_line_style(Stroke::new(MESH, 0.8).style())
            .light_line_style(TRANSPARENT)
            .axis_style(Stroke::new(EDGE, 1.0).style())
            .set_all_tick_mark_size(4 * FINENESS)
            .label_style(text_style(TICK_TEXT, TEXT))
            .axis_desc_style(text_style(LABEL_TEXT, TEXT))
            .x_desc(&self.x.caption)
            .y_desc(&self.y.caption)
            .draw()?;
        let mut plot =
            Plot { chart, root: &root, left: self.x.low, right: self.x.high, floor: self.y.low, ceiling: self.y.high };
        for (mark, row) in self.marks.iter().zip(rows) {
            plot.mark(mark, (TOP - 4 + ROW * row) * FINENESS, self.y.low)?;
        }
        paint(&mut plot)?;
        drop(plot);
        root.present()
    }

    /// The row of each mark's label, counted from the top: no label crosses another or another mark's line.
    fn mark_rows(&self) -> Vec<i32> {
        let [inside, _] = Self::inside(self.width, self.height);
        let px = |x: f64| (x - self.x.low) / (self.x.high - self.x.low) * f64::from(inside);
        let mut placed: Vec<(f64, f64, i32)> = Vec::new();
        for mark in &self.marks {
            let start = px(mark.x);
            let end = start + (mark.text.chars().count() as f64 + 1.5) * ADVANCE * f64::from(TICK_TEXT);
            let row = placed.iter().filter(|label| label.1 >= start).map(|label| label.2 + 1).max().unwrap_or(0);
            placed.push((start, end, row));
        }
        placed.into_iter().map(|label| label.2).collect()
    }
}

fn text_style(size: i32, colour: RGBColor) -> TextStyle<'static> {
    TextStyle { color: colour.to_backend_color(), ..("sans-serif", f64::from(size * FINENESS) * FONT_FACTOR).into() }
}

/// The inside of a figure, in data coordinates.
pub(super) struct Plot<'a, 'b> {
    chart: Chart<'a, 'b>,
    root: &'a DrawingArea<SVGBackend<'b>, plotters::coord::Shift>,
    left: f64,
    right: f64,
    floor: f64,
    ceiling: f64,
}

impl Plot<'_, '_> {
    /// A curve through the points.
    pub(super) fn line(&mut self, points: impl IntoIterator<Item = [f64; 2]>, stroke: Stroke) -> Drawn {
        let points: Vec<(f64, f64)> = points.into_iter().map(|[x, y]| (x, y)).collect();
        self.chart.draw_series([PathElement::new(points, stroke.style())]).map(|_| ())
    }

    /// A dashed straight line across the plot at height `y`.
    pub(super) fn across(&mut self, y: f64, stroke: Stroke) -> Drawn {
        let ends = [(self.left, y), (self.right, y)];
        let dashes = DashedLineSeries::new(ends, 7 * FINENESS, 4 * FINENESS, stroke.style());
        self.chart.draw_series(dashes).map(|_| ())
    }

    /// A filled column from the bottom of the plot to `y`.
    pub(super) fn column(&mut self, x0: f64, x1: f64, y: f64, colour: RGBColor) -> Drawn {
        let corners = [(x0, self.floor), (x1, y)];
        self.chart.draw_series([Rectangle::new(corners, colour.mix(0.75).filled())]).map(|_| ())
    }

    /// A dot with a white rim.
    pub(super) fn dot(&mut self, point: [f64; 2], colour: RGBColor) -> Drawn {
        let at = (point[0], point[1]);
        self.chart
            .draw_series([
                Circle::new(at, 5 * FINENESS, WHITE.filled()),
                Circle::new(at, 4 * FINENESS - 2, colour.filled()),
            ])
            .map(|_| ())
    }

    /// Text centred above a point, `rise` px above it.
    pub(super) fn text_above(&mut self, point: [f64; 2], rise: i32, text: &str) -> Drawn {
        let (x, y) = self.chart.backend_coord(&(point[0], point[1]));
        let style = text_style(TICK_TEXT, TEXT).pos(Pos::new(HPos::Center, VPos::Bottom));
        self.root.draw(&Text::new(text.to_owned(), (x, y - rise * FINENESS), style))
    }

    /// A label above the plot and a faint line from it down to the axis.
    pub(super) fn tick_above(&mut self, x: f64, text: &str) -> Drawn {
        self.line([[x, self.floor], [x, self.ceiling]], Stroke { colour: EDGE, width: 0.6, opacity: 0.4 })?;
        self.text_above([x, self.ceiling], 3, text)
    }

    fn mark(&mut self, mark: &Mark, label_top: i32, low: f64) -> Drawn {
        let (x, bottom) = self.chart.backend_coord(&(mark.x, low));
        let style = Stroke::new(mark.colour, 1.3).style();
        if mark.dashed {
            let (dash, gap) = (6 * FINENESS, 4 * FINENESS);
            for start in (label_top..bottom).step_by((dash + gap).unsigned_abs() as usize) {
                self.root.draw(&PathElement::new([(x, start), (x, (start + dash).min(bottom))], style))?;
            }
        } else {
            self.root.draw(&PathElement::new([(x, label_top), (x, bottom)], style))?;
        }
        let text = text_style(TICK_TEXT, mark.colour).pos(Pos::new(HPos::Left, VPos::Top));
        self.root.draw(&Text::new(mark.text.clone(), (x + 4 * FINENESS, label_top), text))
    }
}

/// One entry of a legend.
pub(super) struct Key<'t> {
    pub(super) colour: RGBColor,
    pub(super) dashed: bool,
    pub(super) text: &'t str,
}

/// A legend as a row above a figure, outside the plot, so that it never covers data.
pub(super) fn legend(keys: &[Key<'_>]) -> String {
    let entry = |key: &Key<'_>| {
        let RGBColor(red, green, blue) = key.colour;
        let dashes = if key.dashed { " stroke-dasharray=\"6 3\"" } else { "" };
        format!(
            "<span class=\"key\"><svg class=\"swatch\" viewBox=\"0 0 26 8\" xmlns=\"http://www.w3.org/2000/svg\">\
             <path d=\"M1 4H25\" stroke=\"#{red:02x}{green:02x}{blue:02x}\" stroke-width=\"2.5\"{dashes}/></svg>{}</span>",
            escape(key.text)
        )
    };
    format!("<div class=\"legend\">{}</div>", keys.iter().map(entry).collect::<String>())
}

/// A figure element: legend, drawing and caption; `class` sets its width.
pub(super) fn framed(class: &str, keys: &[Key<'_>], svg: &str, caption: &str) -> String {
    format!("<figure class=\"{class}\">{}{svg}<figcaption>{}</figcaption></figure>\n", legend(keys), escape(caption))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_inside_the_range_and_not_too_many() {
        for (low, high) in [(0.0, 1.0), (-3.7, 18.4), (0.0, 1e-4), (99_999.0, 100_001.0), (-1e12, 1e12), (0.0, 7e11)] {
            let scale = Scale::exact("", low, high, 6);
            assert!((2..=13).contains(&scale.ticks.len()), "{low} to {high}: {:?}", scale.ticks);
            assert!(scale.ticks.iter().all(|tick| tick.0 >= low - 1e-6 * (high - low) && tick.0 <= high * 1.000_001));
            let mut labels: Vec<&String> = scale.ticks.iter().map(|tick| &tick.1).collect();
            labels.dedup();
            assert_eq!(labels.len(), scale.ticks.len(), "labels must differ: {labels:?}");
        }
    }

    #[test]
    fn a_scale_always_has_a_span() {
        for values in [vec![], vec![0.0], vec![5.0; 3], vec![-1e12, 1e12], vec![f64::NAN, f64::INFINITY], vec![1e-30]] {
            let scale = Scale::linear("", values.clone(), 0.05, 6);
            assert!(scale.high > scale.low && scale.low.is_finite() && scale.high.is_finite(), "{values:?}");
        }
    }

    #[test]
    fn labels_of_marks_never_overlap() {
        let mark = |x| Mark { x, text: "p99.99 12 345 ns".to_owned(), colour: colour::LIMIT, dashed: false };
        let figure = Figure {
            description: String::new(),
            width: 1_000,
            height: 300,
            x: Scale::exact("", 0.0, 1_000.0, 5),
            y: Scale::exact("", 0.0, 1.0, 5),
            head: 0,
            marks: [100.0, 101.0, 150.0, 700.0].map(mark).into(),
        };
        assert_eq!(figure.mark_rows(), [0, 1, 2, 0]);
    }
}
