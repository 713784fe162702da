//! The page of `trueaxis helicoid`: the one page with a script, so that its inputs can be changed.

use crate::helicoid::job::{Document, Job};
use anyhow::Result;
use maud::{PreEscaped, html};
use serde_json::json;
use trueaxis_report::Page;

const STYLE: &str = include_str!("helicoid/page.css");
const BODY: &str = include_str!("helicoid/page.html");
const FORMULAS: &str = include_str!("helicoid/formulas.js");
const DRAWING: &str = include_str!("helicoid/drawing.js");
const PAGE: &str = include_str!("helicoid/page.js");
/// Most points that the page carries for its check of itself.
const CARRIED: usize = 4000;

/// The whole page; the script's formulas are checked against the run's points when it is opened.
pub(crate) fn page(job: &Job, document: &Document) -> Result<String> {
    let every = document.points.len().div_ceil(CARRIED).max(1);
    let points: Vec<[f64; 7]> = (document.points.iter().step_by(every))
        .map(|p| [p.u_rad, p.theta_rad, p.x_mm, p.y_mm, p.z_mm, p.a_deg, p.c_deg])
        .collect();
    let data = json!({ "inputs": document.inputs, "surface": document.surface, "points": points });
    // Neither HTML nor XML may see markup in the data.
    let data = serde_json::to_string(&data)?.replace('<', "\\u003c").replace('&', "\\u0026");
    let surface = match &job.gear {
        Some((gear, _)) => format!(
            "gear mₙ {} mm, z {}, αₙ {}°, β {}°",
            gear.module_mm, gear.teeth, gear.pressure_angle_deg, gear.helix_angle_deg
        ),
        None => format!(
            "base radius {} mm, lead parameter {} mm/rad",
            job.surface.base_radius(),
            job.surface.lead_parameter()
        ),
    };
    let parts = [
        surface,
        job.flank_name().to_string(),
        job.form_name().to_string(),
        format!("pivot length {} mm", job.settings.pivot_mm),
        format!("{} points", document.points.len()),
    ];
    // Scripts are read as they stand; in XML only inside a CDATA section.
    let script = ["//<![CDATA[", FORMULAS, DRAWING, PAGE, "//]]>"].join("\n");
    let body = html! {
        (trueaxis_report::summary(parts.map(|part| html! { (part.replace('-', "−")) })))
        p #check { "The figures need JavaScript." }
        (PreEscaped(BODY))
        script type="application/json" #run { (PreEscaped(data)) }
        script { (PreEscaped(script)) }
    };
    Ok(Page::new("Involute helicoid on five axes").style(STYLE).top(body).document())
}
