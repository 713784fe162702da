//! Error motion of the spindle: orbit, and motion over the angle.

use maud::Markup;
use trueaxis_evaluation::roundness::{DRAWN_REVOLUTIONS, Evaluation, motion_scale, orbit};
use trueaxis_report::{Figure, Scale, Stroke, colour, side_by_side};

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
