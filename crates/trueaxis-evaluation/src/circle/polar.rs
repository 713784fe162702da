//! Polar plot of a trace's departures with its reference circles.

use super::Evaluation;
use std::f64::consts::TAU;
use trueaxis_metrology::circles::ReferenceCircle;
use trueaxis_report::{CIRCLES, Circle, Figure};

/// Number of points of a drawn circle.
const FINE: usize = 360;

/// Which circles a polar plot shows: LSC, MZC, MCC, MIC, the order of [`CIRCLES`].
pub type Drawn = [bool; 4];

/// Polar plot of the departures from the least-squares circle, with the circles selected by `drawn`; `None` without any
/// circle.
pub fn polar(evaluation: &Evaluation, drawn: Drawn) -> Option<Figure> {
    let circles = evaluation.circles.each_ref().map(|circle| circle.as_ref().ok());
    // Departures are from the least-squares circle, or from the next one if it does not exist.
    let base = circles.into_iter().flatten().next()?;
    let departure = |point: &[f64; 2]| {
        let [x, y] = [point[0] - base.centre[0], point[1] - base.centre[1]];
        [y.atan2(x), 1e3 * (x.hypot(y) - base.radius)]
    };
    let mut measured: Vec<[f64; 2]> = evaluation.points.iter().map(departure).collect();
    trueaxis_metrology::order::sort_by_number(&mut measured, |one| one[0]);
    let circles: Vec<Circle> = (CIRCLES.into_iter().zip(circles).zip(drawn).enumerate())
        .filter(|(_, (_, drawn))| *drawn)
        .filter_map(|(i, (((name, colour), circle), _))| circle.map(|circle| (i, name, colour, circle)))
        .map(|(i, name, colour, circle)| {
            let radii = if i == 1 { vec![circle.inner, circle.outer] } else { vec![circle.radius] };
            let curves = radii.into_iter().map(|radius| around(base, circle.centre, radius)).collect();
            Circle { name, colour, zone_um: 1e3 * circle.zone, curves }
        })
        .collect();
    Some(trueaxis_report::polar(
        "points",
        &measured,
        &circles,
        "Departures of the points from the least-squares circle, seen from its centre.",
    ))
}

/// Points at which rays from the base's centre meet a circle, µm beyond the base; a ray that misses an off-centre circle gives
/// its point closest to the circle's centre.
fn around(base: &ReferenceCircle, centre: [f64; 2], radius: f64) -> Vec<f64> {
    let [x, y] = [centre[0] - base.centre[0], centre[1] - base.centre[1]];
    (0..FINE)
        .map(|i| {
            let (sin, cos) = (TAU * i as f64 / FINE as f64).sin_cos();
            let [along, across] = [x * cos + y * sin, y * cos - x * sin];
            1e3 * (along + (radius * radius - across * across).max(0.0).sqrt() - base.radius)
        })
        .collect()
}
