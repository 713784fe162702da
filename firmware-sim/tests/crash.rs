//! A simulation that is killed at any moment, or runs out of disk space, leaves each file old or new.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;
use trueaxis_testing::command::Folder;
use trueaxis_testing::share::share;

const SIMULATOR: &str = env!("CARGO_BIN_EXE_firmware-sim");
const UNFINISHED: &str = ".trueaxis-tmp";
const RUN: [&str; 10] =
    ["run", "--program", "p.ngc", "--rate-hz", "1000", "--trace-every", "1", "--report", "out", "--json"];
const NAMES: [&str; 3] = ["index.html", "trace-full.csv", "trace.csv"];

fn folder() -> Folder {
    let folder = Folder::new(SIMULATOR);
    folder.write("p.ngc", "G21 G90 F3000\nG1 X10 Y4\nG1 X0 Y0\nM2\n");
    folder
}

/// Complete files by name, and the number of unfinished ones.
fn files(folder: &Path) -> (BTreeMap<String, Vec<u8>>, usize) {
    let mut found = BTreeMap::new();
    let mut left = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        if name.ends_with(UNFINISHED) {
            left += 1;
        } else {
            found.insert(name, fs::read(entry.path()).unwrap());
        }
    }
    (found, left)
}

/// Killed, or interrupted by Ctrl-C, at many moments during a run and after its end: 24, and ten times as many in the
/// campaign, which lie closer to the moment at which the files are put in place.
#[test]
fn a_run_that_is_killed_or_interrupted_leaves_each_file_old_or_new() {
    let folder = folder();
    let started = Instant::now();
    folder.good(&RUN);
    let whole = started.elapsed();
    let traces = |found: &BTreeMap<String, Vec<u8>>| [&NAMES[1], &NAMES[2]].map(|name| found[*name].clone());
    let new = traces(&files(&folder.join("out")).0);
    let mut seen = [0; 2];
    let moments = share(240).max(2) as u32;
    for n in 0..moments {
        for name in NAMES {
            fs::write(folder.join("out").join(name), "old").unwrap();
        }
        let mut child = folder.command(&RUN).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        // The moments are the point: each strikes a run elsewhere. However busy the machine is, the last run ends undisturbed.
        if n + 1 < moments {
            std::thread::sleep(whole.mul_f64(1.3 * f64::from(n) / f64::from(moments)));
            let signal = if n % 2 == 0 { "-KILL" } else { "-INT" };
            Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status().unwrap();
        }
        let status = child.wait().unwrap();
        assert!(status.success() || status.signal().is_some(), "{status}");
        let (found, left) = files(&folder.join("out"));
        assert_eq!(found.keys().map(String::as_str).collect::<Vec<_>>(), NAMES);
        assert!(left <= NAMES.len(), "what the last one left is swept by the next: {left}");
        for (trace, new) in traces(&found).iter().zip(&new) {
            assert!(trace == b"old" || trace == new, "{} bytes of {}", trace.len(), new.len());
            seen[usize::from(trace == new)] += 1;
        }
        let page = String::from_utf8(found[NAMES[0]].clone()).unwrap();
        assert!(page == "old" || page.trim_end().ends_with("</html>"), "{} bytes", page.len());
        // The page is put in place last: if it is new, all files are.
        assert!(page == "old" || traces(&found) == new);
    }
    assert!(seen[0] > 0 && seen[1] > 0, "old {}, new {}", seen[0], seen[1]);
    folder.good(&RUN);
    assert_eq!(files(&folder.join("out")).1, 0);
}

/// The disk fills up in the middle of a trace: the error names the file, all old files remain, and no new one stays
/// behind.
#[test]
fn a_disk_that_fills_during_a_trace_is_reported_and_the_old_files_remain() {
    if !Command::new("prlimit").arg("--version").output().is_ok_and(|done| done.status.success()) {
        return eprintln!("not tested: found no prlimit");
    }
    let folder = folder();
    folder.good(&RUN);
    let longest = files(&folder.join("out")).0.values().map(Vec::len).max().unwrap();
    for name in NAMES {
        fs::write(folder.join("out").join(name), "old").unwrap();
    }
    let before = folder.tree();
    // At multiples of 512-byte blocks, and one byte before the end.
    let limits = (0..longest).step_by(512 * longest.div_ceil(512 * 8)).chain([longest - 1]);
    for limit in limits {
        // Ignore the signal, which would end the process silently.
        let script = format!("trap '' XFSZ; exec prlimit --fsize={limit} {SIMULATOR} {}", RUN.join(" "));
        let done = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
        let said = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(2), "{limit}: {said}");
        assert!(said.contains("cannot write out/") && said.contains("File too large"), "{said}");
        assert_eq!(folder.tree(), before, "{limit}");
    }
}
