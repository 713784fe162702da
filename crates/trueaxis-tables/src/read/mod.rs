//! Reads a machine: `machine.toml` and the CSV of each axis.

mod axis_table;
mod common_lag;
mod correlation_toml;
mod crosstalk_toml;
pub(crate) mod grid_table;
pub(crate) mod grid_toml;
pub(crate) mod keys;
mod machine_toml;
mod periodic_toml;
pub(crate) mod refused;
mod roundness_toml;
pub(crate) mod section;
mod servo_toml;
pub(crate) mod table_text;
mod uncertainty_toml;
pub(crate) mod units;

use crate::error::FileError;
use crate::files::{Folder, Source, bytes};
use crate::origin::Origin;
use crate::text::decode;
use crate::uncertainty::Uncertainties;
use crate::{Grid, Machine, Table};
use axis_table::TableFile;
pub(crate) use crosstalk_toml::unit_of;
use grid_toml::GridReference;
use machine_toml::{Description, TableReference};
use std::path::{Path, PathBuf};
use trueaxis::check;
use trueaxis::error::ConfigError;
use trueaxis::machine::{Axis, AxisSettings, MachineSettings, Row};

impl Machine {
    /// Reads a `machine.toml`, or the one in a folder, and the tables it names, with all checks that the controller makes when
    /// it loads them.
    ///
    /// # Errors
    /// The first fault: file, line, column or key, the value found and the value needed.
    pub fn read(path: &Path) -> Result<Machine, FileError> {
        let (folder, name) = Folder::of_machine(path);
        Machine::read_from(&folder, &name, &mut |_| {})
    }

    /// [`Machine::read`] from any source of files; `name` is that of the `machine.toml`. Reports every table with separators
    /// other than commas, or with decimal commas, to the callback. A machine without tables has only the errors that its
    /// settings state.
    ///
    /// # Errors
    /// As [`Machine::read`].
    pub fn read_from(files: &dyn Source, name: &Path, note: &mut dyn FnMut(String)) -> Result<Machine, FileError> {
        let (origin, description) = described(files, name)?;
        let machine = Machine::read_described(files, name, &origin, &description, note)?;
        machine.hold_together(&origin, &description)?;
        Ok(machine)
    }

    fn read_described(
        files: &dyn Source,
        name: &Path,
        origin: &Origin,
        description: &Description,
        note: &mut dyn FnMut(String),
    ) -> Result<Machine, FileError> {
        check::settings(&description.settings).map_err(|error| description.located(origin, &error))?;
        let mut tables = Vec::new();
        for settings in &description.settings.axes {
            let reference = description.tables.iter().find(|table| table.axis == settings.axis);
            tables.push(match reference {
                Some(reference) => Some(read_table(files, name, reference, settings, origin, note)?),
                None => None,
            });
        }
        let mut grids = Vec::new();
        for reference in &description.grids {
            grids.push(read_grid(files, name, reference, origin, note)?);
        }
        Ok(Machine { settings: description.settings.clone(), tables, grids })
    }

    /// The controller's checks of settings and tables together.
    fn hold_together(&self, origin: &Origin, description: &Description) -> Result<(), FileError> {
        let rows = |axis| self.rows(axis);
        check::grids(&self.settings, &self.grids()).map_err(|error| description.located(origin, &error))?;
        let bounds = check::GridBounds::of(&self.grids());
        check::joint_range(&self.settings, rows, &bounds).map_err(|error| description.joint(origin, &error))?;
        check::reversal(&self.settings, rows, &bounds).map_err(|error| description.reversal(origin, &error))?;
        check::machine_passes(&self.settings, rows, &bounds)
            .map_err(|error| refused::contraction(self, origin, &error))?;
        Ok(())
    }

    /// The hysteresis that [`Machine::read_from`] would refuse as too narrow; `None` if another fault comes first.
    pub(crate) fn narrow_hysteresis(files: &dyn Source, name: &Path) -> Option<ConfigError> {
        let (origin, description) = described(files, name).ok()?;
        let machine = Machine::read_described(files, name, &origin, &description, &mut |_| {}).ok()?;
        let bounds = check::GridBounds::of(&machine.grids());
        check::reversal(&machine.settings, |axis| machine.rows(axis), &bounds).err()
    }

    /// Locates an error of the machine's configuration at its key in `machine.toml`, or at its section if the key is absent.
    /// If the file can no longer be read, returns that error.
    pub fn refusal(files: &dyn Source, name: &Path, error: &ConfigError) -> FileError {
        match described(files, name) {
            Ok((origin, description)) => description.located(&origin, error),
            Err(unread) => unread,
        }
    }

    /// The files that [`Machine::read`] reads: `machine.toml` and the tables that it names.
    ///
    /// # Errors
    /// `machine.toml` cannot be read, or is invalid without its tables.
    pub fn files(path: &Path) -> Result<Vec<PathBuf>, FileError> {
        let (folder, name) = Folder::of_machine(path);
        Ok(Machine::files_of(&folder, &name)?.iter().map(|file| folder.path(file)).collect())
    }

    /// [`Machine::files`] for any source, by their names in it; `name` is that of the `machine.toml`, which comes first.
    ///
    /// # Errors
    /// As [`Machine::files`].
    pub fn files_of(files: &dyn Source, name: &Path) -> Result<Vec<PathBuf>, FileError> {
        let (_, description) = described(files, name)?;
        let tables = description.tables.iter().map(|table| &table.file);
        let named = tables.chain(description.grids.iter().map(|grid| &grid.file)).map(|file| path_from(name, file));
        Ok(std::iter::once(name.to_path_buf()).chain(named).collect())
    }

    /// Every numeric key that a `machine.toml` with the sections of this one may have, with its count of numbers.
    ///
    /// # Errors
    /// The text does not describe a machine.
    pub fn number_keys(text: &str) -> Result<Vec<(String, usize)>, FileError> {
        machine_toml::read(text, &Origin::new(Path::new("machine.toml"))).map(|description| description.numbers)
    }

    /// The lines of an axis' table.
    pub fn rows(&self, axis: Axis) -> Option<&[Row]> {
        let index = self.settings.axes.iter().position(|settings| settings.axis == axis)?;
        self.tables.get(index)?.as_ref().map(|table| table.rows.as_slice())
    }
}

impl Uncertainties {
    /// Uncertainties of a `machine.toml`, or the one in a folder, and of the tables that it names.
    ///
    /// # Errors
    /// As [`Machine::read`], for faults within a single file.
    pub fn read(path: &Path) -> Result<Uncertainties, FileError> {
        let (folder, name) = Folder::of_machine(path);
        Uncertainties::read_from(&folder, &name)
    }

    /// [`Uncertainties::read`] from any source of files; `name` is that of the `machine.toml`.
    ///
    /// # Errors
    /// As [`Uncertainties::read`].
    pub fn read_from(files: &dyn Source, name: &Path) -> Result<Uncertainties, FileError> {
        let (_, description) = described(files, name)?;
        let mut found = description.uncertainties;
        for reference in &description.tables {
            let file = path_from(name, &reference.file);
            let origin = Origin::new(&files.path(&file));
            let read = axis_table::read(&bytes(files, &file)?, &origin, reference.axis)?;
            if let Some(own) = found.axes.iter_mut().find(|own| own.axis == reference.axis) {
                own.points = read.uncertainty;
            }
        }
        Ok(found)
    }
}

/// A machine as it is before an edit of its files.
pub(crate) struct Current<'f> {
    pub(crate) files: &'f dyn Source,
    /// Name of the `machine.toml`.
    pub(crate) name: PathBuf,
    /// Unchanged text, byte order mark included.
    pub(crate) text: String,
    pub(crate) settings: MachineSettings,
    pub(crate) tables: Vec<CurrentTable>,
    /// Without those of the tables.
    pub(crate) uncertainties: Uncertainties,
    pub(crate) grids: Vec<GridReference>,
}

/// A table that `machine.toml` names.
pub(crate) struct CurrentTable {
    pub(crate) axis: Axis,
    /// As written in `machine.toml`, relative to it.
    pub(crate) name: String,
    pub(crate) line: u32,
    pub(crate) key: String,
    /// `None` if it cannot be read.
    pub(crate) table: Option<Table>,
}

impl<'f> Current<'f> {
    pub(crate) fn read(files: &'f dyn Source, name: &Path) -> Result<Current<'f>, FileError> {
        let (_, description) = described(files, name)?;
        let text = text(files, name)?;
        let tables = description.tables.into_iter().map(|TableReference { axis, file, line, key }| {
            let at = path_from(name, &file);
            let origin = Origin::new(&files.path(&at));
            let read = bytes(files, &at).and_then(|bytes| axis_table::read(&bytes, &origin, axis));
            CurrentTable { axis, name: file, line, key, table: read.ok().map(|file| file.table) }
        });
        let tables = tables.collect();
        Ok(Current {
            files,
            name: name.into(),
            text,
            settings: description.settings,
            tables,
            uncertainties: description.uncertainties,
            grids: description.grids,
        })
    }
}

/// Path of a file that a `machine.toml` names relative to itself.
pub(crate) fn path_from(machine_toml: &Path, file: &str) -> PathBuf {
    machine_toml.parent().unwrap_or(Path::new("")).join(file)
}

/// The unchanged text of a file, byte order mark included.
pub(crate) fn text(files: &dyn Source, name: &Path) -> Result<String, FileError> {
    Ok(String::from_utf8_lossy(&bytes(files, name)?).into_owned())
}

/// A `machine.toml`, and the origin to which its errors refer.
fn described(files: &dyn Source, name: &Path) -> Result<(Origin, Description), FileError> {
    let path = files.path(name);
    let text = decode(bytes(files, name)?, &path, &[])?;
    let origin = Origin::new(&path);
    let description = machine_toml::read(&text, &origin)?;
    Ok((origin, description))
}

fn read_grid(
    files: &dyn Source,
    machine_toml: &Path,
    reference: &GridReference,
    of_machine: &Origin,
    note: &mut dyn FnMut(String),
) -> Result<Grid, FileError> {
    let name = path_from(machine_toml, &reference.file);
    let path = files.path(&name);
    if !files.entry(&name).is_file() {
        let found = format!("{:?}, but no file at {}", reference.file, path.display());
        let needed = "the CSV of the grid, relative to this file";
        return Err(of_machine.at(reference.line, &reference.key, found, needed));
    }
    let file = grid_table::read(&bytes(files, &name)?, &Origin::new(&path), reference)?;
    if let Some(how) = file.dialect {
        note(format!("{}: {how}", path.display()));
    }
    Ok(file.grid)
}

fn read_table(
    files: &dyn Source,
    machine_toml: &Path,
    reference: &TableReference,
    settings: &AxisSettings,
    of_machine: &Origin,
    note: &mut dyn FnMut(String),
) -> Result<Table, FileError> {
    let name = path_from(machine_toml, &reference.file);
    let path = files.path(&name);
    if !files.entry(&name).is_file() {
        let found = format!("{:?}, but no file at {}", reference.file, path.display());
        let needed = "the CSV of the axis, relative to this file";
        return Err(of_machine.at(reference.line, &reference.key, found, needed));
    }
    let origin = Origin::new(&path);
    let file = axis_table::read(&bytes(files, &name)?, &origin, settings.axis)?;
    if let Some(how) = file.dialect {
        note(format!("{}: {how}", path.display()));
    }
    check::table(settings, file.table.rows.as_slice()).map_err(|fault| file.refused(&origin, &fault))?;
    let TableFile { table, .. } = file;
    Ok(table)
}
