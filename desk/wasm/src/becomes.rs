//! Converts measurement results into settings of the page's machine.

use crate::files::{DESCRIPTION, Texts, machine_of, texts};
use anyhow::Result;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::Path;
use trueaxis_tables::files::Memory;
use trueaxis_tables::formats::location_values;
use trueaxis_tables::{Additions, Machine};

/// The machine with the measurement applied.
#[derive(Debug, Serialize)]
pub(crate) struct Becomes {
    /// The machine's files.
    files: Texts,
    /// Changed numbers of `machine.toml`.
    settings: Vec<Changed>,
    /// Whether any file changes.
    changes: bool,
    /// The decision on every value, and other changes to the files.
    notes: Vec<String>,
}

/// A changed number of `machine.toml`.
#[derive(Debug, Serialize)]
struct Changed {
    /// Full name of the key.
    key: String,
    before: f64,
    after: f64,
    /// Standard uncertainty stated for it.
    uncertainty: Option<f64>,
}

impl Becomes {
    /// Applies `additions` to the machine of `files`.
    pub(crate) fn new(files: &str, additions: &Additions) -> Result<Becomes> {
        let (files, name) = (texts(files)?, Path::new(DESCRIPTION));
        let memory = Memory::new(files.clone());
        let decisions = additions.decide(&memory, name)?;
        let edited = additions.edit(&memory, name)?;
        let changed = edited.files.into_iter().map(|(name, text)| (name.to_string_lossy().into_owned(), text));
        let notes = decisions.iter().map(ToString::to_string).chain(edited.notes).collect();
        let written = decisions.iter().filter_map(|of| Some((of.key.clone(), of.written?.uncertainty?)));
        Becomes::with(files, changed, notes, &written.collect::<Vec<_>>())
    }

    /// Replaces the changed files of the machine.
    pub(crate) fn with(
        files: Texts,
        changed: impl IntoIterator<Item = (String, String)>,
        notes: Vec<String>,
        stated: &[(String, f64)],
    ) -> Result<Becomes> {
        let mut after = files.clone();
        after.extend(changed);
        Becomes::between(&files, after, notes, stated)
    }

    /// Replaces all files of the machine by `after`.
    pub(crate) fn whole(files: &str, after: Vec<(String, String)>) -> Result<Becomes> {
        let names: Vec<&str> = after.iter().map(|(name, _)| name.as_str()).collect();
        let note = format!("rewritten, without the former comments and grids: {}", names.join(" "));
        Becomes::between(&texts(files)?, after.into_iter().collect(), vec![note], &[])
    }

    fn between(before: &Texts, files: Texts, notes: Vec<String>, stated: &[(String, f64)]) -> Result<Becomes> {
        let changes = *before != files;
        let before = values(&machine_of(before, &mut Vec::new())?);
        let after = values(&machine_of(&files, &mut Vec::new())?);
        let of = |all: &[(String, f64)], key: &str| all.iter().find(|own| own.0 == key).map_or(0.0, |own| own.1);
        let keys: BTreeSet<&str> = before.iter().chain(&after).map(|(key, _)| key.as_str()).collect();
        let settings = keys.into_iter().filter_map(|key| {
            let (before, after) = (of(&before, key), of(&after, key));
            let uncertainty = stated.iter().find(|(stated, _)| stated == key);
            let uncertainty = uncertainty.map(|(_, value)| *value);
            (before != after).then(|| Changed { key: key.to_owned(), before, after, uncertainty })
        });
        Ok(Becomes { settings: settings.collect(), changes, notes, files })
    }
}

/// Location errors and lost motion by the full names of their keys.
pub(crate) fn values(machine: &Machine) -> Vec<(String, f64)> {
    let location = location_values(&machine.settings.location).into_iter();
    let mut values: Vec<_> = location.map(|(key, value)| (format!("location.{key}"), value)).collect();
    for own in &machine.settings.axes {
        let (unit, value) = match own.axis.is_rotary() {
            true => ("urad", own.backlash.to_radians() * 1e6),
            false => ("um", own.backlash * 1e3),
        };
        values.push((format!("axis.{}.backlash_{unit}", own.axis.letter()), value));
    }
    values
}
