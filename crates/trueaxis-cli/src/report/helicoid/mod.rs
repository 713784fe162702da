//! The page of `trueaxis helicoid`.

mod displacements;
mod flank;
mod tables;

use maud::html;
use trueaxis_evaluation::helicoid::{HelicoidDocument, Job};
use trueaxis_report::{Page, number::count, number::shortest, summary};

/// The whole page.
pub(crate) fn page(job: &Job, document: &HelicoidDocument) -> String {
    let surface = match &job.gear {
        Some((gear, _)) => format!(
            "gear mₙ {} mm, z {}, αₙ {}°, β {}°",
            shortest(gear.module_mm),
            gear.teeth,
            shortest(gear.pressure_angle_deg),
            shortest(gear.helix_angle_deg)
        ),
        None => format!(
            "base radius {} mm, lead parameter {} mm/rad",
            shortest(job.surface.base_radius()),
            shortest(job.surface.lead_parameter())
        ),
    };
    let parts = [
        surface,
        job.flank_name().to_owned(),
        job.form_name().to_owned(),
        format!("branch {}", job.branch_number()),
        format!("pivot length {} mm", shortest(job.settings.pivot_mm)),
        format!("{} points", count(document.points.len() as u64)),
    ];
    Page::new("Involute helicoid on five axes")
        .top(summary(parts.map(|part| html! { (part) })))
        .top(html! {
            p { "Other inputs, the tool moved over the flank, both branches and travel limits: " code { "trueaxis desk" } "." }
        })
        .top(html! { div.tables { (tables::set_up(job)) (tables::surface(job)) (tables::travel(document)) } })
        .section("The flank and the tool", flank::figures(job))
        .section("Displacements of the five axes", displacements::figures(job, document))
        .section("Points", tables::points(document))
        .document()
}
