//! The residuals on the page of `trueaxis identify`.

use maud::{Markup, Render};
use trueaxis::Axis;
use trueaxis_evaluation::identify::IdentificationDocument;
use trueaxis_report::{Scale, residuals};

/// Root mean square of the residuals at every angle.
pub(crate) fn residuals_of(axis: Axis, found: &IdentificationDocument) -> Markup {
    let points: Vec<[f64; 2]> = found.angles.iter().map(|angle| [angle.angle_deg, angle.residual_um]).collect();
    let x = Scale::linear(&format!("{} in degrees", axis.letter()), points.iter().map(|point| point[0])).margin(0.02);
    let description = "Root mean square of the residuals at every angle";
    let mut figure = residuals(description, x, &points, found.sigma_um);
    figure.caption("Residuals are smaller than sigma: at every angle six of the readings go into the errors.");
    figure.render()
}
