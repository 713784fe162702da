//! A lock that lets only one command at a time change a machine.

use super::staged::{flush_folder, folder_of};
use super::{Folders, OutputError};
use std::fs::{File, TryLockError};
use std::path::Path;

/// A machine's folder, locked for one command that changes it. The lock lasts from before the machine is read until it is
/// written, since this command would undo a change made in between.
///
/// The lock ends with the process, however that ends. It excludes only commands that also take it; commands that only read do
/// not.
#[derive(Debug)]
pub struct Alone {
    _lock: Option<File>,
    // After the lock: a folder created for the machine is removed if it is still empty.
    _made: Folders,
}

impl Alone {
    /// Locks a machine's folder, creating it if it does not exist; reports a file system without locks to `note`.
    ///
    /// # Errors
    /// Another command is using it, or it cannot be created.
    pub fn in_folder(folder: &Path, note: &mut dyn FnMut(String)) -> Result<Alone, OutputError> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let io = |error| OutputError::Io { output: folder.into(), error };
        let mut made = Folders::default();
        made.create(folder).map_err(io)?;
        made.0.iter().try_for_each(|made| flush_folder(folder_of(made))).map_err(io)?;
        let locked = File::open(folder).map_err(TryLockError::Error).and_then(|open| open.try_lock().map(|()| open));
        let lock = match locked {
            Ok(open) => Some(open),
            Err(TryLockError::WouldBlock) => {
                // The folder belongs to the other command, which may not have written anything yet.
                made.0.clear();
                return Err(OutputError::Busy(folder.into()));
            }
            Err(TryLockError::Error(error)) => {
                note(format!("{} is not locked: {error}", folder.display()));
                None
            }
        };
        Ok(Alone { _lock: lock, _made: made })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn one_at_a_time_and_a_folder_that_stays_empty_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let machine = folder.path().join("shop/mill");
        let alone = |path: &Path| Alone::in_folder(path, &mut |note| panic!("{note}"));
        let first = alone(&machine).unwrap();
        let refused = alone(&folder.path().join("shop/../shop/mill")).unwrap_err();
        assert!(refused.to_string().contains("found another command"), "{refused}");
        alone(&folder.path().join("shop")).unwrap();
        drop(first);
        assert!(!folder.path().join("shop").exists());
        let second = alone(&machine).unwrap();
        fs::write(machine.join("machine.toml"), "").unwrap();
        drop(second);
        alone(&machine).unwrap();
        assert!(machine.join("machine.toml").exists());
        fs::write(folder.path().join("file"), "").unwrap();
        assert!(alone(&folder.path().join("file")).unwrap_err().to_string().contains("file"));
    }
}
