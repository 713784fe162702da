//! `trueaxis tables check`, `compile` and `show`.

use crate::model::{self, parsed};
use crate::output::{json, print, report_line};
use anyhow::Result;
use std::path::Path;
use trueaxis::tcomp::Tcomp;
use trueaxis_evaluation::check::{CheckDocument, Findings, findings};
use trueaxis_evaluation::model::bytes;
use trueaxis_tables::files::Folder;
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::counted;
use trueaxis_tables::uncertainty::Uncertainties;
use trueaxis_tables::{Machine, summary};

pub(super) fn check(path: &Path, rate_hz: f64, as_json: bool) -> Result<()> {
    let (machine, bytes) = compiled(path, rate_hz)?;
    let known = Uncertainties::read(path)?;
    let found = findings(&machine, &known, &parsed(&bytes, path)?, rate_hz);
    if as_json {
        // Converting to a `Value` sorts the document's keys alphabetically.
        return json(&serde_json::to_value(CheckDocument::from(found))?);
    }
    let Findings { warnings, lost_motion, margins, dynamic_needs, summary } = found;
    print(&format!("{summary}\n"))?;
    for lost in &lost_motion {
        print(&format!("{lost}\n"))?;
    }
    for margins in &margins {
        print(&format!("{margins}\n"))?;
    }
    for need in &dynamic_needs {
        print(&format!("{need}\n"))?;
    }
    for warning in &warnings {
        report_line(format_args!("warning: {warning}"));
    }
    print(&format!("{}: no errors, {}\n", path.display(), counted(warnings.len(), "warning")))
}

/// A machine with its compiled form, once a controller's build at this rate has accepted it.
fn compiled(path: &Path, rate_hz: f64) -> Result<(Machine, Vec<u8>)> {
    let (folder, name) = Folder::of_machine(path);
    trueaxis_evaluation::check::rate(rate_hz)?;
    let machine = model::source(path)?;
    let bytes = trueaxis_evaluation::check::compiled(&machine, &folder, &name, rate_hz)?;
    Ok((machine, bytes))
}

pub(super) fn compile(path: &Path, rate_hz: f64, output: &Path) -> Result<()> {
    let (machine, bytes) = compiled(path, rate_hz)?;
    for warning in trueaxis_tables::check(&machine, rate_hz) {
        report_line(format_args!("warning: {warning}"));
    }
    let tables = parsed(&bytes, output)?;
    let mut outputs = Outputs::of(model::files(path));
    outputs.put(output, &bytes)?;
    outputs.commit()?;
    report_line(format_args!(
        "{}: {} bytes, machine {} (id {:08x}), CRC {:08x}",
        output.display(),
        bytes.len(),
        machine.settings.name,
        tables.machine_id(),
        tables.crc()
    ));
    Ok(())
}

pub(super) fn show(file: &Path, as_json: bool) -> Result<()> {
    let bytes = bytes(file)?;
    let tables: Tcomp<'_> = parsed(&bytes, file)?;
    if as_json { json(&summary(&tables)) } else { print(&format!("{}\n", summary(&tables))) }
}
