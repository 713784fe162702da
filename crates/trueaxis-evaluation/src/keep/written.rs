//! Files that a command writes, in this order: copies of the files it replaces, the history, the machine's files, the
//! controller's.

use super::entry::{Changed, Entry, EntryKind};
use super::history::sum;
use super::state::{HISTORY, State, copy_path};
use anyhow::{Result, anyhow};
use std::collections::BTreeMap;
use std::path::PathBuf;
use trueaxis::tcomp::machine_id;
use trueaxis_tables::files::Memory;
use trueaxis_tables::text::decode;
use trueaxis_tables::{Machine, compile};

/// Names in the machine's folder with their bytes, in writing order.
pub type Written = Vec<(PathBuf, Vec<u8>)>;

/// New versions of the machine's files; `None` if removed.
pub type FileChanges = Vec<(String, Option<Vec<u8>>)>;

impl State {
    /// All files, with the new versions.
    pub(super) fn with(&self, new: &FileChanges) -> BTreeMap<String, Vec<u8>> {
        let mut after = self.files.clone();
        for (file, bytes) in new {
            match bytes {
                Some(bytes) => after.insert(file.clone(), bytes.clone()),
                None => after.remove(file),
            };
        }
        after
    }

    /// The new files in the form of an entry.
    pub(super) fn changed(&self, new: &FileChanges) -> Vec<Changed> {
        let of = |bytes: &Vec<u8>| sum(bytes);
        new.iter()
            .map(|(file, bytes)| Changed {
                file: file.clone(),
                before: self.files.get(file).map(of),
                after: bytes.as_ref().map(of),
            })
            .collect()
    }

    /// Everything that an entry writes. Copies come first, then the history, before the tables, so that the changes of an
    /// interrupted command are known.
    ///
    /// # Errors
    /// Files that the controller would refuse.
    pub fn written(&self, entry: &Entry, new: &FileChanges) -> Result<Written> {
        let copies =
            new.iter().filter_map(|(file, _)| Some((copy_path(entry.entry, file), self.files.get(file)?.clone())));
        let mut written: Written = copies.collect();
        written.push((HISTORY.into(), self.history.with(entry).into_bytes()));
        written.extend(new.iter().filter_map(|(file, bytes)| Some((file.into(), bytes.clone()?))));
        if matches!(entry.kind, EntryKind::Update | EntryKind::Undo) {
            self.compiled(entry.kind, &self.with(new), &mut written)?;
        }
        Ok(written)
    }

    /// Adds the controller's files, compiled from these files of a machine.
    fn compiled(&self, kind: EntryKind, files: &BTreeMap<String, Vec<u8>>, written: &mut Written) -> Result<()> {
        if self.task.tcomp.is_none() && self.task.ttherm.is_none() {
            return Ok(());
        }
        let memory = Memory::new(files.iter().map(|(name, bytes)| (name, bytes.clone())));
        let machine = Machine::read_from(&memory, &self.name, &mut |_| {})?;
        // An undo removes the compiled file.
        let away = kind == EntryKind::Undo && !is_compilable(&machine);
        if let Some(tcomp) = self.task.tcomp.as_ref().filter(|_| !away) {
            let machine = Machine::read_from(&memory, &self.name, &mut |_| {})?;
            written.push((tcomp.into(), compile(&machine)?));
        }
        if let (Some(thermal), Some(ttherm)) = (&self.task.thermal, &self.task.ttherm) {
            let path = self.folder.join(thermal);
            let text = decode(files.get(thermal).cloned().unwrap_or_default(), &path, &['#'])?;
            let model = crate::thermal::model(&text, &path, &machine.settings)?;
            let id = machine_id(&machine.settings.name, &machine.settings.chain);
            written.push((ttherm.into(), model.encode(id).map_err(|error| anyhow!("{}: {error}", path.display()))?));
        }
        Ok(())
    }
}

/// Whether the machine has tables or grids to compile; before its first update it may have none.
pub(super) fn is_compilable(machine: &Machine) -> bool {
    !machine.grids.is_empty() || machine.tables.iter().any(Option::is_some)
}
