//! `trueaxis calibrate solve`.

use super::table::table;
use super::{Read, SolveArguments, read};
use crate::model;
use crate::output::{json, print, progress, tell};
use crate::report;
use anyhow::{Result, bail};
use std::path::{Path, PathBuf};
use trueaxis_evaluation::calibrate::{Plan, calibrate, read_log, trips};
use trueaxis_tables::output::Outputs;
use trueaxis_tables::{Edited, Machine};

pub(super) fn run(arguments: &SolveArguments) -> Result<()> {
    let read = read(&arguments.task)?;
    let same = is_same(&arguments.output, &read.path);
    if !same && arguments.output.join("machine.toml").symlink_metadata().is_ok() {
        bail!(
            "{}: found another machine, needed {}, which the task names, or a folder without machine.toml",
            arguments.output.display(),
            read.path.display()
        );
    }
    let text = model::text(&arguments.log)?;
    let bar = progress(0, "solving");
    let log = read_log(&text, &arguments.log, read.task.dialect, |how| {
        bar.suspend(|| tell(format_args!("note: {}: {how}", arguments.log.display())));
    })?;
    let plan = Plan::new(&read.task, &read.machine)?;
    let trips = trips(&read.task, &plan, &log, &arguments.log)?;
    let found = calibrate(&read.task, &read.machine, &plan, &trips, &arguments.log)?;
    bar.finish_and_clear();
    let document = found.document(&read.task, &read.machine);
    let mut edited = found.additions().edit(&read.folder, &read.name)?;
    let mut inputs = vec![arguments.task.clone(), arguments.log.clone()];
    if !same {
        copy_rest(&read, &mut edited)?;
        inputs.extend(Machine::files(&read.path).unwrap_or_default());
    }
    let mut outputs = Outputs::of(inputs);
    outputs.folder(&arguments.output)?;
    for (name, text) in &edited.files {
        outputs.put(&arguments.output.join(name), text.as_bytes())?;
    }
    if let Some(directory) = &arguments.report {
        let source = arguments.log.file_name().unwrap_or_default().to_string_lossy();
        let page = report::calibrate::page(&source, &read.task, &plan, &found, &document);
        report::write(&mut outputs, &page, directory, "calibrate.html")?;
    }
    outputs.commit()?;
    for note in &edited.notes {
        tell(note);
    }
    for (name, _) in &edited.files {
        tell(format_args!("written {}", arguments.output.join(name).display()));
    }
    if arguments.json { json(&document) } else { print(&table(&document)?) }
}

fn is_same(one: &Path, other: &Path) -> bool {
    let resolved = |path: &Path| std::fs::canonicalize(path).ok();
    resolved(one).is_some_and(|one| resolved(other) == Some(one))
}

/// Tables that stay as they are go along into a new folder.
fn copy_rest(read: &Read, edited: &mut Edited) -> Result<()> {
    let folder =
        if read.path.is_dir() { read.path.clone() } else { read.path.parent().unwrap_or(Path::new("")).into() };
    for file in Machine::files(&read.path)? {
        let Ok(name) = file.strip_prefix(&folder) else { continue };
        if edited.files.iter().all(|(edited, _)| edited != name) {
            // Before machine.toml, which names it.
            edited.files.insert(0, (PathBuf::from(name), model::text(&file)?));
        }
    }
    Ok(())
}
