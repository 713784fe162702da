//! A task and its machine's folder in the file system: read, locked, written.

use super::history::History;
use super::state::{HISTORY, State};
use super::task::Keep;
use super::undo::Undone;
use super::written::Written;
use anyhow::{Context, Result};
use std::fs;
use std::path::{Path, PathBuf};
use trueaxis_tables::files::Folder;
use trueaxis_tables::output::{Alone, Outputs, left_notes};
use trueaxis_tables::text::read_text;

/// A task, and the machine that it names.
fn task(path: &Path) -> Result<(Keep, PathBuf)> {
    let keep = Keep::read(&read_text(path, &['#', ';'])?, path)?;
    let machine = path.parent().unwrap_or(Path::new("")).join(&keep.task.machine);
    Ok((keep, machine))
}

/// The folder of a machine that is named by its folder or by its file.
fn folder_of(machine: &Path) -> &Path {
    if machine.is_dir() { machine } else { machine.parent().unwrap_or(Path::new("")) }
}

impl State {
    /// Reads everything; `path` is that of the task, from which the machine's folder counts.
    ///
    /// # Errors
    /// A file that cannot be read or is wrong, with its line.
    pub fn read(path: &Path, note: &mut dyn FnMut(String)) -> Result<State> {
        State::of(task(path)?, note)
    }

    fn of((keep, at): (Keep, PathBuf), note: &mut dyn FnMut(String)) -> Result<State> {
        let (source, name) = Folder::of_machine(&at);
        let folder = folder_of(&at);
        let mut state = State::begun(keep, folder.to_path_buf(), Box::new(source), name, note)?;
        left_notes(state.files.keys().map(|file| folder.join(file))).into_iter().for_each(&mut *note);
        let history = folder.join(HISTORY);
        if history.symlink_metadata().is_ok() {
            state.history = History::read(&read_text(&history, &[])?, &history)?;
        }
        Ok(state)
    }

    /// The same for a command that writes. A second command that changes the machine is refused until this is dropped: it would
    /// add to tables what the first one adds.
    ///
    /// # Errors
    /// As [`State::read`], and another command at work.
    pub fn alone(path: &Path, note: &mut dyn FnMut(String)) -> Result<State> {
        let task = task(path)?;
        let alone = Alone::in_folder(folder_of(&task.1), note)?;
        Ok(State { _alone: Some(alone), ..State::of(task, note)? })
    }

    /// Stages what a command writes, in its order.
    ///
    /// # Errors
    /// As [`Outputs::put`].
    pub fn stage(&self, outputs: &mut Outputs, written: &Written) -> Result<()> {
        for (name, bytes) in written {
            if let Some(inner) = name.parent().filter(|inner| !inner.as_os_str().is_empty()) {
                outputs.folder(&self.folder.join(inner))?;
            }
            outputs.put(&self.folder.join(name), bytes)?;
        }
        Ok(())
    }

    /// Writes an undo, with what it takes away.
    ///
    /// # Errors
    /// The file system refused.
    pub fn put_back(&self, mut outputs: Outputs, undone: &Undone) -> Result<()> {
        self.stage(&mut outputs, &self.written(&undone.entry, &undone.files)?)?;
        outputs.commit()?;
        // A table that there was not is named by nothing now; left there, it would stand in the way of the next one, and a
        // compiled file would go on correcting.
        for path in undone.away.iter().map(|file| self.folder.join(file)).filter(|path| path.symlink_metadata().is_ok())
        {
            fs::remove_file(&path).with_context(|| format!("cannot remove {}", path.display()))?;
        }
        Ok(())
    }
}
