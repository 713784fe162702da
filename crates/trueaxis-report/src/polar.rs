use crate::{
    Colour, Figure, Stroke, colour,
    number::{drawable, drawable_point, round_down, shortest, significant},
};
use std::f64::consts::TAU;

/// Side of the figure, px: 160 mm on the page.
const SIDE_PX: i32 = 640;
/// Half the width of the plot, mm on the page.
const HALF_MM: f64 = 80.0;
/// Radius at which the departure is 0, mm.
const BASE_MM: f64 = 46.0;
/// Maximum length on the page for the largest departure, mm.
const REACH_MM: f64 = 21.0;
/// Distance of the angle labels beyond the spokes, mm; half of "180°" has 3.5 mm beside its centre.
const LABEL_MM: f64 = 4.0;
/// Points further apart, rad, are not joined.
const GAP: f64 = TAU / 8.0;

/// Names in the legend and colours of the four reference circles of ISO 12181-1; the minimum zone has two circles.
pub const CIRCLES: [(&str, Colour); 4] = [
    ("LSC", colour::COMPENSATED),
    ("MZC (both circles)", colour::UNCOMPENSATED),
    ("MCC", colour::FULL),
    ("MIC", colour::FOURTH),
];

/// A reference circle of a [`polar`] figure, or the two circles of a zone, which are dashed.
#[derive(Clone, Debug, PartialEq)]
pub struct Circle {
    /// Name in the legend.
    pub name: &'static str,
    /// Colour of the circle.
    pub colour: Colour,
    /// Width of the zone in µm, for the legend.
    pub zone_um: f64,
    /// Departures in µm at equidistant angles once around, from 0.
    pub curves: Vec<Vec<f64>>,
}

/// A curve of a [`polar_traces`] figure.
#[derive(Clone, Debug, PartialEq)]
pub struct PolarTrace<'t> {
    /// Name in the legend.
    pub name: &'t str,
    /// Colour of the curve.
    pub colour: Colour,
    /// Angle in rad and departure in µm, in the order of travel.
    pub points: Vec<[f64; 2]>,
}

/// A polar plot of measured departures `[angle in rad, departure in µm]`, angles ascending, with reference circles.
///
/// Magnification and division are 1, 2, 5 × 10^n, chosen for the largest departure and added to the caption.
#[must_use]
pub fn polar(name: &str, measured: &[[f64; 2]], circles: &[Circle], caption: &str) -> Figure {
    let measured: Vec<[f64; 2]> = measured.iter().copied().filter(drawable_point).collect();
    let drawn = circles.iter().flat_map(|circle| circle.curves.iter().flatten().copied());
    let dial = Dial::of(measured.iter().map(|point| point[1]).chain(drawn));
    let mut figure = dial.figure(&format!("Polar plot of {name} with reference circles"));
    let rings = dial.grid(&mut figure);

    // Dashes last: coinciding circles are then both visible.
    let (zones, plain): (Vec<_>, Vec<_>) = circles.iter().partition(|circle| circle.curves.len() > 1);
    for circle in plain.into_iter().chain(zones) {
        for curve in &circle.curves {
            let angles = (0..).map(|i| TAU * f64::from(i) / curve.len() as f64);
            let closed = angles.zip(curve.iter().chain(curve.first())).filter(|(_, value)| drawable(**value));
            figure.line(closed.map(|(theta, value)| dial.at([theta, *value])), stroke(circle));
        }
    }
    let points: Vec<[f64; 2]> = measured.iter().chain(measured.first()).copied().collect();
    figure.dots(measured.iter().map(|point| dial.at(*point)), colour::MEASURED);
    dial.trace(&mut figure, &points, Stroke::new(colour::MEASURED, 1.3));
    dial.number(&mut figure, rings);

    figure.key(name, Stroke::new(colour::MEASURED, 1.3));
    for circle in circles {
        figure.key(format!("{}, zone {} µm", circle.name, significant(circle.zone_um, 3)), stroke(circle));
    }
    figure.caption(dial.caption(caption));
    figure
}

/// A polar plot of several runs around one circle, as for a ballbar: departure of the radius over the angle.
///
/// Magnification and division as for [`polar`]; the legend gives the zone of each curve, largest − smallest departure.
#[must_use]
pub fn polar_traces(description: &str, traces: &[PolarTrace<'_>], caption: &str) -> Figure {
    let drawable =
        |trace: &PolarTrace<'_>| -> Vec<[f64; 2]> { trace.points.iter().copied().filter(drawable_point).collect() };
    let traces: Vec<(&PolarTrace<'_>, Vec<[f64; 2]>)> = traces.iter().map(|trace| (trace, drawable(trace))).collect();
    let dial = Dial::of(traces.iter().flat_map(|(_, points)| points.iter().map(|point| point[1])));
    let mut figure = dial.figure(description);
    let rings = dial.grid(&mut figure);
    for (trace, points) in &traces {
        let stroke = Stroke::new(trace.colour, 1.3);
        dial.trace(&mut figure, points, stroke);
        let least = points.iter().map(|point| point[1]).fold(f64::INFINITY, f64::min);
        let most = points.iter().map(|point| point[1]).fold(f64::NEG_INFINITY, f64::max);
        figure.key(format!("{}, zone {} µm", trace.name, significant(most - least, 3)), stroke);
    }
    dial.number(&mut figure, rings);
    figure.caption(dial.caption(caption));
    figure
}

/// The scale of a polar plot.
struct Dial {
    /// mm on the page per µm.
    scale: f64,
    /// Distance between rings, µm.
    division: f64,
}

impl Dial {
    /// The scale for the largest of these departures, µm.
    fn of(departures: impl Iterator<Item = f64>) -> Dial {
        let largest = departures.filter(|value| drawable(*value)).map(f64::abs).fold(0.0, f64::max);
        let scale = round_down(REACH_MM / largest);
        Dial { scale, division: round_down(10.0 / scale) }
    }

    fn at(&self, [theta, departure]: [f64; 2]) -> [f64; 2] {
        around(theta, BASE_MM + self.scale * departure)
    }

    fn figure(&self, description: &str) -> Figure {
        Figure::bare(description, "polar", SIDE_PX, HALF_MM)
    }

    /// Draws a curve, without joining points that are too far apart.
    fn trace(&self, figure: &mut Figure, points: &[[f64; 2]], stroke: Stroke) {
        let near = |one: &[f64; 2], next: &[f64; 2]| {
            let apart = (next[0] - one[0]).rem_euclid(TAU);
            apart.min(TAU - apart) < GAP
        };
        for arc in points.chunk_by(near) {
            figure.line(arc.iter().map(|point| self.at(*point)), stroke);
        }
    }

    /// Draws rings one division apart, and spokes of 30° with their labels; returns number and radius of each ring.
    fn grid(&self, figure: &mut Figure) -> Vec<(i32, f64)> {
        let step_mm = self.scale * self.division;
        let thin = Stroke::new(colour::GREY, 0.6).opacity(0.5);
        let reach = (1.2 * REACH_MM / step_mm).floor().min(12.0) as i32;
        let rings: Vec<(i32, f64)> = (-reach..=reach).map(|ring| (ring, BASE_MM + f64::from(ring) * step_mm)).collect();
        for (_, distance) in &rings {
            figure.line((0..=180).map(|i| around(TAU * f64::from(i) / 180.0, *distance)), thin);
        }
        let outside = BASE_MM + 1.2 * REACH_MM;
        for spoke in 0..12 {
            let theta = TAU * f64::from(spoke) / 12.0;
            figure.line([around(theta, 8.0), around(theta, outside)], thin);
            figure.text(around(theta, outside + LABEL_MM), format!("{}°", 30 * spoke));
        }
        rings
    }

    /// Numbers the rings, on top of the curves so that the numbers stay legible.
    fn number(&self, figure: &mut Figure, rings: Vec<(i32, f64)>) {
        for (number, distance) in rings {
            figure.text(around(TAU / 24.0, distance), shortest(f64::from(number) * self.division));
        }
    }

    fn caption(&self, caption: &str) -> String {
        let factor = 1e3 * self.scale;
        let magnification = if factor < 1e7 { shortest(factor) } else { significant(factor, 1) };
        format!(
            "{caption} Magnification {magnification} : 1 at the figure's full width of 160 mm; one division is {} µm. 0° to \
             the right, counter-clockwise.",
            shortest(self.division)
        )
    }
}

fn stroke(circle: &Circle) -> Stroke {
    let stroke = Stroke::new(circle.colour, 1.2);
    if circle.curves.len() > 1 { stroke.dashed() } else { stroke }
}

fn around(theta: f64, distance: f64) -> [f64; 2] {
    let (sin, cos) = theta.sin_cos();
    [distance * cos, distance * sin]
}
