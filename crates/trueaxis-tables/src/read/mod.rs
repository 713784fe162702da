//! Reading a machine: `machine.toml` and the CSV of each axis.

mod axis_table;
mod machine_toml;
mod places;
mod roundness_toml;
mod section;

use crate::error::FileError;
use crate::source::Source;
use crate::text::{counted, read_text};
use crate::{Machine, Table};
use axis_table::TableFile;
use machine_toml::{Description, TableReference};
use std::fs;
use std::path::{Path, PathBuf};
use trueaxis::check;
use trueaxis::error::{ConfigError, Field, Figure};
use trueaxis::machine::{Axis, AxisSettings, MachineSettings, Row};

impl Machine {
    /// Reads a `machine.toml`, or the one in a directory, and the tables it names, and checks everything that the
    /// controller would check when it loads them.
    ///
    /// # Errors
    /// The first thing that is wrong: file, line, column or key, what was found, what is needed.
    pub fn read(path: &Path) -> Result<Machine, FileError> {
        Machine::read_with(path, &[], |_| {})
    }

    /// [`Machine::read`], and tells of every table that has other separators than commas or decimal commas.
    ///
    /// # Errors
    /// As [`Machine::read`].
    pub fn read_telling(path: &Path, tell: impl FnMut(String)) -> Result<Machine, FileError> {
        Machine::read_with(path, &[], tell)
    }

    /// The same with texts in place of what stands on the disk, or does not stand there yet: (file, text), the file named as
    /// the folder of the machine and the name in it.
    ///
    /// # Errors
    /// As [`Machine::read`].
    pub fn read_with(
        path: &Path,
        instead: &[(PathBuf, String)],
        mut tell: impl FnMut(String),
    ) -> Result<Machine, FileError> {
        let file = description_of(path);
        let source = Source::new(&file);
        let text = text(&file, instead)?;
        let description = machine_toml::read(&text, &source)?;
        check::settings(&description.settings).map_err(|error| description.located(&source, &error))?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let mut tables = Vec::new();
        for settings in &description.settings.axes {
            let reference = description.tables.iter().find(|table| table.axis == settings.axis);
            tables.push(match reference {
                Some(reference) => Some(read_table(folder, reference, settings, &source, instead, &mut tell)?),
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

    /// The files that [`Machine::read`] reads: `machine.toml` and the tables that it names.
    ///
    /// # Errors
    /// `machine.toml` cannot be read, or is wrong by itself.
    pub fn files(path: &Path) -> Result<Vec<PathBuf>, FileError> {
        let file = description_of(path);
        let source = Source::new(&file);
        let description = machine_toml::read(&text(&file, &[])?, &source)?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let tables: Vec<PathBuf> = description.tables.iter().map(|table| folder.join(&table.file)).collect();
        Ok(std::iter::once(file).chain(tables).collect())
    }

    /// Every key with a number, or a list of so many, that a `machine.toml` with the sections of this one may have.
    ///
    /// # Errors
    /// The text is not that of a machine.
    pub fn number_keys(text: &str) -> Result<Vec<(String, usize)>, FileError> {
        machine_toml::read(text, &Source::new(Path::new("machine.toml"))).map(|description| description.numbers)
    }

    /// The lines of an axis' table.
    pub fn rows(&self, axis: Axis) -> Option<&[Row]> {
        let place = self.settings.axes.iter().position(|settings| settings.axis == axis)?;
        self.tables.get(place)?.as_ref().map(|table| table.rows.as_slice())
    }
}

/// A machine as it stands on the disk, for an edit of its files.
pub(crate) struct Standing {
    pub(crate) file: PathBuf,
    /// As it is, byte order mark included.
    pub(crate) text: String,
    pub(crate) settings: MachineSettings,
    pub(crate) tables: Vec<StandingTable>,
}

/// A table that `machine.toml` names.
pub(crate) struct StandingTable {
    pub(crate) axis: Axis,
    /// As `machine.toml` has it, relative to it.
    pub(crate) name: String,
    pub(crate) line: u32,
    pub(crate) key: String,
    /// `None` where it cannot be read.
    pub(crate) table: Option<Table>,
}

impl Standing {
    pub(crate) fn read(path: &Path) -> Result<Standing, FileError> {
        let file = description_of(path);
        let source = Source::new(&file);
        let stripped = text(&file, &[])?;
        let description = machine_toml::read(&stripped, &source)?;
        let raw = fs::read_to_string(&file).map_err(|error| source.whole(error.to_string(), "a readable file"))?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let tables = description.tables.into_iter().map(|TableReference { axis, file: name, line, key }| {
            let at = folder.join(&name);
            let source = Source::new(&at);
            let read = bytes(&at, &source, &[]).and_then(|bytes| axis_table::read(&bytes, &source, axis));
            StandingTable { axis, name, line, key, table: read.ok().map(|file| file.table) }
        });
        let tables = tables.collect();
        Ok(Standing { file, text: raw, settings: description.settings, tables })
    }
}

/// `machine.toml` of a machine that is named by it or by its folder.
pub(crate) fn description_of(path: &Path) -> PathBuf {
    if path.is_dir() { path.join("machine.toml") } else { path.to_path_buf() }
}

/// Text of a file, or what is given in its place.
fn text(file: &Path, instead: &[(PathBuf, String)]) -> Result<String, FileError> {
    match instead.iter().find(|(name, _)| name == file) {
        Some((_, text)) => Ok(text.clone()),
        None => read_text(file),
    }
}

/// Bytes of a table, or what is given in its place: comments may be in any encoding.
fn bytes(file: &Path, source: &Source, instead: &[(PathBuf, String)]) -> Result<Vec<u8>, FileError> {
    match instead.iter().find(|(name, _)| name == file) {
        Some((_, text)) => Ok(text.clone().into_bytes()),
        None => fs::read(file).map_err(|error| source.whole(error.to_string(), "a readable file")),
    }
}

fn read_table(
    folder: &Path,
    reference: &TableReference,
    settings: &AxisSettings,
    machine_toml: &Source,
    instead: &[(PathBuf, String)],
    tell: &mut impl FnMut(String),
) -> Result<Table, FileError> {
    let file = folder.join(&reference.file);
    if !file.is_file() && !instead.iter().any(|(name, _)| *name == file) {
        let found = format!("{:?}, which is no file at {}", reference.file, file.display());
        return Err(machine_toml.at(
            reference.line,
            &reference.key,
            found,
            "the CSV of the axis, relative to this file",
        ));
    }
    let source = Source::new(&file);
    let TableFile { table, lines, columns, dialect } =
        axis_table::read(&bytes(&file, &source, instead)?, &source, settings.axis)?;
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
            (_, None) => Figure(fault.found).to_string(),
            (_, Some(component)) if component < 3 => format!("{} um", Figure(fault.found * 1e3)),
            _ => format!("{} urad", Figure(fault.found * 1e6)),
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
        let fits = |place: &&places::Place| place.field == error.field && place.axis == error.axis;
        let exact = self.places.iter().filter(fits).find(|place| place.values.contains(&error.found));
        match exact.or_else(|| self.places.iter().find(fits)) {
            Some(place) => source.at(place.line, &place.key, &place.text, error.needed),
            None => {
                let axis = error.axis.map_or(String::new(), |axis| format!(" of axis {}", axis.letter()));
                source.whole(format!("{:?}{axis} = {}", error.field, Figure(error.found)), error.needed)
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
