//! The figures on the page of `trueaxis helicoid`.

mod displacements;
mod flank;

use maud::{Markup, html};
use trueaxis_evaluation::helicoid::{HelicoidDocument, Job};

/// Sections with the figures.
pub(crate) fn figures(job: &Job, document: &HelicoidDocument) -> [(&'static str, Markup); 2] {
    let displacements = html! {
        (displacements::figures(job, document))
        p { "Other inputs, the tool moved over the flank, both branches and travel limits: " code { "trueaxis desk" } "." }
    };
    [("The flank and the tool", flank::figures(job)), ("Displacements of the five axes", displacements)]
}
