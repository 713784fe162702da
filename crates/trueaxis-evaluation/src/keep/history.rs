//! The history of a machine: one line of JSON per entry, each with a checksum over itself and all previous lines.

use super::entry::{BallPlace, Entry, EntryKind};
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use trueaxis_tables::error::FileError;
use trueaxis_tables::text::counted;

/// CRC-32 in hexadecimal.
pub fn sum(bytes: &[u8]) -> String {
    format!("{:08x}", trueaxis::tcomp::checksum(bytes))
}

/// Whether `file` is a bare file name, without a path.
pub(super) fn is_plain(file: &str) -> bool {
    let mut components = Path::new(file).components();
    matches!((components.next(), components.next()), (Some(Component::Normal(name)), None) if name == file)
}

/// Start of the last field of a line.
const CHECK: &str = ",\"check\":\"";

/// All entries.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    /// Entries in order, numbered from 1.
    pub entries: Vec<Entry>,
    text: String,
    check: String,
    file: PathBuf,
}

impl History {
    /// Reads a history; `file` is used only in errors.
    ///
    /// # Errors
    /// A line that is not an entry, is out of sequence or has a wrong checksum: something was cut off, changed or removed.
    pub fn read(text: &str, file: &Path) -> Result<History, FileError> {
        let mut history = History { file: file.into(), ..History::default() };
        for (line, text) in (1..).zip(text.split_inclusive('\n')) {
            let error = |found: String, needed: &str| FileError {
                file: file.into(),
                line: Some(line),
                column: None,
                found,
                needed: needed.into(),
            };
            let whole = text.strip_suffix('\n').and_then(|text| text.rsplit_once(CHECK));
            let check = whole.and_then(|(body, check)| Some((body, check.strip_suffix("\"}")?)));
            let Some((body, check)) = check else {
                return Err(error("a damaged line".into(), "a whole entry with its check sum: a copy of this file"));
            };
            let own = history.check_of(body);
            if check != own {
                let needed = "what `trueaxis keep` wrote, line by line: the file was changed or lines are missing";
                return Err(error(format!("the check sum {check:?}, of the line {own}"), needed));
            }
            let entry: Entry = serde_json::from_str(&format!("{body}}}"))
                .map_err(|why| error(format!("a line that is not an entry: {why}"), "an entry of `trueaxis keep`"))?;
            let number = history.entries.len() as u32 + 1;
            let sound = match entry.kind {
                EntryKind::Begin => !entry.balls.is_empty(),
                _ => number > 1,
            };
            if entry.entry != number || !sound {
                return Err(error(
                    format!("entry {} ({:?})", entry.entry, entry.kind),
                    "entries in their order, the beginning first",
                ));
            }
            if let Some(changed) = entry.files.iter().find(|changed| !is_plain(&changed.file)) {
                let found = format!("entry {} that changed {:?}", entry.entry, changed.file);
                return Err(error(found, "files of the machine's folder: an undo writes them"));
            }
            history.entries.push(entry);
            history.check = own;
            history.text.push_str(text);
        }
        Ok(history)
    }

    fn check_of(&self, body: &str) -> String {
        sum(format!("{}{body}", self.check).as_bytes())
    }

    /// The text, as it was read.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The text with one more entry.
    pub fn with(&self, entry: &Entry) -> String {
        let body = serde_json::to_string(entry).unwrap_or_default();
        let body = body.strip_suffix('}').unwrap_or(&body);
        format!("{}{body}{CHECK}{}\"}}\n", self.text, self.check_of(body))
    }

    /// The last entry.
    pub fn last(&self) -> Option<&Entry> {
        self.entries.last()
    }

    /// Number of the next entry.
    pub fn next(&self) -> u32 {
        self.entries.len() as u32 + 1
    }

    /// The last beginning.
    ///
    /// # Errors
    /// A history without a beginning.
    pub fn beginning(&self) -> Result<&Entry, FileError> {
        let begun = self.entries.iter().rev().find(|entry| entry.kind == EntryKind::Begin);
        begun.ok_or_else(|| self.error("no beginning", "a first probing, by `trueaxis keep begin`"))
    }

    fn error(&self, found: impl Into<String>, needed: impl Into<String>) -> FileError {
        FileError { file: self.file.clone(), line: None, column: None, found: found.into(), needed: needed.into() }
    }

    /// Positions of the balls at the beginning.
    ///
    /// # Errors
    /// As [`History::beginning`].
    pub fn balls(&self) -> Result<&[BallPlace], FileError> {
        self.beginning().map(|entry| entry.balls.as_slice())
    }

    /// Sums of the updates since the beginning.
    pub fn totals(&self) -> BTreeMap<String, f64> {
        self.last().map(|entry| entry.totals.clone()).unwrap_or_default()
    }

    /// Refuses a log already in the history that changed nothing, or with an update in effect at or after its entry; a log
    /// whose time or part count is before the last one in the history; and a plan other than the beginning's.
    ///
    /// # Errors
    /// The check that failed.
    pub fn follows(&self, plan: &str, crc: &str, time: Option<&str>, parts: Option<u64>) -> Result<(), FileError> {
        let begun = self.beginning()?;
        if begun.plan != plan {
            let found = format!("a plan {plan}, other than {} at the beginning, entry {}", begun.plan, begun.entry);
            return Err(self.error(found, "the same balls, probe and angles, or a new beginning"));
        }
        let now = self.in_effect();
        let same = self.entries.iter().filter(|entry| entry.log.as_ref().is_some_and(|log| log.crc == crc));
        for entry in same {
            let after = now.iter().any(|number| *number >= entry.entry);
            if after || entry.kind == EntryKind::Unchanged {
                let found = format!("the log of entry {} for the second time", entry.entry);
                return Err(self.error(found, "a new one: its findings are already in the tables"));
            }
        }
        let last = |of: fn(&Entry) -> bool| self.entries.iter().rev().find(|entry| of(entry));
        if let (Some(time), Some(entry)) = (time, last(|entry| entry.time.is_some())) {
            let before = entry.time.as_deref().unwrap_or_default();
            if time < before {
                let found = format!("the time {time}, before {before} of entry {}", entry.entry);
                return Err(self.error(found, "a log that was probed after it"));
            }
        }
        if let (Some(parts), Some(entry)) = (parts, last(|entry| entry.parts.is_some())) {
            let before = entry.parts.unwrap_or_default();
            if parts < before {
                let found = format!(
                    "{}, fewer than {before} of entry {}",
                    counted(usize::try_from(parts).unwrap_or(usize::MAX), "part"),
                    entry.entry
                );
                return Err(self.error(found, "a count that does not go back, or a new beginning"));
            }
        }
        Ok(())
    }

    /// Numbers of the updates since the beginning that have not been undone.
    pub fn in_effect(&self) -> Vec<u32> {
        in_effect(&self.entries)
    }

    /// Entry before which an undo restores the files: the one requested, or the last update in effect.
    ///
    /// # Errors
    /// A nonexistent entry, one at or before the beginning, or no update in effect.
    pub fn undoable(&self, number: Option<u32>) -> Result<u32, FileError> {
        let begun = self.beginning()?.entry;
        let number = match number {
            Some(number) => number,
            None => *self.in_effect().last().ok_or_else(|| {
                self.error("no update since the beginning that is in effect", "one that can be undone")
            })?,
        };
        let last = self.entries.len() as u32;
        if number > last {
            return Err(self.error(format!("entry {number} to undo"), format!("at most {last}, the last one")));
        }
        if number <= begun {
            let found = format!("entry {number} to undo, the beginning or before it");
            return Err(self.error(found, format!("one after entry {begun}")));
        }
        Ok(number)
    }

    /// Files that an undo restores: the name, the entry whose folder contains the version before `number`, and its checksum;
    /// `None` if the file did not exist.
    pub fn put_back(&self, number: u32) -> Vec<(String, u32, Option<String>)> {
        let mut found: Vec<(String, u32, Option<String>)> = Vec::new();
        for entry in self.entries.iter().filter(|entry| entry.entry >= number) {
            for changed in &entry.files {
                if found.iter().all(|(file, _, _)| *file != changed.file) {
                    found.push((changed.file.clone(), entry.entry, changed.before.clone()));
                }
            }
        }
        found
    }
}

/// Numbers of the updates among these entries, since the last beginning, that have not been undone.
pub(super) fn in_effect(entries: &[Entry]) -> Vec<u32> {
    let mut after: Vec<Vec<u32>> = vec![Vec::new()];
    for entry in entries {
        let mut now = after.last().cloned().unwrap_or_default();
        match entry.kind {
            EntryKind::Begin => now.clear(),
            EntryKind::Unchanged => {}
            EntryKind::Update => now.push(entry.entry),
            EntryKind::Undo => {
                let before = entry.undone.and_then(|number| number.checked_sub(1));
                now = before.and_then(|number| after.get(number as usize)).cloned().unwrap_or_default();
            }
        }
        after.push(now);
    }
    after.pop().unwrap_or_default()
}
