//! The HTML report of a grinding run.

mod figures;
mod tables;

use super::write_page;
use crate::grinding::{Grinding, Outcome};
use maud::{Markup, html};
use std::{
    io,
    path::{Path, PathBuf},
};
use trueaxis_report::{
    Page, emphasised,
    number::{count, quantity, significant},
};

/// Writes the page to `grinding.html` in `directory`, which is created if needed; returns the file's path.
///
/// # Errors
/// The file system's error if the page cannot be written. A failure leaves no file behind.
pub fn write(grinding: &Grinding, outcome: &Outcome, directory: &Path) -> io::Result<PathBuf> {
    write_page(directory, "grinding.html", &render(grinding, outcome), Vec::new())
}

/// The page as one HTML document that is also well-formed XML.
#[must_use]
pub fn render(grinding: &Grinding, outcome: &Outcome) -> String {
    Page::new("Grinding a crankpin")
        .top(summary(grinding, outcome))
        .section("Roundness, revolution by revolution", figures::progress(outcome))
        .section("The surface", figures::surfaces(grinding, outcome))
        .section("Harmonics of the surface", figures::harmonics(grinding, outcome))
        .section("Infeed correction", figures::correction(grinding, outcome))
        .section("Motion of the pin's centre", figures::orbits(outcome))
        .document()
}

fn summary(grinding: &Grinding, outcome: &Outcome) -> Markup {
    let Outcome { uncorrected: before, corrected: after, .. } = outcome;
    let settings = &grinding.machine.settings;
    let speed = significant(grinding.speed_rpm, 3);
    let rate = significant(grinding.rate_hz, 4);
    html! {
        (trueaxis_report::summary([
            emphasised("machine", &settings.name),
            emphasised("chain", &settings.chain),
            html! { (count(grinding.revolutions.into())) " revolutions at " (speed) " rpm" },
            html! { (count(after.cycles)) " servo cycles at " (rate) " Hz" },
        ]))
        p.result {
            "With correction " strong { (significant(100.0 * outcome.imprint_ratio(), 2)) " %" }
            " of the synchronous imprint remains: " strong { (quantity(after.imprint_um, "µm")) } " instead of "
            strong { (quantity(before.imprint_um, "µm")) } "."
        }
        p {
            "The synchronous imprint is the part that repeats with every turn: the root mean square of the corrected harmonics of \
             the true surface, averaged over the last " (after.averaged) " revolutions, so that the rest \
             cancels. Once-per-revolution motion leaves an eccentric pin, asynchronous motion a random one; neither is \
             corrected."
        }
        div.tables {
            (tables::runs(outcome))
            div {
                (tables::motions(outcome))
                p {
                    "X across probe 1, Y along it. Seen from the machine the centre of the pin moves with the spindle and \
                     with the eccentricity that was ground. The gauge's asynchronous value holds the probes' noise as well."
                }
            }
        }
    }
}
