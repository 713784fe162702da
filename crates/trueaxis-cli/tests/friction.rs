//! `trueaxis friction` as called, on a record from an independent integration.

use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::sync::OnceLock;
use trueaxis_testing::command::Folder;
use trueaxis_testing::covariance::{at, check};

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");
const PERIOD_S: f64 = 5e-4;
const COULOMB: f64 = 0.5;
const SHARE: f64 = 0.3;
const PRESLIDING: f64 = 0.006;

/// The machine whose drives make the record; it states nothing else about the servo.
const MACHINE: &str = "name = \"m\"\nchain = \"w X' Y' b Z t\"\n[axis.X]\ntable = \"x.csv\"\ntravel_mm = [-100, 100]\n\
    [axis.Y]\ntravel_mm = [-100, 100]\n";
const DRIVES: &str = "[axis.X.drive]\nposition_gain_per_s = 110\nvelocity_gain_per_s = 800\nreset_time_s = 0.006\n\
    velocity_feed_forward = 0.93\n\
    [axis.Y.drive]\nposition_gain_per_s = 110\nvelocity_gain_per_s = 800\nreset_time_s = 0.006\n\
    velocity_feed_forward = 0.93\n";

/// Commands on circles from rest to rest: radius in mm, feeds in mm/s, positive counterclockwise.
fn commands(radius: f64, feeds: &[f64]) -> [Vec<f64>; 2] {
    let (ramp, mut angle) = (0.05, 0.4f64);
    let mut command = [Vec::new(), Vec::new()];
    for &feed in feeds {
        let duration = 1.5 * TAU * radius / feed.abs() + ramp;
        for k in 0..((duration + 0.1) / PERIOD_S) as usize {
            let t = (k as f64 * PERIOD_S - 0.1).max(0.0);
            let edge = (t.min(duration - t).max(0.0) / ramp).min(1.0);
            angle += feed / radius * PERIOD_S * (0.25 * TAU * edge).sin().powi(2);
            command[0].push(radius * angle.cos());
            command[1].push(radius * angle.sin());
        }
    }
    command
}

/// Readings of the drive above, rounded to 10 nm; explicit steps of 20 µs, with the command linear between samples.
fn readings(command: &[f64]) -> Vec<f64> {
    let (h, steps) = (2e-5, (PERIOD_S / 2e-5).round() as usize);
    let [mut x, mut v, mut q, mut m, mut f] = [command[0], 0.0, 0.0, 0.0, 0.0];
    let mut out = vec![x];
    for pair in command.windows(2) {
        let rate = (pair[1] - pair[0]) / PERIOD_S;
        for i in 0..steps {
            let r = 110.0 * (pair[0] + rate * h * (i as f64 + 0.5) - x) + 0.93 * rate;
            q += h * (r - v) / 0.006;
            m += h * (800.0 * (r - v + q) - m) / 2.5e-4;
            f += h * (v - f64::abs(v) * f) / PRESLIDING;
            v += h * (m - 800.0 * COULOMB * (1.0 + SHARE / (1.0 + v * v / 4.0)) * f);
            x += h * v;
        }
        out.push((x / 1e-5).round() * 1e-5);
    }
    out
}

fn text(feeds: &[f64]) -> String {
    on_circles(5.004, feeds)
}

fn on_circles(radius: f64, feeds: &[f64]) -> String {
    let [x, y] = commands(radius, feeds);
    let [read_x, read_y] = [readings(&x), readings(&y)];
    let mut text = String::from("t_s,x_cmd_mm,x_mm,y_cmd_mm,y_mm\n");
    for k in 0..x.len() {
        let t = k as f64 * PERIOD_S;
        writeln!(text, "{t:.4},{:.7},{:.5},{:.7},{:.5}", x[k], read_x[k], y[k], read_y[k]).unwrap();
    }
    text
}

/// A valid record.
fn record() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| text(&[25.0, -25.0, 10.0, -10.0]))
}

fn folder(record: &str) -> Folder {
    let folder = Folder::new(TRUEAXIS);
    folder.write("record.csv", record);
    folder.write("x.csv", "X_mm,EXX_um\n-100,0\n0,1\n100,0\n");
    folder.write("machine.toml", format!("{MACHINE}{DRIVES}"));
    folder
}

const CALL: [&str; 6] = ["friction", "record.csv", "--axes", "X,Y", "--machine", "machine.toml"];

/// Names of the figures in the covariance, whose diagonal are the squares of the standard errors.
#[track_caller]
fn covariant(found: &Value) -> Vec<String> {
    check(&found["covariance"], |name| {
        let (letter, key) = name.split_once('.').unwrap();
        let axis = found["axes"].as_array().unwrap().iter().find(|own| own["axis"] == letter).unwrap();
        let of = if axis["friction"][key].is_null() { "drive" } else { "friction" };
        [at(&axis[of], key), at(&axis["standard_errors"], key)]
    })
}

fn near(value: &Value, truth: f64, tolerance: f64) {
    let value = value.as_f64().unwrap();
    assert!((value / truth - 1.0).abs() < tolerance, "{value} for {truth}");
}

#[test]
fn friction_is_found_and_what_is_written_is_a_machine_s() {
    let folder = folder(record());
    let found = folder.json(&[&CALL[..], &["--json", "-o", "friction.toml", "--report", "out"]].concat());
    assert_eq!(found["axes"].as_array().unwrap().len(), 2);
    for axis in found["axes"].as_array().unwrap() {
        near(&axis["friction"]["coulomb_mm_per_s"], COULOMB, 0.03);
        near(&axis["friction"]["presliding_um"], 1e3 * PRESLIDING, 0.03);
        near(&axis["friction"]["stribeck_share"], SHARE, 0.15);
        assert_eq!(axis["drive_found"], false);
        near(&axis["drive"]["position_gain_per_s"], 110.0, 1e-9);
        assert!(axis["standard_errors"]["coulomb_mm_per_s"].as_f64().unwrap() < 0.05);
        assert!(axis["standard_errors"]["position_gain_per_s"].is_null());
        let size = |of: &str| axis["glitch_um"][of]["max"].as_f64().unwrap();
        assert!(size("before") > 1.0 && size("after") < 0.15 * size("before"), "{}", axis["glitch_um"]);
        assert!(axis["explained"].as_f64().unwrap() > 0.98);
        assert!(axis["resonance"].is_null() && axis["resonance_not_found"].is_null(), "nobody asked: {axis}");
    }
    let names = covariant(&found);
    assert!(names.contains(&"X.coulomb_mm_per_s".into()) && names.contains(&"Y.presliding_um".into()), "{names:?}");
    assert!(!names.iter().any(|name| name.ends_with("position_gain_per_s")), "{names:?}");
    let page = folder.read("out/friction.html");
    assert!(page.contains("Axis Y, ") && page.contains("after, expected"));
    // The machine accepts the settings when they are appended to it.
    let settings = folder.read("friction.toml");
    assert!(settings.contains("[axis.X.friction]") && !settings.contains(".drive]"), "{settings}");
    folder.write("joined.toml", format!("{MACHINE}{DRIVES}{settings}"));
    folder.good(&["tables", "check", "joined.toml"]);
    let table = folder.good(&CALL);
    assert!(table.contains("± 95 %, Y"), "{table}");
    assert!(table.contains("Coulomb friction F_c/K_vp, mm/s") && table.contains("the machine's"), "{table}");
}

#[test]
fn the_drive_is_found_where_no_machine_states_it() {
    let folder = folder(record());
    let found = folder.json(&["friction", "record.csv", "--axes", "X,Y", "--json", "-o", "found.toml"]);
    for axis in found["axes"].as_array().unwrap() {
        assert_eq!(axis["drive_found"], true);
        for (key, truth) in [("position_gain_per_s", 110.0), ("reset_time_s", 0.006), ("velocity_gain_per_s", 800.0)] {
            let error = axis["standard_errors"][key].as_f64().unwrap();
            let off = (axis["drive"][key].as_f64().unwrap() - truth).abs();
            assert!(off < 4.0 * error || off < 0.05 * truth, "{key}: {axis}");
        }
    }
    // The encoder is read when the row's command takes effect; if that is unknown, the uncertainty of the feed-forward
    // includes it.
    let timed = folder.json(&["friction", "record.csv", "--axes", "X,Y", "--json", "--read-after-us", "0"]);
    near(&timed["axes"][0]["drive"]["velocity_feed_forward"], 0.93, 0.003);
    let error = |found: &Value| found["axes"][0]["standard_errors"]["velocity_feed_forward"].as_f64().unwrap();
    assert!(error(&timed) < 0.1 * error(&found), "{} with the time, {} without", error(&timed), error(&found));
    let fitted = |found: &Value| {
        let figures = covariant(found);
        let standard =
            found["axes"].as_array().unwrap().iter().flat_map(|axis| axis["standard_errors"].as_object().unwrap());
        assert_eq!(figures.len(), standard.filter(|(_, error)| !error.is_null()).count(), "{figures:?}");
        figures
    };
    assert!(fitted(&found).contains(&"Y.velocity_gain_per_s".into()));
    fitted(&timed);
    let settings = folder.read("found.toml");
    assert!(settings.contains("[axis.X.drive]") && settings.contains("[axis.Y.friction]"), "{settings}");
    folder.write("joined.toml", format!("{MACHINE}{settings}"));
    folder.good(&["tables", "check", "joined.toml"]);
}

#[test]
fn unusable_records_are_refused_and_nothing_is_written() {
    let good = record();
    let lines: Vec<&str> = good.lines().collect();
    let without = |from: usize, to: usize| [&lines[..from], &lines[to..]].concat().join("\n");
    let cases = [
        (without(3000, 3100), "record.csv:3001: column t_s: found 0.050500 s after the line before"),
        (text(&[25.0, -25.0]), "needed accelerations that differ by 1.5 or more"),
        (without(1500, lines.len()), "needed at least 2000"),
        (text(&[25.0, 10.0]), "needed at least 2 of each: circles in both directions"),
        (good.replace("x_mm", "x_um"), "column x_um"),
        (good.replace("t_s", "t_ms"), "column t_ms"),
        (good.replace("\n0.0050,", "\n0.0o50,"), "column t_s: found"),
    ];
    for (record, needed) in cases {
        let folder = folder(&record);
        folder.bad(&[&CALL[..], &["-o", "friction.toml", "--report", "out"]].concat(), &[needed]);
    }
}

#[test]
fn options_that_do_not_fit_are_refused() {
    let folder = folder(record());
    folder.bad(&["friction", "record.csv", "--axes", "X,X"], &["needed two of X, Y and Z"]);
    let never = ["friction", "record.csv", "--axes", "X,Y", "--read-after-us", "1e6"];
    folder.bad(&never, &["needed -100000 to 20000 µs"]);
    folder.bad(&["friction", "record.csv", "--axes", "X,C"], &["needed two of X, Y and Z"]);
    folder.bad(&["friction", "record.csv", "--axes", "X,Z"], &["column z_cmd_mm"]);
    folder.write("flat.toml", "name = \"m\"\nchain = \"w b X t\"\n[axis.X]\ntable = \"x.csv\"\n");
    folder.bad(&["friction", "record.csv", "--axes", "X,Y", "--machine", "flat.toml"], &["found no axis Y"]);
    let over_the_input = ["-o", "record.csv"];
    folder.bad(&[&CALL[..], &over_the_input].concat(), &["an input is never written"]);
    folder.bad(&[&CALL[..], &["-o", "machine.toml"]].concat(), &["an input is never written"]);
    folder.bad(&["friction", "record.csv", "--axes", "X,Y", "--dry-run"], &["--machine"]);
}

/// Decided and written by the rule of all commands: an axis' figures together, with their uncertainties.
#[test]
fn friction_goes_into_a_machine_by_the_rule_of_all_commands() {
    let folder = folder(record());
    let stated = "[axis.X.friction] # a guess\ncoulomb_mm_per_s = 0.4\npresliding_um = 9 # ours\n";
    folder.write("machine.toml", format!("{MACHINE}{DRIVES}{stated}"));
    let before = folder.tree();
    let said = folder.json(&[&CALL[..], &["--dry-run", "--json"]].concat());
    assert_eq!(folder.tree(), before);
    let written = said["written"].as_array().unwrap();
    let of = |key: &str| written.iter().find(|of| of["key"] == key).unwrap_or_else(|| panic!("{key}: {said}"));
    let coulomb = of("axis.X.friction.coulomb_mm_per_s");
    assert!(coulomb["old"]["value"] == 0.4 && coulomb["why"] == "no uncertainty is stated", "{coulomb}");
    near(&coulomb["written"]["value"], COULOMB, 0.03);
    assert!(of("axis.Y.friction.viscous")["old"].is_null() && said["axes"].is_array(), "{said}");
    assert!(written.iter().all(|of| !of["key"].as_str().unwrap().contains(".drive.")), "the machine's: {said}");
    let [_, stderr] = folder.both(&[&CALL[..], &["-o", "found"]].concat());
    assert!(
        stderr.lines().any(|line| line.starts_with("axis.X.friction.presliding_um") && line.contains("9 ")),
        "{stderr}"
    );
    let text = folder.read("found/machine.toml");
    for part in [
        "[axis.X.friction] # a guess\n",
        " # ours\n",
        "[axis.X.friction.uncertainty]\n",
        "[axis.Y.friction]\n",
        "[axis.Y.friction.uncertainty]\n",
        "degrees_of_freedom = ",
        "records = [",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
    folder.good(&["tables", "check", "found"]);
    // A record that the machine already contains counts once.
    let [_, stderr] = folder.both(&["friction", "record.csv", "--axes", "X,Y", "--machine", "found", "-o", "found"]);
    assert!(stderr.contains("this record is already included"), "{stderr}");
    assert_eq!(folder.read("found/machine.toml"), text);
    // More of the spikes remains than three times the noise that the machine states.
    folder.write("machine.toml", format!("{MACHINE}{DRIVES}{stated}[uncertainty]\neve_um = 0.0001\n"));
    let [_, stderr] = folder.both(&[&CALL[..], &["-o", "misfit"]].concat());
    assert!(stderr.contains("misfit: "), "{stderr}");
    assert_eq!(folder.read("misfit/machine.toml"), folder.read("machine.toml"));
    let said = folder.json(&[&CALL[..], &["-o", "forced", "--force", "--json"]].concat());
    let forced = |of: &Value| {
        of["written"].is_object()
            && of["why"].as_str().unwrap().starts_with("forced, the rule writes nothing: misfit: ")
    };
    assert!(said["written"].as_array().unwrap().iter().all(forced), "{said}");
    assert!(folder.read("forced/machine.toml").contains("[axis.Y.friction]"));
}

/// The drive that makes the record has one mass. Counts of 1 µm keep the search short.
#[test]
fn a_rigid_drive_gets_no_resonance_and_a_note_says_what_was_found_and_needed() {
    let fine = on_circles(3.004, &[25.0, -25.0, 10.0, -10.0]);
    let coarse = |(column, text): (usize, &str)| match text.parse::<f64>() {
        Ok(value) if column == 2 || column == 4 => format!("{value:.3}"),
        _ => text.to_owned(),
    };
    let line = |line: &str| line.split(',').enumerate().map(coarse).collect::<Vec<_>>().join(",");
    let folder = folder(&fine.lines().map(line).collect::<Vec<_>>().join("\n"));
    let found = folder.json(&[&CALL[..], &["--find-resonance", "--json", "-o", "found"]].concat());
    for axis in found["axes"].as_array().unwrap() {
        assert!(axis["resonance"].is_null(), "{axis}");
        let why = axis["resonance_not_found"].as_str().unwrap();
        assert!(why.starts_with("found a gain of ") && why.contains(", needed 40: "), "{why}");
        let note = format!("axis {}: resonance not found: {why}", axis["axis"].as_str().unwrap());
        let notes = found["warnings"].as_array().unwrap();
        assert!(notes.iter().any(|said| said.as_str().unwrap().starts_with(&note)), "{note} in {notes:?}");
    }
    let text = folder.read("found/machine.toml");
    assert!(text.contains("[axis.X.friction]") && !text.contains("resonance_hz = "), "{text}");
}
