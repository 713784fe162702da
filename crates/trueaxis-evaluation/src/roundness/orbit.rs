//! Orbit of the spindle's axis.

use super::Evaluation;
use trueaxis_report::{Figure, Scale, Stroke, colour};

/// Number of single revolutions drawn: the last ones. Skipping at intervals could hide a pattern that repeats every second
/// one.
const DRAWN_REVOLUTIONS: usize = 30;

/// A scale that covers both directions of the error motion.
fn motion_scale(evaluation: &Evaluation, caption: &str) -> Scale {
    let (x, y) = (&evaluation.x.revolutions, &evaluation.y.revolutions);
    Scale::symmetric(caption, x.iter().chain(y).copied())
}

/// Orbit of the spindle's axis, the mean of the revolutions drawn over the last single ones.
pub fn orbit(evaluation: &Evaluation) -> Figure {
    let skipped = evaluation.document.revolutions.saturating_sub(DRAWN_REVOLUTIONS);
    let (x, y) = (&evaluation.x, &evaluation.y);
    let pairs = |x: &[f64], y: &[f64]| -> Vec<[f64; 2]> { x.iter().zip(y).map(|(x, y)| [*x, *y]).collect() };
    let description = "Orbit of the spindle's axis without position and once-per-revolution part";
    let mut figure =
        Figure::square(description, motion_scale(evaluation, "X in µm"), motion_scale(evaluation, "Y in µm"));
    let thin = Stroke::new(colour::GREY, 0.6).opacity(0.6);
    let points = x.mean_contour.len();
    for (x, y) in x.revolutions.chunks(points).zip(y.revolutions.chunks(points)).skip(skipped) {
        // Open: the end of a revolution is the start of the next, not of the same.
        figure.line(pairs(x, y), thin);
    }
    let mut mean = pairs(&x.mean_contour, &y.mean_contour);
    mean.extend(mean.first().copied());
    let shown = if skipped == 0 { "All".to_owned() } else { format!("The last {DRAWN_REVOLUTIONS}") };
    figure
        .bold(&mean, colour::COMPENSATED)
        .key("mean of the revolutions (synchronous)", Stroke::new(colour::COMPENSATED, 2.2))
        .key("single revolutions (asynchronous)", Stroke::new(colour::GREY, 0.6))
        .caption(format!("{shown} of the revolutions; position and once-per-revolution part are removed (ISO 230-7)."));
    figure
}
