//! Polar plot of departures from a circle, with reference circles.

use super::figure::{Drawn, Figure, Key, Plot, Stroke, colour, framed};
use super::text::{round_down, significant, tick};
use plotters::style::RGBColor;
use std::f64::consts::TAU;

/// Half the width of the plot, mm on the page.
const HALF_MM: f64 = 80.0;
/// Radius at which the departure is 0, mm.
const BASE_MM: f64 = 46.0;
/// The largest departure takes at most this much, mm.
const REACH_MM: f64 = 21.0;
/// Labels of the angles, beyond the spokes, mm; half of "180°" has 3.5 mm beside its centre.
const LABEL_MM: f64 = 4.0;
/// So many points and fewer are dots.
const DOTS: usize = 200;

/// Points further apart, rad, are not joined.
const GAP: f64 = TAU / 8.0;

/// A reference circle: its departures at equidistant angles once around; a ring has two.
pub(super) struct Reference {
    pub(super) name: &'static str,
    pub(super) zone_um: f64,
    pub(super) colour: RGBColor,
    pub(super) dashed: bool,
    pub(super) curves: Vec<Vec<f64>>,
}

/// The colours of the four circles: least squares, minimum zone, circumscribed, inscribed.
pub(super) const COLOURS: [RGBColor; 4] = [colour::BLUE, colour::ORANGE, colour::GREEN, colour::PURPLE];

/// A figure of measured departures in µm over angles in rad, ascending, and of reference circles. `caption` says what is
/// seen; magnification and division are added to it.
pub(super) fn polar(what: &str, measured: &[[f64; 2]], references: &[Reference], caption: &str) -> String {
    let departures = measured.iter().map(|point| point[1]);
    let largest = departures
        .chain(references.iter().flat_map(|reference| reference.curves.iter().flatten().copied()))
        .map(f64::abs)
        .fold(0.0, f64::max);
    // mm on the page per µm; 1, 2 or 5 times a power of ten.
    let scale = round_down(REACH_MM / largest);
    let division = round_down(10.0 / scale);
    let place = |theta: f64, departure: f64| {
        let ((sin, cos), distance) = (theta.sin_cos(), BASE_MM + scale * departure);
        [distance * cos, distance * sin]
    };
    let figure = Figure {
        description: &format!("Polar plot of {what} with reference circles"),
        size: [640, 640],
        x: -HALF_MM..HALF_MM,
        y: -HALF_MM..HALF_MM,
        axes: None,
    };
    let svg = figure.draw(|plot| {
        grid(plot, scale * division, division)?;
        // Dashes last: where circles coincide both are seen.
        let (dashed, plain): (Vec<_>, Vec<_>) = references.iter().partition(|reference| reference.dashed);
        for reference in plain.into_iter().chain(dashed) {
            for curve in &reference.curves {
                let angles = (0..).map(|i| TAU * f64::from(i) / curve.len() as f64);
                let closed = angles.zip(curve.iter().chain(curve.first())).map(|(theta, d)| place(theta, *d));
                let stroke = Stroke::new(reference.colour, 1.2);
                if reference.dashed { plot.dashed(closed, stroke)? } else { plot.line(closed, stroke)? }
            }
        }
        let points: Vec<&[f64; 2]> = measured.iter().chain(measured.first()).collect();
        let at = |point: &[f64; 2]| place(point[0], point[1]);
        if measured.len() <= DOTS {
            points.iter().try_for_each(|point| plot.dot(at(point), colour::PROFILE))?;
        }
        for arc in points.chunk_by(|one, next| (next[0] - one[0]).rem_euclid(TAU) < GAP) {
            plot.line(arc.iter().map(|point| at(point)), Stroke::new(colour::PROFILE, 1.3))?;
        }
        Ok(())
    });
    let texts: Vec<String> =
        references.iter().map(|r| format!("{}, zone {} µm", r.name, significant(r.zone_um, 3))).collect();
    let mut keys = vec![Key { colour: colour::PROFILE, dashed: false, text: what }];
    for (text, reference) in texts.iter().zip(references) {
        keys.push(Key { colour: reference.colour, dashed: reference.dashed, text });
    }
    let factor = 1e3 * scale;
    let magnification = if factor < 1e7 { tick(factor) } else { significant(factor, 1) };
    let caption = format!(
        "{caption} Magnification {magnification} : 1 at the figure's full width of 160 mm; one division is {} µm. 0° to \
         the right, counter-clockwise.",
        tick(division)
    );
    framed("polar", &keys, &svg, &caption)
}

fn grid(plot: &mut Plot<'_, '_>, step_mm: f64, division: f64) -> Drawn {
    let thin = Stroke { colour: colour::GREY, width: 0.6, opacity: 0.5 };
    let reach = (1.2 * REACH_MM / step_mm).floor().min(12.0) as i32;
    let rings = -reach..=reach;
    let on = |theta: f64, distance: f64| [distance * theta.cos(), distance * theta.sin()];
    for ring in rings.clone() {
        let distance = BASE_MM + f64::from(ring) * step_mm;
        plot.line((0..=180).map(|i| on(TAU * f64::from(i) / 180.0, distance)), thin)?;
    }
    let outside = BASE_MM + 1.2 * REACH_MM;
    for spoke in 0..12 {
        let theta = TAU * f64::from(spoke) / 12.0;
        plot.line([on(theta, 8.0), on(theta, outside)], thin)?;
        plot.text(on(theta, outside + LABEL_MM), &format!("{}°", 30 * spoke))?;
    }
    for ring in rings {
        let distance = BASE_MM + f64::from(ring) * step_mm;
        plot.text(on(TAU / 24.0, distance), &tick(f64::from(ring) * division))?;
    }
    Ok(())
}
