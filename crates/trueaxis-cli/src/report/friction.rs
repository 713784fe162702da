//! The spikes on the page of `trueaxis friction`.

use maud::{Markup, html};
use trueaxis_metrology::friction::{Identified, Spike};
use trueaxis_report::{Figure, Scale, Stroke, colour, number::significant};

/// A section for each axis.
pub(crate) fn spikes(found: &[Identified]) -> Vec<(String, Markup)> {
    let section = |own: &Identified| {
        let letter = own.axis.letter();
        let figures = own.glitch.spikes.iter().map(|spike| figure(letter, spike));
        (format!("Spikes of axis {letter}"), html! { @for figure in figures { (figure) } })
    };
    found.iter().map(section).collect()
}

fn figure(letter: char, spike: &Spike) -> Figure {
    let points = |curve: &[f64]| -> Vec<[f64; 2]> {
        spike.time_s.iter().zip(curve).map(|(time, value)| [1e3 * time, 1e3 * value]).collect()
    };
    let curves = [
        ("before, recorded", points(&spike.before), colour::UNCOMPENSATED),
        ("predicted by the model", points(&spike.predicted), colour::MEASURED),
        ("after, predicted", points(&spike.after), colour::COMPENSATED),
    ];
    let x = Scale::linear("time after the reversal in ms", spike.time_s.iter().map(|time| 1e3 * time));
    let heights = curves.iter().flat_map(|(_, points, _)| points.iter().map(|point| point[1]));
    let y = Scale::linear("following error in µm", heights);
    let acceleration = significant(spike.acceleration, 3);
    let description = format!("Spike of axis {letter} where it turns with {acceleration} mm/s²");
    let mut figure = Figure::full(&description, 240, x, y);
    for (name, points, colour) in curves {
        figure.curve(name, points, Stroke::new(colour, 1.4));
    }
    figure.caption(format!(
        "Mean of {} reversals at {acceleration} mm/s² (feed²/radius), turned into the new direction of travel. After: the record \
         minus the effect of the feed-forward with the parameters found, in the model.",
        spike.reversals
    ));
    figure
}
