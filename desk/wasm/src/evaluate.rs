//! Records of tests with instruments: detecting the test, displaying the results, and the resulting settings.

use crate::becomes::Becomes;
use crate::files::machine;
use crate::{Refusal, json, to_js};
use anyhow::{Context, Result, anyhow, bail};
use serde::{Deserialize, Serialize};
use std::path::Path;
use trueaxis_evaluation::rows::{Column, Rows};
use trueaxis_evaluation::shown::Shown;
use trueaxis_evaluation::{diagonal, points, probing, r_test, thermal_test};
use trueaxis_tables::Additions;
use trueaxis_tables::sheet::Sheet;
use wasm_bindgen::prelude::*;

/// Inputs in addition to the record: every test uses those that apply to it, under the names of its options.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Request {
    alignment_urad: Option<f64>,
    tool_mm: Option<[f64; 3]>,
    free_sensor: bool,
    without: Vec<String>,
    nodes: Option<Vec<usize>>,
    feature: probing::Feature,
    diameter_mm: Option<f64>,
    /// Points in a plane: a second record, on which the errors are tested.
    against: Option<Against>,
    test: String,
    period_min: f64,
    distance_mm: Option<f64>,
}

/// A second record.
#[derive(Deserialize)]
struct Against {
    name: String,
    text: String,
}

impl Default for Request {
    fn default() -> Request {
        Request {
            alignment_urad: None,
            tool_mm: None,
            free_sensor: false,
            without: Vec::new(),
            nodes: None,
            feature: probing::Feature::Ring,
            diameter_mm: None,
            against: None,
            test: "spindle".into(),
            period_min: 60.0,
            distance_mm: None,
        }
    }
}

/// An evaluated record.
#[derive(Serialize)]
struct Evaluated {
    /// The contents of the `trueaxis evaluate` report page.
    shown: Shown,
    /// The corrected machine, for tests that determine any of its errors.
    becomes: Option<Becomes>,
    notes: Vec<String>,
}

/// The tests under their command-line names, with their columns.
const TESTS: [(&str, &[Column]); 5] = [
    ("step-diagonal", &diagonal::COLUMNS),
    ("r-test", &r_test::COLUMNS),
    ("points", &points::COLUMNS),
    ("probing", &probing::COLUMNS),
    ("thermal", &thermal_test::COLUMNS),
];

/// The test that names most of a header's columns; among several, the one whose required columns are all present.
fn test_of(header: &[String]) -> Option<&'static str> {
    let fitting = TESTS.iter().filter_map(|(test, columns)| {
        let count = columns.iter().filter(|column| header.iter().any(|cell| cell == column.name)).count();
        let whole = columns.iter().all(|column| !column.needed || header.iter().any(|cell| cell == column.name));
        (count > 0).then_some(((count, whole), *test))
    });
    fitting.max_by_key(|(rank, _)| *rank).map(|(_, test)| test)
}

fn test(name: &str, bytes: &[u8]) -> Result<String> {
    let sheet = Sheet::new(bytes, Path::new(name))?;
    let known = test_of(sheet.header()).map(str::to_owned);
    Ok(known.ok_or_else(|| {
        let columns = TESTS.map(|(test, columns)| {
            let names: Vec<&str> = columns.iter().filter(|column| column.needed).map(|column| column.name).collect();
            format!("{test} ({})", names.join(", "))
        });
        let found = format!("columns {}", sheet.header().join(", "));
        sheet.error("", found, format!("those of one of {}", columns.join(", ")))
    })?)
}

/// Detects the test of a record by its columns: "step-diagonal", "r-test", "points", "probing" or "thermal".
#[wasm_bindgen]
pub fn evaluate_test(name: &str, bytes: &[u8]) -> Result<String, Refusal> {
    to_js(test(name, bytes))
}

fn located(files: &str, bytes: &[u8], additions: Additions) -> Result<Option<Becomes>> {
    Becomes::new(files, &additions.of_record(bytes)).map(Some)
}

fn evaluate(test: &str, files: &str, name: &str, bytes: &[u8], request: &str) -> Result<String> {
    let request: Request = serde_json::from_str(request).context("the request of a test")?;
    let (path, mut notes) = (Path::new(name), Vec::new());
    let (shown, becomes) = match test {
        "step-diagonal" => {
            diagonal::check(request.alignment_urad).map_err(|wrong| wrong.option())?;
            let test = diagonal::read(&mut Rows::new(bytes, path, &diagonal::COLUMNS, |note| notes.push(note))?)?;
            let document = diagonal::DiagonalDocument::new(&test, request.alignment_urad);
            (document.shown(&test), located(files, bytes, diagonal::additions(&test))?)
        }
        "r-test" => {
            r_test::check(request.tool_mm).map_err(|wrong| wrong.option())?;
            let record = Rows::new(bytes, path, &r_test::COLUMNS, |note| notes.push(note))?;
            let record = r_test::Record::read(&mut { record })?;
            let mut machine = machine(files, &mut notes)?;
            machine.settings.tool_mm = request.tool_mm.unwrap_or(machine.settings.tool_mm);
            let options = r_test::Options { without: request.without, free_sensor: request.free_sensor };
            let found = r_test::identify(&record, name, &machine, &options)?;
            let document = r_test::RTestDocument::new(&record, &found, &machine);
            (document.shown(&record, &found), located(files, bytes, found.additions())?)
        }
        "points" => {
            let nodes = request.nodes.as_deref().map(points::nodes).transpose();
            let nodes = nodes.map_err(|wrong| anyhow!("--nodes: {wrong}"))?;
            let mut read = |bytes: &[u8], name: &str| {
                points::Points::read(&mut Rows::new(bytes, Path::new(name), &points::COLUMNS, |note| notes.push(note))?)
            };
            let record = read(bytes, name)?;
            let against = request.against.as_ref();
            let against = against.map(|of| Ok::<_, anyhow::Error>((read(of.text.as_bytes(), &of.name)?, &of.name)));
            let against = against.transpose()?;
            let machine = machine(files, &mut notes)?;
            let options = points::Options { nodes, without: request.without };
            let context = |error: anyhow::Error| error.context(name.to_owned());
            if record.are_flat() {
                let against = against.as_ref().map(|(points, name)| (points, name.as_str()));
                let found = points::identify_plane(&record, Some(&machine), &options, against).map_err(context)?;
                let document = points::PlaneDocument::new(&found, record.stated);
                let changed = document.files(&found, name);
                (document.shown(&found), changed.map(|changed| Becomes::whole(files, changed)).transpose()?)
            } else {
                if against.is_some() {
                    bail!("--against: found points along X, Y and Z, needed points in a plane or on a line");
                }
                let found = points::identify(&record, &machine, &options).map_err(context)?;
                let document = points::PointsDocument::new(&record, &found);
                let becomes = Becomes::whole(files, document.files(&found, name))?;
                (document.shown(&record, &found), Some(becomes))
            }
        }
        "probing" => {
            probing::check(request.diameter_mm).map_err(|wrong| wrong.option())?;
            let rows = &mut Rows::new(bytes, path, &probing::COLUMNS, |note| notes.push(note))?;
            let record = probing::Record::read(rows, request.feature, request.diameter_mm)?;
            (probing::ProbingDocument::new(&record).shown(&record), None)
        }
        "thermal" => {
            thermal_test::check(request.period_min, request.distance_mm).map_err(|wrong| wrong.option())?;
            let kinds = thermal_test::KINDS;
            let kind = kinds.into_iter().find(|kind| *kind == request.test);
            let kind =
                kind.ok_or_else(|| anyhow!("--test: found {}, needed one of {}", request.test, kinds.join(", ")))?;
            let test =
                thermal_test::read(&mut Rows::new(bytes, path, &thermal_test::COLUMNS, |note| notes.push(note))?)?;
            let document = thermal_test::ThermalTestDocument::new(&test, kind, request.period_min, request.distance_mm);
            (document.shown(&test), None)
        }
        found => {
            return Err(anyhow!("found the test {found:?}, needed one of {}", TESTS.map(|(test, _)| test).join(", ")));
        }
    };
    json(&Evaluated { shown, becomes, notes })
}

/// Evaluates a record of a test ([`evaluate_test`]) on the machine of these files: `shown` (the contents of the `trueaxis
/// evaluate` report page), `becomes` (the corrected machine), `notes`. `request`: the test's options by name.
#[wasm_bindgen]
pub fn evaluate_record(test: &str, files: &str, name: &str, bytes: &[u8], request: &str) -> Result<String, Refusal> {
    to_js(evaluate(test, files, name, bytes, request))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_columns_identify_the_test() {
        for (header, needed) in [
            ("x_mm,y_mm,z_mm,a_deg,c_deg,dx_um,dy_um,dz_um", "r-test"),
            ("X_mm;y_mm;z_mm;a_deg;dx;dy_um;dz_um", "r-test"),
            ("diagonal,run,direction,x_mm,y_mm,z_mm,deviation_um", "step-diagonal"),
            ("x_mm,y_mm,z_mm,actual_x_mm,actual_y_mm,actual_z_mm,u_um", "points"),
            ("x_mm,y_mm", "probing"),
            ("x_mm,y_mm,z_mm,run,spindle_deg", "probing"),
            ("t_s,x1_um,ambient_c", "thermal"),
        ] {
            assert_eq!(test("r.csv", format!("{header}\n").as_bytes()).unwrap(), needed, "{header}");
        }
        let refused = test("r.csv", b"angle_deg,deviation\n").unwrap_err().to_string();
        assert!(
            refused.starts_with("r.csv:1: found columns angle_deg, deviation, needed those of one of"),
            "{refused}"
        );
    }
}
