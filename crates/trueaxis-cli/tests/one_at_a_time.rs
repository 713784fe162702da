//! Concurrent commands that change one machine.

use std::fs::File;
use std::process::Stdio;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

const REFUSED: &str = "found another command that is changing this machine, needed it to end: try again";

/// A machine without tables, and one table of the control.
fn bare() -> Folder {
    let folder = Folder::new(TRUEAXIS);
    let axes = ["X", "Y", "Z"].map(|axis| format!("[axis.{axis}]\ntravel_mm = [0, 20]\nbacklash_um = 1\n")).concat();
    folder.write("m/machine.toml", format!("name = \"m\"\nchain = \"w b X Y Z t\"\n{axes}"));
    folder.write("new.comp", "0 0.001 0.002\n10 10.001 10.002\n20 20.001 20.003\n");
    folder
}

fn import<'a>(axis: &'a str, output: &'a str) -> Vec<&'a str> {
    ["tables", "import", "--from", "linuxcnc-0", "--unit", "mm", "new.comp", "--axis", axis, "-o", output].to_vec()
}

/// Each command takes the lock before it reads anything.
#[test]
fn commands_that_change_a_machine_are_refused_while_another_does() {
    let folder = bare();
    let before = folder.tree();
    let first = File::open(folder.join("m")).unwrap();
    first.lock().unwrap();
    for command in [
        import("X", "m"),
        vec!["calibrate", "solve", "task.toml", "log", "-o", "m"],
        vec!["ballbar", "record.csv", "--radius-mm", "100", "--machine", "m", "-o", "m"],
        vec!["evaluate", "step-diagonal", "record.csv", "--machine", "m", "-o", "m"],
        vec!["evaluate", "r-test", "record.csv", "--machine", "m", "-o", "m"],
        vec!["evaluate", "points", "record.csv", "--machine", "m", "-o", "m"],
    ] {
        folder.bad(&command, &["m: ", REFUSED]);
    }
    let other = File::open(folder.join("m/..")).unwrap();
    other.lock().unwrap();
    folder.bad(&["tables", "collapse", "m", "-o", "."], &[".: ", REFUSED]);
    drop(other);
    assert_eq!(folder.tree(), before);
    // Reading is always permitted, and so are commands that do not change this machine.
    folder.good(&["tables", "check", "m"]);
    folder.reported(&import("X", "n"));
    drop(first);
    folder.reported(&import("X", "m"));
}

/// In any order: the machine contains every import that reported success, including into a new machine.
#[test]
fn simultaneous_imports_lose_no_axis() {
    for round in 0..20 {
        let folder = bare();
        let output = if round % 2 == 0 { "m" } else { "new" };
        let begun = ["X", "Y", "Z"].map(|axis| {
            let child = folder.command(&import(axis, output)).stderr(Stdio::piped()).spawn().unwrap();
            (axis, child)
        });
        let done = begun.map(|(axis, child)| (axis, child.wait_with_output().unwrap()));
        let machine = folder.read(format!("{output}/machine.toml"));
        let mut written = 0;
        for (axis, output) in done {
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            if output.status.success() {
                assert!(machine.contains(&format!("table = \"{}.csv\"", axis.to_lowercase())), "{axis}: {machine}");
                written += 1;
            } else {
                // A later import into a new machine does not find its axis in the chain that the first one wrote.
                assert!(said.contains(REFUSED) || said.contains("in the chain"), "{axis}: {said}");
            }
        }
        assert!(written > 0);
        folder.reported(&["tables", "check", output]);
    }
}
