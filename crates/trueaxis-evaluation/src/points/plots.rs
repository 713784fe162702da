//! Figures of measured points.

use super::{Found, Points};
use trueaxis_metrology::volumetric::{AXES, COMPONENTS};
use trueaxis_report::{Figure, Scale, colour, error_bars, heat_map};

/// Translations and rotations of every axis with their standard errors.
pub fn errors(found: &Found) -> Vec<Figure> {
    let mut figures = Vec::new();
    for (axis, letter) in AXES.into_iter().enumerate() {
        for (first, unit, scale) in [(0, "µm", 1e3), (3, "µrad", 1e6)] {
            let names = [0, 1, 2].map(|c| format!("E{}{letter}", COMPONENTS[first + c]));
            let nodes = &found.basis.nodes_mm[axis];
            let x = Scale::linear(&format!("{letter} in mm"), nodes.iter().copied()).margin(0.02);
            let curve = |c: usize| {
                let values = &found.errors.errors[axis][first + c];
                let deviations = &found.errors.standard_errors[axis][first + c];
                let points = nodes.iter().zip(values).zip(deviations);
                (names[c].as_str(), points.map(|((q, value), error)| [*q, scale * value, scale * error]).collect())
            };
            let mut figure = error_bars(&format!("{} over {letter}", names.join(", ")), x, unit, [0, 1, 2].map(curve));
            figure.caption("Bars: 2 standard errors to either side.");
            figures.push(figure);
        }
    }
    figures
}

/// What is left of every point along X, Y and Z over the position of each axis.
pub fn residuals(points: &Points, found: &Found) -> Vec<Figure> {
    let figures = AXES.into_iter().enumerate().map(|(axis, letter)| {
        let at = || points.points.iter().map(|point| point.command_mm[axis]);
        let x = Scale::linear(&format!("{letter} in mm"), at()).margin(0.02);
        let y = Scale::symmetric("left in µm", found.left_mm.iter().flatten().map(|mm| 1e3 * mm)).margin(0.06);
        let mut figure = Figure::half(&format!("What is left over {letter}"), 260, x, y);
        for (c, (name, colour)) in ["along X", "along Y", "along Z"].into_iter().zip(colour::AXES).enumerate() {
            figure.area_key(name, colour).dots(at().zip(&found.left_mm).map(|(q, left)| [q, 1e3 * left[c]]), colour);
        }
        figure
    });
    figures.collect()
}

/// Cells of the map in each direction.
const CELLS: usize = 12;

/// Root mean square of what is left over X and Y, all heights together.
pub fn map(points: &Points, found: &Found) -> Figure {
    let scale = |axis: usize, name: &str| {
        let values = points.points.iter().map(|point| point.command_mm[axis]);
        let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
        (Scale::exact(name, low, high), low, (high - low).max(f64::MIN_POSITIVE))
    };
    let ((x, x_low, x_width), (y, y_low, y_width)) = (scale(0, "X in mm"), scale(1, "Y in mm"));
    let mut sums = vec![vec![(0.0, 0_u32); CELLS]; CELLS];
    let cell = |value: f64, low: f64, width: f64| (((value - low) / width * CELLS as f64) as usize).min(CELLS - 1);
    for (point, left) in points.points.iter().zip(&found.left_mm) {
        let [px, py, _] = point.command_mm;
        let (sum, count) = &mut sums[cell(py, y_low, y_width)][cell(px, x_low, x_width)];
        *sum += left.iter().map(|mm| 1e6 * mm * mm).sum::<f64>();
        *count += 1;
    }
    let rms = |(sum, count): (f64, u32)| if count == 0 { f64::NAN } else { (sum / f64::from(count)).sqrt() };
    let rows: Vec<Vec<f64>> = sums.into_iter().map(|row| row.into_iter().map(rms).collect()).collect();
    let mut figure = heat_map("Root mean square of what is left over X and Y", x, y, &rows, "µm");
    figure.caption("All heights together; blank where there is no point.");
    figure
}
