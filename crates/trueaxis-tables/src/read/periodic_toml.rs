//! `[[axis.*.periodic]]` of `machine.toml`: errors that repeat within a period of the axis.

use super::section::{KeyValue, Section};
use super::uncertainty_toml::{UM, URAD};
use super::units::{degrees_from_urad, from_um};
use crate::error::FileError;
use trueaxis::machine::{Axis, PERIODIC_CAPACITY, PERIODIC_HARMONICS, PeriodicSettings};

/// Adds the sections of an axis, in the order of the file.
pub(super) fn read(
    own: &Section<'_>,
    axis: Axis,
    to: &mut heapless::Vec<PeriodicSettings, PERIODIC_CAPACITY>,
) -> Result<(), FileError> {
    for section in own.sections("periodic")? {
        let line = section.first_line();
        if to.push(read_one(section, axis)?).is_err() {
            let needed = format!("at most {PERIODIC_CAPACITY} on all axes together");
            return Err(own.at(line, "periodic", "another section [[axis.*.periodic]]", needed));
        }
    }
    Ok(())
}

fn read_one(section: Section<'_>, axis: Axis) -> Result<PeriodicSettings, FileError> {
    let (unit, micro) = if axis.is_rotary() { ("deg", "urad") } else { ("mm", "um") };
    let length = format!("period_{unit}");
    let period = section.number(&length)?;
    let period = period.ok_or_else(|| section.missing_here(&length, "the length of a period"))?.value;
    let (forward, reverse) = (format!("harmonics_{micro}"), format!("reverse_{micro}"));
    let harmonics = section.lists::<2>(&forward)?;
    let needed = "pairs of cosine and sine of the harmonics 1, 2, …";
    let harmonics = harmonics.ok_or_else(|| section.missing_here(&forward, needed))?;
    let harmonics = pairs(&section, axis, &harmonics)?;
    let reverse = section.lists::<2>(&reverse)?.map(|list| pairs(&section, axis, &list)).transpose()?;
    // Stated beside the figures like every uncertainty, and not compiled.
    let uncertainty = format!("standard_uncertainty_{micro}");
    let bounds = if axis.is_rotary() { &URAD } else { &UM };
    if let Some(stated) = section.number(&uncertainty)?.filter(|stated| !bounds.contains(stated.value)) {
        return Err(section.wrong(&stated, bounds.needed));
    }
    section.finish(None)?;
    Ok(PeriodicSettings { axis, period, harmonics, reverse: reverse.unwrap_or_default() })
}

fn pairs(
    section: &Section<'_>,
    axis: Axis,
    list: &KeyValue<Vec<[f64; 2]>>,
) -> Result<heapless::Vec<[f64; 2], PERIODIC_HARMONICS>, FileError> {
    if !(1..=PERIODIC_HARMONICS).contains(&list.value.len()) {
        return Err(section.wrong(list, format!("1 to {PERIODIC_HARMONICS} pairs of cosine and sine")));
    }
    let small = if axis.is_rotary() { degrees_from_urad } else { from_um };
    Ok(list.value.iter().map(|pair| pair.map(small)).collect())
}
