//! Figures of an R-test.

use super::{Found, Record};
use trueaxis_report::{Figure, Scale, Stroke, colour};

/// Displacements along X, Y, Z from reading to reading.
pub fn displacements(record: &Record) -> Figure {
    let rows: Vec<[f64; 3]> = record.readings.iter().map(|reading| reading.displacement_mm).collect();
    over_readings("Displacement of the tool from the ball", "displacement in µm", &rows)
}

/// What the location errors leave of them.
pub fn left(found: &Found) -> Figure {
    over_readings("What the location errors leave", "left in µm", &found.left_mm)
}

fn over_readings(description: &str, caption: &str, rows: &[[f64; 3]]) -> Figure {
    let x = Scale::linear("reading", (0..rows.len()).map(|i| (i + 1) as f64)).margin(0.02);
    let y = Scale::symmetric(caption, rows.iter().flatten().map(|mm| 1e3 * mm)).margin(0.06);
    let mut figure = Figure::full(description, 260, x, y);
    for (c, (name, colour)) in ["along X", "along Y", "along Z"].into_iter().zip(colour::AXES).enumerate() {
        let points: Vec<[f64; 2]> = rows.iter().enumerate().map(|(i, d)| [(i + 1) as f64, 1e3 * d[c]]).collect();
        figure.curve(name, points.iter().copied(), Stroke::new(colour, 1.0)).dots(points, colour);
    }
    figure
}
