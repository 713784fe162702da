//! The program of a scenario: arguments, reading, and notes.

use anyhow::{Result, ensure};
use clap::{Args, ValueEnum};
use firmware_sim::rs274;
use std::path::{Path, PathBuf};
use trueaxis_sim::program::{Program, ReadOptions, Source};

#[derive(Args)]
pub(crate) struct ProgramArgs {
    /// Program: a G-code file, or circle-diamond-square, butterfly, pocket-3d, cone-5axis, s-shape, short-tour.
    #[arg(
        long = "program",
        value_name = "P.ngc",
        default_value = "circle-diamond-square",
        help_heading = "Machine and program"
    )]
    pub(crate) file: PathBuf,
    /// Tool table in LinuxCNC's form, for G43 [default: tools without length].
    #[arg(long, value_name = "FILE", help_heading = "Machine and program")]
    tool_table: Option<PathBuf>,
    /// Work offsets G54 to G59.3 and G92, positions of G28 and G30: LinuxCNC's parameter file, or a .toml [default: all zero].
    #[arg(long, value_name = "FILE", help_heading = "Machine and program")]
    pub(crate) offsets: Option<PathBuf>,
    /// Skip the lines that begin with `/`.
    #[arg(long, help_heading = "Machine and program")]
    block_delete: bool,
    /// What probing moves G38.2 to G38.5 touch: a .toml with a plane, boxes, balls, a height map [default: nothing].
    #[arg(long, value_name = "FILE", help_heading = "Machine and program")]
    surface: Option<PathBuf>,
    /// Interpreter of the program.
    #[arg(
        long,
        value_name = "WHO",
        value_enum,
        default_value_t = Interpreter::Own,
        help_heading = "Machine and program"
    )]
    interpreter: Interpreter,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Interpreter {
    /// This program.
    Own,
    /// LinuxCNC's own, if it is installed: for cutter compensation.
    Rs274,
}

impl ProgramArgs {
    /// All input files.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        let given = [Some(&self.file), self.tool_table.as_ref(), self.offsets.as_ref(), self.surface.as_ref()];
        given.into_iter().flatten().map(PathBuf::as_path)
    }

    pub(crate) fn read(&self) -> Result<Program> {
        let mut options =
            ReadOptions::from_files(self.tool_table.as_deref(), self.offsets.as_deref(), self.block_delete)?
                .beside(&self.file);
        if let Some(surface) = &self.surface {
            ensure!(
                self.interpreter == Interpreter::Own,
                "found --surface with --interpreter rs274, needed one of them"
            );
            options = options.probing(surface)?;
        }
        let read = match self.interpreter {
            Interpreter::Own => Program::read,
            Interpreter::Rs274 => rs274::read,
        };
        let source = Source::read(&self.file)?;
        Ok(read(&source.name, &source.bytes, &source.file, &options)?)
    }
}

/// Program words without effect, once per kind.
pub(crate) fn noted(program: &Program) -> String {
    let (plain, explained): (Vec<_>, Vec<_>) = program.notes.iter().partition(|note| note.why.is_empty());
    let mut text = String::new();
    if !plain.is_empty() {
        let kinds: Vec<String> = plain.iter().map(ToString::to_string).collect();
        text += &format!("noted, no effect: {}\n", kinds.join(", "));
    }
    for note in explained {
        text += &format!("noted    {note}\n");
    }
    text
}
