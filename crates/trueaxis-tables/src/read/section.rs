//! Typed access to a section of a TOML file, with lines, and no key unread.

use crate::error::FileError;
use crate::origin::Origin;
use std::cell::RefCell;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value with its line.
pub(super) struct Found<T> {
    pub(super) value: T,
    pub(super) line: u32,
    /// Full name of the key.
    pub(super) key: String,
    /// As written.
    pub(super) text: String,
}

/// The line, from 1, of a byte of a text.
pub(super) fn line(text: &str, offset: usize) -> u32 {
    let before = text.as_bytes().get(..offset).unwrap_or_default();
    u32::try_from(1 + before.iter().filter(|byte| **byte == b'\n').count()).unwrap_or(0)
}

/// A section, e.g. `[axis.X.limits]`.
pub(super) struct Section<'a> {
    origin: &'a Origin,
    text: &'a str,
    table: &'a DeTable<'a>,
    /// `axis.X.limits.`, empty for the file as a whole.
    prefix: String,
    asked: RefCell<Vec<String>>,
    /// Full names of the numbers asked for in all sections, and how many each is.
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

    fn refuse(&self, key: &str, span: &Range<usize>, needed: impl Into<String>) -> FileError {
        let found = self.text.get(span.clone()).unwrap_or_default();
        self.origin.at(line(self.text, span.start), &format!("{}{key}", self.prefix), found, needed)
    }

    fn value(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.asked.borrow_mut().push(key.to_owned());
        self.table.get(key)
    }

    fn found<T>(&self, key: &str, span: &Range<usize>, value: T) -> Found<T> {
        let text = self.text.get(span.clone()).unwrap_or_default().to_owned();
        Found { value, line: line(self.text, span.start), key: format!("{}{key}", self.prefix), text }
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

    /// A finite number.
    pub(super) fn number(&self, key: &str) -> Result<Option<Found<f64>>, FileError> {
        self.numbers.borrow_mut().push((format!("{}{key}", self.prefix), 1));
        let Some(value) = self.value(key) else { return Ok(None) };
        Ok(Some(self.found(key, &value.span(), self.plain_number(key, value)?)))
    }

    /// A list of `N` finite numbers.
    pub(super) fn numbers<const N: usize>(&self, key: &str) -> Result<Option<Found<[f64; N]>>, FileError> {
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

    /// Stores a number where the key is given.
    pub(super) fn set(&self, key: &str, to: &mut f64, convert: impl Fn(f64) -> f64) -> Result<(), FileError> {
        if let Some(found) = self.number(key)? {
            *to = convert(found.value);
        }
        Ok(())
    }

    /// Stores a list of numbers where the key is given; whether it is.
    pub(super) fn set_all<const N: usize>(&self, key: &str, to: &mut [f64; N]) -> Result<bool, FileError> {
        let found = self.numbers(key)?;
        let given = found.is_some();
        *to = found.map_or(*to, |found| found.value);
        Ok(given)
    }

    /// A whole number that fits into its type.
    pub(super) fn whole<T: TryFrom<i64>>(&self, key: &str, needed: &str) -> Result<Option<T>, FileError> {
        let Some(found) = self.number(key)? else { return Ok(None) };
        let value = found.value;
        let whole = (value.fract() == 0.0 && value.abs() < 9e15).then_some(value as i64);
        let whole = whole.and_then(|value| T::try_from(value).ok()).ok_or_else(|| self.wrong(&found, needed))?;
        Ok(Some(whole))
    }

    /// Stores a whole number where the key is given.
    pub(super) fn set_whole<T: TryFrom<i64>>(&self, key: &str, to: &mut T, needed: &str) -> Result<(), FileError> {
        if let Some(value) = self.whole(key, needed)? {
            *to = value;
        }
        Ok(())
    }

    /// Stores the sense of an axis where the key is given.
    pub(super) fn set_direction(&self, key: &str, to: &mut i8) -> Result<(), FileError> {
        if let Some(found) = self.number(key)? {
            *to = match found.value {
                1.0 => 1,
                -1.0 => -1,
                _ => return Err(self.wrong(&found, "1 or -1")),
            };
        }
        Ok(())
    }

    /// A string.
    pub(super) fn string(&self, key: &str) -> Result<Option<Found<&'a str>>, FileError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        match value.get_ref().as_str() {
            Some(string) => Ok(Some(self.found(key, &value.span(), string))),
            None => Err(self.refuse(key, &value.span(), "a string")),
        }
    }

    /// One of several words.
    pub(super) fn choice<T: Copy>(&self, key: &str, words: [(&str, T); 2]) -> Result<Option<T>, FileError> {
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
    pub(super) fn boolean(&self, key: &str) -> Result<Option<bool>, FileError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        match value.get_ref().as_bool() {
            Some(given) => Ok(Some(given)),
            None => Err(self.refuse(key, &value.span(), "true or false")),
        }
    }

    /// A section in this one.
    pub(super) fn section(&self, key: &str) -> Result<Option<Section<'a>>, FileError> {
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

    /// Refuses every key that was not asked for.
    pub(super) fn finish(self, needed: Option<&str>) -> Result<(), FileError> {
        let asked = self.asked.borrow();
        let unknown = self.table.keys().filter(|key| !asked.contains(&key.get_ref().to_string()));
        // In the order of the file.
        match unknown.min_by_key(|key| key.span().start) {
            None => Ok(()),
            Some(key) => {
                let known = format!("one of {}", asked.join(", "));
                Err(self.refuse(key.get_ref(), &key.span(), needed.map_or(known, str::to_owned)))
            }
        }
    }

    /// An error at a value.
    pub(super) fn wrong<T>(&self, at: &Found<T>, needed: impl Into<String>) -> FileError {
        self.origin.at(at.line, &at.key, &at.text, needed)
    }

    /// An error because a key is missing.
    pub(super) fn missing(&self, key: &str, needed: &str) -> FileError {
        self.origin.at(0, &format!("{}{key}", self.prefix), "nothing", needed)
    }
}
