//! Contour error over the path length.

use plotters::style::RGBColor;

use super::{
    Report, Section, decimate,
    figure::{Figure, Key, Scale, Stroke, colour, framed, plottable, plottable_points},
    number::significant,
};

const WIDTH: i32 = 1120;
/// A second figure shows the small curves alone when the compensated maximum is below this share of the other.
const ENLARGE_BELOW: f64 = 0.4;
/// Least distance of two program line numbers, in px.
const LINE_SPACING: f64 = 34.0;

struct Curve {
    name: &'static str,
    colour: RGBColor,
    points: Vec<[f64; 2]>,
    largest: [f64; 2],
}

impl Curve {
    fn new(name: &'static str, colour: RGBColor, series: &[[f64; 2]]) -> Option<Self> {
        let magnitudes: Vec<[f64; 2]> =
            plottable_points(series).into_iter().map(|[length, error]| [length, error.abs()]).collect();
        let largest = magnitudes.iter().copied().max_by(|a, b| a[1].total_cmp(&b[1]))?;
        Some(Self { name, colour, points: decimate(&magnitudes, 700), largest })
    }
}

pub(super) fn section(report: &Report) -> Option<Section> {
    let series = &report.contour;
    let curves: Vec<Curve> = [
        Curve::new("uncompensated", colour::UNCOMPENSATED, &series.uncompensated),
        Curve::new("compensated", colour::COMPENSATED, &series.compensated),
        Curve::new("servo only", colour::SERVO, &series.servo_only),
    ]
    .into_iter()
    .flatten()
    .collect();
    let mut html = String::new();
    if curves.is_empty() {
        html.push_str("<p class=\"empty\">No contour error was recorded.</p>\n");
    } else {
        let all: Vec<&Curve> = curves.iter().collect();
        let caption = "Magnitude of the distance from the true tool tip to the programmed path. The dots mark the \
                       largest error of each run; the numbers above are program lines.";
        html.push_str(&figure(report, &all, &all, caption));
        let largest = curves.iter().map(|curve| curve.largest[1]).fold(0.0, f64::max);
        let small: Vec<&Curve> = curves.iter().filter(|curve| curve.largest[1] < ENLARGE_BELOW * largest).collect();
        if !small.is_empty() {
            html.push_str(&figure(report, &small, &all, "The small errors of the figure above, enlarged."));
        }
    }
    Some(Section { heading: "Contour error over the path", html })
}

/// One figure of `curves`; its path-length axis spans `all`, so that figures below each other line up.
fn figure(report: &Report, curves: &[&Curve], all: &[&Curve], caption: &str) -> String {
    let lengths = all.iter().flat_map(|curve| curve.points.iter().map(|point| point[0]));
    let errors = curves.iter().map(|curve| curve.largest[1]);
    let highest = errors.fold(0.0, f64::max);
    let x = Scale::linear("path length in mm", lengths, 0.0, 12);
    let lines = spaced_lines(&report.contour.program_lines, &x);
    let figure = Figure {
        description: format!("{caption} Curves: {}", curves.iter().map(|c| c.name).collect::<Vec<_>>().join(", ")),
        width: WIDTH,
        height: 270,
        x,
        y: Scale::exact("contour error in µm", 0.0, if highest > 0.0 { 1.08 * highest } else { 1.0 }, 6),
        head: if lines.is_empty() { 0 } else { 12 },
        marks: Vec::new(),
    };
    let svg = figure.draw(|plot| {
        for &(length, line) in &lines {
            plot.tick_above(length, &line.to_string())?;
        }
        // Compensated before servo only in the legend, but on top of it in the plot.
        for curve in curves.iter().rev() {
            let run = |point: &[f64; 2]| report.contour.breaks.partition_point(|at| *at <= point[0]);
            for points in curve.points.chunk_by(|a, b| run(a) == run(b)) {
                plot.line(points.iter().copied(), Stroke { colour: curve.colour, width: 1.2, opacity: 0.85 })?;
            }
        }
        curves.iter().try_for_each(|curve| plot.dot(curve.largest, curve.colour))
    });
    let texts: Vec<String> = curves
        .iter()
        .map(|curve| {
            let [length, error] = curve.largest;
            format!("{}: largest {} µm at {} mm", curve.name, significant(error, 3), significant(length, 4))
        })
        .collect();
    let keys: Vec<Key<'_>> =
        curves.iter().zip(&texts).map(|(curve, text)| Key { colour: curve.colour, dashed: false, text }).collect();
    framed("full", &keys, &svg, caption)
}

/// The program lines whose numbers fit above the figure without touching.
fn spaced_lines(lines: &[(f64, u32)], x: &Scale) -> Vec<(f64, u32)> {
    let [inside, _] = Figure::inside(WIDTH, 0);
    let least = LINE_SPACING * (x.high - x.low) / f64::from(inside);
    let mut kept: Vec<(f64, u32)> = Vec::new();
    for &(length, line) in lines.iter().filter(|line| plottable(line.0) && (x.low..=x.high).contains(&line.0)) {
        if kept.last().is_none_or(|last| length - last.0 >= least) {
            kept.push((length, line));
        }
    }
    kept
}
