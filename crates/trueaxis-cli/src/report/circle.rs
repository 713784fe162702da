//! The page of `trueaxis circle`.

use super::polar::{COLOURS, Reference, polar};
use super::text::{escape, significant};
use super::{document, section};
use std::f64::consts::TAU;
use std::fmt::Write;
use trueaxis_metrology::circles::{NoCircle, ReferenceCircle};

/// Points of a drawn circle.
const FINE: usize = 360;
/// Names of the circles, in the order in which they are given.
const NAMES: [&str; 4] = ["LSC", "MZC (both circles)", "MCC", "MIC"];

/// A circle, or why there is none.
pub(crate) type Fitted<'c> = Result<&'c ReferenceCircle, &'c NoCircle>;

/// The whole page; lengths in mm, circles in the order LSC, MZC, MCC, MIC. `source` is the name of the points' file.
pub(crate) fn page(source: &str, points: &[[f64; 2]], circles: [Fitted<'_>; 4]) -> String {
    let mut body = format!("<p class=\"run\">{} · {} points · ISO 12181-1</p>\n", escape(source), points.len());
    body.push_str(&table(&circles));
    let circles = circles.map(Result::ok);
    // Departures are from the least-squares circle, or from another where there is none.
    if let Some(base) = circles.into_iter().flatten().next() {
        body.push_str(&section("Departures", &figure(points, base, circles)));
    }
    document("Reference circles", &body)
}

fn table(circles: &[Fitted<'_>; 4]) -> String {
    let mut html = String::from(
        "<table><thead><tr><th>circle</th><th>centre x in mm</th><th>centre y in mm</th><th>radius in mm</th>\
         <th>zone in µm</th></tr></thead>\n<tbody>\n",
    );
    for (name, circle) in ["LSC", "MZC", "MCC", "MIC"].into_iter().zip(circles) {
        let _ = match circle {
            Ok(circle) => writeln!(
                html,
                "<tr><th>{name}</th><td>{:.6}</td><td>{:.6}</td><td>{:.6}</td><td>{}</td></tr>",
                circle.centre[0],
                circle.centre[1],
                circle.radius,
                significant(1e3 * circle.zone, 4)
            ),
            Err(reason) => writeln!(
                html,
                "<tr><th>{name}</th><td class=\"words\" colspan=\"4\">none: {}</td></tr>",
                escape(&reason.to_string())
            ),
        };
    }
    html.push_str("</tbody></table>\n");
    html
}

fn figure(points: &[[f64; 2]], base: &ReferenceCircle, circles: [Option<&ReferenceCircle>; 4]) -> String {
    let mut measured: Vec<[f64; 2]> = points
        .iter()
        .map(|point| {
            let [x, y] = [point[0] - base.centre[0], point[1] - base.centre[1]];
            [y.atan2(x), 1e3 * (x.hypot(y) - base.radius)]
        })
        .collect();
    measured.sort_by(|one, other| one[0].total_cmp(&other[0]));
    let references: Vec<Reference> = (NAMES.into_iter().zip(COLOURS).zip(circles))
        .filter_map(|((name, colour), circle)| circle.map(|circle| (name, colour, circle)))
        .map(|(name, colour, circle)| {
            let ring = name.starts_with("MZC");
            let radii = if ring { vec![circle.inner, circle.outer] } else { vec![circle.radius] };
            let curves = radii.into_iter().map(|radius| around(base, circle.centre, radius)).collect();
            Reference { name, zone_um: 1e3 * circle.zone, colour, dashed: ring, curves }
        })
        .collect();
    let caption = "Departures of the points from the least-squares circle, seen from its centre.";
    polar("points", &measured, &references, caption)
}

/// Where the rays from the base's centre meet a circle, µm beyond the base; circles that do not surround the centre are
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
