//! A paced run whose processor is withheld, as a kernel occasionally does for 100 ms.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use trueaxis_testing::command::Folder;

const SIMULATOR: &str = env!("CARGO_BIN_EXE_firmware-sim");
const PERIOD_S: f64 = 1e-3;

fn signal(which: &str, process: u32) {
    let _ = Command::new("kill").args([which, &process.to_string()]).stderr(Stdio::null()).status();
}

/// The number that precedes given words in a note.
fn number(notes: &str, words: &str) -> u64 {
    let before = notes.split(words).next().unwrap();
    before.rsplit(' ').find(|word| !word.is_empty()).unwrap().parse().unwrap_or_else(|_| panic!("{words}: {notes}"))
}

/// Stopped repeatedly for 100 ms: the results equal those of an undisturbed run bit for bit; the missed periods are counted
/// and reported but not made up for, and the run ends that many periods later.
#[test]
fn a_paced_run_that_is_stalled_gives_the_same_results_and_says_what_it_missed() {
    let folder = Folder::new(SIMULATOR);
    folder.write("p.ngc", "G21 G90 F1200\nG1 X20 Y5\nG1 X0 Y0\nM2\n");
    let run = ["run", "--program", "p.ngc", "--rate-hz", "1000", "--trace-every", "1", "--json"];
    let calm = folder.json(&[&run[..], &["--report", "calm"]].concat());

    let mut stalled = folder.command(&[&run[..], &["--paced", "--report", "stalled"]].concat());
    let started = Instant::now();
    let mut child = stalled.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    while child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(300));
        signal("-STOP", child.id());
        std::thread::sleep(Duration::from_millis(100));
        signal("-CONT", child.id());
    }
    let took_s = started.elapsed().as_secs_f64();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();

    for key in ["cycles", "contour_error_um", "faults"] {
        assert_eq!(found[key], calm[key], "{key}");
    }
    for trace in ["trace.csv", "trace-full.csv"] {
        assert_eq!(folder.read(format!("stalled/{trace}")), folder.read(format!("calm/{trace}")), "{trace}");
    }
    let notes = found["notes"].to_string();
    let (cycles, skipped) = (number(&notes, " cycles, "), number(&notes, " periods skipped"));
    let latest_ns = number(&notes, " ns after its deadline");
    assert!(skipped >= 80 && latest_ns >= 80_000_000, "{notes}");
    assert!(number(&notes, " late wake-ups") >= 1 && notes.contains("busy kernel"), "{notes}");
    let least_s = (cycles + skipped) as f64 * PERIOD_S;
    assert!(took_s >= least_s, "{took_s} s for {cycles} cycles and {skipped} periods without: some were made up for");
    assert!(cycles as f64 * PERIOD_S > 1.0, "long enough to be stalled");
}
