//! Restores the files as they were before an entry.

use super::entry::{Entry, EntryKind};
use super::history::sum;
use super::state::{State, copy_path, tables};
use super::written::{FileChanges, is_compilable};
use anyhow::{Context, Result, bail};
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;

/// An undo.
#[derive(Clone, Debug)]
pub struct Undone {
    /// The history entry that the undo adds.
    pub entry: Entry,
    /// Files that change, `machine.toml` last.
    pub files: FileChanges,
    /// Names of the files to remove: those that did not exist before, and the controller's file if the machine then has no
    /// table.
    pub away: Vec<String>,
}

impl State {
    /// Computes the files as they were before an entry, or before the last update in effect. Writes nothing.
    ///
    /// # Errors
    /// An entry that cannot be undone, tables other than those the history left, missing or damaged copies.
    pub fn undone(
        &self,
        entry: Option<u32>,
        time: Option<String>,
        by_hand: bool,
        note: &mut dyn FnMut(String),
    ) -> Result<Undone> {
        let number = self.history.undoable(entry)?;
        self.untouched(by_hand, note)?;
        let mut new = FileChanges::new();
        for (file, entry, before) in self.history.put_back(number) {
            let bytes = before.map(|check| self.copy(entry, &file, &check)).transpose()?;
            new.push((file, bytes));
        }
        // machine.toml names the others, so it comes last.
        new.sort_by_key(|(file, _)| self.name.to_str() == Some(file));
        let after = self.with(&new);
        new.retain(|(file, bytes)| self.files.get(file) != bytes.as_ref());
        let memory = Memory::new(after.iter().map(|(name, bytes)| (name, bytes.clone())));
        let machine = Machine::read_from(&memory, &self.name, &mut |_| {})?;
        let mut away: Vec<String> = new.iter().filter(|(_, new)| new.is_none()).map(|(file, _)| file.clone()).collect();
        away.extend(self.task.tcomp.iter().filter(|_| !is_compilable(&machine)).cloned());
        let entry = Entry {
            entry: self.history.next(),
            kind: EntryKind::Undo,
            time,
            parts: None,
            plan: self.history.beginning()?.plan.clone(),
            log: None,
            undone: Some(number),
            sigma_um: None,
            measured: Vec::new(),
            balls: Vec::new(),
            totals: self.history.entries[number as usize - 2].totals.clone(),
            files: self.changed(&new),
            tables: [self.tables(), tables(&after)],
        };
        Ok(Undone { entry, files: new, away })
    }

    /// Reads the copy of a file that an entry kept.
    fn copy(&self, entry: u32, file: &str, check: &str) -> Result<Vec<u8>> {
        let copy = copy_path(entry, file);
        let path = self.source.path(&copy);
        let bytes = self.source.read(&copy).with_context(|| format!("cannot read {}", path.display()))?;
        let own = sum(&bytes);
        if own != check {
            bail!("{}: found {own}, needed {check} as entry {entry} kept it", path.display());
        }
        Ok(bytes)
    }
}
