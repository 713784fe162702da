//! A task with its machine, the bytes of its files and the history.

use crate::model;
use crate::output::tell;
use anyhow::{Context, Result, bail};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use trueaxis_evaluation::keep::{History, Keep, sum};
use trueaxis_tables::Machine;
use trueaxis_tables::files::Folder;
use trueaxis_tables::output::left_notes;
use trueaxis_tables::text::read_text;

/// Task, machine and history, as every command of `keep` reads them first.
pub(super) struct State {
    pub(super) keep: Keep,
    /// The machine's folder, from here.
    pub(super) folder: PathBuf,
    pub(super) source: Folder,
    /// Name of its description.
    pub(super) name: PathBuf,
    pub(super) machine: Machine,
    /// Files of the machine, and its thermal model, by their name in the folder.
    pub(super) files: BTreeMap<String, Vec<u8>>,
    pub(super) history: History,
}

impl State {
    /// Reads everything; `path` is that of the task.
    pub(super) fn read(path: &Path) -> Result<State> {
        let keep = Keep::read(&model::text(path)?, path)?;
        let at = path.parent().unwrap_or(Path::new("")).join(&keep.task.machine);
        let (source, name) = Folder::of_machine(&at);
        let machine = Machine::read_untabled(&source, &name, &mut |how| tell(format_args!("note: {how}")))?;
        keep.fits(&machine)?;
        let folder = if at.is_dir() { at.clone() } else { at.parent().unwrap_or(Path::new("")).to_path_buf() };
        let mut files = BTreeMap::new();
        let own = Machine::files(&at)?;
        left_notes(own.iter().cloned()).into_iter().for_each(|note| tell(format_args!("note: {note}")));
        for file in own.into_iter().chain(keep.thermal.iter().map(|thermal| folder.join(thermal))) {
            let bytes = fs::read(&file).with_context(|| format!("cannot read {}", file.display()))?;
            let name = file.strip_prefix(&folder).unwrap_or(&file).to_string_lossy().into_owned();
            files.insert(name, bytes);
        }
        let history = folder.join(HISTORY);
        let history = match history.symlink_metadata() {
            Ok(_) => History::read(&read_text(&history, &[])?, &history)?,
            Err(_) => History::read("", &history)?,
        };
        Ok(State { keep, folder, source, name, machine, files, history })
    }

    /// Check sum of all files.
    pub(super) fn tables(&self) -> String {
        tables(&self.files)
    }

    /// Refuses tables that are not as the history left them.
    pub(super) fn untouched(&self, by_hand: bool) -> Result<()> {
        let (Some(last), now) = (self.history.last(), self.tables()) else { return Ok(()) };
        let [before, after] = &last.tables;
        if now == *after {
            return Ok(());
        }
        let folder = self.folder.display();
        if by_hand {
            tell(format_args!("note: {folder}: tables {now} in place of {after}, taken as they are"));
            return Ok(());
        }
        if now == *before {
            bail!(
                "{folder}: found tables as before entry {}, which was ended before it changed them, needed them as after it: \
                 `trueaxis keep undo … {} --by-hand` enters that",
                last.entry,
                last.entry
            );
        }
        bail!(
            "{folder}: found tables {now}, which somebody has changed, needed {after} as entry {} left them: --by-hand takes \
             them as they are",
            last.entry
        )
    }

    /// Where a file was kept that an entry has changed.
    pub(super) fn kept(&self, entry: u32, file: &str) -> PathBuf {
        let name = Path::new(file).file_name().unwrap_or_default();
        self.folder.join("keep").join(format!("{entry:04}")).join(name)
    }
}

/// Name of the history in the machine's folder.
pub(super) const HISTORY: &str = "keep/history.jsonl";

/// Check sum of files with their names.
pub(super) fn tables(files: &BTreeMap<String, Vec<u8>>) -> String {
    let mut all = Vec::new();
    for (name, bytes) in files {
        all.extend_from_slice(format!("{name}\0{}\0", bytes.len()).as_bytes());
        all.extend_from_slice(bytes);
    }
    sum(&all)
}
