//! `[[crosstalk]]` of `machine.toml`: motion of the tip while an axis accelerates.

use super::section::{KeyValue, Section};
use crate::error::FileError;
use trueaxis::machine::{Axis, CROSSTALK_CAPACITY, CROSSTALK_POINTS, CrosstalkSettings};

/// The key of k and the divisor of its number: 1 µm per m/s² is 1e-6 s², 1 µm per deg/s² is 1e-3 mm per deg/s².
pub(crate) fn unit_of(from: Axis) -> (&'static str, f64) {
    if from.is_rotary() { ("k_um_per_deg_per_s2", 1e3) } else { ("k_um_per_m_per_s2", 1e6) }
}

/// All sections, in the order of the file.
pub(super) fn read(root: &Section<'_>) -> Result<heapless::Vec<CrosstalkSettings, CROSSTALK_CAPACITY>, FileError> {
    let mut all = heapless::Vec::new();
    for section in root.sections("crosstalk")? {
        let line = section.first_line();
        let next = read_one(section)?;
        if all.push(next).is_err() {
            let needed = format!("at most {CROSSTALK_CAPACITY}");
            return Err(root.at(line, "crosstalk", "another section [[crosstalk]]", needed));
        }
    }
    Ok(all)
}

fn read_one(section: Section<'_>) -> Result<CrosstalkSettings, FileError> {
    let axis = |key: &str, needed: &str| {
        section.axis(key)?.map(|found| found.value).ok_or_else(|| section.missing_here(key, needed))
    };
    let tip = axis("tip", "the linear axis along which the tip moves, like \"X\"")?;
    let from = axis("from", "the axis that accelerates, like \"Y\"")?;
    let (key, scale) = unit_of(from);
    let (constant, over, table) = (section.number(key)?, section.axis("over")?, section.lists::<2>("table")?);
    let mut settings = CrosstalkSettings { tip, from, over: from, points: heapless::Vec::new() };
    match (constant, over, table) {
        (Some(k), None, None) => {
            let _ = settings.points.push([0.0, k.value / scale]);
        }
        (None, Some(over), Some(table)) => {
            settings.over = over.value;
            settings.points = points(&section, &table, scale)?;
        }
        (Some(k), _, _) => return Err(section.wrong(&k, "either a constant, or over and table")),
        (None, Some(over), None) => return Err(section.wrong(&over, "a table beside it")),
        (None, None, Some(table)) => {
            return Err(section.wrong(&table, "the axis on whose position it depends, over = …"));
        }
        (None, None, None) => return Err(section.missing_here(key, "a number, or over and table")),
    }
    section.finish(None)?;
    Ok(settings)
}

fn points(
    section: &Section<'_>,
    table: &KeyValue<Vec<[f64; 2]>>,
    scale: f64,
) -> Result<heapless::Vec<[f64; 2], CROSSTALK_POINTS>, FileError> {
    let points = table.value.iter().map(|[position, k]| [*position, *k / scale]);
    let count = table.value.len();
    let few = (1..=CROSSTALK_POINTS).contains(&count);
    if !few {
        return Err(section.wrong(table, format!("1 to {CROSSTALK_POINTS} pairs")));
    }
    Ok(points.collect())
}
