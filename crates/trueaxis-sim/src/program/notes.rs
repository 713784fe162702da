//! Words of a program without effect here, once per kind.

/// A kind of word that was accepted although it changes nothing of the path.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Note {
    /// The word, without its value where that does not matter.
    pub word: String,
    /// Number of times it occurs.
    pub count: u32,
    /// Line in which it stands first, from 1.
    pub line: u32,
    /// Why it changes nothing, or what it does instead; empty where that is plain.
    pub why: &'static str,
}

impl std::fmt::Display for Note {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({})", self.word, self.count)?;
        if self.why.is_empty() { Ok(()) } else { write!(f, ": {}", self.why) }
    }
}

/// Notes in the order in which their kinds first came.
#[derive(Debug, Default)]
pub(super) struct Notes(Vec<Note>);

impl Notes {
    pub(super) fn add(&mut self, line: u32, word: &str, why: &'static str) {
        match self.0.iter_mut().find(|note| note.word == word) {
            Some(note) => note.count = note.count.saturating_add(1),
            None => self.0.push(Note { word: word.to_owned(), count: 1, line, why }),
        }
    }

    pub(super) fn into_vec(self) -> Vec<Note> {
        self.0
    }
}
