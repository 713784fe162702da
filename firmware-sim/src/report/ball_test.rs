//! The page of a ball test.

use super::{
    Section,
    figure::{Figure, Key, Scale, Stroke, colour, framed},
    number::{escape, significant},
    page, write_page,
};
use crate::ball_test::{AxisOutcome, BallCycle, Outcome, TipError};
use plotters::style::RGBColor;
use std::{
    io,
    path::{Path, PathBuf},
};

/// Writes the page to `rtcp.html` in `directory`, with the readings and the tables; the folder is created if need be.
///
/// # Errors
/// Whatever the file system answers.
pub fn write(test: &BallCycle, outcome: &Outcome, directory: &Path) -> io::Result<PathBuf> {
    write_page(directory, "rtcp.html", &render(test, outcome), outcome.files())
}

/// The page as one HTML document, which is well-formed XML too.
#[must_use]
pub fn render(test: &BallCycle, outcome: &Outcome) -> String {
    let tip: String = outcome.axes.iter().map(tip_error).collect();
    let errors: String = outcome.axes.iter().map(|of| identified(test, of)).collect();
    let residuals: String = outcome.axes.iter().map(residuals).collect();
    let sections = [
        Section { heading: "True tip error over the angle", html: tip },
        Section { heading: "Identified errors", html: errors },
        Section { heading: "Residuals", html: residuals },
    ];
    page("Ball test of a five-axis head", &summary(test, outcome), &sections)
}

fn summary(test: &BallCycle, outcome: &Outcome) -> String {
    let settings = &test.machine.settings;
    let um = |value: f64| significant(value, 3);
    let row = |name: &str, before: TipError, after: TipError| {
        format!(
            "<tr><th>{name}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{} %</td></tr>\n",
            um(before.max),
            um(before.rms),
            um(after.max),
            um(after.rms),
            significant(100.0 * after.rms / before.rms, 2)
        )
    };
    let rows: String =
        outcome.axes.iter().map(|of| row(&format!("axis {}", of.axis.letter()), of.before, of.after)).collect();
    format!(
        "<p class=\"run\">machine <strong>{}</strong> · chain <strong>{}</strong> · gauge {} µm a reading · seed {}</p>\n\
         <p class=\"result\">Of the tip error that the rotary axes cause, <strong>{} %</strong> is left: <strong>{} µm</strong> \
         rms instead of <strong>{} µm</strong>.</p>\n\
         <p>Three set-ups of a ball for either axis, RTCP holding its centre; linear axes are perfect. The identified \
         tables were compiled and used by the volumetric correction; the true tip error is judged at every degree, not only \
         where the gauge stood.</p>\n\
         <table><caption>True tip error in µm</caption>\n<thead><tr><th></th><th>before, max</th><th>rms</th>\
         <th>after, max</th><th>rms</th><th>left, rms</th></tr></thead>\n<tbody>\n{rows}{}</tbody></table>\n",
        escape(&settings.name),
        escape(&settings.chain),
        significant(test.gauge_noise_um, 3),
        test.seed,
        significant(100.0 * outcome.after.rms / outcome.before.rms, 2),
        um(outcome.after.rms),
        um(outcome.before.rms),
        row("both", outcome.before, outcome.after)
    )
}

fn angle_scale(of: &AxisOutcome) -> Scale {
    Scale::linear(
        &format!("{} in degrees", of.axis.letter()),
        of.over_angle.iter().map(|stop| stop.angle_deg),
        0.02,
        12,
    )
}

fn tip_error(of: &AxisOutcome) -> String {
    let before: Vec<[f64; 2]> = of.over_angle.iter().map(|stop| [stop.angle_deg, stop.before_um]).collect();
    let after: Vec<[f64; 2]> = of.over_angle.iter().map(|stop| [stop.angle_deg, stop.after_um]).collect();
    let values = before.iter().chain(&after).map(|point| point[1]).chain([0.0]);
    let figure = Figure {
        description: format!("true tip error over the angle of {}", of.axis.letter()),
        width: 1120,
        height: 250,
        x: angle_scale(of),
        y: Scale::linear("tip error in µm", values, 0.04, 6),
        head: 0,
        marks: Vec::new(),
    };
    let svg = figure.draw(|plot| {
        plot.line(before, Stroke::new(colour::UNCOMPENSATED, 1.4))?;
        plot.line(after, Stroke::new(colour::COMPENSATED, 1.4))
    });
    let keys = [
        Key { colour: colour::UNCOMPENSATED, dashed: false, text: "before" },
        Key { colour: colour::COMPENSATED, dashed: false, text: "with the identified tables" },
    ];
    let caption = format!("Axis {}: root mean square over the three set-ups.", of.axis.letter());
    framed("full", &keys, &svg, &caption)
}

/// Names and colours of three errors.
const SHOWN: [(&str, RGBColor); 3] = [("X", colour::UNCOMPENSATED), ("Y", colour::COMPENSATED), ("Z", colour::SERVO)];

fn identified(test: &BallCycle, of: &AxisOutcome) -> String {
    let letter = of.axis.letter();
    let figure = |first: usize, unit: &str, scale: f64| {
        let value =
            move |k: usize, i: usize| of.found.angles.get(k).map_or(0.0, |angle| scale * angle.errors[first + i]);
        let half = move |k: usize, i: usize| {
            of.found.angles.get(k).map_or(0.0, |a| 2.0 * scale * a.standard_errors[first + i])
        };
        let stops = || of.stops_deg.iter().copied().enumerate();
        let ends =
            stops().flat_map(|(k, _)| (0..3).flat_map(move |i| [value(k, i) - half(k, i), value(k, i) + half(k, i)]));
        let figure = Figure {
            description: format!("identified errors of {letter} in {unit}"),
            width: 1120,
            height: 270,
            x: angle_scale(of),
            y: Scale::linear(&format!("error in {unit}"), ends, 0.06, 6),
            head: 0,
            marks: Vec::new(),
        };
        let svg = figure.draw(|plot| {
            for (i, (_, colour)) in SHOWN.into_iter().enumerate() {
                plot.line(stops().map(|(k, angle)| [angle, value(k, i)]), Stroke::new(colour, 1.3))?;
                for (k, angle) in stops() {
                    let bar = [[angle, value(k, i) - half(k, i)], [angle, value(k, i) + half(k, i)]];
                    plot.line(bar, Stroke::new(colour, 1.0))?;
                }
            }
            Ok(())
        });
        let names: Vec<String> =
            (0..3).map(|i| format!("E{}{letter}", ["X", "Y", "Z", "A", "B", "C"][first + i])).collect();
        let keys: Vec<Key<'_>> =
            SHOWN.iter().zip(&names).map(|((_, colour), text)| Key { colour: *colour, dashed: false, text }).collect();
        let caption = format!(
            "Axis {letter} of {}, as read; bars: two standard errors to either side, from sigma {} µm with {} degrees of freedom.",
            test.machine.settings.name,
            significant(1e3 * of.found.sigma_mm, 3),
            of.found.degrees_of_freedom
        );
        framed("full", &keys, &svg, &caption)
    };
    figure(0, "µm", 1e3) + &figure(3, "µrad", 1e6)
}

fn residuals(of: &AxisOutcome) -> String {
    let points: Vec<[f64; 2]> =
        of.stops_deg.iter().zip(&of.found.angles).map(|(&angle, found)| [angle, 1e3 * found.residual_mm]).collect();
    let figure = Figure {
        description: format!("residuals of {}", of.axis.letter()),
        width: 1120,
        height: 200,
        x: angle_scale(of),
        y: Scale::linear(
            "residual in µm",
            points.iter().map(|point| point[1]).chain([0.0, 1e3 * of.found.sigma_mm]),
            0.06,
            5,
        ),
        head: 0,
        marks: Vec::new(),
    };
    let svg = figure.draw(|plot| {
        plot.across(1e3 * of.found.sigma_mm, Stroke::new(colour::LIMIT, 1.2))?;
        points.iter().try_for_each(|&point| plot.dot(point, colour::NEUTRAL))
    });
    let keys = [
        Key { colour: colour::NEUTRAL, dashed: false, text: "root mean square of the residuals at a stop" },
        Key { colour: colour::LIMIT, dashed: false, text: "sigma of a reading, pooled" },
    ];
    framed("full", &keys, &svg, &format!("Axis {}.", of.axis.letter()))
}
