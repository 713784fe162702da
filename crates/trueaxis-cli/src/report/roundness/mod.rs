//! The page of `trueaxis roundness`.

mod harmonics;
mod spindle;
mod tables;

use super::warnings;
use maud::html;
use trueaxis::roundness::Gain;
use trueaxis_evaluation::roundness::{Evaluation, polar};
use trueaxis_report::{Page, number::shortest, summary};

/// The whole page; `source` is the name of the readings' file.
pub(crate) fn page(source: &str, evaluation: &Evaluation, gain: &Gain, noise_gain_limit: f64) -> String {
    let found = &evaluation.document;
    let filter = found.upr.map_or("no filter".to_owned(), |upr| format!("Gaussian filter {upr} UPR"));
    let [phi2, phi3] = [gain.phi2(), gain.phi3()].map(|phi| shortest(phi.to_degrees()));
    Page::new("Roundness and spindle error")
        .top(summary([
            html! { (source) },
            html! { (count(found.revolutions)) " of " (found.n) " points" },
            html! { "φ2 = " (phi2) "°, φ3 = " (phi3) "°" },
            html! { (filter) },
        ]))
        .top(warnings(&found.warnings))
        .top(html! { div.tables { (tables::zones(found)) (tables::spindle(found)) } })
        .section("Profile", polar(evaluation, [true; 4]))
        .section("Harmonics", harmonics::figures(found, noise_gain_limit))
        .section("Spindle", spindle::figures(evaluation))
        .section("Development over the revolutions", spindle::development(found))
        .document()
}

fn count(revolutions: usize) -> String {
    format!("{revolutions} revolution{}", if revolutions == 1 { "" } else { "s" })
}
