//! Figures of a diagonal test.

use super::Document;
use trueaxis_metrology::diagonal::Test;
use trueaxis_report::{Colour, Figure, Scale, Stroke, colour, error_bars};

const DIAGONALS: [Colour; 4] = [colour::AXES[0], colour::AXES[1], colour::AXES[2], colour::FOURTH];

/// Mean deviation along every diagonal, away and back.
pub fn deviations(test: &Test) -> Figure {
    let along = test.diagonals.iter().flat_map(|own| own.targets.iter().map(|target| target.along_mm));
    let means = (0..4).flat_map(|k| test.on(k).flat_map(|target| target.mean_mm)).flatten().map(|mm| 1e3 * mm);
    let x = Scale::linear("way along the diagonal in mm", along).margin(0.02);
    let y = Scale::linear("deviation in µm", means.chain([0.0])).margin(0.06);
    let mut figure = Figure::full("Mean deviation along the four diagonals", 300, x, y);
    for (k, colour) in DIAGONALS.into_iter().enumerate() {
        for (way, name) in ["away", "back"].into_iter().enumerate() {
            let points: Vec<[f64; 2]> =
                test.on(k).filter_map(|t| t.mean_mm[way].map(|mean| [t.along_mm, 1e3 * mean])).collect();
            if points.is_empty() {
                continue;
            }
            let stroke = Stroke::new(colour, 1.4);
            let stroke = if way == 1 { stroke.dashed() } else { stroke };
            figure.curve(format!("diagonal {}, {name}", k + 1), points.iter().copied(), stroke).dots(points, colour);
        }
    }
    figure.caption("Targets on the diagonals: ISO 230-6.");
    figure
}

/// Shapes of the errors of every axis, slopes removed.
pub fn shapes(document: &Document) -> Vec<Figure> {
    let shapes = document.steps.iter().flat_map(|steps| &steps.shapes);
    let figures = shapes.map(|shape| {
        let axis = shape.axis;
        let names = ["X", "Y", "Z"].map(|of| format!("E{of}{axis}"));
        let x =
            Scale::linear(&format!("{axis} in mm"), shape.points.iter().map(|point| point.position_mm)).margin(0.02);
        let curve = |c: usize| {
            let points = shape.points.iter().map(|p| [p.position_mm, p.error_um[c], p.standard_error_um[c]]);
            (names[c].as_str(), points.collect())
        };
        let mut figure = error_bars(&format!("Errors of {axis}, slopes removed"), x, "µm", [0, 1, 2].map(curve));
        figure.caption("End-to-end slopes removed. Bars: 2 standard errors to either side.");
        figure
    });
    figures.collect()
}
