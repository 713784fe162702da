use crate::{
    Colour, Mark, Scale, Stroke, colour,
    legend::{Key, Swatch},
    size::{HALF_PX, LABEL_PX, inside},
};

/// Maximum number of points of a curve that are marked with dots.
const DOTS: usize = 200;

/// A figure under construction: legend, plot and caption.
///
/// Layers are drawn in the order in which they are added. A point that is not finite, above 1e12, or not positive on a
/// logarithmic scale is omitted. An empty figure says so.
#[derive(Clone, Debug)]
pub struct Figure {
    pub(crate) description: String,
    pub(crate) class: &'static str,
    /// Size in px, without the labels above the plot.
    pub(crate) size: [i32; 2],
    pub(crate) x: Scale,
    pub(crate) y: Scale,
    /// Without axes the whole figure is the plot.
    pub(crate) axes: bool,
    pub(crate) layers: Vec<Layer>,
    pub(crate) marks: Vec<Mark>,
    /// Labels above the plot with a faint line down to the axis.
    pub(crate) above: Vec<(f64, String)>,
    pub(crate) keys: Vec<Key>,
    pub(crate) caption: String,
}

#[derive(Clone, Debug)]
pub(crate) enum Layer {
    Line { points: Vec<[f64; 2]>, stroke: Stroke },
    Dot { at: [f64; 2], radius: f64, colour: Colour },
    Area { from: [f64; 2], to: [f64; 2], colour: Colour, opacity: f64 },
    Text { at: [f64; 2], text: String, above: bool },
}

impl Figure {
    /// A figure over the full width of the page; height in px, description for readers who cannot see it.
    #[must_use]
    pub fn full(description: &str, height: i32, x: Scale, y: Scale) -> Figure {
        Figure::sized(description, "full", [1120, height], x, y)
    }

    /// A figure over half the width of the page.
    #[must_use]
    pub fn half(description: &str, height: i32, x: Scale, y: Scale) -> Figure {
        Figure::sized(description, "half", [HALF_PX, height], x, y)
    }

    /// A figure over half the width of the page with a square plot.
    #[must_use]
    pub fn square(description: &str, x: Scale, y: Scale) -> Figure {
        let [width, height] = inside(HALF_PX, HALF_PX);
        Figure::half(description, HALF_PX + width - height, x.ticks(8), y.ticks(8))
    }

    /// A square without axes from −`reach` to `reach`.
    pub(crate) fn bare(description: &str, class: &'static str, px: i32, reach: f64) -> Figure {
        let scale = Scale::exact("", -reach, reach);
        Figure::without_axes(description, class, [px, px], scale.clone(), scale)
    }

    /// A figure that is the plot alone.
    pub(crate) fn without_axes(description: &str, class: &'static str, px: [i32; 2], x: Scale, y: Scale) -> Figure {
        Figure { axes: false, ..Figure::sized(description, class, px, x, y) }
    }

    fn sized(description: &str, class: &'static str, size: [i32; 2], x: Scale, y: Scale) -> Figure {
        Figure {
            description: description.into(),
            class,
            size,
            x,
            y,
            axes: true,
            layers: Vec::new(),
            marks: Vec::new(),
            above: Vec::new(),
            keys: Vec::new(),
            caption: String::new(),
        }
    }

    /// Adds a curve with its entry in the legend.
    pub fn curve(
        &mut self,
        name: impl Into<String>,
        points: impl IntoIterator<Item = [f64; 2]>,
        stroke: Stroke,
    ) -> &mut Figure {
        self.key(name, stroke).line(points, stroke)
    }

    /// Adds a curve through the points; a single point becomes a dot.
    pub fn line(&mut self, points: impl IntoIterator<Item = [f64; 2]>, stroke: Stroke) -> &mut Figure {
        let points: Vec<[f64; 2]> = points.into_iter().filter(|point| self.holds(*point)).collect();
        match *points.as_slice() {
            [] => self,
            [at] => self.layer(Layer::Dot { at, radius: stroke.width, colour: stroke.colour }),
            _ => self.layer(Layer::Line { points, stroke }),
        }
    }

    /// Adds a curve interrupted at these ascending positions.
    pub fn interrupted(&mut self, points: &[[f64; 2]], breaks: &[f64], stroke: Stroke) -> &mut Figure {
        let run = |point: &[f64; 2]| breaks.partition_point(|at| *at <= point[0]);
        for run in points.chunk_by(|one, next| run(one) == run(next)) {
            self.line(run.iter().copied(), stroke);
        }
        self
    }

    /// Adds a bold curve that stays visible on top of many others.
    pub fn bold(&mut self, points: &[[f64; 2]], colour: Colour) -> &mut Figure {
        self.line(points.iter().copied(), Stroke::new(colour::WHITE, 4.5));
        self.line(points.iter().copied(), Stroke::new(colour, 2.2))
    }

    /// Adds a dashed line over the whole width at height `y`.
    pub fn across(&mut self, y: f64, colour: Colour) -> &mut Figure {
        self.line([[self.x.low, y], [self.x.high, y]], Stroke::new(colour, 1.2).dashed())
    }

    /// Adds a dot for each point, unless the dots are too many to distinguish.
    pub fn dots(&mut self, points: impl IntoIterator<Item = [f64; 2]>, colour: Colour) -> &mut Figure {
        let points: Vec<[f64; 2]> = points.into_iter().collect();
        if points.len() <= DOTS {
            points.into_iter().for_each(|at| self.dot(at, 3.0, colour));
        }
        self
    }

    /// Adds a dot with a white rim.
    pub fn highlight(&mut self, at: [f64; 2], colour: Colour) -> &mut Figure {
        self.dot(at, 5.0, colour::WHITE);
        self.dot(at, 3.5, colour);
        self
    }

    fn dot(&mut self, at: [f64; 2], radius: f64, colour: Colour) {
        if self.holds(at) {
            self.layer(Layer::Dot { at, radius, colour });
        }
    }

    /// Adds columns from the bottom of the plot, or from 0 if the scale includes it; each point `[x, y]` gives a column from
    /// `x + from` to `x + to`.
    pub fn columns(
        &mut self,
        points: impl IntoIterator<Item = [f64; 2]>,
        [from, to]: [f64; 2],
        colour: Colour,
    ) -> &mut Figure {
        for [x, y] in points {
            self.area([x + from, self.y.base()], [x + to, y], colour, 0.8);
        }
        self
    }

    /// Adds a band over the whole height between two positions.
    pub fn band(&mut self, [from, to]: [f64; 2], colour: Colour) -> &mut Figure {
        self.area([from, self.y.low], [to, self.y.high], colour, 0.25)
    }

    /// Adds a filled rectangle between two corners; opacity 1 is opaque.
    pub fn area(&mut self, from: [f64; 2], to: [f64; 2], colour: Colour, opacity: f64) -> &mut Figure {
        if self.holds(from) && self.holds(to) {
            self.layer(Layer::Area { from, to, colour, opacity });
        }
        self
    }

    /// Adds text centred about a point.
    pub(crate) fn text(&mut self, at: [f64; 2], text: String) -> &mut Figure {
        self.layer(Layer::Text { at, text, above: false })
    }

    /// Adds text centred slightly above a point.
    pub(crate) fn text_above(&mut self, at: [f64; 2], text: String) -> &mut Figure {
        self.layer(Layer::Text { at, text, above: true })
    }

    /// Adds labels above the plot with a faint line down to the axis; omits labels that would touch a previous one.
    pub fn labels_above(&mut self, labels: impl IntoIterator<Item = (f64, String)>) -> &mut Figure {
        let width = f64::from(inside(self.size[0], 0)[0]);
        let mut last = f64::NEG_INFINITY;
        for (x, text) in labels.into_iter().filter(|(x, _)| (self.x.low..=self.x.high).contains(x)) {
            let px = self.x.share(x) * width;
            if px - last >= LABEL_PX {
                last = px;
                self.above.push((x, text));
            }
        }
        self
    }

    /// Adds a vertical line with a label above the plot; marks must be added from left to right.
    pub fn mark(&mut self, mark: Mark) -> &mut Figure {
        if self.x.holds(mark.x) {
            self.marks.push(mark);
        }
        self
    }

    /// Adds a line to the legend.
    pub fn key(&mut self, text: impl Into<String>, stroke: Stroke) -> &mut Figure {
        self.keys.push(Key { swatch: Swatch::Line(stroke), text: text.into() });
        self
    }

    /// Adds a column, band or area to the legend.
    pub fn area_key(&mut self, text: impl Into<String>, colour: Colour) -> &mut Figure {
        self.keys.push(Key { swatch: Swatch::Area(colour), text: text.into() });
        self
    }

    /// Sets the text below the figure.
    pub fn caption(&mut self, text: impl Into<String>) -> &mut Figure {
        self.caption = text.into();
        self
    }

    fn holds(&self, [x, y]: [f64; 2]) -> bool {
        self.x.holds(x) && self.y.holds(y)
    }

    fn layer(&mut self, layer: Layer) -> &mut Figure {
        self.layers.push(layer);
        self
    }
}
