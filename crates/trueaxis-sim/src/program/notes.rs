//! Words of a program without effect here, once per kind.

/// A kind of word that was accepted although it does not change the path.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Note {
    /// The word, without its value if that does not matter.
    pub word: String,
    /// Number of times it occurs.
    pub count: u32,
    /// Line in which it first occurs, from 1.
    pub line: u32,
    /// Reason why it has no effect, or the effect it has instead; empty if that is obvious.
    pub why: &'static str,
}

impl std::fmt::Display for Note {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({})", self.word, self.count)?;
        if self.why.is_empty() { Ok(()) } else { write!(f, ": {}", self.why) }
    }
}

/// Notes in the order in which their kinds first occurred.
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
