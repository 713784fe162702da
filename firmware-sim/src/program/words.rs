//! From text to the words of each line, by the `gcode` crate's parser.
//!
//! The parser recovers from errors and goes on; a controller must not. Every diagnostic is therefore an error here, and
//! so is every character of a line that no word, comment or `%` accounts for. The parser's numbers are f32: values are
//! read again, in f64, from the text each word spans.

use std::ops::{ControlFlow, Range};

use gcode::core::{
    BlockVisitor, CommandVisitor, Diagnostics, HasDiagnostics, Number, ProgramVisitor, Span, TokenType, Value,
};

use super::error::Refusal;

/// Largest magnitude of a number in a program. Beyond it f64 no longer resolves a nanometre.
const LARGEST: f64 = 1.0e6;

/// A letter with its number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Word {
    /// Upper case.
    pub(super) letter: char,
    pub(super) value: f64,
    /// As written, without blanks.
    pub(super) text: String,
}

impl Word {
    /// Number of a G or M word in tenths (G5.2 is 52), if it has at most one decimal.
    pub(super) fn tenths(&self) -> Option<u32> {
        let tenths = (self.value * 10.0).round();
        ((0.0..100_000.0).contains(&tenths) && (self.value * 10.0 - tenths).abs() < 1.0e-6).then_some(tenths as u32)
    }
}

/// The words of one line; comments are gone.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Block {
    /// Line in the file, from 1.
    pub(super) line: u32,
    pub(super) words: Vec<Word>,
    /// The line is the delimiter `%`.
    pub(super) percent: bool,
}

/// Reads one line (without its line end).
pub(super) fn read_line(line: u32, text: &str) -> Result<Block, Refusal> {
    refuse_long_commands(line, text)?;
    let mut reader = Reader { text, ..Reader::default() };
    gcode::core::parse(text, &mut reader);
    if let Some((found, needed)) = reader.problem {
        return Err(Refusal::new(line, found, needed));
    }
    if let Some(at) = first_unread(text, &reader.read) {
        let rest = text.get(at..).unwrap_or_default();
        return Err(Refusal::new(line, format!("`{}`", rest.trim_end()), "words of a letter and a number, ( ) or ;"));
    }
    let mut words = Vec::with_capacity(reader.words.len());
    for range in &reader.words {
        words.push(word(line, text.get(range.clone()).unwrap_or_default())?);
    }
    if reader.percent > 0 && (reader.percent > 1 || !words.is_empty()) {
        return Err(Refusal::new(line, "% beside other words", "% on a line of its own"));
    }
    Ok(Block { line, words, percent: reader.percent > 0 })
}

/// The parser computes ten times the number of a G, M or T word in 32 bits, unchecked: keep such words short.
fn refuse_long_commands(line: u32, text: &str) -> Result<(), Refusal> {
    let mut rest = text.chars();
    let mut digits = None;
    while let Some(c) = rest.next() {
        digits = match c {
            ';' => break,
            '(' => {
                rest.by_ref().find(|c| *c == ')');
                None
            }
            'G' | 'M' | 'T' | 'g' | 'm' | 't' => Some(0),
            ' ' | '\t' | '\r' => digits,
            '0'..='9' => digits.map(|n| n + 1),
            _ => None,
        };
        if digits.is_some_and(|n| n > 8) {
            return Err(Refusal::new(line, "a G, M or T number of more than 8 digits", "a supported word"));
        }
    }
    Ok(())
}

/// Position of the first character that is neither blank nor part of anything read.
fn first_unread(text: &str, read: &[Range<usize>]) -> Option<usize> {
    text.char_indices()
        .find(|(at, c)| !matches!(c, ' ' | '\t' | '\r') && !read.iter().any(|range| range.contains(at)))
        .map(|(at, _)| at)
}

fn word(line: u32, text: &str) -> Result<Word, Refusal> {
    let text: String = text.chars().filter(|c| !matches!(c, ' ' | '\t' | '\r')).collect();
    let letter = text.chars().next().unwrap_or(' ').to_ascii_uppercase();
    let number = text.get(1..).unwrap_or_default();
    match number.parse::<f64>() {
        Ok(value) if value.abs() <= LARGEST => Ok(Word { letter, value, text }),
        _ => Err(Refusal::new(line, format!("`{text}`"), format!("a number within ±{LARGEST} after {letter}"))),
    }
}

/// Collects what the parser reports of one line.
#[derive(Default)]
struct Reader<'a> {
    text: &'a str,
    words: Vec<Range<usize>>,
    read: Vec<Range<usize>>,
    percent: u32,
    /// First diagnostic: found, needed.
    problem: Option<(String, String)>,
}

impl Reader<'_> {
    fn add(&mut self, range: Range<usize>) {
        self.words.push(range.clone());
        self.read.push(range);
    }

    /// Adds the G, M or T word at the beginning of a command's span, which goes on to its last argument.
    fn add_command(&mut self, span: Span) {
        let rest = self.text.get(span.start..span.end()).unwrap_or_default();
        let length = rest
            .char_indices()
            .skip(1)
            .find(|(_, c)| !matches!(c, '0'..='9' | '.' | ' ' | '\t' | '\r'))
            .map_or(rest.len(), |(at, _)| at);
        self.add(span.start..span.start + length);
    }

    fn refuse(&mut self, found: impl Into<String>, needed: impl Into<String>) {
        self.problem.get_or_insert((found.into(), needed.into()));
    }
}

impl Diagnostics for Reader<'_> {
    fn emit_unknown_content(&mut self, text: &str, _: Span) {
        self.refuse(format!("`{text}`"), "words of a letter and a number, ( ) or ;");
    }

    fn emit_unexpected(&mut self, actual: &str, expected: &[TokenType], _: Span) {
        let needed: Vec<&str> = expected.iter().map(|kind| kind.as_str()).collect();
        let needed = if needed == ["number"] || needed == ["eof"] {
            format!("a number after the letter {actual}")
        } else {
            "a letter before every number, N only at the beginning, no block delete".to_owned()
        };
        self.refuse(format!("`{}`", actual.escape_default()), needed);
    }

    // A G, M or T number it cannot read is reported with a private type; such text counts as unread.

    fn emit_parse_int_error(&mut self, value: &str, _: std::num::ParseIntError, _: Span) {
        self.refuse(format!("`{value}`"), "a whole line number");
    }
}

/// One line, and one command in it, feed the same reader.
struct Line<'r, 'a>(&'r mut Reader<'a>);

impl ProgramVisitor for Reader<'_> {
    fn start_block(&mut self) -> ControlFlow<(), impl BlockVisitor + '_> {
        ControlFlow::Continue(Line(self))
    }
}

impl HasDiagnostics for Line<'_, '_> {
    fn diagnostics(&mut self) -> &mut dyn Diagnostics {
        self.0
    }
}

impl BlockVisitor for Line<'_, '_> {
    fn line_number(&mut self, _: u32, span: Span) {
        self.0.add(span.start..span.end());
    }

    fn comment(&mut self, value: &str, span: Span) {
        // The parser would nest parentheses and let a comment run over the following lines.
        if value.starts_with('(') && (!value.ends_with(')') || value.chars().filter(|c| *c == '(').count() > 1) {
            self.0.refuse(format!("`{value}`"), "a comment closed on its line, without ( inside");
        }
        self.0.read.push(span.start..span.end());
    }

    fn program_number(&mut self, _: u32, span: Span) {
        self.0.add(span.start..span.end());
    }

    fn program_delimiter(&mut self, span: Span) {
        self.0.percent += 1;
        self.0.read.push(span.start..span.end());
    }

    fn word_address(&mut self, _: char, _: Value<'_>, span: Span) {
        self.0.add(span.start..span.end());
    }

    fn start_general_code(&mut self, _: Number) -> ControlFlow<(), impl CommandVisitor + '_> {
        ControlFlow::Continue(Line(self.0))
    }

    fn start_miscellaneous_code(&mut self, _: Number) -> ControlFlow<(), impl CommandVisitor + '_> {
        ControlFlow::Continue(Line(self.0))
    }

    fn start_tool_change_code(&mut self, _: Number) -> ControlFlow<(), impl CommandVisitor + '_> {
        ControlFlow::Continue(Line(self.0))
    }
}

impl CommandVisitor for Line<'_, '_> {
    fn argument(&mut self, _: char, _: Value<'_>, span: Span) {
        self.0.add(span.start..span.end());
    }

    fn end_command(self, span: Span) {
        self.0.add_command(span);
    }
}
