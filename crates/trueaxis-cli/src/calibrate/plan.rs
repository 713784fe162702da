//! `trueaxis calibrate plan`.

use super::{PlanArguments, read};
use crate::output::{print, tell};
use anyhow::Result;
use trueaxis_evaluation::calibrate::{Plan, foresee, program};
use trueaxis_report::number::significant;
use trueaxis_tables::Machine;
use trueaxis_tables::output::Outputs;

pub(super) fn run(arguments: &PlanArguments) -> Result<()> {
    let read = read(&arguments.task)?;
    let plan = Plan::new(&read.task, &read.machine)?;
    let foreseen = foresee(&read.task, &read.machine, &plan)?;
    let text = program(&read.task, &read.machine, &plan);
    match &arguments.output {
        None => print(&text)?,
        Some(output) => {
            let machine = Machine::files(&read.path).unwrap_or_default();
            let mut outputs = Outputs::of(machine.iter().chain([&arguments.task]));
            outputs.put(output, text.as_bytes())?;
            outputs.commit()?;
            let minutes = plan.touches.last().map_or(0.0, |touch| touch.time_s / 60.0).ceil();
            tell(format_args!(
                "written {}: {} touches, about {minutes} minutes without set-ups",
                output.display(),
                plan.touches.len()
            ));
        }
    }
    tell("expected standard errors:");
    let terms = &foreseen.observed.terms.terms;
    for (term, error) in terms.iter().zip(&foreseen.solution.standard_errors) {
        let (unit, factor) = term.unit();
        tell(format_args!("  {:<22} {} {unit}", term.name(), significant(factor * error, 2)));
    }
    if read.task.reference.is_none() {
        tell("note: no [reference]: a drift while probing would be in the results");
    }
    Ok(())
}
