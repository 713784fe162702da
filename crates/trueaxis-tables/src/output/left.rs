//! Leftover files of a command that ended while it wrote: through a kill, a power failure or Ctrl-C.
//!
//! A file is written under the name `NAME.XXXXXX.trueaxis-tmp` beside NAME (six letters or digits), and its writer holds a
//! lock on it. The lock ends with the process, so a file without a lock is a leftover.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

/// Suffix of the name of a file that is being written.
pub const UNFINISHED: &str = ".trueaxis-tmp";

/// Letters between the name of the file and [`UNFINISHED`].
pub(super) const LETTERS: usize = 6;

/// Leftovers beside `output` from ended commands that were writing it. Files of a command that is still running are not
/// listed.
///
/// A leftover beside a machine's file indicates that a command that writes several files may have ended between two of them.
pub fn leftovers(output: &Path) -> Vec<PathBuf> {
    let mut left = unfinished(output);
    left.retain(|path| nobodys(path).is_some());
    left.sort();
    left
}

/// Unfinished files for `output`, whoever writes them.
fn unfinished(output: &Path) -> Vec<PathBuf> {
    let target = super::resolved(output);
    let (Some(folder), Some(name)) = (target.parent(), target.file_name().and_then(|name| name.to_str())) else {
        return Vec::new();
    };
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let of_this = |entry: &fs::DirEntry| {
        let is_ours = entry.file_name().to_str().is_some_and(|other| becomes(other) == Some(name));
        is_ours && entry.file_type().is_ok_and(|kind| kind.is_file())
    };
    entries.flatten().filter(of_this).map(|entry| entry.path()).collect()
}

/// A sentence on every leftover beside these files, for a command that reads them.
pub fn left_notes(files: impl IntoIterator<Item = PathBuf>) -> Vec<String> {
    let of = |file: PathBuf| leftovers(&file).into_iter().map(move |left| (left, file.clone()));
    let say = |(left, file): (PathBuf, PathBuf)| {
        format!(
            "{}: left by a command that was interrupted while it wrote {}; its other files may already be new: repeat it",
            left.display(),
            file.display()
        )
    };
    files.into_iter().flat_map(of).map(say).collect()
}

/// Removes leftovers beside `output`, each under its lock: otherwise whoever begins a file of that name could take the lock
/// between the check and the removal, and find the file gone at the end.
pub(super) fn sweep(output: &Path) {
    for path in unfinished(output) {
        if let Some(_held) = nobodys(&path) {
            // Another command may have removed it first, and a file that cannot be removed does no harm.
            let _ = fs::remove_file(path);
        }
    }
}

/// The name of the target of a file with this name.
fn becomes(name: &str) -> Option<&str> {
    let stem = name.strip_suffix(UNFINISHED)?;
    let (target, letters) = stem.rsplit_once('.')?;
    let drawn = letters.len() == LETTERS && letters.bytes().all(|b| b.is_ascii_alphanumeric());
    (drawn && !target.is_empty()).then_some(target)
}

/// The file with its lock, if nobody else has locked it.
fn nobodys(path: &Path) -> Option<File> {
    // A network file system locks only files open for writing; a write-protected file can still be read.
    let file = OpenOptions::new().write(true).open(path).or_else(|_| File::open(path)).ok()?;
    // If locks are not supported, or the file is another user's, it is not reported.
    file.try_lock().is_ok().then_some(file)
}

/// Takes the lock that [`leftovers`] checks. `false`: another command took the file for a leftover and has removed it or is
/// about to.
pub(super) fn hold(file: &File, path: &Path) -> bool {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => false,
        // Without locks nobody takes it for a leftover.
        Err(TryLockError::Error(_)) => true,
        Ok(()) => path.exists(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Staged;
    use std::io::Write;

    #[test]
    fn only_names_of_temporary_files_are_recognised() {
        assert_eq!(becomes("a.tcomp.Ab12Cd.trueaxis-tmp"), Some("a.tcomp"));
        assert_eq!(becomes("a.b.c.000000.trueaxis-tmp"), Some("a.b.c"));
        for other in
            ["a.tcomp", "a.backup.tmp", "a.Ab12C.trueaxis-tmp", "a.Ab-2Cd.trueaxis-tmp", ".Ab12Cd.trueaxis-tmp"]
        {
            assert_eq!(becomes(other), None, "{other}");
        }
    }

    /// A new writer of the same file removes an abandoned temporary file, but neither one that is still being written nor any
    /// other file.
    #[test]
    fn only_what_was_left_is_swept() {
        let folder = tempfile::tempdir().unwrap();
        let [output, left, other, user] =
            ["a.csv", "a.csv.Ab12Cd.trueaxis-tmp", "b.csv.Ab12Cd.trueaxis-tmp", "a.csv.backup.tmp"]
                .map(|name| folder.path().join(name));
        for path in [&left, &other, &user] {
            fs::write(path, "half").unwrap();
        }
        let mut at_work = Staged::create(&output).unwrap();
        assert!(!left.exists() && other.exists() && user.exists());
        fs::write(&left, "half").unwrap();
        assert_eq!(leftovers(&output), [left.canonicalize().unwrap()]);
        let mut second = Staged::create(&output).unwrap();
        assert!(!left.exists());
        at_work.write_all(b"first").unwrap();
        second.write_all(b"second").unwrap();
        at_work.commit().unwrap();
        assert_eq!(fs::read_to_string(&output).unwrap(), "first");
        second.commit().unwrap();
        assert_eq!(fs::read_to_string(&output).unwrap(), "second");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3);
    }

    /// Many threads begin, sweep and commit the same file at once: none loses its file.
    #[test]
    fn nobody_sweeps_what_has_just_been_begun() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.csv");
        std::thread::scope(|scope| {
            for n in 0..4u8 {
                let output = &output;
                scope.spawn(move || {
                    for _ in 0..500 {
                        let mut file = Staged::create(output).unwrap();
                        file.write_all(&[n; 3]).unwrap();
                        file.place().unwrap();
                    }
                });
            }
        });
        assert_eq!(fs::read(&output).unwrap().len(), 3);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
