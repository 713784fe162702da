//! Commands killed at points in time, and run concurrently.

use super::*;
use std::process::Stdio;
use std::time::{Duration, Instant};

#[test]
fn killed_at_many_moments_the_file_is_the_old_or_the_new_one() {
    let folder = machines();
    folder.reported(&COMPILE);
    let new = fs::read(folder.join("t.tcomp")).unwrap();
    let started = Instant::now();
    folder.reported(&COMPILE);
    let whole = started.elapsed();
    let old = b"old".to_vec();
    let mut seen = [0; 2];
    for n in 0..200u32 {
        fs::write(folder.join("t.tcomp"), &old).unwrap();
        let mut child = folder.command(&COMPILE).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(whole.mul_f64(1.2 * f64::from(n) / 200.0));
        let _ = child.kill();
        child.wait().unwrap();
        let (found, left) = files(folder.path());
        let found = &found[&folder.join("t.tcomp")];
        assert!(*found == old || *found == new, "{} bytes of {}", found.len(), new.len());
        assert!(left.len() <= 1, "what the last one left is swept by the next: {left:?}");
        seen[usize::from(*found == new)] += 1;
    }
    assert!(seen[0] > 0, "never before its end: {seen:?}");
    folder.reported(&COMPILE);
    let (found, left) = files(folder.path());
    assert_eq!((&found[&folder.join("t.tcomp")], left.len()), (&new, 0));
}

/// Two commands write the same file at once: one of the two files remains, complete, and neither command removes the other's
/// temporary file.
#[test]
fn two_simultaneous_commands_leave_the_file_of_one() {
    let folder = machines();
    let news = ["m", "other"].map(|machine| {
        folder.reported(&["tables", "compile", machine, "-o", "t.tcomp"]);
        fs::read(folder.join("t.tcomp")).unwrap()
    });
    let end = Instant::now() + Duration::from_secs(2);
    while Instant::now() < end {
        let children = ["m", "other", "m", "other"].map(|machine| {
            folder.command(&["tables", "compile", machine, "-o", "t.tcomp"]).stderr(Stdio::null()).spawn()
        });
        for child in children {
            assert!(child.unwrap().wait().unwrap().success());
        }
        let (found, left) = files(folder.path());
        assert!(news.contains(&found[&folder.join("t.tcomp")]) && left.is_empty(), "{left:?}");
    }
}
