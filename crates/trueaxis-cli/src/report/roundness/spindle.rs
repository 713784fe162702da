//! Error motion of the spindle: orbit, over the angle, and over the revolutions.

use maud::{Markup, Render};
use trueaxis_evaluation::roundness::{Document, Evaluation, Revolution};
use trueaxis_report::{Figure, Scale, Stroke, colour, missing, side_by_side};

/// Single revolutions drawn: the last ones. One in so many would hide what repeats every second one.
const DRAWN_REVOLUTIONS: usize = 30;

pub(super) fn figures(evaluation: &Evaluation) -> Markup {
    let skipped = evaluation.document.revolutions.saturating_sub(DRAWN_REVOLUTIONS);
    side_by_side([orbit(evaluation, skipped), over_theta(evaluation, skipped)])
}

fn scale(evaluation: &Evaluation, caption: &str) -> Scale {
    let (x, y) = (&evaluation.x.revolutions, &evaluation.y.revolutions);
    Scale::symmetric(caption, x.iter().chain(y).copied())
}

fn orbit(evaluation: &Evaluation, skipped: usize) -> Figure {
    let (x, y) = (&evaluation.x, &evaluation.y);
    let pairs = |x: &[f64], y: &[f64]| -> Vec<[f64; 2]> { x.iter().zip(y).map(|(x, y)| [*x, *y]).collect() };
    let description = "Orbit of the spindle's axis without position and once-per-revolution part";
    let mut figure = Figure::square(description, scale(evaluation, "X in µm"), scale(evaluation, "Y in µm"));
    let thin = Stroke::new(colour::GREY, 0.6).opacity(0.6);
    let points = x.mean_contour.len();
    for (x, y) in x.revolutions.chunks(points).zip(y.revolutions.chunks(points)).skip(skipped) {
        // Open: the end of a revolution is the start of the next, not its own.
        figure.line(pairs(x, y), thin);
    }
    let mut mean = pairs(&x.mean_contour, &y.mean_contour);
    mean.extend(mean.first().copied());
    let shown = if skipped == 0 { "All".to_owned() } else { format!("The last {DRAWN_REVOLUTIONS}") };
    figure
        .bold(&mean, colour::COMPENSATED)
        .key("mean of the revolutions (synchronous)", Stroke::new(colour::COMPENSATED, 2.2))
        .key("single revolutions (asynchronous)", Stroke::new(colour::GREY, 0.6))
        .caption(format!(
            "{shown} of the revolutions; position and once-per-revolution part are taken out (ISO 230-7)."
        ));
    figure
}

/// Mean contours of both directions over θ.
fn over_theta(evaluation: &Evaluation, skipped: usize) -> Figure {
    let (x, y) = (&evaluation.x, &evaluation.y);
    let points = x.mean_contour.len();
    let curve = |values: &[f64]| -> Vec<[f64; 2]> {
        values.iter().enumerate().map(|(i, value)| [360.0 * i as f64 / points as f64, *value]).collect()
    };
    let theta = Scale::exact("θ in degrees", 0.0, 360.0);
    let y_scale = scale(evaluation, "error motion in µm");
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

pub(super) fn development(found: &Document) -> Markup {
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
