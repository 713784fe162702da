//! O words: labels with sub, call, if, while, do, repeat and their ends.

use super::error::Refusal;
use super::expression::{Reader, Values};
use super::parameters::ARGUMENTS;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Sub,
    EndSub,
    Call,
    Do,
    While,
    Repeat,
    If,
    ElseIf,
    Else,
    EndIf,
    Break,
    Continue,
    EndWhile,
    EndRepeat,
    Return,
    /// O1234 alone: the number of a program.
    Program,
}

/// The longer one first where one begins with another.
const KINDS: [(&str, Kind); 15] = [
    ("SUB", Kind::Sub),
    ("ENDSUB", Kind::EndSub),
    ("CALL", Kind::Call),
    ("DO", Kind::Do),
    ("WHILE", Kind::While),
    ("REPEAT", Kind::Repeat),
    ("IF", Kind::If),
    ("ELSEIF", Kind::ElseIf),
    ("ELSE", Kind::Else),
    ("ENDIF", Kind::EndIf),
    ("BREAK", Kind::Break),
    ("CONTINUE", Kind::Continue),
    ("ENDWHILE", Kind::EndWhile),
    ("ENDREPEAT", Kind::EndRepeat),
    ("RETURN", Kind::Return),
];

/// A line that begins with O.
#[derive(Clone, Debug)]
pub(super) struct OWord {
    pub(super) kind: Kind,
    /// The number, or the name in upper case.
    pub(super) label: String,
    /// What follows.
    rest: String,
}

impl OWord {
    /// Reads the O word of a line cleaned by [`clean`](super::text::clean); `None` if it has none.
    pub(super) fn read(line: u32, text: &str, values: &impl Values) -> Result<Option<OWord>, Refusal> {
        let text = text.strip_prefix('N').map_or(text, |rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()));
        let Some(rest) = text.strip_prefix('O') else { return Ok(None) };
        let mut reader = Reader::new(line, rest, values);
        let label = if rest.starts_with('<') { reader.name()?.to_owned() } else { reader.whole()?.to_string() };
        let kind = KINDS.into_iter().find(|(name, _)| reader.take(name)).map(|(_, kind)| kind);
        let rest = reader.rest;
        let Some(kind) = kind.or(rest.is_empty().then_some(Kind::Program)) else {
            let names = KINDS.map(|(name, _)| name.to_ascii_lowercase()).join(" ");
            let needed = format!("a program number O1234 on a separate line, or {names} after the label");
            return Err(Refusal::new(line, format!("`{text}`"), needed));
        };
        Ok(Some(OWord { kind, label, rest: rest.to_owned() }))
    }

    /// As it is written: `O100 endwhile`.
    pub(super) fn text(&self, kind: Kind) -> String {
        let label = if self.label.bytes().all(|b| b.is_ascii_digit()) {
            self.label.clone()
        } else {
            format!("<{}>", self.label.to_ascii_lowercase())
        };
        let name = KINDS.iter().find(|(_, of)| *of == kind).map_or("", |(name, _)| name);
        format!("O{label} {}", name.to_ascii_lowercase()).trim_end().to_owned()
    }

    /// The expression of if, elseif, while, repeat.
    pub(super) fn condition(&self, line: u32, values: &impl Values) -> Result<f64, Refusal> {
        let mut reader = Reader::new(line, &self.rest, values);
        let value = reader.bracketed()?;
        nothing_more(line, reader.rest)?;
        Ok(value)
    }

    /// The expression that endsub and return may have.
    pub(super) fn result(&self, line: u32, values: &impl Values) -> Result<Option<f64>, Refusal> {
        if self.rest.is_empty() { Ok(None) } else { self.condition(line, values).map(Some) }
    }

    /// The arguments of a call; those that it omits are zero.
    pub(super) fn arguments(&self, line: u32, values: &impl Values) -> Result<[f64; ARGUMENTS], Refusal> {
        let mut reader = Reader::new(line, &self.rest, values);
        let mut arguments = [0.0; ARGUMENTS];
        for argument in &mut arguments {
            if !reader.rest.starts_with('[') {
                break;
            }
            *argument = reader.bracketed()?;
        }
        if reader.rest.starts_with('[') {
            return Err(Refusal::new(line, "more arguments", format!("at most {ARGUMENTS}")));
        }
        nothing_more(line, reader.rest)?;
        Ok(arguments)
    }

    /// Refuses anything after the word.
    pub(super) fn alone(&self, line: u32) -> Result<(), Refusal> {
        nothing_more(line, &self.rest)
    }
}

fn nothing_more(line: u32, rest: &str) -> Result<(), Refusal> {
    if rest.is_empty() {
        return Ok(());
    }
    Err(Refusal::new(line, format!("`{rest}` after an O word"), "an O word on a separate line"))
}
