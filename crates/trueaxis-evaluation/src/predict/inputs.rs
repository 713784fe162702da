//! A part with its programs and tasks from the folder of its file.

use super::{Growth, GrowthModel, Part, Start, TemperatureRecord};
use crate::calibrate::Task;
use anyhow::{Result, bail};
use std::fs::canonicalize;
use std::path::{Path, PathBuf};
use trueaxis_sim::program::{Program, ReadOptions, Source};
use trueaxis_tables::Machine;
use trueaxis_tables::text::read_text;

/// Begin comments before a table.
const COMMENTS: &[char] = &['#', ';'];

/// A part and the program that cuts it.
pub struct PartFiles {
    /// The part, with the programs of its further set-ups.
    pub part: Part,
    /// Its program.
    pub program: Program,
    /// The program's file.
    pub path: PathBuf,
}

impl PartFiles {
    /// Reads a part's file and its program: `program`, or the file that the part names, beside it. `option` is what states
    /// the program otherwise, for errors.
    ///
    /// # Errors
    /// A file that cannot be read or is refused; no program.
    pub fn read(file: &Path, program: Option<&Path>, option: &str) -> Result<PartFiles> {
        let text = read_text(file, COMMENTS)?;
        let mut part = Part::read(&text, file)?;
        let path = path_of(file, program, part.program.as_deref(), option)?;
        let program = read_program(&path)?;
        part.read_setups(|name| read_program(&file.with_file_name(name)))?;
        Ok(PartFiles { part, program, path })
    }

    /// Reads the program alone, of a part whose features and tolerances may be unfinished; arguments as for
    /// [`PartFiles::read`].
    ///
    /// # Errors
    /// As [`PartFiles::read`], but for the features and tolerances.
    pub fn program_of(file: &Path, program: Option<&Path>, option: &str) -> Result<Program> {
        let named = Part::first_program(&read_text(file, COMMENTS)?, file)?;
        read_program(&path_of(file, program, named.as_deref(), option)?)
    }
}

fn path_of(file: &Path, program: Option<&Path>, named: Option<&str>, option: &str) -> Result<PathBuf> {
    let beside = named.map(|name| file.with_file_name(name));
    let Some(path) = program.map(Path::to_path_buf).or(beside) else {
        bail!("{}: key program: found nothing, needed a G-code file, or {option}", file.display());
    };
    Ok(path)
}

fn read_program(path: &Path) -> Result<Program> {
    let source = Source::read(path)?;
    Ok(Program::read(&source.name, &source.bytes, &source.file, &ReadOptions::default().beside(path))?)
}

impl Part {
    /// The part with the growth of its machine while it is cut: by a record from this start on, otherwise at the constant
    /// temperature that the part's file states.
    ///
    /// # Errors
    /// Those of `model`, [`Growth::recorded`] and [`Growth::constant`].
    pub fn warmed(
        self,
        record: Option<(&TemperatureRecord, Start)>,
        model: impl FnOnce() -> Result<GrowthModel>,
    ) -> Result<Part> {
        let growth = match (record, self.temperature.machine_c) {
            (Some((record, start)), _) => Growth::recorded(model()?, record, start)?,
            (None, Some(celsius)) => Growth::constant(model()?, celsius)?,
            (None, None) => return Ok(self),
        };
        Ok(Part { growth: Some(growth), ..self })
    }
}

/// Reads a task of `calibrate` that a part names, beside the part's file.
///
/// # Errors
/// A file that cannot be read or is refused; a task of another machine than the one in `machine`.
pub fn own_task(part: &Path, name: &str, machine: &Path) -> Result<Task> {
    let file = part.with_file_name(name);
    let task = Task::read(&read_text(&file, COMMENTS)?, &file)?;
    let description = |path: &Path| if path.is_dir() { path.join("machine.toml") } else { path.to_owned() };
    let stated = task.file.with_file_name("").join(&task.machine);
    let [own, wanted] = [stated.as_path(), machine].map(|path| canonicalize(description(path)).ok());
    if own.is_none() || own != wanted {
        let (file, found, needed) = (task.file.display(), stated.display(), machine.display());
        bail!("{file}: key machine: found {found}, needed {needed}, the machine that is predicted");
    }
    Ok(task)
}

/// The `thermal.toml` beside a machine.toml, or in its folder.
pub fn thermal_beside(machine: &Path) -> Option<PathBuf> {
    let path = if machine.is_dir() { machine.join("thermal.toml") } else { machine.with_file_name("thermal.toml") };
    path.is_file().then_some(path)
}

/// The growth of a machine: that of the `thermal.toml` beside its file `path`, otherwise of its `[axis.X.thermal]`.
///
/// # Errors
/// As [`GrowthModel::of`]; a file that cannot be read.
pub fn growth_model(machine: &Machine, path: &Path) -> Result<GrowthModel> {
    let file = thermal_beside(path);
    let text = file.as_deref().map(|file| read_text(file, &['#'])).transpose()?;
    GrowthModel::of(machine, text.as_deref().zip(file.as_deref()))
}
