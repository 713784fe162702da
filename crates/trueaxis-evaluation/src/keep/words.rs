//! Verdicts and entries in words, identical on the command line, in reports and in the desk.

use super::document::TermDocument;
use super::entry::{Entry, EntryKind, Measured};
use super::history::in_effect;
use trueaxis_report::number::significant;

impl TermDocument {
    /// The verdict with its reason.
    pub fn in_words(&self) -> String {
        self.reason.as_ref().map_or_else(|| self.verdict.into(), |reason| format!("{}: {reason}", self.verdict))
    }
}

impl Measured {
    /// Change of the sum of the updates, if any.
    pub fn in_words(&self) -> Option<String> {
        let (from, to) = (significant(self.from, 3), significant(self.to, 3));
        let error = significant(self.standard_error, 2);
        (self.from != self.to).then(|| format!("{} {from} to {to} {} (± {error})", self.term, self.unit))
    }
}

/// Describes each entry in words; needs all entries, as a later one may have undone an update.
pub fn descriptions(entries: &[Entry]) -> Vec<String> {
    let now = in_effect(entries);
    let of = |entry: &Entry| match entry.kind {
        EntryKind::Begin => "begin".to_owned(),
        EntryKind::Unchanged => "re-probing, nothing changed".into(),
        EntryKind::Update if now.contains(&entry.entry) => "update".into(),
        EntryKind::Update => "update, undone".into(),
        EntryKind::Undo => format!("undo, as before entry {}", entry.undone.unwrap_or_default()),
    };
    entries.iter().map(of).collect()
}
