//! Splits the text of a line into letters with values, and assignments.

use super::error::Refusal;
use super::expression::{Parameter, Reader, Values};

/// Largest magnitude of a number in a program. Beyond it f64 no longer resolves a nanometre.
pub(super) const LARGEST: f64 = 1.0e6;

/// A letter with its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Word<'t> {
    /// Upper case; `@` and `^` for radius and angle.
    pub(super) letter: char,
    pub(super) value: f64,
    /// As written, without blanks.
    pub(super) text: &'t str,
}

impl Word<'_> {
    /// Number of a G or M word in tenths (G5.2 is 52), if it has at most one decimal.
    pub(super) fn tenths(&self) -> Option<u16> {
        let tenths = (self.value * 10.0).round();
        ((0.0..10_000.0).contains(&tenths) && (self.value * 10.0 - tenths).abs() < 1.0e-6).then_some(tenths as u16)
    }
}

/// A word or an assignment.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Item<'t> {
    Word(Word<'t>),
    /// `#` … `=` …
    Set(Parameter<'t>, f64),
}

/// The items of a line cleaned by [`clean`](super::text::clean).
pub(super) struct Words<'t, 'v, V> {
    line: u32,
    reader: Reader<'t, 'v, V>,
}

impl<'t, 'v, V: Values> Words<'t, 'v, V> {
    pub(super) fn new(line: u32, text: &'t str, values: &'v V) -> Self {
        Words { line, reader: Reader::new(line, text, values) }
    }

    fn item(&mut self) -> Result<Item<'t>, Refusal> {
        let (line, rest) = (self.line, self.reader.rest);
        let refuse = |found: &str, needed: &str| Err(Refusal::new(line, format!("`{found}`"), needed));
        let letter = rest.chars().next().unwrap_or(' ');
        match letter {
            '#' => return self.assignment(),
            'A'..='Z' | '@' | '^' => {}
            '/' => return refuse(rest, "/ only at the beginning of a line"),
            '%' => return refuse(rest, "% on a separate line"),
            _ => return refuse(rest, "words of a letter and a value, ( ) or ;"),
        }
        self.reader.rest = rest.get(1..).unwrap_or_default();
        if self.reader.rest.is_empty() {
            return refuse(rest, &format!("a number after {letter}"));
        }
        let value = self.reader.value()?;
        let text = rest.get(..rest.len() - self.reader.rest.len()).unwrap_or_default();
        // N and T are ordinal numbers, not measures; F may be above what any machine reaches.
        if value.abs() > LARGEST && !matches!(letter, 'N' | 'T' | 'F') {
            return refuse(text, &format!("a number within ±{LARGEST} after {letter}"));
        }
        Ok(Item::Word(Word { letter, value, text }))
    }

    fn assignment(&mut self) -> Result<Item<'t>, Refusal> {
        let text = self.reader.rest;
        let parameter = self.reader.parameter()?;
        if !self.reader.take("=") {
            return Err(Refusal::new(
                self.line,
                format!("`{text}`"),
                "= and a value, or a letter before the parameter",
            ));
        }
        Ok(Item::Set(parameter, self.reader.value()?))
    }
}

impl<'t, V: Values> Iterator for Words<'t, '_, V> {
    type Item = Result<Item<'t>, Refusal>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.reader.rest.is_empty() {
            return None;
        }
        let item = self.item();
        if item.is_err() {
            self.reader.rest = "";
        }
        Some(item)
    }
}
