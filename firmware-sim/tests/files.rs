//! What the simulator's commands do to files: an input is never written, a refused command leaves nothing.

use std::fs;
use std::path::Path;
use std::process::Command;

/// Exit code 2, what it says, and the input as it was.
fn refused(folder: &Path, arguments: &[&str], input: &str) {
    let before = fs::read(folder.join(input)).unwrap();
    let count = fs::read_dir(folder).unwrap().count();
    let output = Command::new(env!("CARGO_BIN_EXE_firmware-sim")).args(arguments).current_dir(folder).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(error.contains("an input is never written"), "{arguments:?}: {error}");
    assert_eq!(fs::read(folder.join(input)).unwrap(), before, "{arguments:?}");
    assert_eq!(fs::read_dir(folder).unwrap().count(), count, "{arguments:?}");
}

#[test]
fn an_input_is_never_written() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../compensation-tables");
    for (sample, file) in [("mill-3axis", "index.html"), ("grinder", "grinding.html"), ("head-5axis", "rtcp.html")] {
        // Any name does for a machine file.
        fs::copy(samples.join(sample).join("machine.toml"), folder.join(file)).unwrap();
        for entry in fs::read_dir(samples.join(sample)).unwrap() {
            let entry = entry.unwrap();
            fs::copy(entry.path(), folder.join(entry.file_name())).unwrap();
        }
        let command = ["run", "grind", "rtcp"]
            [["index.html", "grinding.html", "rtcp.html"].iter().position(|name| *name == file).unwrap()];
        refused(folder, &[command, "--machine", file, "--report", "."], file);
    }
    fs::copy(samples.join("mill-3axis/machine.toml"), folder.join("machine.toml")).unwrap();
    fs::write(folder.join("trace.csv"), "G21 G90 F500\nG1 X1\nM2\n").unwrap();
    refused(folder, &["run", "--machine", "machine.toml", "--program", "trace.csv", "--report", "./"], "trace.csv");
    let record = ["record", "--machine", "machine.toml", "--program", "trace.csv", "--rate-hz", "1000", "-o"];
    for input in ["trace.csv", "machine.toml", "x.csv"] {
        fs::hard_link(folder.join(input), folder.join("hard")).unwrap();
        refused(folder, &[&record[..], &[input]].concat(), input);
        refused(folder, &[&record[..], &["hard"]].concat(), input);
        fs::remove_file(folder.join("hard")).unwrap();
    }
    fs::copy(folder.join("trace.csv"), folder.join("recording.rec")).unwrap();
    refused(
        folder,
        &["compare", "--machine", "machine.toml", "--program", "recording.rec", "--folder", "."],
        "recording.rec",
    );
}

/// The trace is in its place only when the run is over.
#[test]
fn a_run_leaves_its_report_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("p.ngc"), "G21 G90 F3000\nG1 X1\nM2\n").unwrap();
    let run = |report: &str| {
        let arguments = ["run", "--program", "p.ngc", "--rate-hz", "1000", "--report", report];
        Command::new(env!("CARGO_BIN_EXE_firmware-sim")).args(arguments).current_dir(folder.path()).output().unwrap()
    };
    assert!(run("new/report").status.success());
    let mut names: Vec<_> =
        fs::read_dir(folder.path().join("new/report")).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["index.html", "trace.csv"]);
    // A folder stands where the page would: nothing of the run is left beside it.
    fs::create_dir_all(folder.path().join("taken/index.html")).unwrap();
    assert_eq!(run("taken").status.code(), Some(2));
    assert_eq!(fs::read_dir(folder.path().join("taken")).unwrap().count(), 1);
}
