//! Plots and maps of a result.

use serde::Serialize;
use trueaxis_report::{
    Colour, Figure, PolarTrace, Scale, Stroke, colour, decimate, error_bars, heat_map, polar_traces,
};

/// How curves are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Look {
    /// A line.
    #[default]
    Line,
    /// A line with a point at every value.
    Dotted,
    /// Points alone.
    Points,
    /// Columns, one unit of the horizontal axis apart.
    Columns,
}

/// Curves over one column of positions.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Plot {
    /// Heading of the part of the page that contains the plot.
    pub section: &'static str,
    /// Title of the plot.
    pub title: String,
    /// Quantity of the horizontal axis, and its unit ("" for none).
    pub x: (String, &'static str),
    /// Quantity of the vertical axis, and its unit.
    pub y: (&'static str, &'static str),
    /// How the curves are drawn.
    pub look: Look,
    /// Whether the vertical axis is logarithmic.
    pub logarithmic: bool,
    /// A limit of the quantity, drawn across.
    pub limit: Option<f64>,
    /// Explanation for the reader.
    pub caption: &'static str,
    /// Positions, ascending.
    pub at: Vec<f64>,
    /// The curves.
    pub curves: Vec<Curve>,
}

/// A curve of a [`Plot`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// Name of the curve.
    pub name: String,
    /// Index of the curve's colour, from 0.
    pub colour: usize,
    /// Whether the line is dashed, or a column hatched.
    pub dashed: bool,
    /// A value for every position; NaN (null) if missing.
    pub values: Vec<f64>,
    /// Expanded uncertainties, 95 %; NaN (null) if unknown at a position, empty if unknown everywhere.
    pub expanded: Vec<f64>,
}

impl Curve {
    /// A solid line without uncertainties.
    pub fn new(name: impl Into<String>, colour: usize, values: Vec<f64>) -> Curve {
        Curve { name: name.into(), colour, dashed: false, values, expanded: Vec::new() }
    }
}

/// Colours of curves by index.
const COLOURS: [Colour; 9] = [
    colour::AXES[0],
    colour::AXES[1],
    colour::AXES[2],
    colour::FOURTH,
    colour::LIMIT,
    colour::UNCOMPENSATED,
    colour::COMPENSATED,
    colour::SERVO,
    colour::MEASURED,
];
/// Maximum number of buckets that a line is drawn with, two extremes each.
const BUCKETS: usize = 800;
/// A column extends this far on either side of its position.
const COLUMN: [f64; 2] = [-0.38, 0.38];

impl Plot {
    /// Positions in ascending order, and the original index of each.
    pub(crate) fn ascending(at: &[f64]) -> (Vec<f64>, Vec<usize>) {
        let order = trueaxis_metrology::order::ascending(at);
        (order.iter().map(|i| at[*i]).collect(), order)
    }

    /// Curves along X, Y and Z.
    pub(crate) fn along(rows: &[[f64; 3]]) -> Vec<Curve> {
        let curve = |c: usize| rows.iter().map(|row| row[c]).collect();
        ["along X", "along Y", "along Z"]
            .into_iter()
            .enumerate()
            .map(|(c, name)| Curve::new(name, c, curve(c)))
            .collect()
    }

    /// The figure of a report; half width with `half`.
    pub fn figure(&self, half: bool) -> Figure {
        let points = |values: &[f64]| -> Vec<[f64; 2]> {
            self.at.iter().zip(values).filter(|(_, value)| value.is_finite()).map(|(x, y)| [*x, *y]).collect()
        };
        let (name, unit) = &self.x;
        let name = if unit.is_empty() { name.clone() } else { format!("{name} in {unit}") };
        let x = Scale::linear(&name, self.at.iter().copied()).margin(0.02);
        let with_bars = self.curves.iter().all(|curve| curve.expanded.len() == self.at.len());
        let mut figure = if with_bars {
            let rows = |curve: &Curve| -> Vec<[f64; 3]> {
                let values = self.at.iter().zip(&curve.values).zip(&curve.expanded);
                values.map(|((x, value), half_width)| [*x, *value, *half_width]).collect()
            };
            let curves: Vec<_> = self.curves.iter().map(|curve| (curve.name.as_str(), rows(curve))).collect();
            error_bars(&self.title, x, self.y.1, &curves)
        } else {
            let y = self.vertical();
            let mut figure =
                if half { Figure::half(&self.title, 260, x, y) } else { Figure::full(&self.title, 300, x, y) };
            for curve in &self.curves {
                let (points, colour) = (points(&curve.values), COLOURS[curve.colour % COLOURS.len()]);
                let stroke = Stroke::new(colour, 1.4);
                let stroke = if curve.dashed { stroke.dashed() } else { stroke };
                match self.look {
                    Look::Points => figure.area_key(curve.name.clone(), colour).dots(points, colour),
                    Look::Columns => figure.area_key(curve.name.clone(), colour).columns(points, COLUMN, colour),
                    Look::Line => figure.curve(curve.name.clone(), decimate(&points, BUCKETS), stroke),
                    Look::Dotted => {
                        figure.curve(curve.name.clone(), decimate(&points, BUCKETS), stroke).dots(points, colour)
                    }
                };
            }
            if let Some(limit) = self.limit {
                figure.across(limit, colour::LIMIT).key("limit", Stroke::new(colour::LIMIT, 1.2).dashed());
            }
            figure
        };
        figure.caption(self.caption);
        figure
    }

    fn vertical(&self) -> Scale {
        let (quantity, unit) = self.y;
        let name = if unit.is_empty() { quantity.to_owned() } else { format!("{quantity} in {unit}") };
        let values = self.curves.iter().flat_map(|curve| &curve.values).copied().filter(|value| value.is_finite());
        let values = values.chain(self.limit);
        if self.logarithmic {
            return Scale::decades(&name, values);
        }
        // Temperatures and positions are far from zero, and their zero is arbitrary.
        let zero = (!["°C", "mm", "degrees"].contains(&unit)).then_some(0.0);
        Scale::linear(&name, values.chain(zero)).margin(0.06)
    }
}

/// Deviations of the radius over the angle of a circle. The desk draws all plots of a section to the same scale.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Polar {
    /// Heading of the part of the page that contains the plot.
    pub section: &'static str,
    /// Title of the plot.
    pub title: String,
    /// Axes of the circle's plane; the first is at 0°.
    pub axes: [String; 2],
    /// The curves.
    pub curves: Vec<Around>,
}

/// A curve of a [`Polar`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Around {
    /// Name of the curve.
    pub name: &'static str,
    /// Index of the curve's colour, from 0.
    pub colour: usize,
    /// Angles from the first axis toward the second, in the order of travel.
    pub angle_deg: Vec<f64>,
    /// Deviations, positive outward.
    pub um: Vec<f64>,
}

impl Polar {
    /// The figure of a report.
    pub fn figure(&self) -> Figure {
        let trace = |curve: &Around| PolarTrace {
            name: curve.name,
            colour: COLOURS[curve.colour % COLOURS.len()],
            points: curve.angle_deg.iter().zip(&curve.um).map(|(degrees, um)| [degrees.to_radians(), *um]).collect(),
        };
        let traces: Vec<PolarTrace<'_>> = self.curves.iter().map(trace).collect();
        polar_traces(&format!("Polar plot: {}", self.title), &traces, &format!("{}.", self.title))
    }
}

/// Values over the cells of a plane.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Map {
    /// Title of the map.
    pub title: &'static str,
    /// Unit of the values.
    pub unit: &'static str,
    /// Explanation for the reader.
    pub caption: &'static str,
    /// Lowest and highest X and Y, mm.
    pub ends_mm: [[f64; 2]; 2],
    /// Rows from the lowest Y, cells from the lowest X; NaN (null) for a cell without a value.
    pub rows: Vec<Vec<f64>>,
}

impl Map {
    /// The figure of a report.
    pub fn figure(&self) -> Figure {
        let [x, y] = ["X in mm", "Y in mm"];
        let [x, y] =
            [(x, self.ends_mm[0]), (y, self.ends_mm[1])].map(|(name, [low, high])| Scale::exact(name, low, high));
        let mut figure = heat_map(self.title, x, y, &self.rows, self.unit);
        figure.caption(self.caption);
        figure
    }
}
