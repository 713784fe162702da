//! Involute helicoids on five axes.
//!
//! A request is the JSON object of `trueaxis_evaluation::helicoid::Request`: the command line's options with underscores.

use crate::files::machine;
use crate::{Refusal, json, to_js};
use anyhow::{Result, anyhow, bail};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use trueaxis_evaluation::helicoid::document::csv;
use trueaxis_evaluation::helicoid::{self as evaluation, Fit, HelicoidDocument, Job, Limits, Passes, Reach, Request};
use trueaxis_evaluation::shown::Table;
use trueaxis_tables::formats::machine_files;
use wasm_bindgen::prelude::*;

fn job(request: &str) -> Result<Job> {
    // Via a value, so that errors name the wrong option and not a position in a text that the user did not write.
    let value: Value = serde_json::from_str(request)?;
    let request: Request = serde_json::from_value(value).map_err(|error| anyhow!("{error}"))?;
    Job::new(&request)
}

fn limits(limits: &str) -> Result<Limits> {
    let value: Value = serde_json::from_str(limits)?;
    serde_json::from_value(value).map_err(|error| anyhow!("travel: {error}"))
}

fn along(name: &str) -> Result<Passes> {
    match name {
        "theta" => Ok(Passes::Theta),
        "u" => Ok(Passes::U),
        _ => bail!("found a line along {name}, needed theta or u"),
    }
}

/// The document of the command line's `--json`.
#[wasm_bindgen]
pub fn helicoid_document(request: &str) -> Result<String, Refusal> {
    to_js(document(request))
}

fn document(request: &str) -> Result<String> {
    let job = job(request)?;
    let points = job.points()?;
    json(&HelicoidDocument::new(&job, points))
}

/// The command line's CSV table.
#[wasm_bindgen]
pub fn helicoid_csv(request: &str) -> Result<String, Refusal> {
    to_js(job(request).and_then(|job| Ok(csv(&job.points()?))))
}

/// The text written by `--gcode`.
#[wasm_bindgen]
pub fn helicoid_gcode(request: &str) -> Result<String, Refusal> {
    to_js(job(request).and_then(|job| job.program()))
}

/// Data of a request without its points: inputs, flank and gear data, notes, travel on both branches, and whether the desk's
/// machine fits.
#[derive(Serialize)]
struct Outline {
    /// The document without its points.
    #[serde(flatten)]
    document: HelicoidDocument,
    /// Values derived from the gear or the base circle.
    flank: Table,
    notes: Vec<String>,
    reach: [Reach; 2],
    fit: Fit,
}

/// Inputs, flank and gear data, notes, travel of both branches within the limits, and whether the machine fits.
///
/// `limits` is `{"X": [low, high], …}`; an empty text means the machine's own limits, if it has A and C.
#[wasm_bindgen]
pub fn helicoid_outline(request: &str, limits: &str, files: &str) -> Result<String, Refusal> {
    to_js(outline(request, limits, files))
}

fn outline(request: &str, typed: &str, files: &str) -> Result<String> {
    let job = job(request)?;
    let fit = evaluation::fit(&job, &machine(files, &mut Vec::new())?.settings);
    let limits = if typed.is_empty() { fit.travel.unwrap_or_default() } else { limits(typed)? };
    let reach = job.reach(&limits)?;
    let notes = job.notes();
    let document = HelicoidDocument::new(&job, Vec::new());
    json(&Outline { flank: document.flank(), document, notes, reach, fit })
}

/// The tool at (u, θ), rad: both branches with their travel, independent check of the pose, distance from the singular pose.
#[wasm_bindgen]
pub fn helicoid_tool(request: &str, limits: &str, u: f64, theta: f64) -> Result<String, Refusal> {
    to_js(tool(request, limits, u, theta))
}

fn tool(request: &str, typed: &str, u: f64, theta: f64) -> Result<String> {
    json(&job(request)?.tool(u, theta, &limits(typed)?)?)
}

/// Eleven columns: u or θ, then X, Y, Z, A and C of branch 1 and of branch 2, for `count` values along `theta` or `u` with the
/// other parameter fixed.
#[wasm_bindgen]
pub fn helicoid_curve(request: &str, line: &str, held: f64, count: usize) -> Result<Vec<f64>, Refusal> {
    to_js(job(request).and_then(|job| job.curve(along(line)?, held, count)))
}

/// Points of the flank, rows of θ with columns of u, in the gear's frame, raised from it by `lift_mm`.
#[wasm_bindgen]
pub fn helicoid_mesh(request: &str, rows: usize, columns: usize, lift_mm: f64) -> Result<Vec<f32>, Refusal> {
    to_js(job(request).map(|job| job.mesh(rows, columns, lift_mm)))
}

/// Base circles, the other teeth and the gear's axis, as pairs of points.
#[wasm_bindgen]
pub fn helicoid_surroundings(request: &str) -> Result<Vec<f32>, Refusal> {
    to_js(job(request).map(|job| job.surroundings()))
}

/// Tip error along a line of the flank on the machine of these files, before and after its own compensation.
#[wasm_bindgen]
pub fn helicoid_flank(request: &str, files: &str, line: &str, held: f64, count: usize) -> Result<String, Refusal> {
    to_js(flank(request, files, line, held, count))
}

fn flank(request: &str, files: &str, line: &str, held: f64, count: usize) -> Result<String> {
    json(&evaluation::flank(&job(request)?, &machine(files, &mut Vec::new())?, along(line)?, held, count)?)
}

/// Adapts an upright machine of the chain `w C' b X Y Z A t` with positive senses to the request; returns its files.
#[wasm_bindgen]
pub fn helicoid_machine(request: &str, files: &str) -> Result<String, Refusal> {
    to_js(adapted(request, files))
}

fn adapted(request: &str, files: &str) -> Result<String> {
    let job = job(request)?;
    let machine = evaluation::adapted(&job, machine(files, &mut Vec::new())?)?;
    let comment = format!(
        "{}, {} at A = 0, pivot length {} mm, directions A {}, C {}: for a program of trueaxis helicoid.",
        machine.settings.name,
        job.form_name(),
        job.settings.pivot_mm,
        job.settings.direction_a,
        job.settings.direction_c
    );
    json(&machine_files(&machine, &comment).into_iter().collect::<BTreeMap<_, _>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASE: &str = r#"{"base_radius_mm":36,"lead_parameter_mm_per_rad":130,"pivot_mm":150,"form":"vertical","#;

    #[test]
    fn a_refusal_names_the_option_and_no_place_in_the_request() {
        for (rest, said) in [
            (r#""u_rad":"0:1:0","theta_rad":"0:1:2"}"#, "--u-rad: found COUNT 0, needed 1 to 1000000"),
            (r#""u_rad":"-1:1:3","theta_rad":"0:1:2"}"#, "--u-rad: found -1, needed u >= 0 on the right flank"),
            (
                r#""u_rad":"0:1:3","theta_rad":"0:1:2","teeth":3}"#,
                "found both --base-radius-mm and --teeth, needed either base radius and lead parameter or a gear",
            ),
        ] {
            assert_eq!(document(&format!("{BASE}{rest}")).unwrap_err().to_string(), said);
        }
        let good = format!(r#"{BASE}"u_rad":"0:1:3","theta_rad":"0:1:2"}}"#);
        let error = tool(&good, r#"{"X":[3,-3]}"#, 0.5, 0.5).unwrap_err().to_string();
        assert_eq!(error, "travel of X: found 3 to -3, needed the low end first");
        let document: Value = serde_json::from_str(&document(&good).unwrap()).unwrap();
        assert_eq!(document["points"].as_array().unwrap().len(), 6);
    }
}
