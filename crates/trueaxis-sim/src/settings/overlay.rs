//! Settings from TOML: given values replace present ones.

use super::Settings;
use crate::message::LONGEST_FOUND;
use crate::plant::drive::{ScaleAt, Variant};
use crate::plant::variation::DRIVES;
use std::collections::BTreeMap;
use std::fmt;
use toml::de::DeTable;
use toml::{Table, Value};
use trueaxis_tables::Keys;
use trueaxis_tables::text::{line_at, one_line, one_of};

/// Most characters of an error's `needed`, which may list every setting.
const LONGEST_NEEDED: usize = 1200;

/// Key of a drive's table that names a tuned drive. The drive's figures replace it; it is not a setting itself.
const VARIANT: &str = "variant";

/// A setting that is refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SettingError {
    /// File that it comes from, if any.
    pub file: Option<String>,
    /// Line in the file or text, from 1.
    pub line: u32,
    /// The setting; empty if the text is not TOML.
    pub key: String,
    /// The value of the setting, or the defect in it.
    pub found: String,
    /// Accepted range or keys.
    pub needed: String,
}

impl fmt::Display for SettingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{file}:{}: ", self.line)?;
        }
        if !self.key.is_empty() {
            write!(f, "{}: ", self.key)?;
        }
        write!(f, "found {}, needed {}", self.found, self.needed)
    }
}

impl std::error::Error for SettingError {}

fn wrong(line: u32, key: &str, found: String, needed: String) -> SettingError {
    SettingError {
        file: None,
        line,
        key: one_line(key, LONGEST_FOUND),
        found: one_line(&found, LONGEST_FOUND),
        needed: one_line(&needed, LONGEST_NEEDED),
    }
}

/// Extent of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extent {
    /// The range of every setting.
    Ranges,
    /// Also whether they agree with each other.
    All,
}

/// Refuses the first setting out of its range, then the first that does not agree with others; `line` finds the line of a key.
pub(super) fn check(settings: &Settings, extent: Extent, line: impl Fn(&str) -> u32) -> Result<(), SettingError> {
    if let Some((key, found, needed)) = settings.out_of_range() {
        return Err(wrong(line(&key), &key, found.to_string(), needed));
    }
    match settings.disagreement().filter(|_| extent == Extent::All) {
        Some((key, of)) => Err(wrong(line(&key), &key, of.found, of.needed)),
        None => Ok(()),
    }
}

impl SettingError {
    pub(super) fn in_file(self, file: &str) -> SettingError {
        SettingError { file: Some(file.to_owned()), ..self }
    }
}

/// Keys that may be left out, each with a value of its type that marks it as absent.
fn optional() -> [(&'static str, Value); 2] {
    [("temperature_c", Value::Float(f64::NAN)), ("origin_mm", Value::Array(Vec::new()))]
}

/// Names that a setting can have, for a key with names.
fn names(key: &str) -> Option<&'static [&'static str]> {
    match key {
        "drive.scale_at" => Some(&ScaleAt::NAMES),
        _ if key.starts_with("axis.") && key.ends_with(".drive") => Some(&DRIVES),
        _ => None,
    }
}

/// Replaces the drive of all axes by the variant that `given` names, and takes the name out of it. An error as of [`merge`].
fn choose_variant(all: &mut Table, given: &mut Table) -> Result<(), Wrong> {
    let name = given.get_mut("drive").and_then(Value::as_table_mut).and_then(|drive| drive.remove(VARIANT));
    let Some(name) = name else { return Ok(()) };
    let key = format!("drive.{VARIANT}");
    let variant = match &name {
        Value::String(text) => Variant::named(text),
        _ => Err(format!("one of {}", Variant::ALL.map(Variant::name).join(", "))),
    };
    let variant = variant.map_err(|needed| (key, name.to_string(), needed))?;
    all.insert("drive".into(), Value::Table(Table::try_from(variant.settings()).unwrap_or_default()));
    Ok(())
}

pub(super) fn overlay(settings: &mut Settings, text: &str, extent: Extent) -> Result<(), SettingError> {
    let no_toml = |error: toml::de::Error| {
        let line = error.span().map_or(1, |span| line_at(text, span.start));
        wrong(line, "", error.message().replace('\n', " "), "KEY = VALUE lines of TOML".into())
    };
    let keys = Keys::new(text, DeTable::parse(text).map_err(no_toml)?.get_ref());
    let mut given: Table = toml::from_str(text).map_err(no_toml)?;
    let line = |key: &str| keys.get(key).map_or(1, |key| key.line);

    let mut all = table(settings);
    for (key, none) in optional() {
        all.entry(key).or_insert(none);
    }
    let merged = choose_variant(&mut all, &mut given).and_then(|()| merge(&mut all, given, ""));
    merged.map_err(|(key, found, needed)| wrong(line(&key), &key, found, needed))?;
    for (key, none) in optional() {
        // NaN differs from itself.
        if all.get(key).is_some_and(|value| value.to_string() == none.to_string()) {
            all.remove(key);
        }
    }
    let lists = ["faults", "events", "origin_mm"].map(|key| (key, all.get(key).cloned()));
    let merged: Settings = Value::Table(all).try_into().map_err(|error: toml::de::Error| {
        // Numbers have been checked: the error can only be in a list, and in a given one.
        let bad = |(key, value): &&(&str, Option<Value>)| {
            let alone = value.clone().map(|value| Table::from_iter([((*key).to_owned(), value)]));
            alone.is_some_and(|alone| Value::Table(alone).try_into::<Settings>().is_err())
        };
        let (key, found) = lists.iter().find(bad).map_or(("", None), |(key, value)| (*key, value.as_ref()));
        let found = found.map(Value::to_string).unwrap_or_default();
        wrong(line(key), key, found, error.message().replace('\n', " "))
    })?;
    check(&merged, extent, line)?;
    *settings = merged;
    Ok(())
}

/// Every setting as TOML.
pub(super) fn text(settings: &Settings) -> String {
    toml::to_string(settings).unwrap_or_default()
}

pub(super) fn changes(settings: &Settings) -> Vec<(String, String, String)> {
    let (mut now, mut before) = (BTreeMap::new(), BTreeMap::new());
    leaves(&table(settings), "", &mut now);
    leaves(&table(&Settings::default()), "", &mut before);
    let default = |key: &str| before.get(key).cloned().unwrap_or_else(|| "none".into());
    let changed = now.into_iter().filter(|(key, value)| default(key) != *value);
    changed.map(|(key, value)| (key.clone(), value, default(&key))).collect()
}

fn table(settings: &Settings) -> Table {
    Table::try_from(settings).unwrap_or_default()
}

fn dotted(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

fn leaves(table: &Table, path: &str, into: &mut BTreeMap<String, String>) {
    for (key, value) in table {
        match value {
            Value::Table(inner) => leaves(inner, &dotted(path, key), into),
            value => {
                into.insert(dotted(path, key), value.to_string());
            }
        }
    }
}

/// Key, value found and value needed.
type Wrong = (String, String, String);

/// Replaces values by the given ones.
fn merge(all: &mut Table, given: Table, path: &str) -> Result<(), Wrong> {
    for (key, value) in given {
        let name = dotted(path, &key);
        let variant = (name.starts_with("drive.")).then_some(VARIANT);
        let known = || one_of(&key, all.keys().map(String::as_str).chain(variant), ", ");
        let Some(place) = all.get(&key) else {
            let found = "no such setting".to_owned();
            return Err((name, found, known()));
        };
        let merged = match (place, value) {
            (Value::Table(inner), Value::Table(value)) => {
                let mut inner = inner.clone();
                merge(&mut inner, value, &name)?;
                Value::Table(inner)
            }
            (Value::Float(_), Value::Integer(value)) => Value::Float(value as f64),
            (Value::Float(_), value @ Value::Float(_))
            | (Value::Integer(_), value @ Value::Integer(0..))
            | (Value::Array(_), value @ Value::Array(_)) => value,
            (Value::String(_), Value::String(value)) => {
                let known = names(&name).unwrap_or_default();
                if !known.contains(&value.as_str()) {
                    let needed = one_of(&value, known.iter().copied(), ", ");
                    return Err((name, Value::String(value).to_string(), needed));
                }
                Value::String(value)
            }
            (place, value) => {
                let needed = match place {
                    Value::String(_) => format!("one of {}", names(&name).unwrap_or_default().join(", ")),
                    Value::Table(inner) => {
                        format!("a table of {}", inner.keys().map(String::as_str).collect::<Vec<_>>().join(", "))
                    }
                    Value::Integer(_) => "a whole number from 0".into(),
                    Value::Array(_) => "a list".into(),
                    _ => "a number".into(),
                };
                return Err((name, value.to_string(), needed));
            }
        };
        all.insert(key, merged);
    }
    Ok(())
}
