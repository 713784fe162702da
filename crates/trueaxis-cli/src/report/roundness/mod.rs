//! The figures on the page of `trueaxis roundness`.

mod harmonics;
mod spindle;

use maud::{Markup, Render};
use trueaxis_evaluation::roundness::{Evaluation, polar};

/// Sections with the figures.
pub(crate) fn figures(evaluation: &Evaluation, noise_gain_limit: f64) -> [(&'static str, Markup); 3] {
    [
        ("Profile", polar(evaluation, [true; 4]).render()),
        ("Harmonics", harmonics::figures(&evaluation.document, noise_gain_limit)),
        ("Spindle", spindle::figures(evaluation)),
    ]
}
