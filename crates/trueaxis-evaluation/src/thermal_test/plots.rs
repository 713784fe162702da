//! Figures of a thermal test.

use super::{Test, document::NAMES};
use trueaxis_report::{Colour, Figure, Scale, Stroke, colour};

const COLOURS: [Colour; 5] = [colour::AXES[0], colour::AXES[1], colour::AXES[2], colour::FOURTH, colour::LIMIT];

fn minutes(times: &[f64]) -> impl Iterator<Item = f64> + Clone {
    times.iter().map(|t| t / 60.0)
}

/// Displacements over time, a figure for each position.
pub fn distortions(test: &Test) -> Vec<Figure> {
    let places = test.positions.iter().zip(&test.times_s).zip(&test.displacements_um);
    let figures = places.map(|((position, times), of)| {
        let from_zero = |values: &[f64]| -> Vec<f64> {
            let first = values.first().copied().unwrap_or(0.0);
            values.iter().map(|value| value - first).collect()
        };
        let series = of.iter().map(|values| from_zero(values)).collect::<Vec<_>>();
        let x = Scale::linear("time in min", minutes(times)).margin(0.02);
        let y = Scale::linear("distortion in µm", series.iter().flatten().copied().chain([0.0])).margin(0.06);
        let mut figure = Figure::full(&format!("Distortion over time, position {position}"), 300, x, y);
        for ((name, values), colour) in NAMES.into_iter().zip(&series).zip(COLOURS) {
            if !values.is_empty() {
                let points = minutes(times).zip(values).map(|(t, v)| [t, *v]);
                figure.curve(
                    name,
                    trueaxis_report::decimate(&points.collect::<Vec<_>>(), 800),
                    Stroke::new(colour, 1.4),
                );
            }
        }
        figure.caption("From the first reading.");
        figure
    });
    figures.collect()
}

/// Temperatures over time, where any were recorded.
pub fn temperatures(test: &Test) -> Option<Figure> {
    let all: Vec<f64> = test.temperatures_c.iter().flatten().copied().collect();
    if all.is_empty() {
        return None;
    }
    let x = Scale::linear("time in min", minutes(&test.all_times_s)).margin(0.02);
    let mut figure = Figure::full("Temperatures", 220, x, Scale::linear("temperature in °C", all).margin(0.06));
    for ((name, values), colour) in ["ambient", "spindle", "machine"].into_iter().zip(&test.temperatures_c).zip(COLOURS)
    {
        if !values.is_empty() {
            let points = minutes(&test.all_times_s).zip(values).map(|(t, v)| [t, *v]);
            figure.curve(name, trueaxis_report::decimate(&points.collect::<Vec<_>>(), 800), Stroke::new(colour, 1.4));
        }
    }
    Some(figure)
}
