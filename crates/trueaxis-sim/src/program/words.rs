//! Splits the text of a line into letters with numbers.

use super::error::{Refusal, THROUGH_LINUXCNC};

/// Largest magnitude of a number in a program. Beyond it f64 no longer resolves a nanometre.
pub(super) const LARGEST: f64 = 1.0e6;

/// A letter with its number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Word<'t> {
    /// Upper case.
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

/// The words of a line cleaned by [`clean`](super::text::clean).
pub(super) struct Words<'t> {
    line: u32,
    rest: &'t str,
}

impl<'t> Words<'t> {
    pub(super) fn new(line: u32, text: &'t str) -> Self {
        Words { line, rest: text }
    }

    fn word(&mut self) -> Result<Word<'t>, Refusal> {
        let (line, rest) = (self.line, self.rest);
        let refuse = |found: &str, needed: &str| Err(Refusal::new(line, format!("`{found}`"), needed));
        let letter = rest.chars().next().unwrap_or(' ');
        match letter {
            '#' | '[' => return refuse(rest, &format!("numbers; parameters and expressions {THROUGH_LINUXCNC}")),
            'A'..='Z' => {}
            '/' => return refuse(rest, "/ only at the beginning of a line"),
            '%' => return refuse(rest, "% on a separate line"),
            _ => return refuse(rest, "words of a letter and a number, ( ) or ;"),
        }
        let number = rest.get(1..).unwrap_or_default();
        if number.starts_with(['#', '[']) {
            return refuse(rest, &format!("a number after {letter}; parameters and expressions {THROUGH_LINUXCNC}"));
        }
        let signs = usize::from(number.starts_with(['+', '-']));
        let digits = number.bytes().skip(signs).take_while(|b| b.is_ascii_digit() || *b == b'.').count();
        let (number, after) = number.split_at(signs + digits);
        let text = rest.get(..1 + number.len()).unwrap_or_default();
        self.rest = after;
        let value = match number.parse::<f64>() {
            Ok(value) => value,
            Err(_) => return refuse(text, &format!("a number after {letter}")),
        };
        // N and T are ordinal numbers, not measures.
        if value.abs() > LARGEST && !matches!(letter, 'N' | 'T') {
            return refuse(text, &format!("a number within ±{LARGEST} after {letter}"));
        }
        Ok(Word { letter, value, text })
    }
}

impl<'t> Iterator for Words<'t> {
    type Item = Result<Word<'t>, Refusal>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let word = self.word();
        if word.is_err() {
            self.rest = "";
        }
        Some(word)
    }
}
