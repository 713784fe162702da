//! The mutants, as listed by `cargo mutants --list --json`.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde::Deserialize;

/// The rooms of the core that the campaign covers: folders and files of `crates/trueaxis/src`.
pub const ROOMS: [&str; 9] =
    ["limiter", "sample", "output", "compensation", "contour", "kinematics", "roundness", "exchange", "tcomp"];

pub const SOURCE: &str = "crates/trueaxis/src/";

#[derive(Deserialize)]
struct Place {
    line: usize,
    column: usize,
}

#[derive(Deserialize)]
struct Span {
    start: Place,
    end: Place,
}

#[derive(Deserialize)]
struct Function {
    function_name: String,
}

#[derive(Deserialize)]
struct Listed {
    name: String,
    file: String,
    function: Option<Function>,
    genre: String,
    replacement: String,
    span: Span,
}

/// One mutant.
#[derive(Clone, Debug)]
pub struct Mutant {
    /// Name given by cargo-mutants, with file, line and column.
    pub name: String,
    /// The mutation without its location: `replace + with - in Limiter<R>::new`.
    pub change: String,
    pub file: String,
    pub function: String,
    pub genre: String,
    pub replacement: String,
    pub line: usize,
    pub column: usize,
    pub start: usize,
    pub end: usize,
    /// The source line, trimmed.
    pub code: String,
}

impl Mutant {
    pub fn room(&self) -> &str {
        let inside = self.file.strip_prefix(SOURCE).unwrap_or(&self.file);
        inside.split('/').next().unwrap_or(inside).trim_end_matches(".rs")
    }

    /// Key that identifies the mutant in a later run, even if lines above it have moved.
    pub fn key(&self) -> String {
        format!("{}|{}|{}|{}", self.file, self.column, self.change, self.code)
    }
}

/// Lists all mutants of the rooms; with a diff, only those on its lines.
pub fn list(root: &Path, diff: Option<&Path>) -> Result<Vec<Mutant>> {
    let mut command = Command::new("cargo");
    command.current_dir(root).args(["mutants", "-p", "trueaxis", "--list", "--json"]);
    for room in ROOMS {
        command.args(["--file", &format!("{SOURCE}{room}.rs"), "--file", &format!("{SOURCE}{room}/**/*.rs")]);
    }
    if let Some(diff) = diff {
        command.arg("--in-diff").arg(diff);
    }
    let output = command.output().context("cargo mutants: not installed? cargo install --locked cargo-mutants")?;
    if !output.status.success() {
        bail!("cargo mutants --list: {}", String::from_utf8_lossy(&output.stderr));
    }
    // The output is empty if the diff contains no mutant, for example only comments or tests.
    if output.stdout.is_empty() {
        return Ok(Vec::new());
    }
    let listed: Vec<Listed> = serde_json::from_slice(&output.stdout).context("cargo mutants --list --json")?;
    let mut file = (String::new(), String::new());
    let mut mutants = Vec::with_capacity(listed.len());
    for one in listed {
        if file.0 != one.file {
            file = (one.file.clone(), std::fs::read_to_string(root.join(&one.file))?);
        }
        mutants.push(placed(one, &file.1)?);
    }
    Ok(mutants)
}

fn placed(one: Listed, text: &str) -> Result<Mutant> {
    let change = one.name.splitn(4, ':').nth(3).map(str::trim).unwrap_or(&one.name).to_string();
    Ok(Mutant {
        change,
        function: one.function.map(|f| f.function_name).unwrap_or_default(),
        line: one.span.start.line,
        column: one.span.start.column,
        start: offset(text, &one.span.start).with_context(|| one.name.clone())?,
        end: offset(text, &one.span.end).with_context(|| one.name.clone())?,
        code: text.lines().nth(one.span.start.line - 1).unwrap_or_default().trim().to_string(),
        name: one.name,
        file: one.file,
        genre: one.genre,
        replacement: one.replacement,
    })
}

/// Byte offset of a line and column, both from 1, the column in characters.
fn offset(text: &str, place: &Place) -> Option<usize> {
    let line = text.split_inclusive('\n').nth(place.line - 1)?;
    let before: usize = text.split_inclusive('\n').take(place.line - 1).map(str::len).sum();
    let inside = line.char_indices().nth(place.column - 1).map_or(line.len(), |(at, _)| at);
    Some(before + inside)
}
