//! Every system call that touches a file, under strace: the process is killed at it, the call fails, and the order is checked.

use super::*;
use std::process::Output;

/// System calls that put a file in its place.
const CALLS: [&str; 12] = [
    "openat",
    "write",
    "chmod",
    "fchmod",
    "flock",
    "fsync",
    "rename",
    "renameat",
    "renameat2",
    "link",
    "unlink",
    "close",
];

/// A command of several files: three tables and `machine.toml`.
const IMPORT: [&str; 7] = ["tables", "import", "--from", "isg", "new.csv", "-o", "m"];

/// Two machines, and a file of the second in another control's format to import into the first; `None` without strace.
fn to_import() -> Option<Folder> {
    if !has("strace") {
        return None;
    }
    let folder = machines();
    folder.reported(&["tables", "export", "--to", "isg", "other", "-o", "new.csv"]);
    Some(folder)
}

/// Runs the import under strace, which filters by `expressions` and writes the calls to `to`; `None` if tracing is not
/// permitted.
fn traced(folder: &Folder, expressions: &[&str], to: &str) -> Option<Output> {
    let mut strace = Command::new("strace");
    strace.args(["-f", "-qq", "-y", "-o", to]).args(expressions.iter().flat_map(|expression| ["-e", expression]));
    let done = strace.arg(TRUEAXIS).args(IMPORT).current_dir(folder.path()).output().unwrap();
    // Exit code 1 comes from strace: the command returns 0 or 2.
    if done.status.code() == Some(1) {
        eprintln!("not tested: strace may not trace here: {}", text(&done.stderr));
        return None;
    }
    Some(done)
}

/// A command that writes several files is killed: each file is the old or the new one, and if the files do not belong
/// together, every command that reads them reports it.
#[test]
fn killed_at_any_system_call_a_machine_is_old_or_new_or_said_to_be_neither() {
    let Some(folder) = to_import() else { return };
    let (old, _) = files(&folder.join("m"));
    folder.reported(&IMPORT);
    let (new, _) = files(&folder.join("m"));
    let changed = old.iter().filter(|(path, bytes)| new[*path] != **bytes).count();
    assert!(changed >= 3, "{changed} files differ");
    let mut seen = [0; 3];
    for call in CALLS {
        for nth in 1.. {
            for (path, bytes) in &old {
                fs::write(path, bytes).unwrap();
            }
            let expressions = [format!("trace={call}"), format!("inject={call}:signal=KILL:when={nth}")];
            let Some(done) = traced(&folder, &expressions.each_ref().map(String::as_str), "/dev/null") else {
                assert_eq!(seen, [0; 3], "strace may trace, and then may not");
                return;
            };
            let (found, left) = files(&folder.join("m"));
            assert_eq!(found.len(), old.len());
            for (path, bytes) in &found {
                assert!(*bytes == old[path] || *bytes == new[path], "{}: {}", path.display(), text(bytes));
            }
            let mixed = found != old && found != new;
            assert!(!mixed || !left.is_empty(), "mixed, and nothing reports it: {call} {nth}");
            if !left.is_empty() {
                let said = folder.reported(&["tables", "check", "m"]);
                for left in &left {
                    let name = left.file_name().unwrap().to_str().unwrap();
                    assert!(said.contains(name) && said.contains("repeat it"), "{said}");
                }
                folder.reported(&IMPORT);
                let (again, left) = files(&folder.join("m"));
                assert!(again == new && left.is_empty(), "the command repeated: {left:?}");
            }
            seen[if mixed { 2 } else { usize::from(found == new) }] += 1;
            if done.status.success() {
                break;
            }
        }
    }
    assert!(seen[0] > 20 && seen[1] > CALLS.len() && seen[2] >= changed - 1, "old, new, mixed: {seen:?}");
}

/// All data is on disk before the first file is renamed, and the folder's entries are flushed last.
#[test]
fn everything_is_flushed_before_the_first_rename_and_the_folder_after_the_last() {
    let Some(folder) = to_import() else { return };
    let trace = ["trace=fsync,fdatasync,rename,renameat,renameat2"];
    let Some(done) = traced(&folder, &trace, "calls") else { return };
    assert!(done.status.success(), "{}", text(&done.stderr));
    let calls = folder.read("calls");
    let of = |line: &str| {
        let what = if line.contains("sync(") { "flush" } else { "rename" };
        if line.contains(UNFINISHED) || what == "rename" { what } else { "folder" }
    };
    let order: Vec<&str> = calls.lines().filter(|line| line.contains('(')).map(of).collect();
    let files = order.iter().filter(|what| **what == "flush").count();
    assert!(files >= 3, "{calls}");
    let expected = [vec!["flush"; files], vec!["rename"; files], vec!["folder"]].concat();
    assert_eq!(order, expected, "{calls}");
}

/// A disk fails at the flush: the error is reported and nothing has changed.
#[test]
fn a_failed_flush_is_reported_and_changes_nothing() {
    let Some(folder) = to_import() else { return };
    let before = folder.tree();
    for nth in 1..=3 {
        let inject = format!("inject=fsync:error=EIO:when={nth}");
        let Some(done) = traced(&folder, &["trace=fsync", &inject], "/dev/null") else { return };
        let said = text(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{said}");
        assert!(said.contains("cannot write ") && said.contains("Input/output error"), "{said}");
        assert_eq!(folder.tree(), before);
    }
}

/// A rename fails after others have succeeded: the message says which files are new.
#[test]
fn a_rename_that_fails_after_another_says_which_files_are_new() {
    let Some(folder) = to_import() else { return };
    let inject = "inject=rename,renameat,renameat2:error=EIO:when=2";
    let Some(done) = traced(&folder, &["trace=rename,renameat,renameat2", inject], "/dev/null") else { return };
    let said = text(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{said}");
    let new = said.split("already written: ").nth(1).expect(&said);
    assert!(said.contains("cannot write ") && new.contains(".csv: Input/output error"), "{said}");
}
