//! Reading a machine: `machine.toml` and the CSV of each axis.

mod axis_table;
mod machine_toml;
mod roundness_toml;
mod section;

use crate::error::FileError;
use crate::source::Source;
use crate::text::{counted, read_text};
use crate::{Machine, Table};
use axis_table::TableFile;
use machine_toml::{Description, TableReference};
use std::path::Path;
use trueaxis::check;
use trueaxis::error::{ConfigError, Field};
use trueaxis::machine::{Axis, AxisSettings, Row};

impl Machine {
    /// Reads a `machine.toml`, or the one in a directory, and the tables it names, and checks everything that the
    /// controller would check when it loads them.
    ///
    /// # Errors
    /// The first thing that is wrong: file, line, column or key, what was found, what is needed.
    pub fn read(path: &Path) -> Result<Machine, FileError> {
        Machine::read_telling(path, |_| {})
    }

    /// [`Machine::read`], and tells of every table that has other separators than commas or decimal commas.
    ///
    /// # Errors
    /// As [`Machine::read`].
    pub fn read_telling(path: &Path, mut tell: impl FnMut(String)) -> Result<Machine, FileError> {
        let file = if path.is_dir() { path.join("machine.toml") } else { path.to_path_buf() };
        let source = Source::new(&file);
        let text = read_text(&file)?;
        let description = machine_toml::read(&text, &source)?;
        check::settings(&description.settings).map_err(|error| description.located(&source, &error))?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let mut tables = Vec::new();
        for settings in &description.settings.axes {
            let reference = description.tables.iter().find(|table| table.axis == settings.axis);
            tables.push(match reference {
                Some(reference) => Some(read_table(folder, reference, settings, &source, &mut tell)?),
                None => None,
            });
        }
        let machine = Machine { settings: description.settings.clone(), tables };
        if machine.tables.iter().all(Option::is_none) {
            return Err(source.whole("no axis with a table", "a table in at least one [axis.…] section"));
        }
        let rows = |axis| machine.rows(axis);
        check::joint_range(&machine.settings, rows).map_err(|error| description.joint(&source, &error))?;
        check::reversal(&machine.settings, rows).map_err(|error| description.reversal(&source, &error))?;
        check::machine_passes(&machine.settings, rows).map_err(|error| contraction(&machine, &source, &error))?;
        Ok(machine)
    }

    /// The lines of an axis' table.
    pub fn rows(&self, axis: Axis) -> Option<&[Row]> {
        let place = self.settings.axes.iter().position(|settings| settings.axis == axis)?;
        self.tables.get(place)?.as_ref().map(|table| table.rows.as_slice())
    }
}

fn read_table(
    folder: &Path,
    reference: &TableReference,
    settings: &AxisSettings,
    machine_toml: &Source,
    tell: &mut impl FnMut(String),
) -> Result<Table, FileError> {
    let file = folder.join(&reference.file);
    if !file.is_file() {
        let found = format!("{:?}, which is no file at {}", reference.file, file.display());
        return Err(machine_toml.at(
            reference.line,
            &reference.key,
            found,
            "the CSV of the axis, relative to this file",
        ));
    }
    let source = Source::new(&file);
    // Comments may be in any encoding.
    let bytes = std::fs::read(&file).map_err(|error| source.whole(error.to_string(), "a readable file"))?;
    let TableFile { table, lines, columns, dialect } = axis_table::read(&bytes, &source, settings.axis)?;
    if let Some(how) = dialect {
        tell(format!("{}: {how}", file.display()));
    }
    check::table(settings, table.rows.as_slice()).map_err(|fault| {
        let line = lines.get(fault.row).copied().unwrap_or(0);
        let given = columns.iter().find(|column| column.holds(fault.component, fault.reverse));
        let name = given.map_or("", |column| column.name.as_str());
        let found = match (fault.rule, fault.component) {
            (check::TableRule::Count, _) if fault.found == 1.0 => String::from("one line"),
            (check::TableRule::Count, _) => counted(fault.found as usize, "line"),
            (check::TableRule::Slope, _) => format!("a slope of {:.4} up to the next line", fault.found),
            (_, None) => fault.found.to_string(),
            (_, Some(component)) if component < 3 => format!("{} um", fault.found * 1e3),
            _ => format!("{} urad", fault.found * 1e6),
        };
        match fault.rule {
            check::TableRule::Count => source.whole(found, fault.rule.needed()),
            _ => source.at(line, name, found, fault.rule.needed()),
        }
    })?;
    Ok(table)
}

/// All tables together are too steep.
fn contraction(machine: &Machine, source: &Source, error: &ConfigError) -> FileError {
    if error.field != Field::Inverse {
        return source.whole(error.found.to_string(), error.needed);
    }
    let mut steepest = (0.0, String::from("the squareness errors"));
    for (settings, table) in machine.axes() {
        let Some(table) = table else { continue };
        for (slope, direction) in check::slopes(settings, table.rows.as_slice()).into_iter().zip(Axis::ALL).take(3) {
            if slope > steepest.0 {
                steepest = (slope, format!("E{}{}", direction.letter(), settings.axis.letter()));
            }
        }
    }
    source.whole(
        format!(
            "a norm of {:.4} (all tables, thermal growth of 0.001 included), most of it {}",
            error.found, steepest.1
        ),
        error.needed,
    )
}

impl Description {
    /// An error of the settings at the line it comes from.
    fn located(&self, source: &Source, error: &ConfigError) -> FileError {
        let fits = |place: &&machine_toml::Place| place.field == error.field && place.axis == error.axis;
        let exact = self.places.iter().filter(fits).find(|place| place.values.contains(&error.found));
        match exact.or_else(|| self.places.iter().find(fits)) {
            Some(place) => source.at(place.line, &place.key, &place.text, error.needed),
            None => {
                let axis = error.axis.map_or(String::new(), |axis| format!(" of axis {}", axis.letter()));
                source.whole(format!("{:?}{axis} = {}", error.field, error.found), error.needed)
            }
        }
    }

    /// The hysteresis is too narrow.
    fn reversal(&self, source: &Source, error: &ConfigError) -> FileError {
        let at = self.located(source, error);
        let rotary = error.axis.is_some_and(Axis::is_rotary);
        let micro = |value: f64| if rotary { value.to_radians() * 1e6 } else { value * 1e3 };
        let unit = if rotary { "urad" } else { "um" };
        let given = self.places.iter().any(|place| place.field == error.field && place.axis == error.axis);
        let letter = error.axis.map_or(' ', Axis::letter);
        FileError {
            found: if given {
                at.found
            } else {
                format!(
                    "a hysteresis_{unit} of {} of axis {letter}, the default",
                    (micro(error.found) * 1e3).round() / 1e3
                )
            },
            needed: match error.bound {
                // Rounded up: what is written off the message must do.
                Some(bound) => format!("{}: {} {unit}", error.needed, (micro(bound) * 1e3 - 1e-6).ceil() / 1e3),
                None => at.needed,
            },
            ..at
        }
    }

    /// Command + correction leaves the joint.
    fn joint(&self, source: &Source, error: &ConfigError) -> FileError {
        let at = self.located(source, error);
        let unit = if error.axis.is_some_and(Axis::is_rotary) { "degrees" } else { "mm" };
        FileError {
            found: format!("{} {unit} as command + correction at an end of the travel", error.found),
            needed: String::from("a joint range with room for travel and correction"),
            ..at
        }
    }
}
