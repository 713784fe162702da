//! Writes results of an identification into a machine's folder, or into a copy of it.

use crate::model;
use crate::output::{json, print, report_line};
use anyhow::{Result, bail};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use trueaxis_tables::error::FileError;
use trueaxis_tables::files::Folder;
use trueaxis_tables::finding::{Decision, table};
use trueaxis_tables::output::{Alone, Outputs};
use trueaxis_tables::{Additions, Edited};

/// Locks the folder that a machine is written into, until the value is dropped. Call it before reading the machine.
pub(crate) fn alone(output: &Path) -> Result<Alone> {
    Ok(Alone::in_folder(output, &mut model::note)?)
}

/// Files of the machine that a command reads and must not write. Empty if it writes into the machine's own folder.
pub(crate) fn inputs(machine: &Path, output: Option<&Path>) -> Vec<PathBuf> {
    let same = output.is_some_and(|output| own(machine, output).1);
    if same { Vec::new() } else { model::files(machine).into_iter().collect() }
}

/// Splits `-o` of a command that writes either a result file or, with a machine and without the file's extension, a folder for
/// the machine.
pub(crate) fn file_or_folder<'o>(
    output: Option<&'o Path>,
    extension: &str,
    has_machine: bool,
) -> (Option<&'o Path>, Option<&'o Path>) {
    let is_file =
        |path: &Path| path.is_file() || path.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension));
    let file = output.filter(|path| !has_machine || is_file(path));
    (file, output.filter(|_| file.is_none()))
}

/// The machine's own folder, and whether `output` is that folder.
fn own(machine: &Path, output: &Path) -> (PathBuf, bool) {
    let own = if machine.is_dir() { machine.to_path_buf() } else { machine.parent().unwrap_or(Path::new("")).into() };
    let own = if own.as_os_str().is_empty() { PathBuf::from(".") } else { own };
    let same = matches!((own.canonicalize(), output.canonicalize()), (Ok(own), Ok(output)) if own == output);
    (own, same)
}

/// Stages `machine` with the results added, in `output`: its own folder, or another one without a machine.toml, which gets all
/// of its files. Existing settings, their order and comments are preserved. Returns the notes to print once it is written.
pub(crate) fn write(
    outputs: &mut Outputs,
    machine: &Path,
    output: &Path,
    edit: impl FnOnce(&Folder, &Path) -> Result<Edited, FileError>,
) -> Result<Vec<String>> {
    let (folder, name) = Folder::of_machine(machine);
    if machine.extension().is_some_and(|extension| extension == "tcomp") {
        bail!("--machine: found {}, needed a machine.toml or its folder to write into", machine.display());
    }
    let (own, same) = own(machine, output);
    if !same && output.join("machine.toml").exists() {
        bail!(
            "--output: found a machine in {}, needed the folder of --machine or one without a machine",
            output.display()
        );
    }
    let edited = edit(&folder, &name)?;
    let mut notes = edited.notes;
    if !same {
        for file in model::files(machine) {
            let of = file.strip_prefix(&own).unwrap_or(&file);
            if edited.files.iter().any(|(changed, _)| changed == of) {
                continue;
            }
            let target = if of == name { Path::new("machine.toml") } else { of };
            outputs.put(&output.join(target), &std::fs::read(&file)?)?;
        }
    }
    for (file, text) in &edited.files {
        let target = if !same && *file == name { Path::new("machine.toml") } else { file.as_path() };
        outputs.put(&output.join(target), text.as_bytes())?;
        notes.push(format!("written {}", output.join(target).display()));
    }
    Ok(notes)
}

/// How a command writes into a machine.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Writing {
    /// Print the changes to the machine, with old values and reasons, and write nothing.
    #[arg(long, help_heading = "Writing into a machine")]
    pub(crate) dry_run: bool,
    /// Write every value found, even one that the rule rejects: within its scatter of zero, less certain than the stated one,
    /// a misfit. The command still reports the rule's decision, and refuses a value that the controller would refuse.
    #[arg(long, help_heading = "Writing into a machine")]
    pub(crate) force: bool,
}

impl Writing {
    /// The folder or file that `-o` names; `None` in a dry run.
    pub(crate) fn output<'o>(&self, output: Option<&'o Path>) -> Option<&'o Path> {
        output.filter(|_| !self.dry_run)
    }

    /// Whether the command decides on its findings: it does if it writes `into` a machine, or if it reports the decisions in a
    /// dry run. Refuses `--force` otherwise.
    pub(crate) fn decides(&self, into: Option<&Path>) -> Result<bool> {
        let decides = into.is_some() || self.dry_run;
        if self.force && !decides {
            bail!("--force: found no machine to write, needed -o MACHINE_DIR or --dry-run");
        }
        Ok(decides)
    }
}

/// The decisions of a command, and its notes on them.
#[derive(Default)]
pub(crate) struct Done {
    /// `None` without a machine.
    decisions: Option<Vec<Decision>>,
    notes: Vec<String>,
}

/// The document of a command with its decisions, under `written`.
#[derive(Serialize)]
struct WithDecisions<'d, D> {
    #[serde(flatten)]
    document: &'d D,
    #[serde(skip_serializing_if = "Option::is_none")]
    written: Option<&'d [Decision]>,
}

impl Done {
    /// Prints the notes on the decisions and the written files.
    pub(crate) fn print_notes(&self) {
        print_notes(&self.notes);
    }

    /// Prints the document with the decisions as JSON.
    pub(crate) fn json(&self, document: &impl Serialize) -> Result<()> {
        json(&WithDecisions { document, written: self.decisions.as_deref() })
    }

    /// Prints the decisions: with the document as JSON, or as notes only.
    pub(crate) fn dry_run(&self, document: &impl Serialize, as_json: bool) -> Result<()> {
        if as_json {
            return self.json(document);
        }
        print(&self.notes.iter().map(|note| format!("{note}\n")).collect::<String>())
    }
}

/// Decides on every finding of the additions, which are based on the file `record`, and stages the machine with the accepted
/// ones, like [`write()`]. Without a folder nothing is staged, but a finding that cannot be written is still refused.
pub(crate) fn decide(
    outputs: &mut Outputs,
    machine: &Path,
    into: Option<&Path>,
    record: &Path,
    (writing, additions): (Writing, Additions),
) -> Result<Done> {
    let additions = Additions { force: writing.force, ..additions.of_record(&std::fs::read(record)?) };
    let (folder, name) = Folder::of_machine(machine);
    let decisions = additions.decide(&folder, &name)?;
    let mut notes = Vec::from_iter(Some(table(&decisions)).filter(|table| !table.is_empty()));
    if let Some(output) = into {
        notes.extend(write(outputs, machine, output, |folder, name| additions.edit(folder, name))?);
    } else {
        additions.edit(&folder, &name)?;
    }
    Ok(Done { decisions: Some(decisions), notes })
}

/// Prints the notes on the written files.
pub(crate) fn print_notes(notes: &[String]) {
    notes.iter().for_each(report_line);
}

/// Stages a whole machine in a folder without one. Returns the notes to print once it is written.
pub(crate) fn whole(outputs: &mut Outputs, output: &Path, files: &[(String, String)]) -> Result<Vec<String>> {
    if output.join("machine.toml").exists() {
        bail!("--output: found a machine in {}, needed a folder without one", output.display());
    }
    let mut notes = Vec::new();
    for (name, text) in files {
        outputs.put(&output.join(name), text.as_bytes())?;
        notes.push(format!("written {}", output.join(name).display()));
    }
    Ok(notes)
}
