//! `trueaxis keep plan`.

use super::PlanArgs;
use crate::model::note;
use crate::output::{data, json, report_line};
use anyhow::Result;
use trueaxis_evaluation::keep::{Planning, State};
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::counted;

pub(super) fn run(arguments: &PlanArgs) -> Result<()> {
    let state = State::read(&arguments.task, &mut note)?;
    let Planning { program, foreseen, .. } = Planning::new(&state.task, &state.machine)?;
    match &arguments.output {
        None => data(&program)?,
        Some(output) => {
            let own = state.files.keys().map(|file| state.folder.join(file));
            let mut outputs = Outputs::of(own.chain([arguments.task.clone()]));
            outputs.put(output, program.as_bytes())?;
            outputs.commit()?;
            let minutes = counted(foreseen.minutes.ceil() as usize, "minute");
            let touches = foreseen.touches;
            report_line(format_args!("written {}: {touches} touches, about {minutes}", output.display()));
        }
    }
    if arguments.json {
        return json(&foreseen);
    }
    foreseen.expected().to_string().lines().for_each(report_line);
    Ok(())
}
