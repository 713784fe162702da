//! Reads a program, tools and offsets from their files. Nothing else in this crate opens a file.

use super::{Offsets, Program, ProgramError, ReadOptions, Surface, ToolTable, limits};
use crate::error::{Result, SimError};
use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

/// The text of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Name of the program.
    pub name: String,
    /// Text in any encoding.
    pub bytes: Cow<'static, [u8]>,
    /// File name for errors.
    pub file: String,
}

impl Source {
    /// Reads a file of at most [`limits::MOST_BYTES`], and never more than that; if no such file exists, a shipped program of
    /// that name.
    ///
    /// # Errors
    /// A file that cannot be read, or is too long.
    pub fn read(given: &Path) -> Result<Source> {
        let (file, name) = (given.display().to_string(), given.to_string_lossy());
        if !given.exists()
            && let Some(text) = Program::builtin_text(&name)
        {
            return Ok(Source { name: name.into_owned(), bytes: text.as_bytes().into(), file });
        }
        let mut bytes = Vec::new();
        let opened = std::fs::File::open(given);
        let read = opened.and_then(|opened| opened.take(limits::MOST_BYTES + 1).read_to_end(&mut bytes));
        read.map_err(|error| SimError::Unread { file: file.clone(), error })?;
        if bytes.len() as u64 > limits::MOST_BYTES {
            let line = bytes.iter().filter(|byte| **byte == b'\n').count() as u32 + 1;
            let found = format!("more than {} bytes", limits::MOST_BYTES);
            return Err(ProgramError::new(&file, line, found, "a shorter program").into());
        }
        let name = given.file_stem().unwrap_or(given.as_os_str()).to_string_lossy().into_owned();
        Ok(Source { name, bytes: bytes.into(), file })
    }
}

impl ReadOptions {
    /// Reads tools from LinuxCNC's tool table, offsets from its parameter file or a .toml.
    ///
    /// # Errors
    /// A file that cannot be read, or has another format; with its line.
    pub fn from_files(tools: Option<&Path>, offsets: Option<&Path>, block_delete: bool) -> Result<Self, ProgramError> {
        let of = |path: &Path, error, needed| {
            ProgramError::new(&path.display().to_string(), 1, format!("a file that cannot be read ({error})"), needed)
        };
        let tools = tools.map(|path| {
            let bytes = std::fs::read(path).map_err(|error| of(path, error, "a tool table"))?;
            ToolTable::parse(&String::from_utf8_lossy(&bytes), &path.display().to_string())
        });
        let offsets = offsets.map(|path| {
            let text = std::fs::read_to_string(path).map_err(|error| of(path, error, "a file of offsets"))?;
            Offsets::parse(&text, &path.display().to_string())
        });
        Ok(ReadOptions {
            tools: tools.transpose()?,
            offsets: offsets.transpose()?,
            block_delete,
            ..ReadOptions::default()
        })
    }

    /// Probing moves touch the surface of a file ([`Surface::parse`]), with its height map beside it.
    ///
    /// # Errors
    /// A file that cannot be read, or has another format; with its line.
    pub fn probing(mut self, surface: &Path) -> Result<Self, ProgramError> {
        let file = surface.display().to_string();
        let text = std::fs::read_to_string(surface).map_err(|error| {
            ProgramError::new(&file, 1, format!("a file that cannot be read ({error})"), "a file of a surface")
        })?;
        let beside = |name: &str| std::fs::read_to_string(surface.with_file_name(name));
        self.surface = Some(Surface::parse(&text, &file, beside)?);
        Ok(self)
    }

    /// Also finds subprograms in the files beside the program.
    pub fn beside(mut self, program: &Path) -> Self {
        self.folder =
            program.parent().map(|folder| if folder == Path::new("") { Path::new(".") } else { folder }.into());
        self
    }
}

/// Path and bytes of a subprogram's file, if there is one: `name.ngc`.
pub(super) fn subprogram(options: &ReadOptions, name: &str) -> Option<(String, Vec<u8>)> {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    if name.is_empty() || !name.chars().all(plain) {
        return None;
    }
    let file = format!("{name}.ngc");
    if let Some(text) = options.texts.as_ref().and_then(|texts| texts.get(&file)) {
        return Some((file, text.clone().into_bytes()));
    }
    let path = options.folder.as_ref()?.join(file);
    let mut bytes = Vec::new();
    std::fs::File::open(&path).ok()?.take(limits::MOST_BYTES).read_to_end(&mut bytes).ok()?;
    Some((path.display().to_string(), bytes))
}
