//! Verdicts and entries in words, identical on the command line, in reports and in the desk.

use super::document::TermDocument;
use super::entry::{Entry, EntryKind, Measured};
use super::history::in_effect;
use crate::shown::half_width;
use trueaxis_report::number::significant;

impl TermDocument {
    /// The verdict with its reason.
    pub fn in_words(&self) -> String {
        self.reason.as_ref().map_or_else(|| self.verdict.into(), |reason| format!("{}: {reason}", self.verdict))
    }
}

impl Measured {
    /// Expanded uncertainty of the value, 95 %; by the factor of a normal distribution, as an entry states no degrees of
    /// freedom.
    pub fn half_width(&self) -> f64 {
        half_width(self.standard_error, f64::INFINITY)
    }

    /// Change of the sum of the updates, if any.
    pub fn in_words(&self) -> Option<String> {
        let (from, to) = (significant(self.from, 3), significant(self.to, 3));
        let error = significant(self.half_width(), 2);
        (self.from != self.to).then(|| format!("{} {from} to {to} {} (± {error}, 95 %)", self.term, self.unit))
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
