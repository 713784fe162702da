//! Consecutive parts: the correction learned from each reduces the next one's error, and applies only to the same path.

use serde_json::Value;
use std::path::Path;
use trueaxis_testing::command::Folder;

const SIMULATOR: &str = env!("CARGO_BIN_EXE_firmware-sim");

fn rms(document: &Value, part: usize) -> f64 {
    document["parts"][part]["contour_error_um"]["rms"].as_f64().unwrap()
}

/// The sample mill without contour feedback, whose integral part would counteract the learned correction.
fn mill_without_feedback(folder: &Folder) {
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("../compensation-tables/mill-3axis");
    folder.copy(&sample, "mill");
    let text = folder.read("mill/machine.toml");
    let sections = text.split("\n[").filter(|section| !section.starts_with("contour.feedback]"));
    folder.write("mill/machine.toml", sections.collect::<Vec<_>>().join("\n["));
}

/// Learned with a grid encoder, with new noise and quantisation in every part; compared with every correction except learning.
#[test]
fn after_three_parts_sixty_percent_of_full_are_left() {
    let folder = Folder::new(SIMULATOR);
    mill_without_feedback(&folder);
    let full =
        folder.json(&["run", "--json", "--rate-hz", "4000"])["contour_error_um"]["full"]["rms"].as_f64().unwrap();
    let law = ["--measured-by", "grid", "--gain", "1", "--cutoff-mm", "0.2"];
    let found = folder
        .json(&[&["learn", "--json", "--parts", "3", "--machine", "mill", "--rate-hz", "4000"], &law[..]].concat());
    let left = [0, 1, 2].map(|part| rms(&found, part));
    assert!(left[2] <= 0.6 * full && left[1] < left[0] && left[2] < left[1], "{full}: {left:?}");
    assert!(found["parts"].as_array().unwrap().iter().all(|part| part["stopped"] == false));
}

/// The full correction leaves little that the encoders can measure: the estimated error falls, and the part never gets worse.
#[test]
fn errors_that_the_encoders_do_not_see_are_not_made_worse() {
    for program in ["circle-diamond-square", "butterfly"] {
        let at = ["--program", program, "--rate-hz", "4000"];
        let found = Folder::new(SIMULATOR).json(&[&["learn", "--json", "--parts", "3"], &at[..]].concat());
        for part in 1..3 {
            assert!(rms(&found, part) < 1.02 * rms(&found, 0), "{program}: {found}");
        }
        let estimated = |part: usize| found["parts"][part]["estimated_um"]["rms"].as_f64().unwrap();
        assert!(estimated(2) < estimated(0), "{program}: {found}");
    }
}

const PROGRAM: &str = "G21 G90 G17 F1500\nG1 X12\nG2 X12 Y-24 J-12\nG1 X0 Y0\nG0 Z5\nM2\n";

#[test]
fn a_part_comes_out_the_same_by_hand() {
    let folder = Folder::new(SIMULATOR);
    folder.write("p.ngc", PROGRAM);
    let at = ["--program", "p.ngc", "--rate-hz", "4000"];
    let all = folder.json(&[&["learn", "--json", "--parts", "2"], &at[..]].concat());
    folder.good(&[&["learn", "--parts", "1", "-o", "1.tlearn"], &at[..]].concat());
    let second = [&["run", "--json", "--learned", "1.tlearn", "--record", "2.csv", "--seed", "2"], &at[..]].concat();
    let second = folder.json(&second);
    assert_eq!(second["contour_error_um"]["full"]["rms"].as_f64().unwrap(), rms(&all, 1));
    assert!(rms(&all, 1) < rms(&all, 0), "{all}");
    // Continue from the second part.
    let third =
        folder.json(&[&["learn", "--json", "--parts", "1", "--learned", "1.tlearn", "--seed", "2"], &at[..]].concat());
    assert_eq!(rms(&third, 0), rms(&all, 1));
    // The record has every cycle; the rapid motion at its end is not measured.
    let record = folder.read("2.csv");
    let head: Vec<&str> = record.lines().take(4).collect();
    assert!(head[0].starts_with("# program_id = ") && head[1].starts_with("# machine_id = "), "{head:?}");
    assert_eq!(head[3], "s_mm,ex_um,ey_um,ez_um,measured");
    assert_eq!(record.lines().count() as u64, 4 + second["cycles"].as_u64().unwrap());
    assert!(record.lines().last().unwrap().ends_with(",0") && record.lines().nth(2000).unwrap().ends_with(",1"));
}

#[test]
fn a_correction_of_another_program_machine_or_length_is_refused() {
    let folder = Folder::new(SIMULATOR);
    folder.write("p.ngc", PROGRAM);
    folder.write("q.ngc", PROGRAM.replace("G1 X12\n", "G1 X6 Y0.001\nG1 X12\n"));
    folder.good(&["learn", "--parts", "1", "--program", "p.ngc", "--rate-hz", "1000", "-o", "1.tlearn"]);
    let table = std::fs::read(folder.join("1.tlearn")).unwrap();
    let refused = |arguments: &[&str], needed: &[&str]| {
        for command in ["run", "learn"] {
            folder.bad(&[&[command, "--rate-hz", "1000"], arguments].concat(), needed);
        }
    };
    let own = ["--program", "p.ngc", "--learned", "1.tlearn"];
    folder.good(&[&["run", "--rate-hz", "1000"], &own[..]].concat());
    refused(&["--program", "q.ngc", "--learned", "1.tlearn"], &["--learned 1.tlearn", "learned on the program"]);
    // The same path at another position on the machine.
    refused(&[&own[..], &["--origin-mm", "1,0,-200"]].concat(), &["learned on the program"]);
    refused(&[&own[..], &["--machine", "mill-5axis"]].concat(), &["--learned 1.tlearn"]);
    folder.write("2.tlearn", &table[..table.len() - 1]);
    refused(&["--program", "p.ngc", "--learned", "2.tlearn"], &["--learned 2.tlearn", "shorter"]);
    folder.write("3.tlearn", "s_mm,ex_um,ey_um,ez_um\n0,0,0,0\n20,0,0,0\n");
    refused(&["--program", "p.ngc", "--learned", "3.tlearn"], &["--learned 3.tlearn", "TRUELRND"]);
    refused(&["--program", "p.ngc", "--learned", "none.tlearn"], &["--learned: cannot read none.tlearn"]);
    // Invalid figures of the law, and an input that must not be overwritten.
    folder.bad(&["learn", "--gain", "2.5"], &["--gain", "2.5", "below 2"]);
    folder.bad(&["learn", "--forget", "0"], &["--forget", "above 0"]);
    folder.bad(&["learn", "--parts", "0"], &["--parts"]);
    folder.bad(&["learn", "--program", "p.ngc", "-o", "p.ngc"], &["an input is never written"]);
    folder.bad(&["run", "--program", "p.ngc", "--record", "p.ngc"], &["an input is never written"]);
}
