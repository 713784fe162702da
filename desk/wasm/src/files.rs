//! A machine's files as the page stores them.

use anyhow::{Context, Result, anyhow, bail};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::formats::{iso230_2::read_measurement, machine_files};
use trueaxis_tables::text::{counted, decode};

/// File name of a machine's description.
pub(crate) const DESCRIPTION: &str = "machine.toml";

/// Texts by name.
pub(crate) type Texts = BTreeMap<String, String>;

/// Files from `{"name": "text", …}`.
pub(crate) fn texts(files: &str) -> Result<Texts> {
    serde_json::from_str(files).context("the files of a machine")
}

/// A source of files from `{"name": "text", …}`.
pub(crate) fn memory(files: &str) -> Result<Memory> {
    Ok(Memory::new(texts(files)?))
}

/// The machine of these files; `notes` receives the detected separators.
pub(crate) fn machine(files: &str, notes: &mut Vec<String>) -> Result<Machine> {
    machine_of(&texts(files)?, notes)
}

/// Like [`machine`], from parsed texts.
pub(crate) fn machine_of(texts: &Texts, notes: &mut Vec<String>) -> Result<Machine> {
    read(&Memory::new(texts.clone()), notes)
}

fn read(memory: &Memory, notes: &mut Vec<String>) -> Result<Machine> {
    Ok(Machine::read_from(memory, Path::new(DESCRIPTION), &mut |note| notes.push(note))?)
}

/// Files read as a machine.
#[derive(Debug, Serialize)]
pub(crate) struct MachineFiles {
    /// Name of the folder, of the file, or of the machine.
    pub(crate) name: String,
    /// Texts by name.
    pub(crate) files: Texts,
    /// Detected formats and omitted files.
    pub(crate) notes: Vec<String>,
}

/// A given file: its path and bytes.
type Given<'b> = (PathBuf, &'b [u8]);

/// The files of `names`, `[["mill/x.csv", 1234], …]`, whose bytes are concatenated.
pub(crate) fn given<'b>(names: &str, bytes: &'b [u8]) -> Result<Vec<Given<'b>>> {
    let names: Vec<(PathBuf, usize)> = serde_json::from_str(names).context("names and lengths of files")?;
    let mut rest = bytes;
    let next = |(name, length): (PathBuf, usize)| {
        let (own, others) = rest.split_at_checked(length).context("fewer bytes than the lengths say")?;
        rest = others;
        Ok((name, own))
    };
    names.into_iter().map(next).collect()
}

/// Reads a machine from dropped files: a folder with its `machine.toml`, a compiled file, or files that replace those of the
/// current machine or are added to them.
///
/// # Errors
/// The files contain no machine, or several; all errors of reading, with file, line and column.
pub(crate) fn from_given(current: &Texts, given: &[Given<'_>]) -> Result<MachineFiles> {
    if let [(name, bytes)] = given
        && has_ending(name, "tcomp")
    {
        return from_tcomp(name, bytes);
    }
    match description(given)? {
        Some(description) => folder(description, given),
        None => joined(current, given),
    }
}

/// The files of a compiled machine, in the library's format.
fn from_tcomp(name: &Path, bytes: &[u8]) -> Result<MachineFiles> {
    let tables = Tcomp::parse(bytes).map_err(|error| anyhow!("{}: {error}", name.display()))?;
    let machine = Machine::from_tcomp(&tables);
    let files = machine_files(&machine, "From a compiled file: settings and tables as it holds them.");
    let mut notes = Vec::new();
    read(&Memory::new(files.clone()), &mut notes)?;
    Ok(MachineFiles { name: machine.settings.name.to_string(), files: files.into_iter().collect(), notes })
}

fn has_ending(name: &Path, ending: &str) -> bool {
    name.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending))
}

/// The single `machine.toml` at the highest level, or the only TOML file.
fn description<'g>(given: &'g [Given<'_>]) -> Result<Option<&'g Path>> {
    let depth = |name: &Path| name.components().count();
    let called = |name: &&Path| name.file_name().is_some_and(|own| own == DESCRIPTION);
    let all = || given.iter().map(|(name, _)| name.as_path());
    let mut found: Vec<&Path> = all().filter(called).collect();
    if found.is_empty() {
        found = all().filter(|name| has_ending(name, "toml")).collect();
    }
    let highest = found.iter().map(|name| depth(name)).min().unwrap_or(0);
    found.retain(|name| depth(name) == highest);
    match found.as_slice() {
        [] => Ok(None),
        [only] => Ok(Some(only)),
        several => {
            let names: Vec<String> = several.iter().map(|name| name.display().to_string()).collect();
            bail!("found several machines, {}, needed one", names.join(" and "))
        }
    }
}

/// Takes a folder with all the files of a machine.
fn folder(description: &Path, given: &[Given<'_>]) -> Result<MachineFiles> {
    let folder = description.parent().unwrap_or(Path::new(""));
    let (mut files, mut left) = (BTreeMap::new(), 0);
    for (name, bytes) in given {
        if name == description {
            files.insert(PathBuf::from(DESCRIPTION), *bytes);
        } else if has_ending(name, "csv") {
            files.insert(relative(name, folder), *bytes);
        } else {
            left += 1;
        }
    }
    // A table may have any file extension.
    if let Ok(text) = decode(files[Path::new(DESCRIPTION)].to_vec(), description, &[]) {
        for (name, bytes) in given {
            let own = relative(name, folder);
            if !files.contains_key(&own) && text.contains(&format!("\"{}\"", own.display())) {
                files.insert(own, bytes);
                left -= 1;
            }
        }
    }
    let mut notes = Vec::new();
    if left > 0 {
        notes.push(format!("{} left out that no machine needs", counted(left, "file")));
    }
    let own = folder.file_name().map(|name| name.to_string_lossy().into_owned());
    read_files(files, own, notes)
}

/// A path relative to the folder of the description.
fn relative(name: &Path, folder: &Path) -> PathBuf {
    let mut up = PathBuf::new();
    for ancestor in folder.ancestors() {
        if let Ok(rest) = name.strip_prefix(ancestor) {
            return up.join(rest);
        }
        up.push(Component::ParentDir);
    }
    name.to_path_buf()
}

/// Replaces the machine's files of the same name, and adds measurements.
fn joined(current: &Texts, given: &[Given<'_>]) -> Result<MachineFiles> {
    if given.is_empty() {
        bail!("found no files, needed a folder with a {DESCRIPTION}, its tables, or a .tcomp");
    }
    let mut files: BTreeMap<PathBuf, &[u8]> =
        current.iter().map(|(name, text)| (PathBuf::from(name), text.as_bytes())).collect();
    for (name, bytes) in given {
        let own = PathBuf::from(name.file_name().unwrap_or(name.as_os_str()));
        let names = || files.keys().map(|name| name.display().to_string()).collect::<Vec<_>>().join(" ");
        if !files.contains_key(&own) {
            let read = decode(bytes.to_vec(), &own, &['#', ';']).and_then(|text| read_measurement(&text, &own, None));
            if let Err(error) = read {
                let own = own.display();
                bail!(
                    "{own}: found a file that is none of the machine's and no measurement ({error}), needed one of {}, a \
                     folder with a {DESCRIPTION}, or a .tcomp",
                    names()
                );
            }
        }
        files.insert(own, bytes);
    }
    read_files(files, None, Vec::new())
}

/// Reads the machine and stores its files as texts.
fn read_files(files: BTreeMap<PathBuf, &[u8]>, name: Option<String>, mut notes: Vec<String>) -> Result<MachineFiles> {
    let machine = read(&Memory::new(files.iter().map(|(name, bytes)| (name, *bytes))), &mut notes)?;
    let mut texts = Texts::new();
    for (name, bytes) in files {
        // Comments of a table may be in any encoding; the reader has accepted everything else.
        texts.insert(name.to_string_lossy().into_owned(), String::from_utf8_lossy(bytes).into_owned());
    }
    Ok(MachineFiles { name: name.unwrap_or_else(|| machine.settings.name.to_string()), files: texts, notes })
}
