//! The page of a comparison.

use super::{
    Section, decimate,
    figure::{Figure, Key, Scale, Stroke, colour, framed},
    number::{count, escape, significant},
    page, write_page,
};
use crate::compare::outputs::Row;
use crate::compare::{Comparison, Outcome};
use plotters::style::RGBColor;
use std::{
    io,
    path::{Path, PathBuf},
};
use trueaxis::contour::Flags;

/// Writes the page to `compare.html` in `directory`, which is created if need be.
///
/// # Errors
/// Whatever the file system answers.
pub fn write(outcome: &Outcome, directory: &Path) -> io::Result<PathBuf> {
    write_page(directory, "compare.html", &render(outcome), Vec::new())
}

/// The page as one HTML document, which is well-formed XML too.
#[must_use]
pub fn render(outcome: &Outcome) -> String {
    let period_s = 1e-9 * f64::from(outcome.header.period_ns);
    let sections: Vec<Section> = outcome
        .comparisons
        .iter()
        .map(|one| Section { heading: one.core.title(), html: core(one, period_s) })
        .collect();
    page("Host and bare metal", &summary(outcome), &sections)
}

fn summary(outcome: &Outcome) -> String {
    let header = &outcome.header;
    let row = |one: &Comparison| {
        let nm = |value: f64| significant(value, 3);
        format!(
            "<tr><th>{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
            one.core.title(),
            count(one.cycles as u64),
            count(one.differing as u64),
            nm(one.against_double.correction_p99_9_nm),
            nm(one.against_double.correction_max_nm),
            nm(one.against_double.contour_p99_9_nm),
            nm(one.against_double.contour_max_nm),
            count(one.against_double.other as u64),
        )
    };
    let verdict = if outcome.is_good() {
        "In the same scalar image and host agree in <strong>every bit</strong>; single and double precision agree within \
         <strong>2 nm</strong> in 99.9 % of the cycles."
    } else {
        "<strong>Image and host do not agree</strong> as they must; see the table."
    };
    format!(
        "<p class=\"run\">recording <strong>{}</strong> · {} cycles at {} Hz{}</p>\n<p class=\"result\">{verdict}</p>\n\
         <p>The same recording went through the step on this host and through the bare-metal image in QEMU, cycle by cycle.</p>\n\
         <table><caption>Image against host; against double precision in nm</caption>\n<thead><tr><th></th><th>cycles</th>\
         <th>differing in a bit</th><th>correction, 99.9 %</th><th>max</th><th>contour error, 99.9 %</th><th>max</th>\
         <th>other foot or fault</th></tr></thead>\n<tbody>\n{}</tbody></table>\n",
        escape(&header.name),
        count(u64::from(header.cycles)),
        significant(1e9 / f64::from(header.period_ns), 6),
        if header.gauge { " · with a gauge of three probes" } else { "" },
        outcome.comparisons.iter().map(row).collect::<String>()
    )
}

const AXES: [(&str, RGBColor); 3] = [("X", colour::UNCOMPENSATED), ("Y", colour::COMPENSATED), ("Z", colour::SERVO)];
const WIDTH: usize = 1040;

/// A curve with its entry in the legend.
type Line<'t> = (Vec<[f64; 2]>, Key<'t>);

fn series(rows: &[Row], period_s: f64, value: impl Fn(&Row) -> f64) -> Vec<[f64; 2]> {
    let all: Vec<[f64; 2]> = rows.iter().map(|row| [f64::from(row.sequence) * period_s, value(row)]).collect();
    decimate(&all, WIDTH)
}

/// One of two figures that stand side by side, or one of its own.
fn plot(class: &str, width: i32, caption: &str, y: &str, lines: &[Line<'_>], scaled: &[f64]) -> String {
    let times = lines.iter().flat_map(|(points, _)| points.iter().map(|p| p[0]));
    let figure = Figure {
        description: caption.to_owned(),
        width,
        height: 240,
        x: Scale::linear("time in s", times, 0.0, 8),
        y: Scale::linear(y, scaled.iter().copied(), 0.05, 6),
        head: 0,
        marks: Vec::new(),
    };
    let svg = figure.draw(|plot| {
        lines.iter().try_for_each(|(points, key)| plot.line(points.iter().copied(), Stroke::new(key.colour, 1.2)))
    });
    let keys: Vec<Key<'_>> =
        lines.iter().map(|(_, key)| Key { colour: key.colour, dashed: key.dashed, text: key.text }).collect();
    framed(class, &keys, &svg, caption)
}

/// A contour error, while the foot is known: not while the search looks around for it.
fn found(row: &Row, error: f64) -> f64 {
    let unknown = Flags::COLD.and(Flags::NOT_FOUND).bits();
    if row.flags & unknown == 0 { error } else { f64::NAN }
}

fn core(one: &Comparison, period_s: f64) -> String {
    let corrections = |rows: &[Row]| -> Vec<Line<'static>> {
        let line = |(axis, (text, colour)): (usize, (&'static str, RGBColor))| {
            (series(rows, period_s, |row| 1e3 * row.correction[axis]), Key { colour, dashed: false, text })
        };
        AXES.into_iter().enumerate().map(line).collect()
    };
    let tips = |rows: &[Row]| {
        let line = |text, colour, value: fn(&Row) -> f64| {
            (series(rows, period_s, |row| 1e3 * value(row)), Key { colour, dashed: false, text })
        };
        vec![
            line("plain encoder position", colour::UNCOMPENSATED, |row| found(row, row.encoder)),
            line("estimated tool tip", colour::COMPENSATED, |row| found(row, row.tip)),
        ]
    };
    let values = |sets: [&[Line<'_>]; 2]| -> Vec<f64> {
        sets.into_iter().flatten().flat_map(|(points, _)| points.iter().map(|p| p[1])).chain([0.0]).collect()
    };
    let pair = |what: &str, y: &str, host: Vec<Line<'_>>, image: Vec<Line<'_>>| {
        let scaled = values([&host, &image]);
        format!(
            "<div class=\"figures\">{}{}</div>\n",
            plot("half", 550, &format!("{what}: on the host."), y, &host, &scaled),
            plot("half", 550, &format!("{what}: in the image."), y, &image, &scaled)
        )
    };
    let apart = |value: fn(&Row) -> f64| -> Vec<[f64; 2]> {
        let all: Vec<[f64; 2]> = one
            .image
            .iter()
            .zip(&one.double)
            .map(|(a, b)| [f64::from(a.sequence) * period_s, 1e6 * (value(a) - value(b))])
            .collect();
        decimate(&all, WIDTH)
    };
    let lines = vec![
        (apart(|row| row.correction[0]), Key { colour: AXES[0].1, dashed: false, text: "correction of X" }),
        (apart(|row| row.correction[1]), Key { colour: AXES[1].1, dashed: false, text: "correction of Y" }),
        (apart(|row| row.correction[2]), Key { colour: AXES[2].1, dashed: false, text: "correction of Z" }),
        (
            apart(|row| found(row, row.tip)),
            Key { colour: colour::NEUTRAL, dashed: false, text: "contour error of the tip" },
        ),
    ];
    let scaled: Vec<f64> = lines.iter().flat_map(|(points, _)| points.iter().map(|p| p[1])).chain([0.0]).collect();
    let caption = "The image less the host in double precision, cycle by cycle.";
    pair("Correction", "correction in µm", corrections(&one.host), corrections(&one.image))
        + &pair("Contour error", "contour error in µm", tips(&one.host), tips(&one.image))
        + &plot("full", 1120, caption, "difference in nm", &lines, &scaled)
}
