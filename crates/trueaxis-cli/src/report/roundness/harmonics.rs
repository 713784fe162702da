//! Harmonics of the profile: amplitude and noise gain.

use maud::{Markup, html};
use trueaxis_evaluation::roundness::RoundnessDocument;
use trueaxis_report::{
    Figure, Scale, Stroke, colour,
    number::{shortest, significant},
};

/// A column extends this far on either side of its harmonic.
const COLUMN: [f64; 2] = [-0.38, 0.38];
/// A limit above this many times the largest gain is only stated: drawn, it would flatten the columns.
const WITHIN: f64 = 30.0;

pub(super) fn figures(found: &RoundnessDocument, limit: f64) -> Markup {
    html! { (amplitudes(found)) (noise(found, limit)) }
}

fn scale(found: &RoundnessDocument) -> Scale {
    let ends = [found.harmonics.first(), found.harmonics.last()].map(|end| end.map_or(2.0, |of| f64::from(of.k)));
    Scale::exact("undulations per revolution", ends[0] - 1.0, ends[1] + 1.0)
}

fn amplitudes(found: &RoundnessDocument) -> Figure {
    let (suppressed, kept): (Vec<_>, Vec<_>) = found.harmonics.iter().partition(|of| of.suppressed);
    let y = Scale::from_zero("amplitude in µm", kept.iter().map(|of| of.amplitude_um));
    let mut figure = Figure::full("Amplitude of every harmonic of the mean profile", 270, scale(found), y);
    for of in &suppressed {
        figure.band([f64::from(of.k) - 0.5, f64::from(of.k) + 0.5], colour::LIMIT);
    }
    let points = kept.iter().map(|of| [f64::from(of.k), of.amplitude_um]);
    figure.columns(points, COLUMN, colour::COMPENSATED).area_key("amplitude", colour::COMPENSATED);
    if suppressed.is_empty() {
        figure.caption("Before the filter. None is suppressed.");
    } else {
        let numbers: Vec<String> = suppressed.iter().map(|of| of.k.to_string()).collect();
        figure.area_key("suppressed", colour::LIMIT);
        figure.caption(format!("Before the filter. Suppressed: {}.", numbers.join(", ")));
    }
    figure
}

fn noise(found: &RoundnessDocument, limit: f64) -> Figure {
    let gains = || found.harmonics.iter().map(|of| of.noise_gain);
    let worst = gains().fold(1.0, f64::max);
    let lowest = gains().filter(|gain| *gain > 0.0).fold(1.0, f64::min);
    let drawn = limit < WITHIN * worst;
    let high = (1.3 * worst).max(if drawn { 1.3 * limit } else { 0.0 }).max(10.0);
    let y = Scale::logarithmic("noise gain", 0.9 * lowest, high);
    let mut figure = Figure::full("Noise gain of every harmonic", 230, scale(found), y);
    for of in &found.harmonics {
        let colour = if of.suppressed { colour::LIMIT } else { colour::GREY };
        figure.columns([[f64::from(of.k), of.noise_gain]], COLUMN, colour);
    }
    figure.area_key("noise gain", colour::GREY);
    if drawn {
        figure.across(limit, colour::LIMIT).key("limit", Stroke::new(colour::LIMIT, 1.2).dashed());
    }
    figure.caption(format!(
        "How much the probes' noise grows in each harmonic of the profile; worst {}, limit {}{}.",
        significant(worst, 3),
        shortest(limit),
        if drawn { "" } else { ", outside the figure" }
    ));
    figure
}
