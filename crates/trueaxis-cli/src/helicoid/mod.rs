//! `trueaxis helicoid`.

mod arguments;
mod grid;
pub(crate) mod job;
mod program;

pub(crate) use arguments::{Arguments, HELP};

use crate::output::{json, print, tell};
use crate::report;
use anyhow::{Result, bail};
use grid::{MOST, is_coarse};
use job::{Document, Point};
use std::fmt::Write;
use trueaxis_tables::output::Outputs;

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let job = arguments.job()?;
    let (feed, clearance) = (arguments.feed()?, arguments.clearance()?);
    let count = job.u.count.saturating_mul(job.theta.count);
    if count > MOST {
        bail!("--u-rad, --theta-rad: found {count} points, needed at most {MOST}");
    }
    let points = job.points().map_err(arguments::named)?;
    // Everything is made before anything is written.
    let program = match &arguments.gcode {
        Some(file) => Some((program::write(&job, feed, clearance, arguments.passes).map_err(arguments::named)?, file)),
        None => None,
    };
    let document = Document::new(&job, points);
    let table = csv(&document.points)?;
    let page = match &arguments.report {
        Some(file) => Some((report::helicoid::page(&job, &document)?, file)),
        None => None,
    };
    if let Some([travel, radius]) = job.edge_finder_mm {
        tell(format_args!(
            "note: pivot length {} mm = travel {travel} mm + ball radius {radius} mm",
            job.settings.pivot_mm
        ));
    }
    for (name, range) in [("--u-rad", job.u), ("--theta-rad", job.theta)] {
        if is_coarse(range) {
            tell(format_args!(
                "note: {name}: C turns by more than half a turn between points, and a straight move leaves the surface"
            ));
        }
    }
    let mut outputs = Outputs::default();
    if let Some((text, file)) = &program {
        outputs.put(file, text.as_bytes())?;
    }
    if let Some((page, file)) = &page {
        report::write_to(&mut outputs, page, file, "helicoid.html")?;
    }
    if let Some(file) = &arguments.output {
        outputs.put(file, table.as_bytes())?;
    }
    outputs.commit()?;
    match (arguments.json, &arguments.output) {
        (true, _) => json(&document),
        (false, None) => print(&table),
        (false, Some(_)) => Ok(()),
    }
}

fn csv(points: &[Point]) -> Result<String> {
    let mut text = String::from("u_rad,theta_rad,x_mm,y_mm,z_mm,a_deg,c_deg\n");
    for point in points {
        let Point { u_rad, theta_rad, x_mm, y_mm, z_mm, a_deg, c_deg } = point;
        writeln!(text, "{u_rad},{theta_rad},{x_mm},{y_mm},{z_mm},{a_deg},{c_deg}")?;
    }
    Ok(text)
}
