//! `trueaxis learn` as called: parts made by a simulated linear plant, and every refusal.

use std::fmt::Write;
use trueaxis::learned::Learned;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

const LENGTH: f64 = 20.0;
const HEAD: &str = "# program_id = 1a2b3c4d\n# machine_id = 0x5e6f7a8b\n# length_mm = 20\n";
const COLUMNS: &str = "s_mm,ex_um,ey_um,ez_um\n";

/// A spike and a slow wave, µm.
fn disturbance(s: f64) -> [f64; 3] {
    let spike = 1.5 * (-((s - 8.0) / 0.4).powi(2)).exp();
    [spike, 0.4 * (std::f64::consts::TAU * s / 5.0).sin(), -spike]
}

/// A part made with a correction that the plant applies with a gain.
fn record(table: Option<&[u8]>, gain: f64) -> String {
    let learned = table.map(|table| Learned::<f64>::parse(table).unwrap());
    let mut text = format!("{HEAD}{COLUMNS}");
    for i in 0..=8000 {
        let s = LENGTH * f64::from(i) / 8000.0;
        let u = learned.as_ref().map_or([0.0; 3], |learned| learned.at(s));
        let e: [f64; 3] = std::array::from_fn(|i| disturbance(s)[i] + gain * 1e3 * u[i]);
        writeln!(text, "{s},{},{},{}", e[0], e[1], e[2]).unwrap();
    }
    text
}

#[test]
fn the_residual_falls_from_part_to_part_and_the_tables_count_them() {
    for gain in [0.6, 1.0, 1.4] {
        let directory = Folder::new(TRUEAXIS);
        directory.write("1.csv", record(None, gain));
        let mut left = Vec::new();
        for part in 1..=3 {
            let (this, next, new, old) = (
                format!("{part}.csv"),
                format!("{}.csv", part + 1),
                format!("{part}.tlearn"),
                format!("{}.tlearn", part - 1),
            );
            let mut arguments = vec!["learn", this.as_str(), "--json", "-o", new.as_str()];
            if part > 1 {
                arguments.extend(["--table", old.as_str()]);
            }
            let found = directory.json(&arguments);
            assert_eq!((&found["parts"], &found["program_id"]), (&part.into(), &"1a2b3c4d".into()));
            left.push(found["before"]["rms_um"].as_f64().unwrap());
            if gain == 1.0 && part > 1 {
                // For a plant of gain 1 the prediction comes true.
                let before = directory.json(&["learn", "1.csv", "--json", "-o", "again.tlearn"]);
                let predicted = before["predicted"]["rms_um"].as_f64().unwrap();
                assert!(part > 2 || (predicted - left[1]).abs() < 1e-3 * left[0], "{predicted} {left:?}");
            }
            let table = std::fs::read(directory.join(&new)).unwrap();
            directory.write(&next, record(Some(&table), gain));
        }
        // By the law 1 − L P (f + 1 − L P), 0.345 at a gain of 0.6; Q withholds a little of the spike.
        assert!(left.windows(2).all(|pair| pair[1] < pair[0]) && left[2] < 0.36 * left[0], "{gain}: {left:?}");
    }
}

#[test]
fn the_table_on_the_screen_and_the_page_have_the_figures() {
    let directory = Folder::new(TRUEAXIS);
    directory.write("r.csv", record(None, 1.0));
    let text = directory.good(&["learn", "r.csv", "-o", "t.tlearn", "--report", "out"]);
    for needed in
        ["1a2b3c4d", "20.000 mm, 1 part", "this part", "predicted", "gain 0.7, forgetting 0.98, cut-off 0.4 mm"]
    {
        assert!(text.contains(needed), "{needed}: {text}");
    }
    let page = directory.read("out/learn.html");
    let tree = roxmltree::Document::parse(page.strip_prefix("<!DOCTYPE html>\n").unwrap()).unwrap();
    assert_eq!(tree.descendants().filter(|node| node.has_tag_name("figure")).count(), 2);
    // A table with another cut-off has different nodes, but still belongs.
    let other = ["learn", "r.csv", "--table", "t.tlearn", "--cutoff-mm", "1", "--json", "-o", "u.tlearn"];
    assert_eq!(directory.json(&other)["parts"], 2);
}

/// Unmeasured rows teach nothing and may be far apart.
#[test]
fn stretches_without_a_measurement_are_left_alone() {
    let directory = Folder::new(TRUEAXIS);
    let mut text = format!("{HEAD}s_mm,ex_um,ey_um,ez_um,measured\n");
    for i in 0..=200 {
        let s = 0.1 * f64::from(i);
        if (5.0..10.0).contains(&s) {
            continue;
        }
        let measured = if (4.0..11.0).contains(&s) { 0 } else { 1 };
        writeln!(text, "{s},1,0,0,{measured}").unwrap();
    }
    directory.write("r.csv", text);
    let found = directory.json(&["learn", "r.csv", "--json", "-o", "t.tlearn"]);
    assert!((found["unmeasured"].as_f64().unwrap() - 0.36).abs() < 0.02, "{found}");
    let table = std::fs::read(directory.join("t.tlearn")).unwrap();
    let learned = Learned::<f64>::parse(&table).unwrap();
    assert!(learned.at(7.0)[0].abs() < 1e-9 && (learned.at(2.0)[0] + 0.7e-3).abs() < 1e-6);
}

/// Expects a bad record to be refused with a message that contains all of `needed`, and nothing to be written.
fn refused(text: &str, arguments: &[&str], needed: &[&str]) {
    let directory = Folder::new(TRUEAXIS);
    directory.write("r.csv", text);
    directory.bad(&[&["learn", "r.csv", "-o", "t.tlearn", "--report", "out"], arguments].concat(), needed);
    assert!(!directory.has("t.tlearn") && !directory.has("out"));
}

#[test]
fn gaps_backward_rows_and_wrong_units_are_refused_with_the_numbers() {
    let good = record(None, 1.0);
    let kept = |keep: &dyn Fn(f64) -> bool| {
        let lines = good
            .lines()
            .enumerate()
            .filter(|(i, line)| *i < 4 || line.split(',').next().and_then(|s| s.parse().ok()).is_none_or(keep));
        lines.map(|(_, line)| format!("{line}\n")).collect::<String>()
    };
    let gap = kept(&|s| !(6.0..=7.5).contains(&s));
    refused(&gap, &[], &["r.csv:2405: column s_mm", "no row from 5.9975 to 7.5025 mm", "every 0.2 mm"]);
    refused(&kept(&|s| s < 12.0), &[], &["r.csv:4804", "no row from 11.9975 to 20 mm"]);
    refused(&kept(&|s| s > 3.0), &[], &["r.csv:5", "no row from 0 to 3.0025 mm"]);
    let back = good.replacen("\n10.0025,", "\n9.5,", 1);
    refused(&back, &[], &["r.csv:4006: column s_mm", "found path length 9.5 mm", "at least 10 mm"]);
    // Metres for mm in the head: the rows lie off the path. The other way round they do not reach its end.
    refused(&good.replace("length_mm = 20", "length_mm = 0.02"), &[], &["r.csv:94", "needed 0 to 0.02 mm"]);
    refused(&good.replace("length_mm = 20", "length_mm = 20000"), &[], &["no row from 20 to 20000 mm"]);
    let nanometres = good.replacen("\n8,1.5,", "\n8,1500,", 1);
    refused(&nanometres, &[], &["r.csv:3205: column ex_um", "an error of 1500 µm", "at most 1000 µm"]);
    refused(
        &good.replace("ex_um", "ex_mm"),
        &[],
        &["r.csv:4: column ex_mm", "needed ex_um, or another of s_mm, ex_um"],
    );
    refused(&good.replace(COLUMNS, "s_mm,ex_um,ey_um\n"), &[], &["r.csv:4", "the column ez_um"]);
    refused(&good.replacen("\n8,", "\nnan,", 1), &[], &["r.csv:3205: column s_mm", "nan", "finite"]);
    refused(&format!("{HEAD}{COLUMNS}"), &[], &["r.csv", "no rows"]);
    let flag = format!("{HEAD}s_mm,ex_um,ey_um,ez_um,measured\n0,0,0,0,1\n0.1,0,0,0,2\n");
    refused(&flag, &[], &["r.csv:6: column measured", "found 2", "0 or 1"]);
    let none = format!("{HEAD}s_mm,ex_um,ey_um,ez_um,measured\n0,0,0,0,0\n20,0,0,0,0\n");
    refused(&none, &[], &["r.csv", "no row with a measured error"]);
}

#[test]
fn the_head_of_a_record_is_checked() {
    let good = record(None, 1.0);
    refused(&good.replace("# program_id = 1a2b3c4d\n", ""), &[], &["r.csv", "no program_id", "# program_id = …"]);
    refused(&good.replace("# length_mm = 20\n", ""), &[], &["r.csv", "no length_mm"]);
    refused(&good.replace("0x5e6f7a8b", "mill"), &[], &["r.csv:2: machine_id", "\"mill\"", "hexadecimal"]);
    refused(&good.replace("1a2b3c4d", "1a2b3c4d5"), &[], &["r.csv:1: program_id", "1a2b3c4d5"]);
    for length in ["0", "-20", "nan", "inf", "20 m", ""] {
        let text = good.replace("length_mm = 20", &format!("length_mm = {length}"));
        refused(&text, &[], &["r.csv:3: length_mm", &format!("{length:?}")]);
    }
    let twice = good.replace("# length_mm = 20\n", "# length_mm = 20\n# length_mm = 21\n");
    refused(&twice, &[], &["r.csv:4", "length_mm again", "line 3"]);
}

#[test]
fn a_table_of_another_program_length_or_machine_is_refused() {
    let directory = Folder::new(TRUEAXIS);
    let good = record(None, 1.0);
    directory.write("r.csv", &good);
    directory.good(&["learn", "r.csv", "-o", "old.tlearn"]);
    let against = |text: String, needed: &[&str]| {
        directory.write("s.csv", text);
        directory.bad(&["learn", "s.csv", "--table", "old.tlearn", "-o", "new.tlearn"], needed);
        assert!(!directory.has("new.tlearn"));
    };
    against(good.replace("1a2b3c4d", "1a2b3c4e"), &["--table old.tlearn", "program 1a2b3c4d", "needed 1a2b3c4e"]);
    against(good.replace("5e6f7a8b", "1"), &["--table old.tlearn", "machine 5e6f7a8b", "needed 00000001"]);
    let length = good.replace("length_mm = 20", "length_mm = 20.1");
    against(length, &["a path of 20.000000 mm", "needed 20.100000 mm"]);
    let mut damaged = std::fs::read(directory.join("old.tlearn")).unwrap();
    damaged[60] ^= 4;
    directory.write("old.tlearn", damaged);
    against(good.clone(), &["--table old.tlearn", "CRC-32"]);
    directory.write("old.tlearn", "s_mm,ex_um");
    against(good.clone(), &["--table old.tlearn", "TRUELRND"]);
    directory.bad(&["learn", "r.csv", "--table", "none.tlearn", "-o", "new.tlearn"], &["none.tlearn"]);
    // Never over an input.
    directory.bad(&["learn", "r.csv", "-o", "./r.csv"], &["r.csv", "an input is never written"]);
}

#[test]
fn figures_of_the_law_are_refused_with_their_range() {
    let good = record(None, 1.0);
    for (option, value, needed) in [
        ("--gain", "0", "below 2"),
        ("--gain", "2", "below 2"),
        ("--gain", "-1", "above 0"),
        ("--gain", "nan", "above 0"),
        ("--forget", "1.1", "at most 1"),
        ("--forget", "0", "above 0"),
        ("--cutoff-mm", "0.001", "0.01 to 1000"),
        ("--cutoff-mm", "inf", "0.01 to 1000"),
    ] {
        refused(&good, &[option, value], &[option, needed]);
    }
}
