//! The page of `trueaxis circle`.

use maud::html;
use std::f64::consts::TAU;
use trueaxis_metrology::circles::{NoCircle, ReferenceCircle};
use trueaxis_report::{
    CIRCLES, Circle, Figure, Page, Row, Table,
    number::{decimals, significant},
    polar, summary,
};

/// Points of a drawn circle.
const FINE: usize = 360;

/// A circle, or why there is none.
pub(crate) type Fitted<'c> = Result<&'c ReferenceCircle, &'c NoCircle>;

/// The whole page; lengths in mm, circles in the order LSC, MZC, MCC, MIC. `source` is the name of the points' file.
pub(crate) fn page(source: &str, points: &[[f64; 2]], circles: [Fitted<'_>; 4]) -> String {
    let page = Page::new("Reference circles")
        .top(summary([html! { (source) }, html! { (points.len()) " points" }, html! { "ISO 12181-1" }]))
        .top(table(&circles));
    let circles = circles.map(Result::ok);
    // Departures are from the least-squares circle, or from another where there is none.
    match circles.into_iter().flatten().next() {
        Some(base) => page.section("Departures", figure(points, base, circles)),
        None => page,
    }
    .document()
}

fn table(circles: &[Fitted<'_>; 4]) -> Table {
    let row = |(name, circle): (&str, &Fitted<'_>)| match circle {
        Ok(circle) => {
            let [x, y, radius] = [circle.centre[0], circle.centre[1], circle.radius].map(|mm| decimals(mm, 6));
            Row::new(name, [x, y, radius, significant(1e3 * circle.zone, 4)])
        }
        Err(reason) => Row::whole(name, format!("none: {reason}")),
    };
    let rows = ["LSC", "MZC", "MCC", "MIC"].into_iter().zip(circles).map(row);
    Table::new(["circle", "centre x in mm", "centre y in mm", "radius in mm", "zone in µm"], rows)
}

fn figure(points: &[[f64; 2]], base: &ReferenceCircle, circles: [Option<&ReferenceCircle>; 4]) -> Figure {
    let departure = |point: &[f64; 2]| {
        let [x, y] = [point[0] - base.centre[0], point[1] - base.centre[1]];
        [y.atan2(x), 1e3 * (x.hypot(y) - base.radius)]
    };
    let mut measured: Vec<[f64; 2]> = points.iter().map(departure).collect();
    measured.sort_by(|one, other| one[0].total_cmp(&other[0]));
    let circles: Vec<Circle> = (CIRCLES.into_iter().zip(circles).enumerate())
        .filter_map(|(i, ((name, colour), circle))| circle.map(|circle| (i, name, colour, circle)))
        .map(|(i, name, colour, circle)| {
            let radii = if i == 1 { vec![circle.inner, circle.outer] } else { vec![circle.radius] };
            let curves = radii.into_iter().map(|radius| around(base, circle.centre, radius)).collect();
            Circle { name, colour, zone_um: 1e3 * circle.zone, curves }
        })
        .collect();
    polar(
        "points",
        &measured,
        &circles,
        "Departures of the points from the least-squares circle, seen from its centre.",
    )
}

/// Points where the rays from the base's centre meet a circle, µm beyond the base; circles not around the centre are
/// seen at the nearest point of the ray.
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
