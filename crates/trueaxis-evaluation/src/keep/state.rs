//! A task with its machine, the bytes of its files and the history.

use super::history::{History, is_plain, sum};
use super::task::KeepTask;
use anyhow::{Context, Result, bail};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trueaxis_tables::Machine;
use trueaxis_tables::files::{Memory, Source};
use trueaxis_tables::output::Alone;

/// Name of the history in the machine's folder.
pub const HISTORY: &str = "keep/history.jsonl";

/// Task, machine and history, as every command of `keep` reads them first.
pub struct State {
    /// The task.
    pub task: KeepTask,
    /// The machine's folder, for errors and for writing.
    pub folder: PathBuf,
    /// Files of the folder.
    pub source: Box<dyn Source>,
    /// Name of the machine's description in the folder.
    pub name: PathBuf,
    /// The machine.
    pub machine: Machine,
    /// Files of the machine, including its thermal model, by their names in the folder.
    pub files: BTreeMap<String, Vec<u8>>,
    /// Probings, updates and undos so far.
    pub history: History,
    /// Lock on the machine, released when this is dropped.
    pub(super) _alone: Option<Alone>,
}

impl State {
    /// Reads the machine of a task from a source, with an empty history; `note` receives notes on how files were read.
    pub(super) fn begun(
        task: KeepTask,
        folder: PathBuf,
        source: Box<dyn Source>,
        name: PathBuf,
        note: &mut dyn FnMut(String),
    ) -> Result<State> {
        let machine = Machine::read_from(source.as_ref(), &name, note)?;
        task.fits(&machine)?;
        let mut files = BTreeMap::new();
        for own in Machine::files_of(source.as_ref(), &name)?.into_iter().chain(task.thermal.iter().map(PathBuf::from))
        {
            let (file, path) = (own.to_string_lossy().into_owned(), source.path(&own));
            if !is_plain(&file) {
                bail!(
                    "{}: found a file of another folder, needed it beside machine.toml: an undo writes it",
                    path.display()
                );
            }
            files.insert(file, source.read(&own).with_context(|| format!("cannot read {}", path.display()))?);
        }
        let history = History::read("", &folder.join(HISTORY))?;
        Ok(State { task, folder, source, name, machine, files, history, _alone: None })
    }

    /// Builds a state from texts in memory, the machine's description among them as `machine.toml`; `history` is the text of
    /// its history, empty before the first probing.
    ///
    /// # Errors
    /// An invalid machine or history, terms of axes that the machine lacks, a missing thermal model.
    pub fn of_texts(task: KeepTask, files: Memory, history: &str, note: &mut dyn FnMut(String)) -> Result<State> {
        let folder = task.probing.machine.clone();
        let mut state = State::begun(task, folder.into(), Box::new(files), "machine.toml".into(), note)?;
        state.history = History::read(history, &state.folder.join(HISTORY))?;
        Ok(state)
    }

    /// Checksum of all files.
    pub fn tables(&self) -> String {
        tables(&self.files)
    }

    /// Refuses tables other than those the history left; with `by_hand`, only notes them.
    ///
    /// # Errors
    /// Tables other than the last entry's, with both checksums.
    pub fn untouched(&self, by_hand: bool, note: &mut dyn FnMut(String)) -> Result<()> {
        let (Some(last), now) = (self.history.last(), self.tables()) else { return Ok(()) };
        let [before, after] = &last.tables;
        if now == *after {
            return Ok(());
        }
        let folder = self.folder.display();
        if by_hand {
            note(format!("{folder}: tables {now} instead of {after}, used as they are"));
            return Ok(());
        }
        if now == *before {
            bail!(
                "{folder}: found tables as before entry {}, which was interrupted before it changed them, needed them as after it: \
                 `trueaxis keep undo … {} --by-hand` records that",
                last.entry,
                last.entry
            );
        }
        bail!(
            "{folder}: found tables {now}, which were changed by hand, needed {after} as entry {} left them: --by-hand uses \
             them as they are",
            last.entry
        )
    }
}

/// Path, in the machine's folder, of the copy of a file that an entry changes.
pub(super) fn copy_path(entry: u32, file: &str) -> PathBuf {
    let name = Path::new(file).file_name().unwrap_or_default();
    Path::new("keep").join(format!("{entry:04}")).join(name)
}

/// Checksum of files with their names.
pub(super) fn tables(files: &BTreeMap<String, Vec<u8>>) -> String {
    let mut all = Vec::new();
    for (name, bytes) in files {
        all.extend_from_slice(format!("{name}\0{}\0", bytes.len()).as_bytes());
        all.extend_from_slice(bytes);
    }
    sum(&all)
}
