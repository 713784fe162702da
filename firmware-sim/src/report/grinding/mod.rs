//! The figures on the page of a grinding run.

mod figures;

use crate::grinding::{Grinding, Outcome};
use maud::{Markup, Render};
use trueaxis_evaluation::shown::Shown;

/// The page as one HTML document that is also well-formed XML.
#[must_use]
pub fn page(grinding: &Grinding, outcome: &Outcome, shown: &Shown) -> String {
    let sections: [(&str, Markup); 4] = [
        ("The surface", figures::surfaces(grinding, outcome)),
        ("Harmonics of the surface", figures::harmonics(grinding, outcome).render()),
        ("Infeed correction", figures::correction(grinding, outcome).render()),
        ("Motion of the pin's centre", figures::orbits(outcome)),
    ];
    shown.page("", sections)
}
