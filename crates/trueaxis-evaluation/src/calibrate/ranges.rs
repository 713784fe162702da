//! Numbers of a task within their ranges.

use trueaxis_tables::Section;
use trueaxis_tables::error::FileError;

/// A number, within its range; `unit` as it stands behind one.
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

/// The same where it must be stated; `what` says it to who has left it out.
pub(super) fn needed(
    section: &Section<'_>,
    key: &str,
    range: [f64; 2],
    unit: &str,
    what: &str,
) -> Result<f64, FileError> {
    number(section, key, range, unit)?.ok_or_else(|| section.missing_here(key, what))
}

/// A whole number, within its range.
pub(crate) fn whole(section: &Section<'_>, key: &str, [low, high]: [usize; 2]) -> Result<Option<usize>, FileError> {
    match section.number(key)? {
        Some(found) if found.value.fract() != 0.0 || !(low as f64..=high as f64).contains(&found.value) => {
            Err(section.wrong(&found, format!("a whole number from {low} to {high}")))
        }
        found => Ok(found.map(|found| found.value as usize)),
    }
}
