//! `trueaxis calibrate plan`.

use super::{PlanArgs, of_task, read};
use crate::model;
use crate::output::{data, json, progress, report_line};
use anyhow::{Result, anyhow, bail};
use std::path::Path;
use trueaxis_evaluation::calibrate::{Chosen, Planning, Task, chosen};
use trueaxis_tables::Machine;
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::counted;

/// Steps of the progress bar.
const STEPS: u64 = 100;

pub(super) fn run(arguments: &PlanArgs) -> Result<()> {
    if let (Some(minutes), Some(placed)) = (arguments.minutes, &arguments.placed) {
        return choose(arguments, minutes, placed);
    }
    let read = read(&arguments.task)?;
    let planning = Planning::new(&read.task, &read.machine)?;
    match &arguments.output {
        None => data(&planning.program)?,
        Some(output) => {
            let machine = Machine::files(&read.path).unwrap_or_default();
            let mut outputs = Outputs::of(machine.iter().chain([&arguments.task]));
            outputs.put(output, planning.program.as_bytes())?;
            outputs.commit()?;
            report_line(format_args!("{}", written(output, &planning, &read.task)));
        }
    }
    if arguments.json {
        return json(&planning.foreseen);
    }
    said(&planning);
    Ok(())
}

fn written(output: &Path, planning: &Planning, task: &Task) -> String {
    let minutes = counted(planning.foreseen.minutes.ceil() as usize, "minute");
    let (output, touches, what) = (output.display(), planning.foreseen.touches, task.words());
    format!("written {output}: {touches} {what}, about {minutes} without set-ups")
}

fn said(planning: &Planning) {
    planning.foreseen.expected().to_string().lines().for_each(report_line);
    for warning in &planning.foreseen.warnings {
        report_line(format!("note: {warning}"));
    }
}

/// Chooses places; writes the task with them and its program.
fn choose(arguments: &PlanArgs, minutes: f64, placed: &Path) -> Result<()> {
    if !(minutes > 0.0 && minutes <= 1e5) {
        bail!("--minutes: found {minutes}, needed 0 to 100000 minutes");
    }
    let folder = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        folder.canonicalize().unwrap_or_else(|_| folder.to_owned())
    };
    if folder(placed) != folder(&arguments.task) {
        let (found, task) = (placed.display(), arguments.task.display());
        bail!("--placed: found {found}, needed a file beside {task}, which names its machine");
    }
    let output = arguments.output.as_ref();
    let output = output.ok_or_else(|| anyhow!("--minutes: found no --output, needed a file for the program"))?;
    let text = model::text(&arguments.task)?;
    let read = of_task(Task::read_open(&text, &arguments.task)?, &arguments.task)?;
    let bar = progress(STEPS, "choosing places");
    let mut on = |share: f64| bar.set_position((share * STEPS as f64) as u64);
    let Chosen { document, task, planning } = chosen(&text, &arguments.task, &read.machine, minutes, &mut on)?;
    bar.finish_and_clear();
    let machine = Machine::files(&read.path).unwrap_or_default();
    let mut outputs = Outputs::of(machine.iter().chain([&arguments.task]));
    outputs.put(placed, task.as_bytes())?;
    outputs.put(output, planning.program.as_bytes())?;
    outputs.commit()?;
    report_line(format!(
        "written {}: {} in {:.0} minutes with setting up",
        placed.display(),
        counted(document.choices.len(), "place"),
        document.minutes
    ));
    report_line(written(output, &planning, &read.task));
    if arguments.json {
        return json(&document);
    }
    document.shown().iter().for_each(report_line);
    said(&planning);
    Ok(())
}
