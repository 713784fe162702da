//! The figures on the page of `trueaxis helicoid`.

mod displacements;
mod flank;

use maud::Markup;
use trueaxis_evaluation::helicoid::{HelicoidDocument, Job};

/// Sections with the figures.
pub(crate) fn figures(job: &Job, document: &HelicoidDocument) -> [(&'static str, Markup); 2] {
    [
        ("The flank and the tool", flank::figures(job)),
        ("Displacements of the five axes", displacements::figures(job, document)),
    ]
}
