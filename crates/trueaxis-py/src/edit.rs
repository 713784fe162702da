//! A machine's tables and settings, changed with the comments of its files kept.

use crate::machine::{Machine, axis_of, machine_of};
use crate::measured::columns_of_table;
use crate::{to_python, warn};
use anyhow::{Result, anyhow, bail};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use trueaxis::machine::Axis;
use trueaxis_tables::files::{Folder, Memory, Source};
use trueaxis_tables::output::{Alone, Outputs};
use trueaxis_tables::{Change, Setting, TableText, changes, table_texts};

/// A value of `machine.toml` from Python.
#[derive(FromPyObject)]
pub(crate) enum Given {
    Truth(bool),
    Number(f64),
    Word(String),
    Numbers(Vec<f64>),
}

impl From<Given> for Setting {
    fn from(given: Given) -> Setting {
        match given {
            Given::Truth(truth) => Setting::Truth(truth),
            Given::Number(number) => Setting::Number(number),
            Given::Word(word) => Setting::Word(word),
            Given::Numbers(numbers) => Setting::Numbers(numbers),
        }
    }
}

/// A table with the columns of `table` in that order, row by row.
type Rows = Vec<Vec<f64>>;

#[pymethods]
impl Machine {
    /// Return the table of an axis as it stands in its file.
    ///
    /// Parameters
    /// ----------
    /// axis : {"X", "Y", "Z", "A", "B", "C"}
    ///     The axis.
    ///
    /// Returns
    /// -------
    /// dict of numpy.ndarray
    ///     Columns by their names in the file, such as X_mm and EXX_um; `pandas.DataFrame(mill.table("X"))` shows them.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If the axis has no table, or the machine is a compiled file.
    ///
    /// Examples
    /// --------
    /// >>> mill = trueaxis.Machine.load("compensation-tables/mill-3axis")
    /// >>> list(mill.table("X"))[:2]
    /// ['X_mm', 'EXX_fwd_um']
    fn table<'py>(&self, py: Python<'py>, axis: char) -> PyResult<Bound<'py, PyDict>> {
        let table = to_python(self.text_of(axis_of(axis)?))?;
        let columns = PyDict::new(py);
        for (index, column) in table.columns.iter().enumerate() {
            let values = table.rows.iter().filter_map(|row| row.get(index).copied()).collect();
            columns.set_item(&column.name, PyArray1::from_vec(py, values))?;
        }
        Ok(columns)
    }

    /// Return the machine with another table of an axis: the file's comments, order and notation stay.
    ///
    /// Parameters
    /// ----------
    /// axis : {"X", "Y", "Z", "A", "B", "C"}
    ///     The axis, which has a table.
    /// table : dict of array-likes or data frame
    ///     The columns that `table` returns, of any number of rows in order of position. Rows at positions that the file has
    ///     keep their lines; the others are added or removed.
    ///
    /// Returns
    /// -------
    /// Machine
    ///     The changed machine; nothing is written until `save`.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If the columns are others than the file's, or the controller would refuse the table.
    ///
    /// Examples
    /// --------
    /// >>> mill = trueaxis.Machine.load("compensation-tables/mill-3axis")
    /// >>> table = mill.table("X")
    /// >>> table["EXX_fwd_um"] += 1.5
    /// >>> mill.with_table("X", table) == mill
    /// False
    fn with_table(&self, py: Python<'_>, axis: char, table: &Bound<'_, PyAny>) -> PyResult<Machine> {
        let axis = axis_of(axis)?;
        let old = to_python(self.text_of(axis))?;
        let names: Vec<&str> = old.columns.iter().map(|column| column.name.as_str()).collect();
        let rows = columns_of_table(table, "table", &names)?;
        to_python(py.detach(|| self.tabled(axis, &old, &rows)))
    }

    /// Return the machine with another value of a setting: comments and order of machine.toml stay.
    ///
    /// Parameters
    /// ----------
    /// key : str
    ///     Full name of the setting, such as "axis.X.backlash_um".
    /// value : float, bool, str, sequence of float or None
    ///     The value; None removes the setting, so that its default applies.
    ///
    /// Returns
    /// -------
    /// Machine
    ///     The changed machine; nothing is written until `save`.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If there is no such setting, or its value is out of range: with file and line.
    ///
    /// Examples
    /// --------
    /// >>> mill = trueaxis.Machine.load("compensation-tables/mill-3axis")
    /// >>> mill.with_setting("axis.Y.backlash_um", 2.5) == mill
    /// False
    #[pyo3(signature = (key, value))]
    fn with_setting(&self, py: Python<'_>, key: String, value: Option<Given>) -> PyResult<Machine> {
        let change = Change::Key { key, value: value.map(Setting::from) };
        to_python(py.detach(|| self.changed(&[change])))
    }

    /// Write the machine's files.
    ///
    /// Parameters
    /// ----------
    /// folder : path-like, optional
    ///     A folder without a machine, which gets all files; by default, the folder that the machine was loaded from, of which
    ///     changed files are replaced.
    ///
    /// Returns
    /// -------
    /// list of pathlib.Path
    ///     The files written: all of them, or none if one cannot be written.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If somebody has changed the machine's files since it was loaded, or the folder has a machine.
    #[pyo3(signature = (folder = None))]
    fn save(&self, py: Python<'_>, folder: Option<PathBuf>) -> PyResult<Vec<PathBuf>> {
        let mut notes = Vec::new();
        let written = py.detach(|| self.put(folder.as_deref(), &mut notes));
        notes.iter().try_for_each(|note| warn(py, note))?;
        to_python(written)
    }
}

impl Machine {
    fn memory(&self) -> Result<Memory> {
        if self.stated.is_none() {
            bail!("machine: found a compiled file, needed a machine.toml");
        }
        Ok(Memory::new(self.files.iter().map(|(name, bytes)| (name, bytes.as_slice()))))
    }

    fn text_of(&self, axis: Axis) -> Result<TableText> {
        let table = table_texts(&self.memory()?, &self.name)?.into_iter().find(|table| table.axis == axis);
        table.ok_or_else(|| anyhow!("axis: found {}, which has no table, needed one that has", axis.letter()))
    }

    fn changed(&self, of: &[Change]) -> Result<Machine> {
        let edited = changes(&self.memory()?, &self.name, of)?;
        let mut files = self.files.clone();
        files.extend(edited.files.into_iter().map(|(name, text)| (name, text.into_bytes())));
        machine_of(self.path.clone(), self.name.clone(), files, self.read.clone())
    }

    fn tabled(&self, axis: Axis, old: &TableText, rows: &Rows) -> Result<Machine> {
        let place = old.columns.iter().position(|column| column.component.is_none()).unwrap_or(0);
        let at = |row: &Vec<f64>| row.get(place).copied().unwrap_or_default();
        if let Some(row) = (1..rows.len()).find(|row| at(&rows[*row]) <= at(&rows[row - 1])) {
            let before = at(&rows[row - 1]);
            bail!("table[{row}]: found position {}, needed more than {before} of the row before", at(&rows[row]));
        }
        let has = |rows: &Rows, position: f64| rows.iter().any(|row| at(row) == position);
        let added = rows.iter().map(at).filter(|position| !has(&old.rows, *position));
        let mut all: Vec<Change> = added.map(|position| Change::Insert { axis, position }).collect();
        // Rows of both, in the order of position that the file then has.
        let mut merged: Vec<f64> = old.rows.iter().chain(rows).map(at).collect();
        merged.sort_by(f64::total_cmp);
        merged.dedup();
        let gone = merged.iter().enumerate().rev().filter(|(_, position)| !has(rows, **position));
        all.extend(gone.map(|(row, _)| Change::Remove { axis, row }));
        for (index, row) in rows.iter().enumerate() {
            let before = old.rows.iter().find(|old| at(old) == at(row));
            let differs = |column: usize| before.is_none_or(|before| before.get(column) != row.get(column));
            let values = old.columns.iter().zip(row).enumerate();
            let mut values = values
                .filter(|(column, _)| *column != place && differs(*column))
                .map(|(_, (column, value))| (column.name.clone(), *value));
            if let Some((column, value)) = values.next() {
                all.push(Change::Point { axis, column, row: index, value, also: values.collect() });
            }
        }
        let made = self.changed(&all)?;
        let text = made.text_of(axis)?;
        if let Some(row) = (0..rows.len()).find(|row| text.rows.get(*row) != rows.get(*row)) {
            bail!(
                "table[{row}]: found other values than in the last row, needed the same: a full circle ends where it begins"
            );
        }
        Ok(made)
    }

    fn put(&self, output: Option<&Path>, notes: &mut Vec<String>) -> Result<Vec<PathBuf>> {
        self.memory()?;
        let (own, _) = Folder::of_machine(&self.path);
        let home = own.path(&self.name);
        let home = home.parent().filter(|home| !home.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_path_buf();
        let output = output.unwrap_or(&home);
        let same = matches!((home.canonicalize(), output.canonicalize()), (Ok(one), Ok(other)) if one == other);
        let _alone = Alone::in_folder(output, &mut |note| notes.push(note))?;
        let description = Path::new("machine.toml");
        if !same && output.join(description).exists() {
            bail!("folder: found a machine in {}, needed a folder without one", output.display());
        }
        let (mut outputs, mut written) = (Outputs::default(), Vec::new());
        for (name, bytes) in &self.files {
            let target = output.join(if !same && *name == self.name { description } else { name });
            if same {
                let there = std::fs::read(&target).unwrap_or_default();
                if there == *bytes {
                    continue;
                }
                if self.read.get(name) != Some(&there) {
                    bail!(
                        "{}: found changes since the machine was loaded, needed none: load it again",
                        target.display()
                    );
                }
            }
            outputs.put(&target, bytes)?;
            written.push(target);
        }
        outputs.commit()?;
        Ok(written)
    }
}
