//! Maps refusals of the controller's checks to lines of the files.

use super::axis_table::TableFile;
use super::machine_toml::Description;
use crate::Machine;
use crate::error::FileError;
use crate::origin::Origin;
use crate::text::counted;
use trueaxis::check;
use trueaxis::error::{ConfigError, Field, Figure};
use trueaxis::machine::Axis;

impl TableFile {
    /// The error for a fault of the table, at its line and column.
    pub(super) fn refused(&self, origin: &Origin, fault: &check::TableFault) -> FileError {
        let line = self.lines.get(fault.row).copied().unwrap_or(0);
        let given = self.columns.iter().find(|column| column.holds(fault.component, fault.reverse));
        let name = given.map_or("", |column| column.name.as_str());
        let found = match (fault.rule, fault.component) {
            (check::TableRule::Count, _) if fault.found == 1.0 => String::from("one line"),
            (check::TableRule::Count, _) => counted(fault.found as usize, "line"),
            (check::TableRule::Slope, _) => format!("a slope of {:.4} up to the next line", fault.found),
            (_, None) => Figure(fault.found).to_string(),
            (_, Some(component)) if component < 3 => format!("{} um", Figure(fault.found * 1e3)),
            _ => format!("{} urad", Figure(fault.found * 1e6)),
        };
        match fault.rule {
            check::TableRule::Count => origin.whole(found, fault.rule.needed()),
            _ => origin.at(line, name, found, fault.rule.needed()),
        }
    }
}

/// The error for a total error that is too steep; names the source whose removal leaves the smallest slope.
pub(super) fn contraction(machine: &Machine, origin: &Origin, error: &ConfigError) -> FileError {
    if error.field != Field::Inverse {
        return origin.whole(error.found.to_string(), error.needed);
    }
    let norm = |machine: &Machine| {
        check::jacobian_norm(&machine.settings, |axis| machine.rows(axis), &check::GridBounds::of(&machine.grids()))
    };
    let (mut least, mut cause) = (norm(machine), String::from("the thermal growth"));
    let mut without = |name: &dyn Fn() -> String, other: Machine| {
        let left = norm(&other);
        if left < least {
            (least, cause) = (left, name());
        }
    };
    let mut square = machine.clone();
    square.settings.location = Default::default();
    without(&|| String::from("the location errors"), square);
    for own in &machine.settings.axes {
        let mut smooth = machine.clone();
        smooth.settings.periodic.retain(|period| period.axis != own.axis);
        without(&|| format!("the periods of {}", own.axis.letter()), smooth);
    }
    for (slot, own) in machine.settings.axes.iter().enumerate() {
        for (component, direction) in Axis::ALL.into_iter().enumerate() {
            let mut other = machine.clone();
            let Some(Some(table)) = other.tables.get_mut(slot) else { continue };
            for twist in table.rows.iter_mut().flat_map(|row| [&mut row.forward, &mut row.reverse]) {
                twist[component] = 0.0;
            }
            without(&|| format!("E{}{}", direction.letter(), own.axis.letter()), other);
        }
    }
    for (number, grid) in machine.grids.iter().enumerate() {
        let mut other = machine.clone();
        other.grids.remove(number);
        let letters =
            || grid.header().letters().map(|axis| axis.letter().to_string()).collect::<Vec<_>>().join(" and ");
        without(&|| format!("the grid over {}", letters()), other);
    }
    origin.whole(
        format!("a norm of {:.4} (all tables, thermal growth of 0.001 included), most of it {cause}", error.found),
        error.needed,
    )
}

/// A sufficient hysteresis, in the unit of its key, in thousandths rounded up: the printed value itself must be accepted.
pub(crate) fn least_hysteresis(error: &ConfigError) -> Option<f64> {
    let (bound, key) = error.bound.zip(error.key())?;
    Some((key.in_its_unit(bound) * 1e3 - 1e-6).ceil() / 1e3)
}

fn is_section(field: Field) -> bool {
    matches!(field, Field::Friction | Field::Feedback)
}

/// The `needed` of an error, with the section or value that it refers to.
fn needed(error: &ConfigError, bound: Option<f64>) -> String {
    let letter = error.axis.map_or(' ', Axis::letter);
    match (error.field, bound) {
        (Field::Friction | Field::Feedback | Field::Lag | Field::AccelerationAhead, _) => {
            format!("{}: [axis.{letter}.drive]", error.needed)
        }
        (Field::Proportional | Field::Integral, Some(bound)) => {
            format!("{} {}, because of axis {letter}", error.needed, Figure(bound))
        }
        (Field::DynamicMagnitude | Field::LowestResonance, Some(bound)) => {
            format!("{}: {}", error.needed, Figure(bound))
        }
        _ => error.needed.to_owned(),
    }
}

impl Description {
    /// An error of the settings at the line of its key, or at that of the section if the key is at its default.
    pub(super) fn located(&self, origin: &Origin, error: &ConfigError) -> FileError {
        let Some(key) = error.key() else {
            return origin.whole(format!("{:?} = {}", error.field, Figure(error.found)), error.needed);
        };
        let (found, bound) = (key.in_its_unit(error.found), error.bound.map(|bound| key.in_its_unit(bound)));
        let key = key.to_string();
        let needed = needed(error, bound);
        // In a list of sections, the one with this number.
        let place = match (key.split_once('.'), error.index) {
            (Some((list @ ("crosstalk" | "grid"), rest)), Some(index)) => format!("{list}[{index}].{rest}"),
            (Some(("axis", _)), Some(index)) => key.replace(".periodic.", &format!(".periodic[{index}].")),
            _ => key.clone(),
        };
        match self.keys.get(&place) {
            Some(written) if !written.text.is_empty() => origin.at(written.line, &key, &written.text, needed),
            // A valid section whose error is that another section is missing.
            Some(written) if is_section(error.field) => origin.at(written.line, &key, "this section", needed),
            // A default, or a whole section.
            _ => {
                let line = self.keys.get(&place).map(|written| written.line).or_else(|| self.keys.section(&place));
                origin.at(line.unwrap_or(0), &key, format!("{}, the default", Figure(found)), needed)
            }
        }
    }

    /// The error for a hysteresis that is too narrow.
    pub(super) fn reversal(&self, origin: &Origin, error: &ConfigError) -> FileError {
        let at = self.located(origin, error);
        FileError {
            needed: match least_hysteresis(error) {
                Some(least) => {
                    let unit = if error.axis.is_some_and(Axis::is_rotary) { "urad" } else { "um" };
                    format!("{}: {least} {unit}", error.needed)
                }
                None => at.needed,
            },
            ..at
        }
    }

    /// The error for command + correction outside the joint's range.
    pub(super) fn joint(&self, origin: &Origin, error: &ConfigError) -> FileError {
        let at = self.located(origin, error);
        let unit = if error.axis.is_some_and(Axis::is_rotary) { "degrees" } else { "mm" };
        FileError {
            found: format!("{} {unit} as command + correction at an end of the travel", error.found),
            needed: String::from("a joint range with room for travel and correction"),
            ..at
        }
    }
}
