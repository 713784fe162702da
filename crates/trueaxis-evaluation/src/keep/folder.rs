//! Reads, locks and writes a task and its machine's folder in the file system.

use super::history::History;
use super::state::{HISTORY, State};
use super::task::KeepTask;
use super::undo::Undone;
use super::written::Written;
use anyhow::{Context, Result};
use std::fs;
use std::path::{Path, PathBuf};
use trueaxis_tables::files::Folder;
use trueaxis_tables::output::{Alone, Outputs, left_notes};
use trueaxis_tables::text::read_text;

/// Reads a task and the path of the machine that it names.
fn task(path: &Path) -> Result<(KeepTask, PathBuf)> {
    let task = KeepTask::read(&read_text(path, &['#', ';'])?, path)?;
    let machine = path.parent().unwrap_or(Path::new("")).join(&task.probing.machine);
    Ok((task, machine))
}

/// Folder of a machine, given its folder or its file.
fn folder_of(machine: &Path) -> &Path {
    if machine.is_dir() { machine } else { machine.parent().unwrap_or(Path::new("")) }
}

impl State {
    /// Reads everything; `path` is the task file, to which the machine's folder is relative.
    ///
    /// # Errors
    /// An unreadable or invalid file, with its line.
    pub fn read(path: &Path, note: &mut dyn FnMut(String)) -> Result<State> {
        State::of(task(path)?, note)
    }

    fn of((task, at): (KeepTask, PathBuf), note: &mut dyn FnMut(String)) -> Result<State> {
        let (source, name) = Folder::of_machine(&at);
        let folder = folder_of(&at);
        let mut state = State::begun(task, folder.to_path_buf(), Box::new(source), name, note)?;
        left_notes(state.files.keys().map(|file| folder.join(file))).into_iter().for_each(&mut *note);
        let history = folder.join(HISTORY);
        if history.symlink_metadata().is_ok() {
            state.history = History::read(&read_text(&history, &[])?, &history)?;
        }
        Ok(state)
    }

    /// Like [`State::read`], for a command that writes. Until this is dropped, a second command that changes the
    /// machine is refused: it would add the changes of the first one to the tables again.
    ///
    /// # Errors
    /// As [`State::read`], or another command at work.
    pub fn alone(path: &Path, note: &mut dyn FnMut(String)) -> Result<State> {
        let task = task(path)?;
        let alone = Alone::in_folder(folder_of(&task.1), note)?;
        Ok(State { _alone: Some(alone), ..State::of(task, note)? })
    }

    /// Stages the files that a command writes, in order.
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

    /// Writes an undo and removes the files that it takes away.
    ///
    /// # Errors
    /// The file system refused.
    pub fn put_back(&self, mut outputs: Outputs, undone: &Undone) -> Result<()> {
        self.stage(&mut outputs, &self.written(&undone.entry, &undone.files)?)?;
        outputs.commit()?;
        // No file now names a table that did not exist before; left behind, it would block the next one, and a compiled file
        // would continue to correct.
        for path in undone.away.iter().map(|file| self.folder.join(file)).filter(|path| path.symlink_metadata().is_ok())
        {
            fs::remove_file(&path).with_context(|| format!("cannot remove {}", path.display()))?;
        }
        Ok(())
    }
}
