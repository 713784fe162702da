//! `trueaxis keep plan`.

use super::PlanArguments;
use super::state::State;
use crate::output::{print, tell};
use anyhow::Result;
use trueaxis_evaluation::calibrate::program;
use trueaxis_evaluation::keep::{foreseen, plan};
use trueaxis_report::number::significant;
use trueaxis_tables::output::Outputs;

pub(super) fn run(arguments: &PlanArguments) -> Result<()> {
    let state = State::read(&arguments.task)?;
    let planned = plan(&state.keep, &state.machine)?;
    let errors = foreseen(&state.keep, &state.machine, &planned)?;
    let text = program(&state.keep.task, &state.machine, &planned);
    match &arguments.output {
        None => print(&text)?,
        Some(output) => {
            let own = state.files.keys().map(|file| state.folder.join(file));
            let mut outputs = Outputs::of(own.chain([arguments.task.clone()]));
            outputs.put(output, text.as_bytes())?;
            outputs.commit()?;
            let minutes = planned.touches.last().map_or(0.0, |touch| touch.time_s / 60.0).ceil();
            let touches = planned.touches.len();
            tell(format_args!("written {}: {touches} touches, about {minutes} minutes", output.display()));
        }
    }
    tell("expected standard errors, and what is taken at once and in all:");
    for (kept, error) in state.keep.terms.iter().zip(errors) {
        let (unit, factor) = kept.term.unit();
        let shown = |value: f64| significant(factor * value, 2);
        let (update, total) = (shown(kept.bounds.update), shown(kept.bounds.total));
        tell(format_args!("  {:<14} {:>8} {unit}   {update}, {total}", kept.name, shown(error)));
    }
    Ok(())
}
