//! An entry of the history.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Kind of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Deed {
    /// The first look, from which everything is counted.
    Begin,
    /// A look after which nothing was changed.
    Look,
    /// A look after which files were changed.
    Update,
    /// Files were put back.
    Undo,
}

/// The log that was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LogFile {
    /// Its name.
    pub file: String,
    /// CRC-32 of its bytes.
    pub crc: String,
}

/// A term as it was found, and what was done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// As the task names it.
    pub term: String,
    /// Unit of all values.
    pub unit: String,
    /// What the tables left of it.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Sum of the updates since the beginning, before this entry.
    pub from: f64,
    /// The same after it.
    pub to: f64,
}

/// Where a ball stood, in workpiece coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BallPlace {
    /// Its name.
    pub name: String,
    /// Its centre, mm.
    pub centre_mm: [f64; 3],
    /// Standard errors, µm.
    pub standard_error_um: [f64; 3],
}

/// A file that was changed; what it was before stands in the folder of the entry.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Changed {
    /// Its name in the machine's folder.
    pub file: String,
    /// CRC-32 before; none where it was not there.
    pub before: Option<String>,
    /// CRC-32 after; none where it was taken away.
    pub after: Option<String>,
}

/// An entry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Its number, from 1.
    pub entry: u32,
    /// What was done.
    pub deed: Deed,
    /// When, in UTC, where it was stated.
    pub time: Option<String>,
    /// Parts made until then, where it was stated.
    pub parts: Option<u64>,
    /// Identity of the plan, in hexadecimal.
    pub plan: String,
    /// What was read.
    pub log: Option<LogFile>,
    /// Entry before which an undo has put the files.
    pub undone: Option<u32>,
    /// Standard deviation of a touch, µm.
    pub sigma_um: Option<f64>,
    /// The terms.
    pub measured: Vec<Measured>,
    /// The balls.
    pub balls: Vec<BallPlace>,
    /// Sums of the updates since the beginning, after this entry.
    pub totals: BTreeMap<String, f64>,
    /// Files that were changed.
    pub files: Vec<Changed>,
    /// CRC-32 of all tables before and after.
    pub tables: [String; 2],
}
