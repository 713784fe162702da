//! Absurd numbers on the command line: every command refuses them, and the controller accepts every machine that a command has
//! accepted.

use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

/// Expects a refusal with a short message.
fn bad(directory: &Folder, arguments: &[&str], parts: &[&str]) {
    let error = directory.bad(arguments, parts);
    assert!(error.len() < 400, "{arguments:?}: {error}");
}

const MACHINE: &str = "name = \"m\"\nchain = \"w b X Y Z t\"\n[axis.X]\ntable = \"x.csv\"\ntravel_mm = [-100, 100]\n";

fn machine(directory: &Folder, lines: &str, table: &str) {
    directory.write("m/machine.toml", format!("{MACHINE}{lines}"));
    directory.write("m/x.csv", table);
}

#[test]
fn settings_and_tables_out_of_this_world() {
    let directory = Folder::new(TRUEAXIS);
    const TABLE: &str = "X_mm,EXX_um\n-100,1\n100,2\n";
    for (lines, table, parts) in [
        ("backlash_um = 1e308\n", TABLE, &["machine.toml:6", "backlash_um", "found 1e308", "-1000 to 1000 um"][..]),
        ("hysteresis_um = 1e308\n", TABLE, &["machine.toml:6", "hysteresis_um", "0 to 100 um"]),
        ("[axis.X.thermal]\noffset_um_per_k = 1e308\n", TABLE, &["machine.toml:7", "offset_um_per_k", "um/K"]),
        ("[contour]\nmax_lag_mm = 5000\n", TABLE, &["machine.toml:7", "max_lag_mm", "found 5000", "0.001 to 1000 mm"]),
        ("", "X_mm,EXX_um\n-100,3100\n100,3100\n", &["x.csv:2", "EXX_um", "found 3100 um", "is the unit right?"]),
        ("", "X_mm,EXX_um\n-100,1e308\n100,1e308\n", &["x.csv:2", "EXX_um"]),
    ] {
        machine(&directory, lines, table);
        bad(&directory, &["tables", "check", "m"], parts);
        bad(&directory, &["tables", "compile", "m", "-o", "m.tcomp"], parts);
        assert!(!directory.has("m.tcomp"));
    }
}

#[test]
fn limits_that_the_step_cannot_resolve_at_its_rate_are_refused() {
    let directory = Folder::new(TRUEAXIS);
    machine(&directory, "[axis.X.limits]\nacceleration_mm_per_s2 = 1\n", "X_mm,EXX_um\n-100,1\n100,2\n");
    let parts = ["at 10000 Hz", "machine.toml:", "key axis.X.limits.acceleration_mm_per_s2", "above the resolution"];
    bad(&directory, &["tables", "check", "m"], &parts);
    bad(&directory, &["tables", "compile", "m", "-o", "m.tcomp"], &parts);
    for rate in ["0", "-1", "nan", "1e308"] {
        bad(&directory, &["tables", "compile", "m", &format!("--rate-hz={rate}"), "-o", "m.tcomp"], &["--rate-hz"]);
    }
    assert!(!directory.has("m.tcomp"));
    let output = directory.run(&["tables", "compile", "m", "--rate-hz", "1000", "-o", "m.tcomp"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn measurements_and_other_controls_files() {
    let directory = Folder::new(TRUEAXIS);
    for value in ["1e308", "-1e308", "3100"] {
        let rows = format!("X_mm,run,direction,deviation_um\n0,1,+,1\n0,2,+,{value}\n10,1,+,1\n10,2,+,1\n");
        directory.write("d.csv", &rows);
        bad(&directory, &["tables", "accuracy", "d.csv"], &["d.csv:3", "deviation_um", "is the unit right?"]);
        let import = ["tables", "import", "--from", "iso230-2", "d.csv", "-o", "new"];
        bad(&directory, &import, &["d.csv:3", "deviation_um", "is the unit right?"]);
        directory.write("x.comp", format!("0 0 0\n10 {value} {value}\n"));
        let import = ["tables", "import", "--from", "linuxcnc", "--unit", "mm", "x.comp", "--axis", "X", "-o", "new"];
        bad(&directory, &import, &["x.comp:2", "EXX", "is the unit right?"]);
        assert!(!directory.has("new"));
    }
    machine(&directory, "", "X_mm,EXX_um\n-100,1\n100,2\n");
    directory.write("p.csv", "x_mm,y_mm,z_mm\n1,1e308,0\n");
    bad(&directory, &["compensate", "m", "p.csv"], &["p.csv:2", "y_mm", "1e308"]);
    directory.write("h.csv", "h1_um,h2_um,h3_um\n1,1e9,0\n");
    let roundness = ["roundness", "h.csv", "--n", "64", "--p", "12", "--q", "41", "--harmonics", "2..5"];
    bad(&directory, &roundness, &["h.csv:2", "h2_um", "1e9"]);
}
