//! `firmware-sim replay`: the step's inputs and outputs.

use std::path::Path;
use trueaxis_tables::{Machine, compile};
use trueaxis_testing::command::Folder;

const SIMULATOR: &str = env!("CARGO_BIN_EXE_firmware-sim");
/// Three axes; X is 100 µm/m too long (its screw is off by 0.01 mm at 100), the others are perfect.
const SCREW: &str = "name = \"screw\"\nchain = \"w X' Y' b Z t\"\n[axis.X]\ntable = \"x.csv\"\ntravel_mm = [0.0, 100.0]\n\
    max_feed_mm_per_min = 6000.0\n[axis.Y]\ntravel_mm = [0.0, 100.0]\nmax_feed_mm_per_min = 6000.0\n[axis.Z]\n\
    travel_mm = [0.0, 100.0]\nmax_feed_mm_per_min = 6000.0\n";
const X: &str = "X_mm,EXX_um\n0,0\n100,10\n";
const PATH: &str = "G21 G90 F3000\nG1 X60 Y20 Z10\nG1 X40\nG4 P0.2\nM2\n";

fn prepared() -> Folder {
    let folder = Folder::new(SIMULATOR);
    folder.write("machine.toml", SCREW);
    folder.write("x.csv", X);
    folder.write("path.ngc", PATH);
    let compiled = compile(&Machine::read(&folder.join("machine.toml")).unwrap()).unwrap();
    folder.write("screw.tcomp", compiled);
    folder.good(&[
        "record",
        "--machine",
        "machine.toml",
        "--program",
        "path.ngc",
        "--origin-mm",
        "0,0,0",
        "--rate-hz",
        "1000",
        "-o",
        "run.rec",
    ]);
    folder
}

/// The drive position c satisfies x = c + E(c), E = 1e-4 of the travel from the tables' reference, evaluated independently.
#[test]
fn inputs_and_outputs_are_printed_to_the_last_digit() {
    let folder = prepared();
    let (header, rows) = folder.csv(&["replay", "run.rec", "screw.tcomp"]);
    assert_eq!(
        header,
        "x_cmd_mm,y_cmd_mm,z_cmd_mm,x_mm,y_mm,z_mm,x_drive_mm,y_drive_mm,z_drive_mm,elapsed_ns,homed,enable,reset,\
         encoder_alarm,limited,fault"
    );
    // 80 mm at 50 mm/s and a dwell.
    assert!((1_700..3_000).contains(&rows.len()), "{} rows", rows.len());
    let last = rows.last().unwrap();
    assert!((last[0] - 40.0).abs() < 1e-6 && (last[1] - 20.0).abs() < 1e-6, "{last:?}");
    let mut largest = 0.0_f64;
    for row in &rows {
        assert_eq!((row[9], row[10], row[11], row[12], row[13], row[15]), (1e6, 1.0, 1.0, 0.0, 0.0, 0.0), "{row:?}");
        // Axes without a table go to their commands, bit for bit.
        assert_eq!((row[1].to_bits(), row[2].to_bits()), (row[7].to_bits(), row[8].to_bits()), "{row:?}");
        if row[14] == 0.0 {
            largest = largest.max((row[6] + 1e-4 * row[6] - row[0]).abs());
        }
    }
    // The reading follows the drive one cycle later: 50 mm/s · 1 ms · 1e-4.
    assert!(largest < 5.1e-6 && rows.iter().any(|row| row[0] - row[6] > 5e-3), "{largest}");
    folder.good(&["replay", "run.rec", "screw.tcomp", "-o", "run.csv"]);
    let (_, written) = trueaxis_testing::command::csv(&folder.read("run.csv"));
    assert_eq!(written, rows);
    folder.good(&["replay", "run.rec", "screw.tcomp", "-o", "run.csv", "--telemetry", "frames.bin"]);
    // The only zero in a frame is its end.
    let frames = std::fs::read(folder.join("frames.bin")).unwrap();
    assert_eq!(frames.iter().filter(|byte| **byte == 0).count(), rows.len());
}

#[test]
fn unsuitable_recordings_are_refused() {
    let folder = prepared();
    let other = SCREW.replace("screw", "other");
    folder.write("machine.toml", other);
    folder.write("other.tcomp", compile(&Machine::read(&folder.join("machine.toml")).unwrap()).unwrap());
    folder.bad(&["replay", "run.rec", "other.tcomp"], &["run.rec", "another machine than other.tcomp"]);
    folder.bad(&["replay", "run.rec", "path.ngc"], &["path.ngc"]);
    folder.bad(&["replay", "path.ngc", "screw.tcomp"], &["path.ngc"]);
    folder.bad(&["replay", "none.rec", "screw.tcomp"], &["none.rec"]);
    folder.bad(&["replay", "run.rec", "screw.tcomp", "-o", "run.rec"], &["an input is never written"]);
    folder.bad(&["replay", "run.rec", "screw.tcomp", "-o", "screw.tcomp"], &["an input is never written"]);
    let cut = std::fs::read(folder.join("run.rec")).unwrap();
    folder.write("cut.rec", &cut[..cut.len() / 2]);
    folder.bad(&["replay", "cut.rec", "screw.tcomp", "-o", "cut.csv"], &["cut.rec"]);
    assert!(!folder.has("cut.csv"));
    let gauge = Path::new(env!("CARGO_MANIFEST_DIR")).join("cortex-m/machine/machine.toml");
    folder.write("gauge.tcomp", compile(&Machine::read(&gauge).unwrap()).unwrap());
    let gauge = gauge.to_string_lossy();
    folder.good(&[
        "record",
        "--machine",
        &gauge,
        "--program",
        "short-tour",
        "--cycles",
        "200",
        "--rate-hz",
        "1000",
        "-o",
        "gauge.rec",
    ]);
    folder.bad(&["replay", "gauge.rec", "gauge.tcomp"], &["gauge.rec", "with a gauge or", "firmware-sim compare"]);
}
