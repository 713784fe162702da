//! The page of `trueaxis helicoid`: the one page with a script, so that its inputs can be changed.

use super::document_with;
use super::text::escape;
use crate::helicoid::job::{Document, Job};
use anyhow::Result;
use serde_json::json;

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
    let what = match &job.gear {
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
    let summary = format!(
        "{what} · {} · {} · pivot length {} mm · {} points",
        job.flank_name(),
        job.form_name(),
        job.settings.pivot_mm,
        document.points.len()
    );
    let body = format!(
        "<p class=\"run\">{}</p>\n<p id=\"check\">The figures need JavaScript.</p>\n{BODY}\
         <script type=\"application/json\" id=\"run\">{data}</script>\n\
         <script>//<![CDATA[\n{FORMULAS}\n{DRAWING}\n{PAGE}//]]></script>\n",
        escape(&summary).replace('-', "−")
    );
    Ok(document_with("Involute helicoid on five axes", STYLE, &body))
}
