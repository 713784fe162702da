//! `firmware-sim compare --growth`: inputs refused before anything is recorded, built or written.

use std::path::Path;
use trueaxis::tcomp::machine_id;
use trueaxis_tables::Machine;
use trueaxis_testing::command::Folder;

const SIMULATOR: &str = env!("CARGO_BIN_EXE_firmware-sim");
/// Readings of two sensors and the spindle.
const READINGS: &str = "t_s,spindle_rpm,T1_c,T2_c\n0,0,20,20\n1,0,21,20\n2,6000,,20.5\n";

/// A three-axis machine, its compiled growth (grown.ttherm), and readings for it.
fn prepared() -> Folder {
    let folder = Folder::new(SIMULATOR);
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("cortex-m/machine/thermal.toml");
    folder.copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../compensation-tables/mill-3axis"), ".");
    folder.write("path.ngc", "G21 G90 F3000\nG1 X1\nM2\n");
    folder.write("readings.csv", READINGS);
    let machine = Machine::read(&folder.join("machine.toml")).unwrap().settings;
    let text = std::fs::read_to_string(&sample).unwrap();
    let model = trueaxis_evaluation::thermal::model(&text, &sample, &machine).unwrap();
    let id = machine_id(&machine.name, &machine.chain);
    folder.write("grown.ttherm", model.encode(id).unwrap());
    folder.write("other.ttherm", model.encode(id ^ 1).unwrap());
    folder
}

fn with<'a>(growth: &'a str, readings: &'a str) -> [&'a str; 11] {
    [
        "compare",
        "--machine",
        ".",
        "--program",
        "path.ngc",
        "--rate-hz",
        "1000",
        "--growth",
        growth,
        "--temperatures",
        readings,
    ]
}

#[test]
fn growth_that_is_damaged_or_of_another_machine_is_refused() {
    let folder = prepared();
    folder.bad(&with("other.ttherm", "readings.csv"), &["other.ttherm: found on the machine ", ", needed "]);
    folder.bad(&with("readings.csv", "readings.csv"), &["readings.csv: not a file of thermal growth"]);
    let mut bytes = std::fs::read(folder.join("grown.ttherm")).unwrap();
    bytes[40] ^= 4;
    folder.write("damaged.ttherm", &bytes);
    folder.bad(&with("damaged.ttherm", "readings.csv"), &["damaged.ttherm: the file is damaged (its CRC-32 is wrong)"]);
    folder.bad(&with("nowhere.ttherm", "readings.csv"), &["cannot read nowhere.ttherm"]);
}

#[test]
fn bad_readings_are_refused_with_line_and_column() {
    let folder = prepared();
    let refused = |readings: &str, parts: &[&str]| {
        folder.write("bad.csv", readings);
        folder.bad(&with("grown.ttherm", "bad.csv"), parts);
    };
    let columns = "needed t_s, spindle_rpm, T1_c, T2_c for grown.ttherm";
    refused("t_s,spindle_rpm,T1_c\n0,0,20\n1,0,20\n", &["bad.csv: found columns t_s, spindle_rpm, T1_c, ", columns]);
    refused("t_s,spindle_rpm,T1_c,T2_c,T3_c\n0,0,20,20,20\n1,0,20,20,20\n", &["T3_c, needed t_s", columns]);
    refused("t_s,spindle_rpm,T1_c,T3_c\n0,0,20,20\n1,0,20,20\n", &[columns]);
    refused("t_s,T1_c,T2_c\n0,20,20\n1,20,20\n", &["found columns t_s, T1_c, T2_c, ", columns]);
    refused("t_s,rpm,T1_c,T2_c\n", &["bad.csv:1: column rpm", "found rpm, needed one of t_s, spindle_rpm, T1_c"]);
    refused("t_s,spindle_rpm,T1_c,T2_c\n", &["bad.csv: found no rows, needed at least one"]);
    refused("t_s,spindle_rpm,T1_c,T2_c\n0,0,20,20\n", &["bad.csv: found 1 row, needed at least 2"]);
    let row = |replaced: &str| READINGS.replace("2,6000,,20.5", replaced);
    refused(&row("2,6000,warm,20"), &["bad.csv:4: column T1_c: found ", "warm", ", needed"]);
    refused(&row("2,6000,20,nan"), &["bad.csv:4: column T2_c: found ", ", needed"]);
    refused(&row("2,6000,20"), &["bad.csv:4: found 3 values, needed 4"]);
    refused(&row("2,6000,20,-20000"), &["bad.csv:4: column T2_c: found -20000, needed -10000 to 10000"]);
    refused(&row("2,2000000,20,20"), &["bad.csv:4: column spindle_rpm: found 2000000, needed -1000000 to 1000000"]);
    let even = "needed even times, two or more cycles of 0.001 s apart";
    refused(&row("2.5,6000,20,20"), &["bad.csv:4: column t_s: found 2.5, ", even]);
    refused(&row(",6000,20,20"), &["bad.csv:4: column t_s: found nothing, ", even]);
    refused("t_s,spindle_rpm,T1_c,T2_c\n0,0,20,20\n0.001,0,20,20\n", &["bad.csv:3: column t_s: found 0.001, ", even]);
    refused("t_s,spindle_rpm,T1_c,T2_c\n,0,20,20\n1,0,20,20\n", &["bad.csv:2: column t_s: found nothing, ", even]);
    refused("t_s,spindle_rpm,T1_c,T2_c\n1,0,20,20\n0,0,20,20\n", &["bad.csv:3: column t_s: found 0, ", even]);
    let many: String = (0..3000).map(|t| format!("{t},0,20,20\n")).collect();
    let many = format!("t_s,spindle_rpm,T1_c,T2_c\n{many}");
    refused(&many, &["bad.csv: found 3000 rows, with grown.ttherm 36", " bytes, needed at most 32768"]);
}

#[test]
fn readings_are_never_written_and_come_with_growth() {
    let folder = prepared();
    folder.write("warming.bin", READINGS);
    let here = [&with("grown.ttherm", "warming.bin")[..], &["--folder", "."]].concat();
    folder.bad(&here, &["an input is never written"]);
    folder.bad(&["compare", "--growth", "grown.ttherm"], &["--temperatures"]);
    folder.bad(&["compare", "--temperatures", "readings.csv"], &["--growth"]);
}
