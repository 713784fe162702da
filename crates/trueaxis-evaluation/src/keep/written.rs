//! Files that a command writes, in this order: copies of the files it replaces, the history, the machine's files, the
//! controller's.

use super::entry::{Changed, Deed, Entry};
use super::history::sum;
use super::state::{HISTORY, State, kept};
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
pub type New = Vec<(String, Option<Vec<u8>>)>;

impl State {
    /// All files, with the new versions.
    pub(super) fn with(&self, new: &New) -> BTreeMap<String, Vec<u8>> {
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
    pub(super) fn changed(&self, new: &New) -> Vec<Changed> {
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
    pub fn written(&self, entry: &Entry, new: &New) -> Result<Written> {
        let copies = new.iter().filter_map(|(file, _)| Some((kept(entry.entry, file), self.files.get(file)?.clone())));
        let mut written: Written = copies.collect();
        written.push((HISTORY.into(), self.history.with(entry).into_bytes()));
        written.extend(new.iter().filter_map(|(file, bytes)| Some((file.into(), bytes.clone()?))));
        if matches!(entry.deed, Deed::Update | Deed::Undo) {
            self.compiled(entry.deed, &self.with(new), &mut written)?;
        }
        Ok(written)
    }

    /// Adds the controller's files, compiled from these files of a machine.
    fn compiled(&self, deed: Deed, files: &BTreeMap<String, Vec<u8>>, written: &mut Written) -> Result<()> {
        if self.keep.tcomp.is_none() && self.keep.ttherm.is_none() {
            return Ok(());
        }
        let memory = Memory::new(files.iter().map(|(name, bytes)| (name, bytes.clone())));
        let machine = Machine::read_from(&memory, &self.name, &mut |_| {})?;
        // An undo removes the compiled file.
        let away = deed == Deed::Undo && !is_compilable(&machine);
        if let Some(tcomp) = self.keep.tcomp.as_ref().filter(|_| !away) {
            let machine = Machine::read_from(&memory, &self.name, &mut |_| {})?;
            written.push((tcomp.into(), compile(&machine)?));
        }
        if let (Some(thermal), Some(ttherm)) = (&self.keep.thermal, &self.keep.ttherm) {
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
