//! Messages of the page to its module: exports with JSON, files and texts, several in a row.
//!
//! The input's lines that begin with `>` name an export; the text up to the next one is its arguments, separated by lines of
//! `--`. Counts and sizes that the page determines are small numbers here; texts are arbitrary.

use crate::alone::alone;
use crate::choice::one_in;
use crate::execution::SLOWEST;
use crate::{Target, no_repair, outcome, refusal};
use serde::Deserialize;
use serde_json::value::RawValue;
use std::cell::RefCell;
use trueaxis_desk as desk;
use trueaxis_desk::Refusal;

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "desk",
    about: "messages of the page to the desk's module, several in a row",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/desk.dict"),
    slowest: SLOWEST,
};

/// Most messages in one input.
const MOST: usize = 6;
/// Longest argument.
const LONGEST: usize = 4096;
/// One in so many inputs with an expensive request is answered.
const DEAR_ONE_IN: u64 = 64;

thread_local! {
    static SCOPES: RefCell<Vec<u32>> = const { RefCell::new(Vec::new()) };
}

fn run(bytes: &[u8]) {
    // The page has only text.
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    alone(|| {
        forget();
        let dear = one_in(DEAR_ONE_IN, bytes);
        for message in text.split("\n>").take(MOST) {
            answer(message.strip_prefix('>').unwrap_or(message), dear);
        }
    });
}

/// Closes and forgets everything: a message then finds only what earlier messages of its input left.
fn forget() {
    SCOPES.take().into_iter().for_each(desk::scope::scope_close);
    let _ = desk::roundness::roundness_trace("", "");
    let _ = desk::roundness::probe_angles_finish();
    let _ = desk::grinding::grinding_open("", "");
    desk::ballbar::ballbar_forget();
}

/// Arguments of a message.
struct Parameters<'t>(std::str::Split<'t, &'static str>);

impl<'t> Parameters<'t> {
    fn text(&mut self) -> &'t str {
        let text = self.0.next().unwrap_or_default();
        let end = (0..=LONGEST.min(text.len())).rev().find(|end| text.is_char_boundary(*end));
        &text[..end.unwrap_or(0)]
    }

    /// The name of a file.
    fn name(&mut self) -> &'t str {
        self.text().lines().next().unwrap_or_default()
    }

    /// A number as a control of the page provides it.
    fn number(&mut self) -> f64 {
        self.text().trim().parse().unwrap_or_default()
    }

    /// A count determined by the page.
    fn count(&mut self) -> usize {
        self.number() as usize % 64
    }

    fn switch(&mut self) -> bool {
        self.text().len().is_multiple_of(2)
    }
}

/// Answers one message like the worker.
fn answer(message: &str, dear: bool) {
    let (name, rest) = message.split_once('\n').unwrap_or((message, ""));
    let a = &mut Parameters(rest.split("\n--\n"));
    let area = name.split_once('_').map_or(name, |(area, _)| area);
    match area {
        "machine" => machine(name, a),
        "field" => fields(name, a, dear),
        "roundness" | "probe" => roundness(name, a, dear),
        "scope" => scope(name, a, dear),
        "grinding" => grinding(name, a, dear),
        "ballbar" => ballbar(name, a, dear),
        "calibrate" => calibrate(name, a, dear),
        "keep" => keep(name, a, dear),
        "evaluate" => evaluate(name, a, dear),
        "thermal" => thermal(name, a, dear),
        "uncertainty" if dear => uncertainty(a),
        "friction" => friction(name, a),
        "helicoid" => helicoid(name, a, dear),
        _ => {}
    }
}

fn machine(name: &str, a: &mut Parameters<'_>) {
    use desk::machine::*;
    match name {
        "machine_open" => json(machine_open(a.text())),
        "machine_sample" => json(machine_sample(a.text())),
        "machine_samples" => json(machine_samples()),
        "machine_from_files" => json(machine_from_files(a.text(), a.text(), a.text().as_bytes())),
        "machine_to_tcomp" => {
            if let Some(bytes) = checked(machine_to_tcomp(a.text(), a.number())) {
                assert!(trueaxis::tcomp::Tcomp::parse(&bytes).is_ok(), "a compiled machine that is refused");
            }
        }
        "machine_show" => json(machine_show(a.text(), a.number(), a.number())),
        "machine_change" => {
            // A change must leave a valid machine.
            if let Some(files) = checked(machine_change(a.text(), a.text())) {
                assert!(machine_open(&files).is_ok(), "{files}");
            }
        }
        "machine_curve" => finite(machine_curve(a.text(), a.text(), a.count(), a.number(), a.count())),
        _ => {}
    }
}

fn fields(name: &str, a: &mut Parameters<'_>, dear: bool) {
    use desk::field::*;
    match name {
        "field" if dear => drop(checked(field(a.text(), a.text()))),
        "field_figures" if dear => json(field_figures(a.text(), a.text())),
        _ => {}
    }
}

fn roundness(name: &str, a: &mut Parameters<'_>, dear: bool) {
    use desk::roundness::*;
    match name {
        "roundness_evaluate" if dear => json(roundness_evaluate(a.name(), a.text(), a.text())),
        "roundness_trace" => json(roundness_trace(a.name(), a.text())),
        "roundness_polar" => html(roundness_polar(a.switch(), a.switch(), a.switch(), a.switch())),
        "roundness_orbit" => html(roundness_orbit()),
        "probe_angles_curve" if dear => json(probe_angles_curve(a.text())),
        "probe_angles_open" if dear => drop(checked(probe_angles_open(a.text()))),
        "probe_angles_advance" => drop(checked(probe_angles_advance(a.count() as u32))),
        "probe_angles_finish" => json(probe_angles_finish()),
        _ => {}
    }
}

fn scope(name: &str, a: &mut Parameters<'_>, dear: bool) {
    use desk::scope::*;
    use desk::scope_settings::*;
    // The scope opened last, or none.
    let number = SCOPES.with_borrow(|scopes| scopes.last().copied().unwrap_or(0));
    match name {
        "scope_open" if dear => {
            if let Some(number) = checked(scope_open(a.text())) {
                SCOPES.with_borrow_mut(|scopes| scopes.push(number));
            }
        }
        "scope_describe" => json(scope_describe(number)),
        "scope_path" => drop(checked(scope_path(number))),
        "scope_advance" => json(scope_advance(number, a.count() as u32)),
        "scope_columns" => drop(checked(scope_columns(number))),
        "scope_traces" => drop(checked(scope_traces(number))),
        "scope_figures" => json(scope_figures(number)),
        "scope_act" => json(scope_act(number, a.text())),
        "scope_scenario" => json(scope_scenario(number)),
        "scope_settings" => json(scope_settings(a.text(), a.name())),
        "scope_agreed" => json(scope_agreed(a.text())),
        "scope_scaled" => json(scope_scaled(a.text(), a.number())),
        _ => {}
    }
}

fn grinding(name: &str, a: &mut Parameters<'_>, dear: bool) {
    use desk::grinding::*;
    match name {
        "grinding_open" if dear => drop(checked(grinding_open(a.text(), a.text()))),
        "grinding_advance" => drop(checked(grinding_advance(a.count() as u32))),
        "grinding_plots" => json(grinding_plots()),
        "grinding_finish" => json(grinding_finish()),
        _ => {}
    }
}

fn ballbar(name: &str, a: &mut Parameters<'_>, dear: bool) {
    use desk::ballbar::*;
    match name {
        "ballbar_evaluate" if dear => json(ballbar_evaluate(a.name(), a.text().as_bytes(), a.text())),
        "ballbar_settings" => settings(ballbar_settings(a.text(), a.switch())),
        _ => {}
    }
}

fn calibrate(name: &str, a: &mut Parameters<'_>, dear: bool) {
    use desk::calibrate::*;
    match name {
        "calibrate_rehearse" if dear => {
            json(desk::rehearsal::calibrate_rehearse(a.text(), a.name(), a.text(), a.count() as u32));
        }
        "calibrate_plan" if dear => json(calibrate_plan(a.text(), a.name(), a.text())),
        "calibrate_solve" if dear => json(calibrate_solve(a.text(), a.name(), a.text(), a.name(), a.text())),
        _ => {}
    }
}

fn keep(name: &str, a: &mut Parameters<'_>, dear: bool) {
    use desk::keep::*;
    match name {
        "keep_rehearse" if dear => {
            json(desk::rehearsal::keep_rehearse(a.text(), a.name(), a.text(), a.count() as u32, a.switch()));
        }
        "keep_plan" if dear => json(keep_plan(a.text(), a.name(), a.text())),
        "keep_evaluate" if dear => json(keep_evaluate(a.text(), a.name(), a.text(), a.name(), a.text(), a.text())),
        _ => {}
    }
}

fn evaluate(name: &str, a: &mut Parameters<'_>, dear: bool) {
    use desk::evaluate::*;
    match name {
        "evaluate_test" => drop(checked(evaluate_test(a.name(), a.text().as_bytes()))),
        "evaluate_record" if dear => {
            if let Some(text) = checked(evaluate_record(a.name(), a.text(), a.name(), a.text().as_bytes(), a.text())) {
                let found: Result<Evaluated<'_>, _> = serde_json::from_str(&text);
                assert!(found.is_ok(), "{text}");
                found.ok().and_then(|found| found.becomes).iter().for_each(|becomes| machine_again(becomes.get()));
            }
        }
        _ => {}
    }
}

/// An evaluated test.
#[derive(Deserialize)]
struct Evaluated<'t> {
    #[serde(borrow)]
    becomes: Option<&'t RawValue>,
}

fn thermal(name: &str, a: &mut Parameters<'_>, dear: bool) {
    use desk::thermal::*;
    match name {
        "thermal_fit" if dear => json(thermal_fit(a.text(), a.name(), a.text(), a.text())),
        "thermal_compile" => drop(checked(thermal_compile(a.text(), a.name(), a.text()))),
        _ => {}
    }
}

/// With few points and draws: the page determines their cost.
fn uncertainty(a: &mut Parameters<'_>) {
    let (files, at, confidence) = (a.text(), a.text(), a.number());
    let (points, trials) = (2 + a.count() % 4, 100 + a.count());
    let request = format!(
        r#"{{"at": {at}, "confidence_percent": {confidence}, "points": {points}, "trials": {trials}, "seed": 1}}"#
    );
    json(desk::uncertainty::uncertainty(files, &request));
}

/// Written settings must leave a valid machine.
fn settings(answer: Result<String, Refusal>) {
    checked(answer).iter().for_each(|text| machine_again(text));
}

fn machine_again(text: &str) {
    #[derive(Deserialize)]
    struct Files<'t> {
        #[serde(borrow)]
        files: &'t RawValue,
    }
    let files: Result<Files<'_>, _> = serde_json::from_str(text);
    let files = files.map(|found| desk::machine::machine_open(found.files.get()));
    assert!(matches!(files, Ok(Ok(_))), "{text}");
}

/// Without simulation and fits, which target `friction` covers.
fn friction(name: &str, a: &mut Parameters<'_>) {
    use desk::friction::*;
    match name {
        "friction_read" => json(friction_read(a.name(), a.text(), a.text())),
        "friction_settings" => json(friction_settings()),
        "friction_advance" => drop(checked(friction_advance(a.number()))),
        "friction_record" => json(friction_record()),
        "friction_trace" => json(friction_trace(a.count())),
        "friction_csv" => drop(checked(friction_csv())),
        "friction_fit" => json(friction_fit(a.text(), a.switch())),
        "friction_closed" => json(friction_closed()),
        "friction_becomes" => json(friction_becomes(a.text())),
        _ => {}
    }
}

fn helicoid(name: &str, a: &mut Parameters<'_>, dear: bool) {
    use desk::helicoid::*;
    match name {
        "helicoid_document" if dear => json(helicoid_document(a.text())),
        "helicoid_csv" if dear => drop(checked(helicoid_csv(a.text()))),
        "helicoid_gcode" if dear => drop(checked(helicoid_gcode(a.text()))),
        "helicoid_outline" if dear => json(helicoid_outline(a.text(), a.text(), a.text())),
        "helicoid_tool" => json(helicoid_tool(a.text(), a.text(), a.number(), a.number())),
        "helicoid_curve" => drop(checked(helicoid_curve(a.text(), a.text(), a.number(), a.count()))),
        "helicoid_mesh" => drop(checked(helicoid_mesh(a.text(), a.count(), a.count(), a.number()))),
        "helicoid_surroundings" => drop(checked(helicoid_surroundings(a.text()))),
        "helicoid_flank" => json(helicoid_flank(a.text(), a.text(), a.text(), a.number(), a.count())),
        "helicoid_machine" => json(helicoid_machine(a.text(), a.text())),
        _ => {}
    }
}

/// The answer; a refusal must be words on one line.
fn checked<T>(answer: Result<T, Refusal>) -> Option<T> {
    match answer {
        Ok(answer) => {
            outcome::accepted();
            Some(answer)
        }
        Err(refused) => {
            refusal::in_words(&refused.to_string());
            None
        }
    }
}

/// Expects one JSON document.
fn json(answer: Result<String, Refusal>) {
    if let Some(text) = checked(answer) {
        let document: Result<&RawValue, _> = serde_json::from_str(&text);
        assert!(document.is_ok(), "{text}");
    }
}

/// Expects a figure without anything that a page would run.
fn html(answer: Result<String, Refusal>) {
    if let Some(text) = checked(answer) {
        assert!(text.contains("<svg") && !text.contains("<script"), "{text}");
    }
}

/// Expects a curve of finite numbers.
fn finite(answer: Result<Vec<f64>, Refusal>) {
    if let Some(values) = checked(answer) {
        assert!(values.iter().all(|value| value.is_finite()), "{values:?}");
    }
}

const MACHINE: &str = r#"{"machine.toml": "name = \"m\"\nchain = \"w b X Y Z t\"\n[axis.X]\ntable = \"x.csv\"\n", "x.csv": "X_mm,EXX_um\n0,1\n10,2\n"}"#;
const SQUARE: &str = r#"{"machine.toml": "name = \"m\"\nchain = \"w Y' X' b Z t\"\n[axis.X]\n[axis.Y]\n[axis.Z]\n"}"#;
/// With uncertainties, from which a rehearsal draws.
const RANGED: &str = r#"{"machine.toml": "name = \"m\"\nchain = \"w Y' X' b Z t\"\n[axis.X]\ntravel_mm = [-99, 99]\n[axis.Y]\ntravel_mm = [-99, 99]\n[axis.Z]\ntravel_mm = [-99, 99]\n[uncertainty.location]\nC0Y_urad = 9\n"}"#;
const STATED: &str = r#"{"machine.toml": "name = \"m\"\nchain = \"w Y' X' b Z t\"\n[uncertainty]\ndevice_um_per_m = 1\n[axis.X]\ntravel_mm = [0, 9]\n[axis.Y]\ntravel_mm = [0, 9]\n[axis.Z]\ntravel_mm = [0, 9]\ntable = \"z.csv\"\n", "z.csv": "Z_mm,EZZ_um\n0,1\n9,2\n"}"#;
const TASK: &str = "machine = \"m\"\ndialect = \"linuxcnc\"\n[probe]\ntip_radius_mm = 2\nrepeats = 1\n[[artefact]]\n\
                    name = \"ball\"\nkind = \"ball\"\ndiameter_mm = 25\nuncertainty_um = 0.2\n[[artefact.place]]\n\
                    at_mm = [0, 0, 0]\n[solve]\nsquareness = false\nscale = false\nbacklash = false\n";
const KEEP: &str = "machine = \"m\"\ndialect = \"linuxcnc\"\nevery_parts = 9\n[probe]\ntip_radius_mm = 2\nrepeats = 1\n\
                    [[artefact]]\nname = \"ball\"\nkind = \"ball\"\ndiameter_mm = 25\nuncertainty_um = 0.2\n\
                    [[artefact.place]]\nat_mm = [0, 0, 0]\n[[term]]\nnames = [\"offset X\"]\nlargest_update_um = 15\n\
                    largest_total_um = 30\n";
const REPROBING: &str = r#"{"history": "", "begin": false, "time": null, "parts": 3, "accept": [], "by_hand": false}"#;
const HELICOID: &str = r#"{"base_radius_mm":36,"lead_parameter_mm_per_rad":130,"pivot_mm":150,"form":"vertical","u_rad":"0:1:3","theta_rad":"0:1:2"}"#;
const PROBES: &str = r#"{"n": 64, "harmonics": [2, 15], "p": 11, "q": 14}"#;

fn seeds() -> Vec<Vec<u8>> {
    let message = |name: &str, arguments: &[&str]| format!(">{name}\n{}\n", arguments.join("\n--\n"));
    let scope = format!(
        r#"{{"machine": {MACHINE}, "program": {{"name": "p.ngc", "text": "G21 G90 F6000\nG1 X1\n"}}, "settings": "rate_hz = 200\n", "kinds": ["compensated"]}}"#
    );
    let change = |change: &str| message("machine_change", &[MACHINE, change]);
    let (description, table) =
        ("name = \"m\"\nchain = \"w b X t\"\n[axis.X]\ntable = \"x.csv\"\n", "X_mm,EXX_um\n0,1\n10,2\n");
    let files = format!(r#"[["a/machine.toml", {}], ["a/x.csv", {}]]"#, description.len(), table.len());
    let dropped = [description, table].concat();
    let circle: String = [1, -1]
        .iter()
        .flat_map(|d| (0..40).map(move |k| format!("{},{},{d}\n", 9 * k, if k % 20 < 10 { 3 } else { -2 })))
        .collect();
    let circle = format!("angle_deg,deviation_um,direction\n{circle}");
    let warm_up: String = (0..24).map(|k| format!("{},{},{},{}\n", 300 * k, k / 8, k % 8, 20 + k % 8)).collect();
    let warm_up = format!("t_s,cycle,ex_um,T1_c\n{warm_up}");
    let ring: String =
        (0..8).map(|k| format!("{},{}\n", [5, 3, 0, -3, -5, -3, 0, 3][k], [0, 4, 5, 4, 0, -4, -5, -4][k])).collect();
    let ring = format!("x_mm,y_mm\n{ring}");
    let growth: String = (0..12).map(|k| format!("{},{},{}\n", 60 * k, k * k, 20 + k)).collect();
    let growth = format!("t_s,z_um,ambient_c\n{growth}");
    let diagonals: String = [[1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]]
        .iter()
        .enumerate()
        .flat_map(|(k, [x, y, z])| {
            (0..6).map(move |t| format!("{},1,{},{},{},{}\n", k + 1, t * x, t * y, t * z, t * x * y))
        })
        .collect();
    let diagonals = format!("diagonal,direction,x_mm,y_mm,z_mm,deviation_um\n{diagonals}");
    let evaluate =
        |test: &str, record: &str, request: &str| message("evaluate_record", &[test, SQUARE, "r.csv", record, request]);
    let points = "x_mm,y_mm\n3,0\n0,3\n-3,0\n0,-3.002\n";
    [
        message("machine_open", &[MACHINE]),
        message("machine_show", &[MACHINE, "1000", "0"]) + &message("machine_to_tcomp", &[MACHINE, "1000"]),
        change(r#"{"change": "point", "axis": "X", "column": "EXX_um", "row": 1, "value": 1.5}"#),
        change(r#"{"change": "insert", "axis": "X", "position": 5}"#)
            + &change(r#"{"change": "remove", "axis": "X", "row": 1}"#),
        change(r#"{"change": "key", "key": "axis.X.backlash_um", "value": 2.0}"#),
        message("machine_curve", &[MACHINE, "X", "0", "25", "9"]) + &message("scope_scaled", &[MACHINE, "0.5"]),
        message("machine_from_files", &["{}", &files, &dropped]),
        message("roundness_trace", &["t.csv", points]) + &message("roundness_polar", &["", "", "", ""]),
        message("machine_samples", &[])
            + &message("probe_angles_curve", &[PROBES])
            + &message("probe_angles_open", &[&format!(r#"{{"probes": {PROBES}, "count": 2}}"#)]),
        message("machine_sample", &["grinder"])
            + &message("scope_open", &[&scope])
            + &message("scope_describe", &[])
            + &message("scope_act", &["dropout:X@now+3"])
            + &message("scope_advance", &["40"])
            + &message("scope_figures", &[])
            + &message("scope_scenario", &[]),
        message("scope_settings", &["rate_hz = 4000\n[drive]\ndead_time_s = 0.001\n", "mine.toml"])
            + &message("scope_agreed", &[MACHINE]),
        message("friction_settings", &[])
            + &message("ballbar_evaluate", &["r.csv", &circle, r#"{"radius_mm": 50, "axes": "X,Y"}"#])
            + &message("ballbar_settings", &[SQUARE, ""]),
        message("friction_settings", &[])
            + &message("calibrate_plan", &[SQUARE, "task.toml", TASK])
            + &message("calibrate_rehearse", &[RANGED, "task.toml", TASK, "3"])
            + &message("calibrate_solve", &[SQUARE, "task.toml", TASK, "probe.log", "touch 1 14.5 0 0 0 0 0 1\n"]),
        message("friction_settings", &[])
            + &message("keep_plan", &[SQUARE, "keep.toml", KEEP])
            + &message("keep_rehearse", &[RANGED, "keep.toml", KEEP, "3", ""])
            + &message(
                "keep_evaluate",
                &[SQUARE, "keep.toml", KEEP, "look.log", "touch 1 14.5 0 0 0 0 0 1\n", REPROBING],
            ),
        message("friction_settings", &[])
            + &message("thermal_fit", &[MACHINE, "r.csv", &warm_up, r#"{"hold_out": [], "without": []}"#])
            + &message("thermal_compile", &[MACHINE, "thermal.toml", "reference_temperature_c = 20\n"]),
        message("evaluate_test", &["ring.csv", &ring]) + &evaluate("probing", &ring, "{\"feature\": \"ring\"}"),
        message("friction_settings", &[]) + &evaluate("thermal", &growth, "{\"period_min\": 5}"),
        message("friction_settings", &[]) + &evaluate("step-diagonal", &diagonals, "{\"alignment_urad\": 20}"),
        message("friction_settings", &[])
            + &evaluate("r-test", "x_mm,y_mm,z_mm,c_deg,dx_um,dy_um,dz_um\n1,0,0,0,1,0,0\n0,-1,0,90,0,2,0\n", "{}")
            + &evaluate("points", "x_mm,y_mm,z_mm,actual_x_mm,actual_y_mm,actual_z_mm\n0,0,0,0.001,0,0\n", "{}"),
        message("friction_settings", &[]) + &message("uncertainty", &[STATED, "[1, 2, 3]", "95", "3", "20"]),
        message("friction_settings", &[])
            + &message("friction_read", &["r.csv", "t_s,x_cmd_mm,x_mm,y_cmd_mm,y_mm\n0,1,1,2,2\n", "X,Y"])
            + &message("friction_record", &[]),
        message("friction_settings", &[]) + &message("friction_becomes", &["{}"]),
        message("helicoid_tool", &[HELICOID, r#"{"X": [-300, 300]}"#, "0.5", "0.5"])
            + &message("helicoid_curve", &[HELICOID, "u", "0.5", "5"]),
        message("helicoid_mesh", &[HELICOID, "3", "4", "0.1"]) + &message("helicoid_document", &[HELICOID]),
        message("friction_settings", &[])
            + &message("field_figures", &[MACHINE, "{}"])
            + &message("grinding_open", &[MACHINE, "{}"]),
    ]
    .map(String::into_bytes)
    .into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tasks_of_the_seeds_are_planned() {
        for planned in [
            desk::calibrate::calibrate_plan(SQUARE, "task.toml", TASK),
            desk::keep::keep_plan(SQUARE, "keep.toml", KEEP),
            desk::rehearsal::calibrate_rehearse(RANGED, "task.toml", TASK, 3),
            desk::rehearsal::keep_rehearse(RANGED, "keep.toml", KEEP, 3, true),
            desk::uncertainty::uncertainty(
                STATED,
                r#"{"at": [1, 2, 3], "confidence_percent": 95, "points": 3, "trials": 100, "seed": 1}"#,
            ),
        ] {
            assert!(planned.is_ok(), "{planned:?}");
        }
    }
}
