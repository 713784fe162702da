//! Error motion of the spindle: orbit, motion over the angle, and development over the revolutions.

use maud::{Markup, Render};
use trueaxis_evaluation::roundness::{
    DRAWN_REVOLUTIONS, Evaluation, Revolution, RoundnessDocument, motion_scale, orbit,
};
use trueaxis_report::{Figure, Scale, Stroke, colour, missing, side_by_side};

pub(super) fn figures(evaluation: &Evaluation) -> Markup {
    let skipped = evaluation.document.revolutions.saturating_sub(DRAWN_REVOLUTIONS);
    side_by_side([orbit(evaluation), over_theta(evaluation, skipped)])
}

/// Mean contours of both directions over θ.
fn over_theta(evaluation: &Evaluation, skipped: usize) -> Figure {
    let (x, y) = (&evaluation.x, &evaluation.y);
    let points = x.mean_contour.len();
    let curve = |values: &[f64]| -> Vec<[f64; 2]> {
        values.iter().enumerate().map(|(i, value)| [360.0 * i as f64 / points as f64, *value]).collect()
    };
    let theta = Scale::exact("θ in degrees", 0.0, 360.0);
    let y_scale = motion_scale(evaluation, "error motion in µm");
    let mut figure = Figure::square("Error motion of the spindle over the angle", theta, y_scale);
    let [blue, orange, _] = colour::AXES;
    for (motion, colour) in [(x, blue), (y, orange)] {
        for revolution in motion.revolutions.chunks(points).skip(skipped) {
            figure.line(curve(revolution), Stroke::new(colour, 0.5).opacity(0.25));
        }
    }
    for (motion, colour, name) in [(x, blue, "X, across probe 1"), (y, orange, "Y, along probe 1")] {
        figure.bold(&curve(&motion.mean_contour), colour).key(name, Stroke::new(colour, 2.2));
    }
    figure.caption("The same over the angle: mean contours bold over the single revolutions.");
    figure
}

pub(super) fn development(found: &RoundnessDocument) -> Markup {
    if found.revolutions < 2 {
        return missing("A single revolution has no development and no asynchronous error motion.");
    }
    let series = |pick: fn(&Revolution) -> f64| -> Vec<[f64; 2]> {
        found.per_revolution.iter().map(|of| [of.revolution as f64, pick(of)]).collect()
    };
    let [blue, orange, _] = colour::AXES;
    let curves = [
        ("roundness, MZC zone", colour::MEASURED, series(|of| of.zones.mzc_um)),
        ("X: largest distance from the mean contour", blue, series(|of| of.x_from_mean_um)),
        ("Y: largest distance from the mean contour", orange, series(|of| of.y_from_mean_um)),
    ];
    let values = curves.iter().flat_map(|(.., points)| points.iter().map(|point| point[1]));
    let y = Scale::from_zero("µm", values);
    let x = Scale::exact("revolution", 0.5, found.revolutions as f64 + 0.5);
    let mut figure = Figure::full("Roundness and asynchronous error motion of every revolution", 270, x, y);
    for (name, colour, points) in curves {
        figure.dots(points.iter().copied(), colour).curve(name, points, Stroke::new(colour, 1.2));
    }
    figure.caption("Every revolution for itself.");
    figure.render()
}
