//! `trueaxis tables check`, `compile` and `show`.

use crate::model::{self, parsed};
use crate::output::{json, print, tell};
use anyhow::{Context, Result, bail};
use serde_json::{Value, json};
use std::path::Path;
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::error::FileError;
use trueaxis_tables::files::Folder;
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::counted;
use trueaxis_tables::{LostMotion, Machine, build, feedback_margins, lost_motion, summary};

pub(super) fn check(path: &Path, rate_hz: f64, as_json: bool) -> Result<()> {
    let (machine, bytes) = compiled(path, rate_hz)?;
    let tables = parsed(&bytes, path)?;
    let warnings = trueaxis_tables::check(&machine, rate_hz);
    let lost = lost_motion(&machine);
    let margins = feedback_margins(&machine, rate_hz);
    if as_json {
        let warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        let lost: Vec<Value> = lost.iter().map(lost_motion_json).collect();
        return json(&json!({
            "ok": true, "warnings": warnings, "lost_motion": lost, "feedback_margins": margins, "summary": summary(&tables)
        }));
    }
    print(&format!("{}\n", summary(&tables)))?;
    for lost in &lost {
        print(&format!("{lost}\n"))?;
    }
    for margins in &margins {
        print(&format!("{margins}\n"))?;
    }
    for warning in &warnings {
        tell(format_args!("warning: {warning}"));
    }
    print(&format!("{}: no errors, {}\n", path.display(), counted(warnings.len(), "warning")))
}

/// In the units of the files: µm and mm, of a rotary axis µrad and degrees.
fn lost_motion_json(lost: &LostMotion) -> Value {
    let ms = lost.lead_in_s * 1e3;
    if lost.axis.is_rotary() {
        json!({
            "axis": lost.axis.letter(), "play_urad": lost.play.to_radians() * 1e6, "lead_in_ms": ms,
            "feed_deg_per_s": lost.feed_per_s, "way_deg": lost.way
        })
    } else {
        json!({
            "axis": lost.axis.letter(), "play_um": lost.play * 1e3, "lead_in_ms": ms,
            "feed_mm_per_s": lost.feed_per_s, "way_mm": lost.way
        })
    }
}

/// A machine with its compiled form, accepted by what a controller runs at this rate.
fn compiled(path: &Path, rate_hz: f64) -> Result<(Machine, Vec<u8>)> {
    if !(10.0..=1e6).contains(&rate_hz) {
        bail!("--rate-hz: found {rate_hz}, needed 10 to 1000000");
    }
    let machine = model::source(path)?;
    let (folder, name) = Folder::of_machine(path);
    let bytes = trueaxis_tables::compile(&machine).map_err(|error| Machine::refusal(&folder, &name, &error))?;
    build(&machine, rate_hz).map_err(|error| {
        let refusal = Machine::refusal(&folder, &name, &error);
        FileError { needed: format!("{} (at {rate_hz} Hz)", refusal.needed), ..refusal }
    })?;
    Ok((machine, bytes))
}

pub(super) fn compile(path: &Path, rate_hz: f64, output: &Path) -> Result<()> {
    let (machine, bytes) = compiled(path, rate_hz)?;
    for warning in trueaxis_tables::check(&machine, rate_hz) {
        tell(format_args!("warning: {warning}"));
    }
    let tables = parsed(&bytes, output)?;
    let mut outputs = Outputs::of(model::files(path));
    outputs.put(output, &bytes)?;
    outputs.commit()?;
    tell(format_args!(
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
    let bytes = std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
    let tables: Tcomp<'_> = parsed(&bytes, file)?;
    if as_json { json(&summary(&tables)) } else { print(&format!("{}\n", summary(&tables))) }
}
