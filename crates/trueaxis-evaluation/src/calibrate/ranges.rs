//! Reads the numbers of a task and checks their ranges.

use trueaxis_tables::Section;
use trueaxis_tables::error::FileError;

/// Reads a number and checks its range; `unit` follows the range in errors.
pub(crate) fn number(
    section: &Section<'_>,
    key: &str,
    [low, high]: [f64; 2],
    unit: &str,
) -> Result<Option<f64>, FileError> {
    match section.number(key)? {
        Some(found) if !(low..=high).contains(&found.value) => {
            Err(section.wrong(&found, format!("{low} to {high}{unit}")))
        }
        found => Ok(found.map(|found| found.value)),
    }
}

/// Like [`number`], but required; `what` describes the number if it is missing.
pub(super) fn needed(
    section: &Section<'_>,
    key: &str,
    range: [f64; 2],
    unit: &str,
    what: &str,
) -> Result<f64, FileError> {
    number(section, key, range, unit)?.ok_or_else(|| section.missing_here(key, what))
}

/// Reads a whole number and checks its range.
pub(crate) fn whole(section: &Section<'_>, key: &str, [low, high]: [usize; 2]) -> Result<Option<usize>, FileError> {
    match section.number(key)? {
        Some(found) if found.value.fract() != 0.0 || !(low as f64..=high as f64).contains(&found.value) => {
            Err(section.wrong(&found, format!("a whole number from {low} to {high}")))
        }
        found => Ok(found.map(|found| found.value as usize)),
    }
}
