//! No room: a file size limit, a full disk, a read-only disk, a device that accepts nothing.

use super::*;
use std::os::unix::process::ExitStatusExt;
use std::process::Output;

/// The disk is full after any byte: the refusal names the file, the old file remains, and no temporary file does.
#[test]
fn a_file_that_may_not_grow_past_any_byte_is_refused_and_the_old_one_stays() {
    if !has("prlimit") {
        return;
    }
    let folder = machines();
    folder.reported(&COMPILE);
    let new = fs::read(folder.join("t.tcomp")).unwrap();
    fs::write(folder.join("t.tcomp"), "old").unwrap();
    let before = folder.tree();
    for limit in 0..=new.len() {
        // Ignores the signal, which ends a process silently; prlimit, because the shell's ulimit counts blocks.
        let script = format!("trap '' XFSZ; exec prlimit --fsize={limit} {TRUEAXIS} {}", COMPILE.join(" "));
        let done = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
        let said = text(&done.stderr);
        if limit == new.len() {
            assert_eq!(done.status.code(), Some(0), "{said}");
            assert_eq!(fs::read(folder.join("t.tcomp")).unwrap(), new);
        } else {
            assert_eq!(done.status.code(), Some(2), "{limit}: {said}");
            assert!(said.contains("cannot write t.tcomp: File too large"), "{said}");
            assert_eq!(folder.tree(), before, "{limit}");
        }
    }
}

/// The signal of such a limit ends the process: the old file remains, and the next command cleans up.
#[test]
fn ended_by_the_signal_of_a_limit_the_old_file_stays_and_the_next_command_clears_up() {
    if !has("prlimit") {
        return;
    }
    let folder = machines();
    fs::write(folder.join("t.tcomp"), "old").unwrap();
    let script = format!("exec prlimit --fsize=100 {TRUEAXIS} {}", COMPILE.join(" "));
    let done = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
    assert!(done.status.signal().is_some(), "{done:?}");
    let (found, left) = files(folder.path());
    assert_eq!((found[&folder.join("t.tcomp")].as_slice(), left.len()), (b"old".as_slice(), 1));
    folder.reported(&COMPILE);
    let (found, left) = files(folder.path());
    assert!(found[&folder.join("t.tcomp")].len() > 100 && left.is_empty());
}

/// Runs a script in a private mount namespace; `None` if that is not permitted.
fn mounted(folder: &Folder, script: &str) -> Option<Output> {
    let run = |more: &[&str], script: &str| {
        let mut unshare = Command::new("unshare");
        unshare.arg("--mount").args(more).args(["sh", "-c", script]).current_dir(folder.path()).output().ok()
    };
    let may =
        |more: &[&str]| run(more, "mount -t tmpfs -o size=64k none disk").is_some_and(|done| done.status.success());
    fs::create_dir(folder.join("disk")).unwrap();
    let more: &[&str] = match (may(&[]), may(&["--map-root-user"])) {
        (true, _) => &[],
        (_, true) => &["--map-root-user"],
        _ => {
            eprintln!("not tested: mounting is not permitted");
            return None;
        }
    };
    run(more, &format!("set -e; mount -t tmpfs -o size=64k none disk; {script}"))
}

#[test]
fn a_full_disk_is_reported_with_the_file_and_the_old_one_remains() {
    let folder = machines();
    let script = format!(
        "echo old > disk/t.tcomp; cp -r m disk/m; dd if=/dev/zero of=disk/rest bs=1k 2>/dev/null || true; \
         set +e; {TRUEAXIS} tables compile m -o disk/t.tcomp; echo code $?; cat disk/t.tcomp; ls disk; \
         {TRUEAXIS} tables import --from isg new.csv -o disk/m; echo code $?; diff -r m disk/m && echo same"
    );
    folder.reported(&["tables", "export", "--to", "isg", "other", "-o", "new.csv"]);
    let Some(done) = mounted(&folder, &script) else { return };
    let (out, said) = (text(&done.stdout), text(&done.stderr));
    assert_eq!(out, "code 2\nold\nm\nrest\nt.tcomp\ncode 2\nsame\n", "{said}");
    assert!(said.contains("cannot write disk/t.tcomp: No space left on device"), "{said}");
    assert!(said.contains("cannot write disk/m/"), "{said}");
}

#[test]
fn a_folder_that_cannot_be_written_is_reported() {
    let folder = machines();
    let script = format!(
        "echo old > disk/t.tcomp; mount -o remount,ro disk; set +e; {TRUEAXIS} tables compile m -o disk/t.tcomp; \
         echo code $?; cat disk/t.tcomp; {TRUEAXIS} tables collapse m -o disk/new --volume ,,0:100; echo code $?; ls disk"
    );
    let Some(done) = mounted(&folder, &script) else { return };
    let (out, said) = (text(&done.stdout), text(&done.stderr));
    assert_eq!(out, "code 2\nold\ncode 2\nt.tcomp\n", "{said}");
    assert!(said.contains("cannot write disk/t.tcomp: Read-only file system"), "{said}");
    assert!(said.contains("cannot write disk/new: Read-only file system"), "{said}");
}

/// A device is written to directly, never replaced by a file; a write that it refuses is reported.
#[test]
fn a_full_device_is_reported() {
    let folder = machines();
    folder.bad(&["tables", "compile", "m", "-o", "/dev/full"], &["cannot write /dev/full: No space left on device"]);
    folder.reported(&["tables", "compile", "m", "-o", "/dev/null"]);
    for device in ["/dev/full", "/dev/null"] {
        use std::os::unix::fs::FileTypeExt;
        assert!(fs::metadata(device).unwrap().file_type().is_char_device());
    }
    folder.reported(&COMPILE);
    let script = format!("{TRUEAXIS} tables show t.tcomp > /dev/full");
    let done = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
    assert_eq!(done.status.code(), Some(2));
    let said = text(&done.stderr);
    assert!(said.contains("cannot write to the standard output: No space left on device"), "{said}");
}
