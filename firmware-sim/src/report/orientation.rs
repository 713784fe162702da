//! Orientation error over the path, and where the rotary axes stand.

use plotters::style::RGBColor;

use super::{
    Report, Section, decimate,
    figure::{Figure, Key, Scale, Stroke, colour, framed, plottable_points},
    number::significant,
};

const WIDTH: i32 = 1120;
const LENGTH: &str = "path length in mm (in degrees where nothing but rotary axes moves)";

pub(super) fn section(report: &Report) -> Option<Section> {
    let series = &report.orientation;
    let error = curves(&[
        ("uncompensated", colour::UNCOMPENSATED, &series.uncompensated),
        ("compensated", colour::COMPENSATED, &series.compensated),
        ("servo only", colour::SERVO, &series.servo_only),
    ]);
    if error.is_empty() {
        return None;
    }
    let texts: Vec<String> = error
        .iter()
        .map(|(name, _, points)| {
            let largest = points.iter().map(|p| p[1]).fold(0.0, f64::max);
            format!("{name}: largest {} µrad", significant(largest, 3))
        })
        .collect();
    let highest = error.iter().flat_map(|(_, _, points)| points.iter().map(|p| p[1])).fold(0.0, f64::max);
    let caption = "Angle between the true tool direction and the programmed one at the foot point of the tip.";
    let scale = Scale::exact("orientation error in µrad", 0.0, if highest > 0.0 { 1.08 * highest } else { 1.0 }, 6);
    let mut html = figure(report, &error, scale, &texts, caption);
    let palette = [colour::NEUTRAL, colour::NOMINAL, colour::LIMIT];
    let named: Vec<_> = series
        .rotary
        .iter()
        .zip(palette)
        .map(|((name, points), colour)| (name.as_str(), colour, points.as_slice()))
        .collect();
    let rotary = curves(&named);
    if !rotary.is_empty() {
        let texts: Vec<String> = rotary.iter().map(|(name, ..)| (*name).to_owned()).collect();
        let values = rotary.iter().flat_map(|(_, _, points)| points.iter().map(|p| p[1]));
        let scale = Scale::linear("position in degrees", values, 0.04, 6);
        html.push_str(&figure(report, &rotary, scale, &texts, "Commanded positions of the rotary axes."));
    }
    Some(Section { heading: "Tool direction over the path", html })
}

type Named<'a> = (&'a str, RGBColor, Vec<[f64; 2]>);

fn curves<'a>(series: &[(&'a str, RGBColor, &[[f64; 2]])]) -> Vec<Named<'a>> {
    series
        .iter()
        .map(|(name, colour, points)| (*name, *colour, decimate(&plottable_points(points), 700)))
        .filter(|(_, _, points)| !points.is_empty())
        .collect()
}

fn figure(report: &Report, curves: &[Named<'_>], y: Scale, texts: &[String], caption: &str) -> String {
    let lengths = curves.iter().flat_map(|(_, _, points)| points.iter().map(|point| point[0]));
    let figure = Figure {
        description: caption.to_owned(),
        width: WIDTH,
        height: 230,
        x: Scale::linear(LENGTH, lengths, 0.0, 12),
        y,
        head: 0,
        marks: Vec::new(),
    };
    let svg = figure.draw(|plot| {
        for (_, colour, points) in curves.iter().rev() {
            let run = |point: &[f64; 2]| report.contour.breaks.partition_point(|at| *at <= point[0]);
            for points in points.chunk_by(|a, b| run(a) == run(b)) {
                plot.line(points.iter().copied(), Stroke { colour: *colour, width: 1.2, opacity: 0.85 })?;
            }
        }
        Ok(())
    });
    let keys: Vec<Key<'_>> =
        curves.iter().zip(texts).map(|((_, colour, _), text)| Key { colour: *colour, dashed: false, text }).collect();
    framed("full", &keys, &svg, caption)
}
