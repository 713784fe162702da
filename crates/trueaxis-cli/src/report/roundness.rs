//! The page of `trueaxis roundness`.

use super::figure::{Axes, Figure, Key, Stroke, colour, framed};
use super::polar::{COLOURS, Reference, polar};
use super::text::{escape, significant, tick};
use super::{document, section};
use crate::roundness::evaluation::{Document, Evaluation, SpindleDirection, Zones};
use std::f64::consts::TAU;
use std::fmt::Write;
use trueaxis::roundness::Gain;
use trueaxis_metrology::circles::ReferenceCircle;

/// Points of a drawn circle.
const FINE: usize = 360;
/// Single revolutions drawn with the spindle: the last ones. One in so many would hide what repeats every second one.
const DRAWN_REVOLUTIONS: usize = 30;

/// The whole page; `source` is the name of the readings' file.
pub(crate) fn page(source: &str, evaluation: &Evaluation, gain: &Gain, noise_gain_limit: f64) -> String {
    let found = &evaluation.document;
    let filter = found.upr.map_or("no filter".to_owned(), |upr| format!("Gaussian filter {upr} UPR"));
    let body = [
        format!(
            "<p class=\"run\">{} · {} of {} points · φ2 = {}°, φ3 = {}° · {filter}</p>\n",
            escape(source),
            count(found.revolutions),
            found.n,
            tick(gain.phi2().to_degrees()),
            tick(gain.phi3().to_degrees())
        ),
        warnings(found),
        tables(found),
        section("Profile", &profile(evaluation)),
        section("Harmonics", &harmonics(found, noise_gain_limit)),
        section("Spindle", &orbit(evaluation)),
        section("Development over the revolutions", &development(found)),
    ];
    document("Roundness and spindle error", &body.concat())
}

fn count(revolutions: usize) -> String {
    format!("{revolutions} revolution{}", if revolutions == 1 { "" } else { "s" })
}

fn warnings(found: &Document) -> String {
    if found.warnings.is_empty() {
        return String::new();
    }
    let items: String = found.warnings.iter().map(|warning| format!("<li>{}</li>", escape(warning))).collect();
    format!("<ul>{items}</ul>\n")
}

/// One figure of a revolution.
type Pick = fn(&Zones) -> f64;

fn tables(found: &Document) -> String {
    let range = |pick: Pick| {
        let values = || found.per_revolution.iter().map(|revolution| pick(&revolution.zones));
        let [low, high] = [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)];
        format!("{} to {}", significant(low, 3), significant(high, 3))
    };
    let picks: [(&str, Pick); 4] = [
        ("LSC, least squares", |zones| zones.lsc_um),
        ("MZC, minimum zone", |zones| zones.mzc_um),
        ("MIC, maximum inscribed", |zones| zones.mic_um),
        ("MCC, minimum circumscribed", |zones| zones.mcc_um),
    ];
    let mut html = String::from(
        "<div class=\"tables\">\n<table><caption>Roundness, peak to valley in µm</caption>\n<thead><tr><th>circle</th>\
         <th>mean profile</th><th>single revolutions</th></tr></thead>\n<tbody>\n",
    );
    for (name, pick) in picks {
        let zone = significant(pick(&found.zones), 3);
        let _ = writeln!(html, "<tr><th>{name}</th><td>{zone}</td><td>{}</td></tr>", range(pick));
    }
    html.push_str(
        "</tbody></table>\n<table><caption>Spindle error motion in µm</caption>\n<thead><tr><th></th><th>synchronous</th>\
         <th>asynchronous</th><th>total</th><th>once per revolution</th></tr></thead>\n<tbody>\n",
    );
    let mut row = |name: &str, of: &SpindleDirection| {
        let _ = writeln!(
            html,
            "<tr><th>{name}</th><td>{}</td><td>{}</td><td>{}</td><td>{} at {}°</td></tr>",
            significant(of.synchronous_um, 3),
            of.asynchronous_um.map_or("–".to_owned(), |value| significant(value, 3)),
            significant(of.total_um, 3),
            significant(of.once_per_revolution_um, 3),
            tick(of.once_per_revolution_phase_deg.round())
        );
    };
    row("X, across probe 1", &found.spindle.x);
    row("Y, along probe 1", &found.spindle.y);
    html.push_str("</tbody></table>\n</div>\n");
    html
}

fn profile(evaluation: &Evaluation) -> String {
    let (profile, circles) = (&evaluation.profile, &evaluation.circles);
    let base = circles.lsc.radius;
    let turn = |i: usize, count: usize| TAU * i as f64 / count as f64;
    let measured: Vec<[f64; 2]> =
        profile.iter().enumerate().map(|(i, value)| [turn(i, profile.len()), value - base]).collect();
    let reference = |name, colour, circle: &ReferenceCircle, offsets: &[f64]| {
        let limacon = |offset: &f64| {
            let departure = |i| {
                let (sin, cos) = turn(i, FINE).sin_cos();
                circle.radius + offset + circle.centre[0] * cos + circle.centre[1] * sin - base
            };
            (0..FINE).map(departure).collect()
        };
        let curves = offsets.iter().map(limacon).collect();
        Reference { name, zone_um: circle.zone, colour, dashed: offsets.len() > 1, curves }
    };
    let [blue, orange, green, purple] = COLOURS;
    let half_zone = 0.5 * circles.mzc.zone;
    let references = [
        reference("LSC", blue, &circles.lsc, &[0.0]),
        reference("MZC (both circles)", orange, &circles.mzc, &[-half_zone, half_zone]),
        reference("MCC", green, &circles.mcc, &[0.0]),
        reference("MIC", purple, &circles.mic, &[0.0]),
    ];
    let caption = format!(
        "Mean of {}. The circles are limaçons: the radius of the part is not known.",
        count(evaluation.document.revolutions)
    );
    polar("profile", &measured, &references, &caption)
}

fn harmonics(found: &Document, limit: f64) -> String {
    let [first, last] = [found.harmonics.first(), found.harmonics.last()].map(|h| h.map_or(2.0, |h| f64::from(h.k)));
    let x = first - 1.0..last + 1.0;
    let kept = || found.harmonics.iter().filter(|harmonic| !harmonic.suppressed);
    let left_out = || found.harmonics.iter().filter(|harmonic| harmonic.suppressed);
    let highest = kept().map(|h| h.amplitude_um).fold(0.0, f64::max);
    let top = if highest > 0.0 { 1.08 * highest } else { 1.0 };
    let caption = "undulations per revolution";
    let amplitudes = Figure {
        description: "Amplitude of every harmonic of the mean profile",
        size: [1120, 270],
        x: x.clone(),
        y: 0.0..top,
        axes: Some(Axes { x: caption, y: "amplitude in µm", logarithmic: false }),
    };
    let svg = amplitudes.draw(|plot| {
        for harmonic in left_out() {
            let k = f64::from(harmonic.k);
            plot.fill([k - 0.5, 0.0], [k + 0.5, top], colour::RED, 0.25)?;
        }
        for harmonic in kept() {
            let k = f64::from(harmonic.k);
            plot.fill([k - 0.38, 0.0], [k + 0.38, harmonic.amplitude_um], colour::BLUE, 0.85)?;
        }
        Ok(())
    });
    let suppressed: Vec<String> = left_out().map(|harmonic| harmonic.k.to_string()).collect();
    let shown = if suppressed.is_empty() {
        "None is suppressed.".to_owned()
    } else {
        format!("Suppressed: {}.", suppressed.join(", "))
    };
    let mut keys = vec![Key { colour: colour::BLUE, dashed: false, text: "amplitude" }];
    if !suppressed.is_empty() {
        keys.push(Key { colour: colour::RED, dashed: false, text: "suppressed" });
    }
    let mut html = framed("full", &keys, &svg, &format!("Before the filter. {shown}"));

    let gains = || found.harmonics.iter().map(|harmonic| harmonic.noise_gain);
    let worst = gains().fold(1.0, f64::max);
    let high = (1.3 * worst).max(if limit < 30.0 * worst { 1.3 * limit } else { 0.0 }).log10();
    let low = gains().fold(1.0, f64::min).log10().min(0.0) - 0.05;
    let noise = Figure {
        description: "Noise gain of every harmonic",
        size: [1120, 230],
        x: x.clone(),
        y: low..high.max(1.0),
        axes: Some(Axes { x: caption, y: "noise gain", logarithmic: true }),
    };
    let drawn = limit.log10() < high.max(1.0);
    let svg = noise.draw(|plot| {
        for harmonic in &found.harmonics {
            let k = f64::from(harmonic.k);
            let colour = if harmonic.suppressed { colour::RED } else { colour::GREY };
            plot.fill([k - 0.38, low], [k + 0.38, harmonic.noise_gain.log10()], colour, 0.85)?;
        }
        if drawn {
            plot.dashed([[x.start, limit.log10()], [x.end, limit.log10()]], Stroke::new(colour::RED, 1.2))?;
        }
        Ok(())
    });
    let mut keys = vec![Key { colour: colour::GREY, dashed: false, text: "noise gain" }];
    if drawn {
        keys.push(Key { colour: colour::RED, dashed: true, text: "limit" });
    }
    let caption = format!(
        "How much the probes' noise grows in each harmonic of the profile; worst {}, limit {}{}.",
        significant(worst, 3),
        tick(limit),
        if drawn { "" } else { ", outside the figure" }
    );
    html.push_str(&framed("full", &keys, &svg, &caption));
    html
}

fn orbit(evaluation: &Evaluation) -> String {
    let (x, y) = (&evaluation.x, &evaluation.y);
    let points = x.mean_contour.len();
    let largest = x.revolutions.iter().chain(&y.revolutions).map(|value| value.abs()).fold(0.0, f64::max);
    let half = if largest > 0.0 { 1.08 * largest } else { 1.0 };
    let figure = Figure {
        description: "Orbit of the spindle's axis without position and once-per-revolution part",
        // Axes and margins take as much more of the width than of the height.
        size: [518, 500],
        x: -half..half,
        y: -half..half,
        axes: Some(Axes { x: "X in µm", y: "Y in µm", logarithmic: false }),
    };
    let orbit = |x: &[f64], y: &[f64]| {
        let pairs = x.iter().zip(y).map(|(x, y)| [*x, *y]);
        pairs.clone().chain(pairs.take(1)).collect::<Vec<_>>()
    };
    let revolutions = evaluation.document.revolutions;
    let skipped = revolutions.saturating_sub(DRAWN_REVOLUTIONS);
    let thin = Stroke { colour: colour::GREY, width: 0.6, opacity: 0.6 };
    let svg = figure.draw(|plot| {
        for (x, y) in x.revolutions.chunks(points).zip(y.revolutions.chunks(points)).skip(skipped) {
            // Open: the end of a revolution is the start of the next, not its own.
            plot.line(x.iter().zip(y).map(|(x, y)| [*x, *y]), thin)?;
        }
        plot.bold(orbit(&x.mean_contour, &y.mean_contour), colour::BLUE)
    });
    let keys = [
        Key { colour: colour::BLUE, dashed: false, text: "mean of the revolutions (synchronous)" },
        Key { colour: colour::GREY, dashed: false, text: "single revolutions (asynchronous)" },
    ];
    let shown = if skipped == 0 { "All".to_owned() } else { format!("The last {DRAWN_REVOLUTIONS}") };
    let caption =
        format!("{shown} of the revolutions; position and once-per-revolution part are taken out (ISO 230-7).");
    let over_theta = over_theta(evaluation, skipped);
    format!("<div class=\"figures\">\n{}{over_theta}</div>\n", framed("half", &keys, &svg, &caption))
}

/// Mean contours of both directions over θ.
fn over_theta(evaluation: &Evaluation, skipped: usize) -> String {
    let (x, y) = (&evaluation.x, &evaluation.y);
    let points = x.mean_contour.len();
    let largest = x.revolutions.iter().chain(&y.revolutions).map(|value| value.abs()).fold(0.0, f64::max);
    let half = if largest > 0.0 { 1.08 * largest } else { 1.0 };
    let figure = Figure {
        description: "Error motion of the spindle over the angle",
        size: [500, 500],
        x: 0.0..360.0,
        y: -half..half,
        axes: Some(Axes { x: "θ in degrees", y: "error motion in µm", logarithmic: false }),
    };
    let curve = |values: &[f64]| {
        values.iter().enumerate().map(|(i, value)| [360.0 * i as f64 / points as f64, *value]).collect::<Vec<_>>()
    };
    let svg = figure.draw(|plot| {
        for (motion, colour) in [(x, colour::BLUE), (y, colour::ORANGE)] {
            for revolution in motion.revolutions.chunks(points).skip(skipped) {
                plot.line(curve(revolution), Stroke { colour, width: 0.5, opacity: 0.25 })?;
            }
        }
        plot.bold(curve(&x.mean_contour), colour::BLUE)?;
        plot.bold(curve(&y.mean_contour), colour::ORANGE)
    });
    let keys = [
        Key { colour: colour::BLUE, dashed: false, text: "X, across probe 1" },
        Key { colour: colour::ORANGE, dashed: false, text: "Y, along probe 1" },
    ];
    framed("half", &keys, &svg, "The same over the angle: mean contours bold over the single revolutions.")
}

fn development(found: &Document) -> String {
    if found.revolutions < 2 {
        return "<p class=\"empty\">A single revolution has no development and no asynchronous error motion.</p>\n"
            .into();
    }
    let series = |pick: fn(&crate::roundness::evaluation::Revolution) -> f64| {
        found
            .per_revolution
            .iter()
            .map(|revolution| [revolution.revolution as f64, pick(revolution)])
            .collect::<Vec<_>>()
    };
    let curves = [
        (series(|revolution| revolution.zones.mzc_um), colour::PROFILE, "roundness, MZC zone"),
        (series(|revolution| revolution.x_from_mean_um), colour::BLUE, "X: largest distance from the mean contour"),
        (series(|revolution| revolution.y_from_mean_um), colour::ORANGE, "Y: largest distance from the mean contour"),
    ];
    let highest = curves.iter().flat_map(|curve| &curve.0).map(|point| point[1]).fold(0.0, f64::max);
    let figure = Figure {
        description: "Roundness and asynchronous error motion of every revolution",
        size: [1120, 270],
        x: 0.5..found.revolutions as f64 + 0.5,
        y: 0.0..if highest > 0.0 { 1.08 * highest } else { 1.0 },
        axes: Some(Axes { x: "revolution", y: "µm", logarithmic: false }),
    };
    let svg = figure.draw(|plot| {
        for (points, colour, _) in &curves {
            plot.line(points.iter().copied(), Stroke::new(*colour, 1.2))?;
            if points.len() <= 60 {
                points.iter().try_for_each(|point| plot.dot(*point, *colour))?;
            }
        }
        Ok(())
    });
    let keys: Vec<Key<'_>> =
        curves.iter().map(|(_, colour, text)| Key { colour: *colour, dashed: false, text }).collect();
    framed("full", &keys, &svg, "Every revolution for itself.")
}
