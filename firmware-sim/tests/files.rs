//! Effect of the simulator's commands on files: an input is never overwritten, a refused command leaves nothing behind.

use std::fs;
use std::path::Path;
use trueaxis_testing::command::Folder;

const SIMULATOR: &str = env!("CARGO_BIN_EXE_firmware-sim");
const NEVER: &str = "an input is never written";

#[test]
fn an_input_is_never_written() {
    let folder = Folder::new(SIMULATOR);
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../compensation-tables");
    for (sample, file) in [("mill-3axis", "index.html"), ("grinder", "grind.html"), ("head-5axis", "rtcp.html")] {
        folder.copy(&samples.join(sample), ".");
        // A machine file may have any name.
        folder.write(file, folder.read("machine.toml"));
        let command = ["run", "grind", "rtcp"]
            [["index.html", "grind.html", "rtcp.html"].iter().position(|name| *name == file).unwrap()];
        folder.bad(&[command, "--machine", file, "--report", "."], &[NEVER]);
    }
    fs::copy(samples.join("mill-3axis/machine.toml"), folder.join("machine.toml")).unwrap();
    folder.write("trace.csv", "G21 G90 F500\nG1 X1\nM2\n");
    folder.bad(&["run", "--machine", "machine.toml", "--program", "trace.csv", "--report", "./"], &[NEVER]);
    let record = ["record", "--machine", "machine.toml", "--program", "trace.csv", "--rate-hz", "1000", "-o"];
    for input in ["trace.csv", "machine.toml", "x.csv"] {
        fs::hard_link(folder.join(input), folder.join("hard")).unwrap();
        folder.bad(&[&record[..], &[input]].concat(), &[NEVER]);
        folder.bad(&[&record[..], &["hard"]].concat(), &[NEVER]);
        fs::remove_file(folder.join("hard")).unwrap();
    }
    folder.write("recording.rec", folder.read("trace.csv"));
    folder.bad(&["compare", "--machine", "machine.toml", "--program", "recording.rec", "-o", "."], &[NEVER]);
}

/// The trace appears at its path only when the run is over.
#[test]
fn a_run_leaves_its_report_and_nothing_else() {
    let folder = Folder::new(SIMULATOR);
    folder.write("p.ngc", "G21 G90 F3000\nG1 X1\nM2\n");
    let run = |report| ["run", "--program", "p.ngc", "--rate-hz", "1000", "--report", report];
    folder.good(&run("new/report"));
    let mut names: Vec<_> = fs::read_dir(folder.join("new/report")).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["index.html", "trace-full.csv", "trace.csv"]);
    // A folder in the page's place: the run leaves nothing beside it.
    fs::create_dir_all(folder.join("taken/index.html")).unwrap();
    folder.bad(&run("taken"), &[]);
}

/// Traces and figures in columns: all in their places, or none.
#[test]
fn a_run_leaves_its_columns_and_nothing_else() {
    let folder = Folder::new(SIMULATOR);
    folder.write("p.ngc", "G21 G90 F3000\nG1 X1\nM2\n");
    let run = ["run", "--program", "p.ngc", "--rate-hz", "1000", "--parquet", "new/columns"];
    folder.good(&run);
    let files = folder.tree();
    let mut names: Vec<_> = fs::read_dir(folder.join("new/columns")).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["result.parquet", "trace-full.parquet", "trace.parquet"]);
    for name in names {
        let bytes = fs::read(folder.join("new/columns").join(name)).unwrap();
        assert_eq!((&bytes[..4], &bytes[bytes.len() - 4..]), (&b"PAR1"[..], &b"PAR1"[..]));
    }
    // A second run gives the same traces byte for byte; the figures contain measured times.
    folder.good(&run);
    for (path, bytes) in &files {
        let same = fs::read(folder.join(path)).is_ok_and(|again| again == *bytes);
        assert!(same || path.ends_with("result.parquet") || folder.join(path).is_dir(), "{}", path.display());
    }
    folder.write("trace.parquet", "G21 G90 F500\nG1 X1\nM2\n");
    folder.bad(&["run", "--program", "trace.parquet", "--parquet", "."], &[NEVER]);
}
