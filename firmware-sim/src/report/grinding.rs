//! The page of a grinding run.

use super::{
    Section,
    figure::{Drawn, Figure, Key, Plot, Scale, Stroke, colour, framed},
    number::{count, decimals, escape, round_down, significant},
    page, write_page,
};
use crate::grinding::{CELLS, Grinding, Harmonic, Outcome, Run};
use plotters::style::RGBColor;
use std::{
    f64::consts::TAU,
    io,
    path::{Path, PathBuf},
};
use trueaxis::roundness::ErrorMotion;

/// Share of the drawn radius that the largest deviation takes.
const SHARE: f64 = 0.22;
/// Points of a drawn surface: the peaks of harmonic 100 are drawn within 0.3 %.
const DRAWN: usize = 2048;

/// Writes the page to `grinding.html` in `directory`, which is created if need be; returns the file's path.
///
/// # Errors
/// Whatever the file system answers.
pub fn write(grinding: &Grinding, outcome: &Outcome, directory: &Path) -> io::Result<PathBuf> {
    write_page(directory, "grinding.html", &render(grinding, outcome), Vec::new())
}

/// The page as one HTML document, which is well-formed XML too.
#[must_use]
pub fn render(grinding: &Grinding, outcome: &Outcome) -> String {
    let sections = [
        Section { heading: "Roundness, revolution by revolution", html: progress(outcome) },
        Section { heading: "The surface", html: surfaces(grinding, outcome) },
        Section { heading: "Harmonics of the surface", html: harmonics(grinding, outcome) },
        Section { heading: "Infeed correction", html: correction(grinding, outcome) },
        Section { heading: "Motion of the pin's centre", html: orbits(outcome) },
    ];
    page("Grinding a crankpin", &summary(grinding, outcome), &sections)
}

fn summary(grinding: &Grinding, outcome: &Outcome) -> String {
    let Outcome { uncorrected: before, corrected: after, .. } = outcome;
    let settings = &grinding.machine.settings;
    let run = format!(
        "<p class=\"run\">machine <strong>{}</strong> · chain <strong>{}</strong> · {} revolutions at {} rpm · \
         {} servo cycles at {} Hz</p>\n",
        escape(&settings.name),
        escape(&settings.chain),
        count(grinding.revolutions.into()),
        significant(grinding.speed_rpm, 3),
        count(after.cycles),
        significant(grinding.rate_hz, 4)
    );
    let result = format!(
        "<p class=\"result\">With correction <strong>{} %</strong> of the synchronous imprint is left: <strong>{} µm</strong> \
         instead of <strong>{} µm</strong>.</p>\n",
        significant(100.0 * outcome.imprint_ratio(), 2),
        significant(after.imprint_um, 3),
        significant(before.imprint_um, 3)
    );
    let explained = format!(
        "<p>The synchronous imprint is what repeats with every turn: the root mean square of the corrected harmonics of the \
         true surface, averaged over the last {} revolutions, so that what does not repeat cancels. Once-per-revolution \
         motion leaves an eccentric pin, asynchronous motion a random one; neither is corrected.</p>\n",
        after.averaged
    );
    [run, result, explained, "<div class=\"tables\">\n".into(), results(outcome), motions(outcome), "</div>\n".into()]
        .concat()
}

fn results(outcome: &Outcome) -> String {
    let [off, on] = [&outcome.uncorrected, &outcome.corrected];
    let row = |name: &str, value: &dyn Fn(&Run) -> String| {
        format!("<tr><th>{name}</th><td>{}</td><td>{}</td></tr>\n", value(off), value(on))
    };
    let um = |value: f64| format!("{} µm", significant(value, 3));
    let seen = |value: Option<f64>| value.map_or("–".to_owned(), um);
    let rows = [
        row("synchronous imprint", &|run| um(run.imprint_um)),
        row("out of roundness, mean", &|run| um(run.roundness_um)),
        row("last revolution: imprint, true", &|run| seen(run.revolutions.last().map(|r| r.imprint_um))),
        row("imprint, gauge", &|run| seen(run.revolutions.last().and_then(|r| r.gauge_imprint_um))),
        row("out of roundness, true", &|run| seen(run.revolutions.last().map(|r| r.roundness_um))),
        row("out of roundness, gauge", &|run| seen(run.revolutions.last().and_then(|r| r.gauge_roundness_um))),
        row("revolutions evaluated", &|run| count(run.counts.evaluated.into())),
        row("revolutions skipped", &|run| count(run.counts.skipped.into())),
        row("revolutions discarded", &|run| count(run.counts.discarded.into())),
        row("cycles of work on a revolution, at most", &|run| count(run.cycles_of_work as u64)),
        row("cycles in which the limiter held back", &|run| count(run.limited_cycles)),
        row("cycles beyond a limit of the correction", &|run| count(run.limits_exceeded)),
    ];
    format!(
        "<table><caption>The two runs</caption>\n<thead><tr><th></th><th>without</th><th>with correction</th></tr></thead>\n\
         <tbody>\n{}</tbody></table>\n",
        rows.concat()
    )
}

fn motions(outcome: &Outcome) -> String {
    let row = |name: &str, motion: &ErrorMotion<f64>| {
        let [a, b] = motion.once_per_revolution_um;
        let cells = [motion.synchronous_um, motion.asynchronous_um, a.hypot(b)].map(|um| decimals(um, 3));
        format!("<tr><th>{name}</th><td>{}</td></tr>\n", cells.join("</td><td>"))
    };
    let [x, y] = &outcome.motion;
    let mut rows = row("X, true", x);
    let measured = outcome.corrected.evaluation.filter(|e| e.revolutions > 0);
    if let Some(measured) = measured {
        rows += &row("X, gauge", &measured.x);
    }
    rows += &row("Y, true", y);
    if let Some(measured) = measured {
        rows += &row("Y, gauge", &measured.y);
    }
    format!(
        "<div><table><caption>Error motion of the pin's centre in µm, with correction</caption>\n<thead><tr><th></th>\
         <th>synchronous</th><th>asynchronous</th><th>once per revolution</th></tr></thead>\n<tbody>\n{rows}</tbody></table>\n\
         <p>X across probe 1, Y along it. Seen from the machine the centre of the pin moves with the spindle and with the \
         eccentricity that was ground. The gauge's asynchronous value holds the probes' noise as \
         well.</p></div>\n"
    )
}

const KEYS: [Key<'static>; 2] = [
    Key { colour: colour::UNCOMPENSATED, dashed: false, text: "without correction" },
    Key { colour: colour::COMPENSATED, dashed: false, text: "with correction" },
];

fn both(outcome: &Outcome) -> [(&Run, RGBColor); 2] {
    [(&outcome.uncorrected, colour::UNCOMPENSATED), (&outcome.corrected, colour::COMPENSATED)]
}

/// Logarithmic scale over positive values, at most four decades.
fn decades(caption: &str, values: impl Iterator<Item = f64>) -> Scale {
    let positive = values.filter(|v| *v > 0.0 && v.is_finite());
    let [low, high] = positive.fold([f64::INFINITY, 0.0_f64], |[low, high], v| [low.min(v), high.max(v)]);
    let high = if high > 0.0 { high } else { 1.0 };
    let top = (1.3 * high).log10();
    Scale::logarithmic(caption, (0.7 * low).log10().max(top - 4.0).min(top - 1.0), top, true)
}

fn progress(outcome: &Outcome) -> String {
    let figure = |what: &str, unit: &str, value: fn(&crate::grinding::Revolution) -> f64, caption: &str| {
        let values = both(outcome).into_iter().flat_map(|(run, _)| run.revolutions.iter().map(value));
        let last = outcome.corrected.revolutions.len().max(2) as f64;
        let figure = Figure {
            description: format!("{what} of the true surface per revolution, without and with correction"),
            width: 550,
            height: 300,
            x: Scale::exact("revolution", 1.0, last, 8),
            y: decades(&format!("{what} in {unit}"), values),
            head: 0,
            marks: Vec::new(),
        };
        let svg = figure.draw(|plot| {
            both(outcome).into_iter().try_for_each(|(run, colour)| {
                let points = run.revolutions.iter().enumerate().filter(|(_, r)| value(r) > 0.0);
                plot.line(points.map(|(n, r)| [n as f64 + 1.0, value(r).log10()]), Stroke::new(colour, 1.6))
            })
        });
        framed("half", &KEYS, &svg, caption)
    };
    format!(
        "<div class=\"figures\">\n{}{}</div>\n",
        figure(
            "out-of-roundness",
            "µm",
            |r| r.roundness_um,
            "Peak to valley of the true surface about its least-squares circle, all harmonics. The first revolutions still \
             show the rough pin."
        ),
        figure(
            "imprint",
            "µm rms",
            |r| r.imprint_um,
            "Corrected harmonics of the true surface of each single revolution, asynchronous motion included."
        )
    )
}

fn surfaces(grinding: &Grinding, outcome: &Outcome) -> String {
    let pin_mm = grinding.machine.settings.roundness.and_then(|g| g.arm).map_or(10.0, |arm| arm.lengths.pin_mm);
    let [rough, off] = &outcome.uncorrected.surfaces;
    let [_, on] = &outcome.corrected.surfaces;
    let rough: (&[f64], RGBColor, &str) = (rough, colour::NEUTRAL, "before grinding");
    let off: (&[f64], RGBColor, &str) = (off, colour::UNCOMPENSATED, "without correction");
    let on: (&[f64], RGBColor, &str) = (on, colour::COMPENSATED, "with correction");
    format!("<div class=\"figures\">\n{}{}</div>\n", polar(pin_mm, &[rough, off, on]), polar(pin_mm, &[on]))
}

/// Surfaces round the pin, deviations magnified.
fn polar(pin_mm: f64, curves: &[(&[f64], RGBColor, &str)]) -> String {
    let largest = curves.iter().flat_map(|(r, ..)| r.iter()).fold(0.0, |worst: f64, r| worst.max(r.abs()));
    let magnification = if largest > 0.0 { round_down(SHARE * pin_mm / (1e-3 * largest)) } else { 1.0 };
    let round = |surface: &[f64]| {
        let step = (surface.len() / DRAWN).max(1);
        let places = (0..=surface.len()).step_by(step);
        let points = places.filter_map(|j| {
            let radius = pin_mm + magnification * 1e-3 * surface.get(j % surface.len().max(1))?;
            let (sin, cos) = (TAU * j as f64 / surface.len() as f64).sin_cos();
            Some([radius * cos, radius * sin])
        });
        points.collect::<Vec<_>>()
    };
    let nominal = round(&[0.0; CELLS / 8]);
    let reach = 1.3 * pin_mm;
    // A square inside the axes.
    let (width, mut height) = (550, 550);
    let [inside_x, inside_y] = Figure::inside(width, height);
    height += inside_x - inside_y;
    let figure = Figure {
        description: "the pin's surface with deviations from its circle magnified".into(),
        width,
        height,
        x: Scale::exact("mm", -reach, reach, 7),
        y: Scale::exact("mm", -reach, reach, 7),
        head: 0,
        marks: Vec::new(),
    };
    let svg = figure.draw(|plot| {
        plot.line(nominal, Stroke::new(colour::NOMINAL, 0.9))?;
        curves.iter().try_for_each(|(surface, colour, _)| plot.line(round(surface), Stroke::new(*colour, 1.2)))
    });
    let mut keys = vec![Key { colour: colour::NOMINAL, dashed: false, text: "least-squares circle" }];
    keys.extend(curves.iter().map(|(_, colour, text)| Key { colour: *colour, dashed: false, text }));
    let caption = format!(
        "True surface about its least-squares circle; deviations magnified {} times, largest {} µm. The angle is that of the \
         pin's surface, counterclockwise.",
        count(magnification as u64),
        significant(largest, 3)
    );
    framed("half", &keys, &svg, &caption)
}

fn harmonics(grinding: &Grinding, outcome: &Outcome) -> String {
    let amplitude = |[a, b]: &Harmonic| a.hypot(*b);
    let first = grinding.machine.settings.roundness.and_then(|g| g.infeed).map_or(2, |i| usize::from(i.band.first));
    let last = outcome.corrected.average.len().max(first + 1);
    let values = both(outcome).into_iter().flat_map(|(run, _)| run.average.iter().skip(first).map(amplitude));
    let y = decades("amplitude in µm", values);
    let floor = y.low;
    let figure = Figure {
        description: "amplitudes of the surface's harmonics without and with correction".into(),
        width: 1120,
        height: 270,
        x: Scale::exact("undulations per revolution", first as f64 - 0.6, last as f64 - 0.4, 24),
        y,
        head: 0,
        marks: Vec::new(),
    };
    let svg = figure.draw(|plot| {
        for ((run, colour), shift) in both(outcome).into_iter().zip([-0.38, 0.02]) {
            for (k, harmonic) in run.average.iter().enumerate().skip(first) {
                let top = amplitude(harmonic).log10();
                if top > floor {
                    plot.column(k as f64 + shift, k as f64 + shift + 0.36, top, colour)?;
                }
            }
        }
        Ok(())
    });
    let caption =
        format!("Amplitudes of the true surface, averaged over the last {} revolutions.", outcome.corrected.averaged);
    framed("full", &KEYS, &svg, &caption)
}

fn correction(grinding: &Grinding, outcome: &Outcome) -> String {
    let first = grinding.machine.settings.roundness.and_then(|g| g.infeed).map_or(2, |i| usize::from(i.band.first));
    let degrees = |n: usize, of: usize| 360.0 * n as f64 / of.max(1) as f64;
    let table = &outcome.corrected.correction;
    let fed: Vec<[f64; 2]> = (0..=table.len())
        .filter_map(|n| Some([degrees(n, table.len()), *table.get(n % table.len().max(1))?]))
        .collect();
    let needed = |n: usize| {
        let angle = TAU * n as f64 / 720.0;
        let terms = outcome.uncorrected.average.iter().enumerate().skip(first);
        terms.map(|(k, [a, b])| a * (k as f64 * angle).cos() + b * (k as f64 * angle).sin()).sum::<f64>()
    };
    let needed: Vec<[f64; 2]> = (0..=720).map(|n| [degrees(n, 720), needed(n)]).collect();
    let figure = Figure {
        description: "infeed correction over the angle of the surface".into(),
        width: 1120,
        height: 250,
        x: Scale::exact("angle of the surface in degrees", 0.0, 360.0, 12),
        y: Scale::linear("infeed in µm", fed.iter().chain(&needed).map(|p| p[1]), 0.06, 6),
        head: 0,
        marks: Vec::new(),
    };
    let svg = figure.draw(|plot| {
        plot.line(needed, Stroke { colour: colour::UNCOMPENSATED, width: 3.0, opacity: 0.45 })?;
        plot.line(fed, Stroke::new(colour::COMPENSATED, 1.4))
    });
    let keys = [
        Key { colour: colour::UNCOMPENSATED, dashed: false, text: "what stands on the surface without correction" },
        Key { colour: colour::COMPENSATED, dashed: false, text: "correction that the gauge has learnt" },
    ];
    framed("full", &keys, &svg, "Where the surface would stand high, the wheel is fed in further.")
}

/// A closed curve in the plane, without its mean and, if asked, without its first harmonic.
fn centred(points: &[[f64; 2]], first_too: bool) -> Vec<[f64; 2]> {
    let n = points.len().max(1) as f64;
    let mut terms = [[0.0; 3]; 2];
    for (k, point) in points.iter().enumerate() {
        let (sin, cos) = (TAU * k as f64 / n).sin_cos();
        for (terms, value) in terms.iter_mut().zip(point) {
            for (term, weight) in terms.iter_mut().zip([1.0, 2.0 * cos, 2.0 * sin]) {
                *term += value * weight / n;
            }
        }
    }
    let rest = |(k, point): (usize, &[f64; 2])| {
        let (sin, cos) = (TAU * k as f64 / n).sin_cos();
        std::array::from_fn(|i| {
            let [mean, a, b] = terms[i];
            point[i] - mean - if first_too { a * cos + b * sin } else { 0.0 }
        })
    };
    points.iter().enumerate().chain(points.first().map(|first| (0, first))).map(rest).collect()
}

fn orbits(outcome: &Outcome) -> String {
    let [x, y] = &outcome.corrected.motion;
    let seen: Vec<[f64; 2]> = x.iter().zip(y).map(|(x, y)| [*x, *y]).collect();
    let figure = |first_too: bool, caption: &str| {
        let (truth, seen) = (centred(&outcome.orbit, first_too), centred(&seen, first_too));
        let reach = truth.iter().chain(&seen).flatten().fold(0.0, |worst: f64, v| worst.max(v.abs()));
        let reach = if reach > 0.0 { 1.1 * reach } else { 1.0 };
        let (width, mut height) = (550, 550);
        let [inside_x, inside_y] = Figure::inside(width, height);
        height += inside_x - inside_y;
        let figure = Figure {
            description: caption.to_owned(),
            width,
            height,
            x: Scale::exact("R_X in µm", -reach, reach, 7),
            y: Scale::exact("R_Y in µm", -reach, reach, 7),
            head: 0,
            marks: Vec::new(),
        };
        let svg = figure.draw(|plot: &mut Plot<'_, '_>| -> Drawn {
            plot.line(truth, Stroke { colour: colour::NEUTRAL, width: 3.0, opacity: 0.45 })?;
            plot.line(seen, Stroke::new(colour::COMPENSATED, 1.2))
        });
        let keys = [
            Key { colour: colour::NEUTRAL, dashed: false, text: "true, mean revolution" },
            Key { colour: colour::COMPENSATED, dashed: false, text: "gauge, latest revolution" },
        ];
        framed("half", &keys, &svg, caption)
    };
    format!(
        "<div class=\"figures\">\n{}{}</div>\n",
        figure(false, "Motion of the pin's centre about its mean place."),
        figure(true, "The same without the first harmonic: error motion.")
    )
}
