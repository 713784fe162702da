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
/// The largest departure takes at most this much, mm.
const REACH_MM: f64 = 21.0;
/// Labels of the angles, beyond the spokes, mm; half of "180°" has 3.5 mm beside its centre.
const LABEL_MM: f64 = 4.0;
/// Points further apart, rad, are not joined.
const GAP: f64 = TAU / 8.0;

/// Names in the legend and colours of the four reference circles of ISO 12181-1; the minimum zone has two circles.
pub const CIRCLES: [(&str, Colour); 4] = [
    ("LSC", colour::COMPENSATED),
    ("MZC (both circles)", colour::UNCOMPENSATED),
    ("MCC", colour::SERVO),
    ("MIC", colour::FOURTH),
];

/// A reference circle of a [`polar`] figure, or the two circles of a zone, which are dashed.
#[derive(Clone, Debug, PartialEq)]
pub struct Circle {
    /// Name in the legend.
    pub name: &'static str,
    /// Its colour.
    pub colour: Colour,
    /// Width of the zone in µm, for the legend.
    pub zone_um: f64,
    /// Departures in µm at equidistant angles once around, from 0.
    pub curves: Vec<Vec<f64>>,
}

/// A polar plot of measured departures `[angle in rad, departure in µm]`, angles ascending, with reference circles.
///
/// Magnification and division are chosen for the largest departure, from 1, 2, 5 × 10^n, and added to the caption.
#[must_use]
pub fn polar(name: &str, measured: &[[f64; 2]], circles: &[Circle], caption: &str) -> Figure {
    let measured: Vec<[f64; 2]> = measured.iter().copied().filter(drawable_point).collect();
    let drawn = circles.iter().flat_map(|circle| circle.curves.iter().flatten().copied());
    let departures = measured.iter().map(|point| point[1]).chain(drawn).filter(|value| drawable(*value));
    let largest = departures.map(f64::abs).fold(0.0, f64::max);
    // mm on the page per µm.
    let scale = round_down(REACH_MM / largest);
    let division = round_down(10.0 / scale);
    let at = |theta: f64, departure: f64| around(theta, BASE_MM + scale * departure);
    let description = format!("Polar plot of {name} with reference circles");
    let mut figure = Figure::bare(&description, "polar", SIDE_PX, HALF_MM);
    let rings = grid(&mut figure, scale * division);

    // Dashes last: where circles coincide both are seen.
    let (zones, plain): (Vec<_>, Vec<_>) = circles.iter().partition(|circle| circle.curves.len() > 1);
    for circle in plain.into_iter().chain(zones) {
        for curve in &circle.curves {
            let angles = (0..).map(|i| TAU * f64::from(i) / curve.len() as f64);
            let closed = angles.zip(curve.iter().chain(curve.first())).filter(|(_, value)| drawable(**value));
            figure.line(closed.map(|(theta, value)| at(theta, *value)), stroke(circle));
        }
    }
    let points: Vec<&[f64; 2]> = measured.iter().chain(measured.first()).collect();
    figure.dots(measured.iter().map(|point| at(point[0], point[1])), colour::MEASURED);
    for arc in points.chunk_by(|one, next| (next[0] - one[0]).rem_euclid(TAU) < GAP) {
        figure.line(arc.iter().map(|point| at(point[0], point[1])), Stroke::new(colour::MEASURED, 1.3));
    }
    // On top of the curves, so that they stay legible.
    for (number, distance) in rings {
        figure.text(around(TAU / 24.0, distance), shortest(f64::from(number) * division));
    }

    figure.key(name, Stroke::new(colour::MEASURED, 1.3));
    for circle in circles {
        figure.key(format!("{}, zone {} µm", circle.name, significant(circle.zone_um, 3)), stroke(circle));
    }
    let factor = 1e3 * scale;
    let magnification = if factor < 1e7 { shortest(factor) } else { significant(factor, 1) };
    figure.caption(format!(
        "{caption} Magnification {magnification} : 1 at the figure's full width of 160 mm; one division is {} µm. 0° to \
         the right, counter-clockwise.",
        shortest(division)
    ));
    figure
}

fn stroke(circle: &Circle) -> Stroke {
    let stroke = Stroke::new(circle.colour, 1.2);
    if circle.curves.len() > 1 { stroke.dashed() } else { stroke }
}

fn around(theta: f64, distance: f64) -> [f64; 2] {
    let (sin, cos) = theta.sin_cos();
    [distance * cos, distance * sin]
}

/// Rings one division apart, and spokes of 30° with their labels; returns number and radius of each ring.
fn grid(figure: &mut Figure, step_mm: f64) -> Vec<(i32, f64)> {
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
