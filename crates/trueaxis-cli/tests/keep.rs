//! `trueaxis keep` as called. The tests simulate the machine, its drift and the corrections of its files in a few lines.

use std::path::Path;
use trueaxis_testing::command::{Folder, csv};

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

const MACHINE: &str = "# of my own hand\nname = \"mill\"\nchain = \"w X' Y' b Z t\"\n\n[axis.X] # long\ntravel_mm = [0.0, 500.0]\n\
                       table = \"x.csv\"\n[axis.Y]\ntravel_mm = [0.0, 400.0]\n[axis.Z]\ntravel_mm = [-300.0, 0.0]\n";
const X_CSV: &str = "X_mm,EXX_um\n0,0\n250,3\n500,0\n";

const HEAD: &str = "machine = \"mill\"\ndialect = \"linuxcnc\"\nevery_parts = 10\n";
const PROBE: &str = "[probe]\ntip_radius_mm = 3.0\ntip_uncertainty_um = 20.0\nrepeatability_um = 0.5\n";
const BALL: &str = "[[artefact]]\nname = \"ball\"\nkind = \"ball\"\ndiameter_mm = 25.0\nuncertainty_um = 0.3\n\
                    [[artefact.place]]\nat_mm = [440.0, 340.0, -250.0]\n";
const SECOND: &str = "[[artefact]]\nname = \"second\"\nkind = \"ball\"\ndiameter_mm = 25.0\nuncertainty_um = 0.3\n\
                      [[artefact.place]]\nat_mm = [440.0, 60.0, -150.0]\n";
const OFFSETS: &str = "[[term]]\nnames = [\"offset X\", \"offset Y\", \"offset Z\"]\nlargest_update_um = 15.0\n\
                       largest_total_um = 30.0\n";
const SQUARE: &str = "[[term]]\nnames = [\"C0Y\"]\nlargest_update_urad = 60.0\nlargest_total_urad = 90.0\n";

const BACKLASH: &str = "[[term]]\nnames = [\"backlash X\"]\nlargest_update_um = 8.0\nlargest_total_um = 20.0\n";

/// Errors of the machine beyond those in its initial tables: offsets, µm, C0Y, µrad, and lost motion of X, µm.
#[derive(Clone, Copy, Default)]
struct Drift {
    offset_um: [f64; 3],
    c0y_urad: f64,
    backlash_um: f64,
}

/// A line of machine.toml that states a number.
fn stated(text: &str, key: &str) -> f64 {
    let line = text.lines().find_map(|line| line.strip_prefix(&format!("{key} = ")));
    line.map_or(0.0, |value| value.parse().unwrap())
}

struct Bench<'f> {
    folder: &'f Folder,
    drift: Drift,
    /// Added to the ball's diameter, mm.
    larger: f64,
    /// µm per touch.
    creep_um: f64,
}

impl Bench<'_> {
    /// Error of an axis that its table corrects, mm.
    fn table(&self, axis: usize, q: f64) -> f64 {
        let name = ["mill/x.csv", "mill/y.csv", "mill/z.csv"][axis];
        if !self.folder.has(name) {
            return 0.0;
        }
        let text = self.folder.read(name);
        let (_, rows) = csv(&text.replace("# ", ""));
        let right = rows.iter().position(|row| row[0] >= q).unwrap_or(rows.len() - 1).max(1);
        let (a, b) = (&rows[right - 1], &rows[right]);
        1e-3 * (a[1] + (b[1] - a[1]) * (q - a[0]) / (b[0] - a[0]))
    }

    fn run(&self, program: &str) -> String {
        let toml = self.folder.read("mill/machine.toml");
        let square = 1e-6 * (self.drift.c0y_urad - stated(&toml, "C0Y_urad"));
        let play = 1e-3 * (self.drift.backlash_um - stated(&toml, "backlash_um"));
        let own = |q: f64| 1e-3 * (3.0 - 3.0 * (q - 250.0).abs() / 250.0);
        // Reads each table once per place: it is linear there.
        let ends = [0, 1, 2].map(|axis| [0.0, 1.0].map(|q| self.table(axis, [440.0, 340.0, -250.0][axis] + q)));
        trueaxis_testing::control::run(program, |touch| {
            let creep = 1e-3 * self.creep_um * touch.count;
            let off = |axis: usize| {
                let from = touch.at[axis] - [440.0, 340.0, -250.0][axis];
                let corrected = ends[axis][0] + (ends[axis][1] - ends[axis][0]) * from;
                1e-3 * self.drift.offset_um[axis] - corrected
            };
            let [mut x, y, z] = touch.at;
            x += if touch.reverse[0] { play } else { 0.0 };
            let tip = [x + own(x) + off(0) - square * y + creep, y + off(1), z + off(2)];
            let gap = |centre: [f64; 3]| {
                let away: f64 = (0..3).map(|k| (tip[k] - centre[k]).powi(2)).sum();
                away.sqrt() - 0.5 * (25.0 + self.larger) - 2.992
            };
            gap([440.12, 339.91, -250.2]).min(gap([439.9, 60.1, -150.1]))
        })
    }
}

fn folder(task: &str) -> (Folder, String) {
    let folder = Folder::new(TRUEAXIS);
    folder.write("mill/machine.toml", MACHINE);
    folder.write("mill/x.csv", X_CSV);
    folder.write("keep.toml", task);
    let program = folder.good(&["keep", "plan", "keep.toml"]);
    (folder, program)
}

/// Probes with a drift and writes the log.
fn probe(folder: &Folder, program: &str, drift: Drift) {
    folder.write("look.log", Bench { folder, drift, larger: 0.0, creep_um: 0.0 }.run(program));
}

fn term<'d>(document: &'d serde_json::Value, name: &str) -> &'d serde_json::Value {
    let terms = document["terms"].as_array().unwrap();
    terms.iter().find(|term| term["name"] == name).unwrap_or_else(|| panic!("{name} in {document}"))
}

fn near(found: &serde_json::Value, truth: f64, tolerance: f64) {
    assert!((found.as_f64().unwrap() - truth).abs() < tolerance, "{found} for {truth}");
}

const LOG: [&str; 2] = ["keep.toml", "look.log"];

fn keep<'a>(verb: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    ["keep", verb].into_iter().chain(LOG).chain(more.iter().copied()).collect()
}

/// A folder whose history has begun without drift.
fn begun(task: &str) -> (Folder, String) {
    let (folder, program) = folder(task);
    probe(&folder, &program, Drift::default());
    folder.good(&keep("begin", &["--time", "2026-05-04T06:00:00Z", "--parts", "0"]));
    (folder, program)
}

fn one_ball() -> String {
    format!("{HEAD}tcomp = \"mill.tcomp\"\n{PROBE}{BALL}{OFFSETS}")
}

#[test]
fn terms_from_one_ball_are_written_round_by_round_and_undone() {
    let (folder, program) = begun(&one_ball());
    assert!(!program.contains("M0\n"), "the program must not pause for an operator");
    let drifted = Drift { offset_um: [6.0, 0.0, -9.0], ..Drift::default() };
    probe(&folder, &program, drifted);
    let before = folder.tree();
    let shown = folder.json(&keep("check", &["--json"]));
    assert_eq!(folder.tree(), before, "a check writes nothing");
    near(&term(&shown, "offset X")["value"], 6.0, 0.02);
    near(&term(&shown, "offset Z")["value"], -9.0, 0.02);
    assert_eq!(term(&shown, "offset Y")["verdict"], "keep");
    assert_eq!((shown["updates"].as_u64(), shown["refused"].as_u64()), (Some(2), Some(0)));
    let time = ["--time", "2026-05-04T07:00:00Z", "--parts", "25", "--json", "--report", "out"];
    let applied = folder.json(&keep("apply", &time));
    assert!(
        applied["applied"] == true && applied["notes"][0].as_str().unwrap().contains("25 parts since"),
        "{applied}"
    );
    assert!(folder.read("out/keep.html").trim_end().ends_with("</html>") && folder.has("mill/mill.tcomp"));
    // 6 µm more on every existing line, and no additional line.
    assert_eq!(folder.read("mill/x.csv").lines().count(), 4);
    let middle: f64 = folder.read("mill/x.csv").lines().nth(2).unwrap().split(',').nth(1).unwrap().parse().unwrap();
    assert!((middle - 9.0).abs() < 0.02, "{middle}");
    assert!(folder.read("mill/machine.toml").contains("# of my own hand"));
    // The machine drifts further; re-probing finds the remaining error and adds it.
    probe(&folder, &program, Drift { offset_um: [6.0, 0.0, -14.0], ..Drift::default() });
    let second = folder.json(&keep("apply", &["--json"]));
    near(&term(&second, "offset Z")["value"], -5.0, 0.02);
    near(&term(&second, "offset Z")["to"], -14.0, 0.04);
    assert_eq!(term(&second, "offset X")["verdict"], "keep");
    // Nothing moved, so nothing changes.
    probe(&folder, &program, Drift { offset_um: [6.0, 0.0, -14.05], ..Drift::default() });
    let tables = folder.read("mill/z.csv");
    let third = folder.json(&keep("apply", &["--json"]));
    assert!(third["applied"] == false && folder.read("mill/z.csv") == tables, "{third}");
    // Undo to before the second update, then to before the first.
    let first = |name: &str| folder.read(Path::new("mill/keep/0003").join(name));
    let z = first("z.csv");
    folder.good(&["keep", "undo", "keep.toml"]);
    assert_eq!(folder.read("mill/z.csv"), z);
    folder.good(&["keep", "undo", "keep.toml"]);
    assert_eq!((folder.read("mill/machine.toml"), folder.read("mill/x.csv")), (MACHINE.into(), X_CSV.into()));
    assert!(!folder.has("mill/z.csv"));
    folder.bad(&["keep", "undo", "keep.toml"], &["no update since the beginning"]);
    // An undo can be undone like any other entry: back to before entry 5, the first undo.
    folder.good(&["keep", "undo", "keep.toml", "5"]);
    assert_eq!(folder.read("mill/z.csv"), tables);
    let history = folder.json(&["keep", "history", "keep.toml", "--json"]);
    near(&history.as_array().unwrap().last().unwrap()["totals"]["offset Z"], -14.0, 0.04);
    let text = folder.good(&["keep", "history", "keep.toml"]);
    assert_eq!(text.lines().filter(|line| line.contains("undo, as before entry")).count(), 3, "{text}");
}

#[test]
fn an_undo_to_a_machine_without_tables_takes_the_compiled_file_away() {
    let (folder, program) = folder(&one_ball());
    let bare = MACHINE.replace("table = \"x.csv\"\n", "");
    folder.write("mill/machine.toml", &bare);
    std::fs::remove_file(folder.join("mill/x.csv")).unwrap();
    probe(&folder, &program, Drift::default());
    folder.good(&keep("begin", &[]));
    probe(&folder, &program, Drift { offset_um: [6.0, 0.0, -9.0], ..Drift::default() });
    folder.good(&keep("apply", &[]));
    assert!(folder.has("mill/mill.tcomp") && folder.has("mill/z.csv"));
    folder.good(&["keep", "undo", "keep.toml"]);
    assert_eq!(folder.read("mill/machine.toml"), bare);
    assert!(!folder.has("mill/mill.tcomp") && !folder.has("mill/z.csv"), "nothing to compile is left");
}

#[test]
fn two_balls_determine_a_squareness() {
    let (folder, program) = begun(&format!("{HEAD}{PROBE}{BALL}{SECOND}{OFFSETS}{SQUARE}"));
    probe(&folder, &program, Drift { offset_um: [0.0, 5.0, 0.0], c0y_urad: 40.0, ..Drift::default() });
    let found = folder.json(&keep("apply", &["--json"]));
    near(&term(&found, "C0Y")["value"], 40.0, 0.2);
    near(&term(&found, "offset Y")["value"], 5.0, 0.05);
    let [squareness] = &found["written"].as_array().unwrap()[..] else { panic!("{found}") };
    assert!(squareness["key"] == "location.C0Y_urad" && squareness["why"] == "by the test's own statistics");
    near(&squareness["written"]["value"], 40.0, 0.2);
    let toml = folder.read("mill/machine.toml");
    assert!((stated(&toml, "C0Y_urad") - 40.0).abs() < 0.2 && toml.contains("[uncertainty.location]"), "{toml}");
    // The tables now correct 40 µrad and leave nothing.
    probe(&folder, &program, Drift { offset_um: [0.0, 5.0, 0.0], c0y_urad: 40.0, ..Drift::default() });
    assert_eq!(folder.json(&keep("check", &["--json"]))["updates"], 0);
}

/// Lost motion that grows, and that a new nut then removes: found together with an offset, recorded, and never negative.
#[test]
fn oblique_touches_determine_a_backlash() {
    let (folder, program) = begun(&format!("{HEAD}{PROBE}{BALL}{OFFSETS}{BACKLASH}"));
    let worn = Drift { offset_um: [4.0, 0.0, 0.0], backlash_um: 5.0, ..Drift::default() };
    probe(&folder, &program, worn);
    let found = folder.json(&keep("apply", &["--json"]));
    near(&term(&found, "backlash X")["value"], 5.0, 0.05);
    near(&term(&found, "offset X")["value"], 4.0, 0.05);
    let toml = || folder.read("mill/machine.toml");
    assert!(
        (stated(&toml(), "backlash_um") - 5.0).abs() < 0.05 && toml().contains("[axis.X.uncertainty]"),
        "{}",
        toml()
    );
    probe(&folder, &program, worn);
    assert_eq!(folder.json(&keep("check", &["--json"]))["updates"], 0);
    // With a new nut the tables correct too much: the rest is negative.
    let renewed = Drift { backlash_um: 0.0, ..worn };
    probe(&folder, &program, renewed);
    let found = folder.json(&keep("apply", &["--json"]));
    near(&term(&found, "backlash X")["value"], -5.0, 0.05);
    near(&term(&found, "backlash X")["to"], 0.0, 0.05);
    assert!((0.0..0.05).contains(&stated(&toml(), "backlash_um")), "{}", toml());
    probe(&folder, &program, renewed);
    assert_eq!(folder.json(&keep("check", &["--json"]))["updates"], 0);
    // 9 µm at once indicate a crash, not wear.
    probe(&folder, &program, Drift { backlash_um: 9.0, ..worn });
    let output = folder.run(&keep("apply", &[]));
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(3) && error.contains("backlash X moved by"), "{error}");
}

#[test]
fn out_of_bounds_needs_a_person() {
    let (folder, program) = begun(&one_ball());
    let far = |z: f64| probe(&folder, &program, Drift { offset_um: [0.0, 0.0, z], ..Drift::default() });
    far(22.0);
    let before = folder.tree();
    for verb in ["check", "apply"] {
        let output = folder.run(&keep(verb, &[]));
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(3), "{error}");
        assert!(error.contains("offset Z moved by 22") && error.contains("at most 15.0 µm"), "{error}");
        assert!(String::from_utf8(output.stdout).unwrap().contains("refused"));
        assert_eq!(folder.tree(), before);
    }
    folder.bad(&keep("apply", &["--accept", "offset W"]), &["--accept", "\"offset W\"", "offset X, offset Y"]);
    folder.good(&keep("apply", &["--accept", "offset Z"]));
    // 22 and 12 µm add up to 34, of which 30 are permitted in total.
    far(34.0);
    let output = folder.run(&keep("apply", &[]));
    assert_eq!(output.status.code(), Some(3));
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("would be 34") && error.contains("at most 30.0 µm"), "{error}");
}

#[test]
fn bad_reprobings_are_refused_with_their_line() {
    let (folder, program) = begun(&one_ball());
    let drift = Drift { offset_um: [6.0, 0.0, 0.0], ..Drift::default() };
    let log = Bench { folder: &folder, drift, larger: 0.0, creep_um: 0.0 }.run(&program);
    let lines: Vec<&str> = log.lines().collect();
    let refused = |text: &str, parts: &[&str]| {
        folder.write("look.log", text);
        for verb in ["check", "apply"] {
            folder.bad(&keep(verb, &["--report", "out"]), parts);
        }
    };
    let index = lines.iter().position(|line| line.starts_with("touch 8 ")).unwrap();
    refused(&[&lines[..index], &lines[index + 1..]].concat().join("\n"), &["look.log:", "no touch 8"]);
    refused(&[&lines[..=index], &lines[index..]].concat().join("\n"), &["look.log:", "touch 8 for the second time"]);
    let words: Vec<f64> = lines[index].split(' ').skip(2).map(|word| word.parse().unwrap()).collect();
    let rapid = format!("touch 8 {} {} {} 0 0 0 1", words[0] + 4.0, words[1] + 2.0, words[2]);
    refused(&log.replace(lines[index], &rapid), &["look.log:", "beside its probing move", "rapid"]);
    let identity = log.split_whitespace().nth(2).unwrap().to_owned();
    refused(&log.replace(&identity, "0000abcd"), &["look.log:1:", "program 0000abcd", &identity]);
    refused("", &["look.log", "no touch 1"]);
    let bench = |larger: f64, creep_um: f64| Bench { folder: &folder, drift, larger, creep_um }.run(&program);
    refused(&bench(0.4, 0.0), &["look.log:", "ball at place 1 measured 25.3", "25 mm within 150 µm"]);
    refused(&bench(0.0, 2.0), &["look.log:", "a drift of", "less than the measured errors"]);
    // Applying a log twice would add it twice, and an earlier log does not belong to these tables.
    folder.write("look.log", &log);
    folder.good(&keep("apply", &["--time", "2026-05-04T08:00:00Z", "--parts", "10"]));
    refused(&log, &["history.jsonl", "the log of entry 2 for the second time"]);
    folder.write("look.log", bench(0.0, 0.0));
    folder.bad(&keep("apply", &["--time", "2026-05-04T07:00:00Z"]), &["2026-05-04T07:00:00Z", "before", "entry 2"]);
    folder.bad(&keep("apply", &["--parts", "9"]), &["9 parts, fewer than 10 of entry 2"]);
    folder.bad(&keep("apply", &["--time", "yesterday"]), &["2026-05-04T06:00:00Z"]);
}

#[test]
fn a_machine_changed_by_hand_is_seen() {
    let (folder, program) = begun(&one_ball());
    folder.write("mill/x.csv", X_CSV.replace(",3", ",4"));
    probe(&folder, &program, Drift { offset_um: [6.0, 0.0, 0.0], ..Drift::default() });
    folder.bad(&keep("check", &[]), &["mill", "changed by hand", "entry 1", "--by-hand"]);
    folder.bad(&keep("apply", &[]), &["changed by hand"]);
    folder.good(&keep("apply", &["--by-hand"]));
    folder.good(&["keep", "undo", "keep.toml"]);
    assert_eq!(folder.read("mill/x.csv"), X_CSV.replace(",3", ",4"));
}

/// The history would name a file that an undo may not write.
#[test]
fn a_table_of_another_folder_is_refused_before_anything_is_probed() {
    let (folder, _) = folder(&one_ball());
    for table in ["tables/x.csv", "../x.csv"] {
        folder.write("mill/machine.toml", MACHINE.replace("\"x.csv\"", &format!("{table:?}")));
        folder.write(format!("mill/{table}"), X_CSV);
        folder.bad(&["keep", "plan", "keep.toml"], &[table, "another folder", "beside machine.toml"]);
    }
}

#[test]
fn a_command_interrupted_between_history_and_tables_is_reported_and_recorded() {
    let (folder, program) = begun(&one_ball());
    probe(&folder, &program, Drift { offset_um: [6.0, 0.0, -9.0], ..Drift::default() });
    folder.good(&keep("apply", &[]));
    // The history is written first: this is the state after an interruption right behind it.
    folder.write("mill/machine.toml", MACHINE);
    folder.write("mill/x.csv", X_CSV);
    std::fs::remove_file(folder.join("mill/z.csv")).unwrap();
    let ended = ["before entry 2", "interrupted before it changed them", "2 --by-hand"];
    probe(&folder, &program, Drift { offset_um: [6.0, 0.0, -9.1], ..Drift::default() });
    folder.bad(&keep("apply", &[]), &ended);
    folder.good(&["keep", "undo", "keep.toml", "2", "--by-hand"]);
    assert_eq!((folder.read("mill/machine.toml"), folder.read("mill/x.csv")), (MACHINE.into(), X_CSV.into()));
    let again = folder.json(&keep("apply", &["--json"]));
    near(&term(&again, "offset Z")["to"], -9.1, 0.02);
    // An interruption between the tables: some are new, but machine.toml, which names them, is not.
    folder.write("mill/machine.toml", MACHINE);
    folder.bad(&keep("check", &[]), &["changed by hand", "entry 4"]);
    folder.good(&["keep", "undo", "keep.toml", "4", "--by-hand"]);
    assert_eq!((folder.read("mill/machine.toml"), folder.read("mill/x.csv")), (MACHINE.into(), X_CSV.into()));
}

#[test]
fn a_program_of_one_minute_is_one() {
    let fast = "probe_feed_mm_per_min = 1000.0\nfeed_mm_per_min = 20000.0\n";
    let (folder, _) = folder(&format!("{HEAD}{PROBE}{fast}{BALL}{OFFSETS}"));
    let stderr = folder.reported(&["keep", "plan", "keep.toml", "-o", "look.ngc"]);
    assert!(stderr.contains(" touches, about 1 minute\n"), "{stderr}");
    assert!(folder.read("look.ngc").contains("about 1 minute)"));
}

#[test]
fn a_second_command_at_the_same_time_writes_nothing() {
    let (folder, program) = begun(&one_ball());
    probe(&folder, &program, Drift { offset_um: [6.0, 0.0, -9.0], ..Drift::default() });
    let before = folder.tree();
    let first = std::fs::File::open(folder.join("mill")).unwrap();
    first.lock().unwrap();
    folder.bad(&keep("apply", &[]), &["mill", "another command that is changing this machine"]);
    folder.bad(&["keep", "undo", "keep.toml", "2"], &["mill", "another command that is changing this machine"]);
    folder.good(&keep("check", &[]));
    assert_eq!(folder.tree(), before);
    drop(first);
    folder.good(&keep("apply", &[]));
}

#[test]
fn a_damaged_history_is_refused() {
    let (folder, program) = begun(&one_ball());
    probe(&folder, &program, Drift { offset_um: [6.0, 0.0, 0.0], ..Drift::default() });
    let update = folder.tree();
    folder.bad(&["keep", "undo", "keep.toml", "1"], &["entry 1", "the beginning"]);
    folder.bad(&["keep", "undo", "keep.toml", "7"], &["entry 7", "at most 1"]);
    assert_eq!(folder.tree(), update);
    folder.good(&keep("apply", &[]));
    let history = folder.read("mill/keep/history.jsonl");
    let damaged = |text: String, parts: &[&str]| {
        folder.write("mill/keep/history.jsonl", text);
        folder.bad(&["keep", "history", "keep.toml"], parts);
        folder.bad(&["keep", "undo", "keep.toml"], parts);
    };
    damaged(history[..history.len() - 40].to_owned(), &["history.jsonl:2:", "damaged line"]);
    damaged(history.replace("\"parts\":0", "\"parts\":1"), &["history.jsonl:1:", "check sum"]);
    damaged(history.lines().nth(1).unwrap().to_owned() + "\n", &["history.jsonl:1:", "check sum"]);
    damaged("{}\n".into(), &["history.jsonl:1:"]);
    // A file elsewhere, in a line whose check sum is right.
    let (first, second) = history.split_once('\n').unwrap();
    let check = first.rsplit_once(",\"check\":\"").unwrap().1.strip_suffix("\"}").unwrap();
    let body = second.rsplit_once(",\"check\":\"").unwrap().0.replace("\"x.csv\"", "\"../x.csv\"");
    let sum = trueaxis::tcomp::checksum(format!("{check}{body}").as_bytes());
    damaged(
        format!("{first}\n{body},\"check\":\"{sum:08x}\"}}\n"),
        &["history.jsonl:2:", "\"../x.csv\"", "files of the machine's folder"],
    );
    folder.write("mill/keep/history.jsonl", &history);
    // The saved copy has been changed.
    folder.write("mill/keep/0002/x.csv", "X_mm,EXX_um\n0,0\n500,1\n");
    folder.bad(&["keep", "undo", "keep.toml"], &["keep/0002/x.csv", "as entry 2 kept it"]);
    std::fs::remove_file(folder.join("mill/keep/0002/x.csv")).unwrap();
    folder.bad(&["keep", "undo", "keep.toml"], &["cannot read", "keep/0002/x.csv"]);
    std::fs::remove_file(folder.join("mill/keep/history.jsonl")).unwrap();
    folder.bad(&keep("apply", &[]), &["no beginning", "keep begin"]);
}

#[test]
fn bounds_are_needed_and_bound_something() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("mill/machine.toml", MACHINE);
    folder.write("mill/x.csv", X_CSV);
    let refused = |task: String, parts: &[&str]| {
        folder.write("keep.toml", task);
        folder.bad(&["keep", "plan", "keep.toml", "-o", "look.ngc"], parts)
    };
    let with = |from: &str, to: &str| one_ball().replace(from, to);
    refused(format!("{HEAD}{PROBE}{BALL}"), &["keep.toml", "[[term]]"]);
    refused(with("largest_update_um = 15.0\n", ""), &["keep.toml:17:", "largest_update_um", "found nothing"]);
    refused(
        with("largest_update_um = 15.0", "largest_update_urad = 15.0"),
        &["keep.toml:18: key term.largest_update_urad", "needed largest_update_um: the largest single update"],
    );
    refused(with("largest_update_um = 15.0", "largest_update_um = 0.0"), &["found 0.0", "0.001 to 1000 µm"]);
    refused(with("largest_total_um = 30.0", "largest_total_um = 5000"), &["found 5000", "0.001 to 1000 µm"]);
    refused(with("largest_total_um = 30.0", "largest_total_um = 10.0"), &["found 10.0", "at least 15"]);
    refused(
        with("largest_update_um = 15.0", "largest_update_um = 0.2"),
        &["largest update of 0.2", "this probe can resolve"],
    );
    refused(with("\"offset Y\"", "\"offset X\""), &["\"offset X\" a second time"]);
    refused(with("\"offset Y\"", "\"EX0C\""), &["no C"]);
    refused(with("\"offset Y\"", "\"growth Y\""), &["without a thermal model"]);
    refused(with("\"offset Y\"", "\"colour\""), &["names like"]);
    refused(with("every_parts = 10", "every_parts = 0"), &["keep.toml:3:", "every_parts", "1 to 1000000"]);
    refused(with("every_parts = 10\n", ""), &["every_parts", "found nothing"]);
    refused(with("mill.tcomp", "../mill.tcomp"), &["tcomp", "in the machine's folder"]);
    refused(with("kind = \"ball\"", "kind = \"ring\""), &["not a ball at a fixed place"]);
    // With one ball, only its roundness distinguishes squareness from an offset.
    refused(
        format!("{}{SQUARE}", one_ball()),
        &["for offset X", "the balls and this probe can resolve", "fewer terms"],
    );
}

#[test]
fn growth_goes_into_the_thermal_model() {
    let thermal = "# mine\nreference_temperature_c = 20.0\n[[sensor]]\nname = \"head\"\nknots_c = [15.0, 25.0, 40.0]\n\
                   [axis.Z.sensor.head]\noffset_um = [-5.0, 5.0, 20.0] # of the spindle\n";
    let task = one_ball()
        .replace("\"offset Z\"", "\"growth Z\"")
        .replace("tcomp = ", "thermal = \"thermal.toml\"\nttherm = \"mill.ttherm\"\ntcomp = ");
    let folder = Folder::new(TRUEAXIS);
    folder.write("mill/machine.toml", MACHINE);
    folder.write("mill/x.csv", X_CSV);
    folder.write("mill/thermal.toml", thermal);
    folder.write("keep.toml", task);
    let program = folder.good(&["keep", "plan", "keep.toml"]);
    probe(&folder, &program, Drift::default());
    folder.good(&keep("begin", &[]));
    probe(&folder, &program, Drift { offset_um: [0.0, 0.0, 8.0], ..Drift::default() });
    folder.good(&keep("apply", &[]));
    let text = folder.read("mill/thermal.toml");
    let line = text.lines().find(|line| line.starts_with("offset_um")).unwrap();
    let values: Vec<f64> =
        line.split(['[', ']']).nth(1).unwrap().split(',').map(|v| v.trim().parse().unwrap()).collect();
    for (value, before) in values.iter().zip([-5.0, 5.0, 20.0]) {
        assert!((value - before - 8.0).abs() < 0.02, "{line}");
    }
    assert!(text.contains("# mine") && line.ends_with("# of the spindle") && folder.has("mill/mill.ttherm"), "{text}");
    folder.good(&["keep", "undo", "keep.toml"]);
    assert_eq!(folder.read("mill/thermal.toml"), thermal);
    folder.write("mill/thermal.toml", thermal.replace("[axis.Z", "[axis.X"));
    folder.bad(&keep("apply", &["--by-hand"]), &["no curve of axis Z", "[axis.Z.sensor.NAME]"]);
}
