//! The program of a scenario: its arguments, reading, and notes.

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use firmware_sim::rs274;
use std::io::Read;
use std::path::{Path, PathBuf};
use trueaxis_sim::program::{Note, Offsets, Program, ProgramError, ReadOptions, ToolTable, limits};

#[derive(Args)]
pub(crate) struct ProgramArgs {
    /// Program: a G-code file, or circle-diamond-square, butterfly, pocket-3d, cone-5axis, short-tour.
    #[arg(long = "program", value_name = "P.ngc", default_value = "circle-diamond-square")]
    pub(crate) file: PathBuf,
    /// Tool table in LinuxCNC's form, for G43 [default: tools without length].
    #[arg(long, value_name = "FILE")]
    tool_table: Option<PathBuf>,
    /// Work offsets G54 to G59.3 and G92, places of G28 and G30: LinuxCNC's parameter file, or a .toml [default: all zero].
    #[arg(long, value_name = "FILE")]
    pub(crate) offsets: Option<PathBuf>,
    /// Leave out the lines that begin with `/`.
    #[arg(long)]
    block_delete: bool,
    /// Who interprets the program.
    #[arg(long, value_name = "WHO", value_enum, default_value_t = Interpreter::Own)]
    interpreter: Interpreter,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Interpreter {
    /// This program.
    Own,
    /// LinuxCNC's own, where it is installed: parameters, subprograms, cutter compensation.
    Rs274,
}

impl ProgramArgs {
    /// Every file that is read.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        [Some(&self.file), self.tool_table.as_ref(), self.offsets.as_ref()].into_iter().flatten().map(PathBuf::as_path)
    }

    pub(crate) fn read(&self) -> Result<Program> {
        let options = ReadOptions {
            tools: self.tool_table.as_deref().map(read_tools).transpose()?,
            offsets: self.offsets.as_deref().map(read_offsets).transpose()?,
            block_delete: self.block_delete,
        };
        let read = match self.interpreter {
            Interpreter::Own => Program::read,
            Interpreter::Rs274 => rs274::read,
        };
        let file = self.file.display().to_string();
        let name = self.file.to_string_lossy();
        if !self.file.exists()
            && let Some(text) = Program::builtin_text(&name)
        {
            return Ok(read(&name, text.as_bytes(), &file, &options)?);
        }
        let bytes = read_bounded(&self.file)?;
        let stem = self.file.file_stem().map_or(name.clone(), |s| s.to_string_lossy());
        Ok(read(&stem, &bytes, &file, &options)?)
    }
}

/// A file of at most [`limits::MOST_BYTES`]; no more is read of a longer one.
fn read_bounded(path: &Path) -> Result<Vec<u8>> {
    let cannot = || format!("cannot read the program {}", path.display());
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).with_context(cannot)?;
    file.take(limits::MOST_BYTES + 1).read_to_end(&mut bytes).with_context(cannot)?;
    if bytes.len() as u64 > limits::MOST_BYTES {
        let line = bytes.iter().filter(|byte| **byte == b'\n').count() as u32 + 1;
        let found = format!("more than {} bytes", limits::MOST_BYTES);
        return Err(ProgramError::new(&path.display().to_string(), line, found, "a shorter program").into());
    }
    Ok(bytes)
}

fn read_tools(path: &Path) -> Result<ToolTable, ProgramError> {
    let file = path.display().to_string();
    let bytes = std::fs::read(path)
        .map_err(|e| ProgramError::new(&file, 1, format!("a file that cannot be read ({e})"), "a tool table"))?;
    ToolTable::parse(&String::from_utf8_lossy(&bytes), &file)
}

fn read_offsets(path: &Path) -> Result<Offsets, ProgramError> {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path)
        .map_err(|e| ProgramError::new(&file, 1, format!("a file that cannot be read ({e})"), "a file of offsets"))?;
    Offsets::parse(&text, &file)
}

/// The document that `run --json` prints.
#[derive(serde::Serialize)]
pub(crate) struct Document<'p, Run> {
    #[serde(flatten)]
    pub(crate) run: Run,
    /// Words of the program without effect, once per kind.
    pub(crate) noted: &'p [Note],
}

/// Words of the program without effect, once per kind.
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
