//! `trueaxis calibrate plan`.

use super::{PlanArgs, read};
use crate::output::{data, json, report_line};
use anyhow::Result;
use trueaxis_evaluation::calibrate::Planning;
use trueaxis_tables::Machine;
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::counted;

pub(super) fn run(arguments: &PlanArgs) -> Result<()> {
    let read = read(&arguments.task)?;
    let Planning { program, foreseen, .. } = Planning::new(&read.task, &read.machine)?;
    match &arguments.output {
        None => data(&program)?,
        Some(output) => {
            let machine = Machine::files(&read.path).unwrap_or_default();
            let mut outputs = Outputs::of(machine.iter().chain([&arguments.task]));
            outputs.put(output, program.as_bytes())?;
            outputs.commit()?;
            let minutes = counted(foreseen.minutes.ceil() as usize, "minute");
            let touches = foreseen.touches;
            let output = output.display();
            let what = read.task.words();
            report_line(format_args!("written {output}: {touches} {what}, about {minutes} without set-ups"));
        }
    }
    if arguments.json {
        return json(&foreseen);
    }
    foreseen.expected().to_string().lines().for_each(report_line);
    for warning in &foreseen.warnings {
        report_line(format_args!("note: {warning}"));
    }
    Ok(())
}
