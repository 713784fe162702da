//! An entry of the history.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Kind of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EntryKind {
    /// The first probing, from which everything is counted.
    Begin,
    /// A probing that changed nothing.
    #[serde(rename = "look")]
    Unchanged,
    /// A probing that changed files.
    Update,
    /// An undo that restored files.
    Undo,
}

/// The log that was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LogFile {
    /// Name of the log file.
    pub file: String,
    /// CRC-32 of its bytes.
    pub crc: String,
}

/// A measured term and its update.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Name in the task.
    pub term: String,
    /// Unit of all values.
    pub unit: String,
    /// Residual that the tables left.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
    /// Sum of the updates since the beginning, before this entry.
    pub from: f64,
    /// That sum after this entry.
    pub to: f64,
}

/// Position of a ball in workpiece coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BallPlace {
    /// Name of the ball.
    pub name: String,
    /// Centre of the ball, mm.
    pub centre_mm: [f64; 3],
    /// Standard errors, µm.
    pub standard_error_um: [f64; 3],
}

/// A changed file; the entry's folder contains its previous version.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Changed {
    /// Name in the machine's folder.
    pub file: String,
    /// CRC-32 before; `None` if the file did not exist.
    pub before: Option<String>,
    /// CRC-32 after; `None` if the file was removed.
    pub after: Option<String>,
}

/// An entry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Number of the entry, from 1.
    pub entry: u32,
    /// Kind of the entry.
    #[serde(rename = "deed")]
    pub kind: EntryKind,
    /// Time in UTC, if stated.
    pub time: Option<String>,
    /// Number of parts made until then, if stated.
    pub parts: Option<u64>,
    /// Identity of the plan, in hexadecimal.
    pub plan: String,
    /// The log that was read.
    pub log: Option<LogFile>,
    /// Entry before which an undo restored the files.
    pub undone: Option<u32>,
    /// Standard deviation of a touch, µm.
    pub sigma_um: Option<f64>,
    /// The terms.
    pub measured: Vec<Measured>,
    /// The balls.
    pub balls: Vec<BallPlace>,
    /// Sums of the updates since the beginning, after this entry.
    pub totals: BTreeMap<String, f64>,
    /// Changed files.
    pub files: Vec<Changed>,
    /// CRC-32 of all tables before and after.
    pub tables: [String; 2],
}
