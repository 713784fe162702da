//! The page of `trueaxis identify`.

use super::figure::{Axes, Figure, Key, Stroke, colour, framed};
use super::text::{escape, significant, tick};
use super::{document, section};
use crate::identify::document::{Document, names};
use plotters::style::RGBColor;
use std::fmt::Write;
use trueaxis::Axis;

/// Standard errors an error bar reaches to either side: 95 % of normal deviations.
const BAR: f64 = 2.0;

/// The whole page; `source` is the name of the readings' file.
pub(crate) fn page(source: &str, axis: Axis, found: &Document) -> String {
    let mut body = format!(
        "<p class=\"run\">{} · {} set-ups · {} angles · sigma of a reading {} µm, {} degrees of freedom · location errors {}</p>\n",
        escape(source),
        found.set_ups.len(),
        found.angles.len(),
        significant(found.sigma_um, 3),
        found.degrees_of_freedom,
        escape(found.location_sentence())
    );
    if !found.warnings.is_empty() {
        let items: String = found.warnings.iter().map(|warning| format!("<li>{}</li>", escape(warning))).collect();
        let _ = writeln!(body, "<ul>{items}</ul>");
    }
    body.push_str(&table(axis, found));
    let names = names(axis);
    let colours = [colour::BLUE, colour::ORANGE, colour::GREEN];
    let shown = |first: usize| [0, 1, 2].map(|i| (names[first + i].as_str(), colours[i], first + i));
    body.push_str(&section("Translations", &errors(axis, found, shown(0), "µm")));
    body.push_str(&section("Rotations", &errors(axis, found, shown(3), "µrad")));
    body.push_str(&section("Residuals", &residuals(axis, found)));
    document(&format!("Errors of the axis {}", axis.letter()), &body)
}

fn table(axis: Axis, found: &Document) -> String {
    let mut html = String::from(
        "<table><thead><tr><th>error</th><th>from</th><th>to</th><th>standard error</th></tr></thead>\n<tbody>\n",
    );
    for (i, name) in names(axis).iter().enumerate() {
        let values = || found.angles.iter().map(|angle| angle.values[i]);
        let standard = found.standard_errors.get(&name.to_lowercase()).and_then(serde_json::Value::as_f64);
        let _ = writeln!(
            html,
            "<tr><th>{}</th><td>{}</td><td>{}</td><td>{}</td></tr>",
            escape(name),
            significant(values().fold(f64::INFINITY, f64::min), 3),
            significant(values().fold(f64::NEG_INFINITY, f64::max), 3),
            significant(standard.unwrap_or(f64::NAN), 2)
        );
    }
    html.push_str("</tbody></table>\n");
    html
}

/// First and last angle with room at the ends.
fn range(found: &Document) -> std::ops::Range<f64> {
    let angles = || found.angles.iter().map(|angle| angle.angle_deg);
    let (low, high) = (angles().fold(f64::INFINITY, f64::min), angles().fold(f64::NEG_INFINITY, f64::max));
    let room = 0.02 * (high - low).max(1.0);
    low - room..high + room
}

fn errors(axis: Axis, found: &Document, shown: [(&str, RGBColor, usize); 3], unit: &str) -> String {
    let reach = |i: usize| {
        let ends = move |sign: f64| found.angles.iter().map(move |a| a.values[i] + sign * BAR * a.deviations[i]);
        (ends(-1.0).fold(0.0, f64::min), ends(1.0).fold(0.0, f64::max))
    };
    let (low, high) = shown
        .iter()
        .map(|(_, _, i)| reach(*i))
        .fold((0.0, 0.0), |(low, high): (f64, f64), (l, h)| (low.min(l), high.max(h)));
    let room = if high > low { 0.06 * (high - low) } else { 1.0 };
    let axes = Axes { x: &format!("{} in degrees", axis.letter()), y: &format!("error in {unit}"), logarithmic: false };
    let description = format!("{} over the angle", shown.map(|(name, _, _)| name).join(", "));
    let figure = Figure {
        description: &description,
        size: [1120, 300],
        x: range(found),
        y: low - room..high + room,
        axes: Some(axes),
    };
    let svg = figure.draw(|plot| {
        for (_, colour, i) in shown {
            plot.line(found.angles.iter().map(|angle| [angle.angle_deg, angle.values[i]]), Stroke::new(colour, 1.4))?;
            for angle in &found.angles {
                let (value, half) = (angle.values[i], BAR * angle.deviations[i]);
                let bar = [[angle.angle_deg, value - half], [angle.angle_deg, value + half]];
                plot.line(bar, Stroke { colour, width: 1.0, opacity: 0.7 })?;
                if found.angles.len() <= 120 {
                    plot.dot([angle.angle_deg, value], colour)?;
                }
            }
        }
        Ok(())
    });
    let keys: Vec<Key<'_>> =
        shown.iter().map(|(name, colour, _)| Key { colour: *colour, dashed: false, text: name }).collect();
    framed("full", &keys, &svg, &format!("Bars: {} standard errors to either side.", tick(BAR)))
}

fn residuals(axis: Axis, found: &Document) -> String {
    let highest = found.angles.iter().map(|angle| angle.residual_um).fold(found.sigma_um, f64::max);
    let figure = Figure {
        description: "Root mean square of the residuals at every angle",
        size: [1120, 230],
        x: range(found),
        y: 0.0..if highest > 0.0 { 1.08 * highest } else { 1.0 },
        axes: Some(Axes { x: &format!("{} in degrees", axis.letter()), y: "residual in µm", logarithmic: false }),
    };
    let svg = figure.draw(|plot| {
        let steps = found.angles.windows(2).map(|pair| pair[1].angle_deg - pair[0].angle_deg);
        let half = 0.35 * steps.fold(10.0, f64::min);
        for angle in &found.angles {
            let (from, to) = ([angle.angle_deg - half, 0.0], [angle.angle_deg + half, angle.residual_um]);
            plot.fill(from, to, colour::GREY, 0.85)?;
        }
        let x = range(found);
        plot.dashed([[x.start, found.sigma_um], [x.end, found.sigma_um]], Stroke::new(colour::RED, 1.2))
    });
    let keys = [
        Key { colour: colour::GREY, dashed: false, text: "root mean square of the residuals at one angle" },
        Key { colour: colour::RED, dashed: true, text: "sigma of a reading, pooled" },
    ];
    let caption = "Residuals are smaller than sigma: at every angle six of the readings go into the errors.";
    framed("full", &keys, &svg, caption)
}
