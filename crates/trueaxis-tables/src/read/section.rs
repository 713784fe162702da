//! Typed access to a section of a TOML file, with lines, and no key unread.

use crate::error::FileError;
use crate::origin::Origin;
use crate::text::line_at;
use std::cell::RefCell;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use trueaxis::machine::Axis;

/// A value with its line and key.
pub(super) struct Found<T> {
    pub(super) value: T,
    pub(super) line: u32,
    /// Full name of the key.
    pub(super) key: String,
    /// As written.
    pub(super) text: String,
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

    fn found<T>(&self, key: &str, span: &Range<usize>, value: T) -> Found<T> {
        let text = self.text.get(span.clone()).unwrap_or_default().to_owned();
        Found { value, line: self.line(span), key: format!("{}{key}", self.prefix), text }
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

    /// Stores a number, converted, where the key is given.
    pub(super) fn store(&self, to: &mut f64, key: &str, convert: impl Fn(f64) -> f64) -> Result<(), FileError> {
        if let Some(found) = self.number(key)? {
            *to = convert(found.value);
        }
        Ok(())
    }

    /// Stores a list of numbers where the key is given; whether it is.
    pub(super) fn store_all<const N: usize>(&self, to: &mut [f64; N], key: &str) -> Result<bool, FileError> {
        let found = self.numbers(key)?;
        let given = found.is_some();
        if let Some(found) = found {
            *to = found.value;
        }
        Ok(given)
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

    /// The sections of an array of tables, `[[key]]`, in the order of the file; none where the key is not there.
    pub(super) fn sections(&self, key: &str) -> Result<Vec<Section<'a>>, FileError> {
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

    /// A list of pairs of finite numbers.
    pub(super) fn pairs(&self, key: &str) -> Result<Option<Found<Vec<[f64; 2]>>>, FileError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        let refuse = || self.refuse(key, &value.span(), "a list of pairs of numbers");
        let mut pairs = Vec::new();
        for pair in value.get_ref().as_array().ok_or_else(refuse)? {
            let pair = pair.get_ref().as_array().filter(|pair| pair.len() == 2).ok_or_else(refuse)?;
            let mut numbers = [0.0; 2];
            for (number, value) in numbers.iter_mut().zip(pair.iter()) {
                *number = self.plain_number(key, value)?;
            }
            pairs.push(numbers);
        }
        Ok(Some(self.found(key, &value.span(), pairs)))
    }

    /// A list of axes by their letters.
    pub(super) fn axes(&self, key: &str) -> Result<Option<Found<Vec<Axis>>>, FileError> {
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
    pub(super) fn axis(&self, key: &str) -> Result<Option<Found<Axis>>, FileError> {
        let Some(found) = self.string(key)? else { return Ok(None) };
        let letter = found.value.chars().next().filter(|_| found.value.len() == 1);
        match letter.and_then(Axis::from_letter) {
            Some(value) => Ok(Some(Found { value, line: found.line, key: found.key, text: found.text })),
            None => Err(self.wrong(&found, "an axis, like \"X\"")),
        }
    }

    /// The line of the section's first key, for what is wrong with all of it.
    pub(super) fn first_line(&self) -> u32 {
        self.table.keys().map(|key| self.line(&key.span())).min().unwrap_or(0)
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

    /// An error at a line.
    pub(super) fn at(&self, line: u32, key: &str, found: &str, needed: impl Into<String>) -> FileError {
        self.origin.at(line, &format!("{}{key}", self.prefix), found, needed)
    }

    /// An error because a key is missing in one of several sections of the same name: at its first line.
    pub(super) fn missing_here(&self, key: &str, needed: &str) -> FileError {
        self.at(self.first_line(), key, "nothing", needed)
    }

    /// An error because a key is missing.
    pub(super) fn missing(&self, key: &str, needed: &str) -> FileError {
        self.origin.at(0, &format!("{}{key}", self.prefix), "nothing", needed)
    }
}
