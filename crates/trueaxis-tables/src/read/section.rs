//! Typed access to a section of a TOML file, with line numbers and a check for unread keys.
//!
//! Error of every function: a value of the wrong kind, with its line and the key's full name.

use crate::error::FileError;
use crate::origin::Origin;
use crate::text::{self, line_at, one_of};
use std::cell::RefCell;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use trueaxis::machine::Axis;

/// Reads a TOML text; `file` is only named in errors. `read` receives the file as a section and ends with [`Section::finish`].
///
/// # Errors
/// Text that is not TOML, and errors of `read`.
pub fn read_toml<T>(
    text: &str,
    file: &Path,
    read: impl FnOnce(Section<'_>) -> Result<T, FileError>,
) -> Result<T, FileError> {
    let origin = Origin::new(file);
    let document = DeTable::parse(text).map_err(|error| {
        let line = error.span().map_or(1, |span| line_at(text, span.start));
        origin.at(line, "", error.message(), "a valid TOML file")
    })?;
    let numbers = RefCell::default();
    read(Section::new(&origin, text, document.get_ref(), &numbers))
}

/// A value with its line and key.
#[derive(Clone, Debug)]
pub struct KeyValue<T> {
    /// The value.
    pub value: T,
    /// Line, from 1.
    pub line: u32,
    /// Full name of the key.
    pub key: String,
    /// As written.
    pub text: String,
}

/// A section, e.g. `[axis.X.limits]`.
pub struct Section<'a> {
    origin: &'a Origin,
    text: &'a str,
    table: &'a DeTable<'a>,
    /// `axis.X.limits.`, empty for the file as a whole.
    prefix: String,
    asked: RefCell<Vec<String>>,
    /// Full names of the numbers requested in all sections, with their counts.
    numbers: &'a RefCell<Vec<(String, usize)>>,
}

impl<'a> Section<'a> {
    pub(super) fn new(
        origin: &'a Origin,
        text: &'a str,
        table: &'a DeTable<'a>,
        numbers: &'a RefCell<Vec<(String, usize)>>,
    ) -> Self {
        Section { origin, text, table, prefix: String::new(), asked: RefCell::default(), numbers }
    }

    fn line(&self, span: &Range<usize>) -> u32 {
        line_at(self.text, span.start)
    }

    fn refuse(&self, key: &str, span: &Range<usize>, needed: impl Into<String>) -> FileError {
        let found = self.text.get(span.clone()).unwrap_or_default();
        self.origin.at(self.line(span), &format!("{}{key}", self.prefix), found, needed)
    }

    fn value(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.asked.borrow_mut().push(key.to_owned());
        self.table.get(key)
    }

    fn found<T>(&self, key: &str, span: &Range<usize>, value: T) -> KeyValue<T> {
        let text = self.text.get(span.clone()).unwrap_or_default().to_owned();
        KeyValue { value, line: self.line(span), key: format!("{}{key}", self.prefix), text }
    }

    fn plain_number(&self, key: &str, value: &Spanned<DeValue<'a>>) -> Result<f64, FileError> {
        let number = match value.get_ref() {
            DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
            DeValue::Integer(integer) => {
                i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|integer| integer as f64)
            }
            _ => return Err(self.refuse(key, &value.span(), "a number")),
        };
        match number {
            Some(number) if number.is_finite() => Ok(number),
            _ => Err(self.refuse(key, &value.span(), "a finite number")),
        }
    }

    /// Stores a number, converted, if the section has the key.
    pub fn store(&self, to: &mut f64, key: &str, convert: impl Fn(f64) -> f64) -> Result<(), FileError> {
        if let Some(found) = self.number(key)? {
            *to = convert(found.value);
        }
        Ok(())
    }

    /// Stores a list of numbers if the section has the key; returns whether it has.
    pub fn store_all<const N: usize>(&self, to: &mut [f64; N], key: &str) -> Result<bool, FileError> {
        let found = self.numbers(key)?;
        let given = found.is_some();
        if let Some(found) = found {
            *to = found.value;
        }
        Ok(given)
    }

    /// A finite number.
    pub fn number(&self, key: &str) -> Result<Option<KeyValue<f64>>, FileError> {
        self.numbers.borrow_mut().push((format!("{}{key}", self.prefix), 1));
        let Some(value) = self.value(key) else { return Ok(None) };
        Ok(Some(self.found(key, &value.span(), self.plain_number(key, value)?)))
    }

    /// A list of `N` finite numbers.
    pub fn numbers<const N: usize>(&self, key: &str) -> Result<Option<KeyValue<[f64; N]>>, FileError> {
        self.numbers.borrow_mut().push((format!("{}{key}", self.prefix), N));
        let Some(value) = self.value(key) else { return Ok(None) };
        let needed = format!("a list of {N} numbers");
        let Some(list) = value.get_ref().as_array().filter(|list| list.len() == N) else {
            return Err(self.refuse(key, &value.span(), needed));
        };
        let mut numbers = [0.0; N];
        for (number, value) in numbers.iter_mut().zip(list.iter()) {
            *number = self.plain_number(key, value)?;
        }
        Ok(Some(self.found(key, &value.span(), numbers)))
    }

    /// A string.
    pub fn string(&self, key: &str) -> Result<Option<KeyValue<&'a str>>, FileError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        match value.get_ref().as_str() {
            Some(string) => Ok(Some(self.found(key, &value.span(), string))),
            None => Err(self.refuse(key, &value.span(), "a string")),
        }
    }

    /// One of several words.
    pub fn choice<T: Copy, const N: usize>(&self, key: &str, words: [(&str, T); N]) -> Result<Option<T>, FileError> {
        let Some(found) = self.string(key)? else { return Ok(None) };
        match words.iter().find(|(word, _)| *word == found.value) {
            Some((_, choice)) => Ok(Some(*choice)),
            None => {
                let needed = words.map(|(word, _)| format!("{word:?}")).join(" or ");
                Err(self.origin.at(found.line, &found.key, &found.text, needed))
            }
        }
    }

    /// True or false.
    pub fn boolean(&self, key: &str) -> Result<Option<bool>, FileError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        match value.get_ref().as_bool() {
            Some(given) => Ok(Some(given)),
            None => Err(self.refuse(key, &value.span(), "true or false")),
        }
    }

    /// A subsection.
    pub fn section(&self, key: &str) -> Result<Option<Section<'a>>, FileError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        let Some(table) = value.get_ref().as_table() else {
            return Err(self.refuse(key, &value.span(), format!("a section [{}{key}]", self.prefix)));
        };
        let prefix = format!("{}{key}.", self.prefix);
        Ok(Some(Section {
            origin: self.origin,
            text: self.text,
            table,
            prefix,
            asked: RefCell::default(),
            numbers: self.numbers,
        }))
    }

    /// The sections of an array of tables, `[[key]]`, in the order of the file; empty if the key is absent.
    pub fn sections(&self, key: &str) -> Result<Vec<Section<'a>>, FileError> {
        let Some(value) = self.value(key) else { return Ok(Vec::new()) };
        let refuse = |span| self.refuse(key, &span, format!("sections [[{}{key}]]", self.prefix));
        let list = value.get_ref().as_array().ok_or_else(|| refuse(value.span()))?;
        let of = |item: &'a Spanned<DeValue<'a>>| {
            let table = item.get_ref().as_table().ok_or_else(|| refuse(item.span()))?;
            let prefix = format!("{}{key}.", self.prefix);
            Ok(Section { table, prefix, asked: RefCell::default(), ..*self })
        };
        list.iter().map(of).collect()
    }

    /// A list of lists of `N` finite numbers.
    pub fn lists<const N: usize>(&self, key: &str) -> Result<Option<KeyValue<Vec<[f64; N]>>>, FileError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        let what = if N == 2 { String::from("pairs of numbers") } else { format!("lists of {N} numbers") };
        let refuse = || self.refuse(key, &value.span(), format!("a list of {what}"));
        let mut lists = Vec::new();
        for list in value.get_ref().as_array().ok_or_else(refuse)? {
            let list = list.get_ref().as_array().filter(|list| list.len() == N).ok_or_else(refuse)?;
            let mut numbers = [0.0; N];
            for (number, value) in numbers.iter_mut().zip(list.iter()) {
                *number = self.plain_number(key, value)?;
            }
            lists.push(numbers);
        }
        Ok(Some(self.found(key, &value.span(), lists)))
    }

    /// A list of finite numbers, of any length.
    pub fn list(&self, key: &str) -> Result<Option<KeyValue<Vec<f64>>>, FileError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        let list = value.get_ref().as_array();
        let list = list.ok_or_else(|| self.refuse(key, &value.span(), "a list of numbers"))?;
        let numbers = list.iter().map(|value| self.plain_number(key, value)).collect::<Result<_, _>>()?;
        Ok(Some(self.found(key, &value.span(), numbers)))
    }

    /// A list of strings, of any length.
    pub fn strings(&self, key: &str) -> Result<Option<KeyValue<Vec<&'a str>>>, FileError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        let refuse = || self.refuse(key, &value.span(), "a list of strings");
        let list = value.get_ref().as_array().ok_or_else(refuse)?;
        let strings: Option<Vec<&'a str>> = list.iter().map(|item| item.get_ref().as_str()).collect();
        Ok(Some(self.found(key, &value.span(), strings.ok_or_else(refuse)?)))
    }

    /// A list of axes by their letters.
    pub fn axes(&self, key: &str) -> Result<Option<KeyValue<Vec<Axis>>>, FileError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        let refuse = || self.refuse(key, &value.span(), "a list of axes, like [\"X\", \"Y\"]");
        let axis = |item: &Spanned<DeValue<'a>>| {
            let mut letters = item.get_ref().as_str()?.chars();
            letters.next().filter(|_| letters.next().is_none()).and_then(Axis::from_letter)
        };
        let axes: Option<Vec<Axis>> = value.get_ref().as_array().ok_or_else(refuse)?.iter().map(axis).collect();
        Ok(Some(self.found(key, &value.span(), axes.ok_or_else(refuse)?)))
    }

    /// An axis by its letter.
    pub fn axis(&self, key: &str) -> Result<Option<KeyValue<Axis>>, FileError> {
        let Some(found) = self.string(key)? else { return Ok(None) };
        let letter = found.value.chars().next().filter(|_| found.value.len() == 1);
        match letter.and_then(Axis::from_letter) {
            Some(value) => Ok(Some(KeyValue { value, line: found.line, key: found.key, text: found.text })),
            None => Err(self.wrong(&found, "an axis, like \"X\"")),
        }
    }

    /// The line of the section's first key, for errors about the whole section.
    pub fn first_line(&self) -> u32 {
        self.table.keys().map(|key| self.line(&key.span())).min().unwrap_or(0)
    }

    /// Refuses every key that was not requested.
    pub fn finish(self, needed: Option<&str>) -> Result<(), FileError> {
        let asked = self.asked.borrow();
        let unknown = self.table.keys().filter(|key| !asked.contains(&key.get_ref().to_string()));
        // The first in the order of the file.
        match unknown.min_by_key(|key| key.span().start) {
            None => Ok(()),
            Some(key) => {
                let known = one_of(key.get_ref(), asked.iter().map(AsRef::as_ref), ", ");
                Err(self.refuse(key.get_ref(), &key.span(), needed.map_or(known, str::to_owned)))
            }
        }
    }

    /// An error at a value.
    pub fn wrong<T>(&self, at: &KeyValue<T>, needed: impl Into<String>) -> FileError {
        self.origin.at(at.line, &at.key, &at.text, needed)
    }

    /// An error at a line.
    pub fn at(&self, line: u32, key: &str, found: &str, needed: impl Into<String>) -> FileError {
        self.origin.at(line, &format!("{}{key}", self.prefix), found, needed)
    }

    /// An error because a key is missing in one of several sections of the same name, at the section's first line or at a
    /// misspelling of the key.
    pub fn missing_here(&self, key: &str, needed: &str) -> FileError {
        self.misspelt(key, needed).unwrap_or_else(|| self.at(self.first_line(), key, "nothing", needed))
    }

    /// An error because a key is missing, at a misspelling of the key if there is one.
    pub fn missing(&self, key: &str, needed: &str) -> FileError {
        let nothing = || self.origin.at(0, &format!("{}{key}", self.prefix), "nothing", needed);
        self.misspelt(key, needed).unwrap_or_else(nothing)
    }

    /// An error at a key that is not requested and is nearly spelt like the missing one.
    fn misspelt(&self, missing: &str, needed: &str) -> Option<FileError> {
        let asked = self.asked.borrow();
        let unknown = self.table.keys().filter(|key| !asked.iter().any(|asked| *asked == *key.get_ref()));
        let near = unknown.filter(|key| text::near(key.get_ref(), missing)).min_by_key(|key| key.span().start)?;
        Some(self.refuse(near.get_ref(), &near.span(), format!("{missing}: {needed}")))
    }
}
