//! `trueaxis keep simulate`.

use super::SimulateArgs;
use crate::model::note;
use anyhow::Result;
use trueaxis_evaluation::keep::State;
use trueaxis_evaluation::simulated::rehearsal::keep;
use trueaxis_tables::output::Outputs;

pub(super) fn run(arguments: &SimulateArgs) -> Result<()> {
    let conditions = arguments.disturbances.conditions(Some(arguments.set_up))?;
    let state = State::read(&arguments.task, &mut note)?;
    let path = state.folder.join(&state.name);
    let truth = arguments.truth.machine(&path, &state.machine, &conditions)?;
    let log = keep(&state.task, &state.machine, &truth, &conditions)?;
    let own = state.files.keys().map(|file| state.folder.join(file));
    let inputs = arguments.truth.inputs(&path).into_iter().chain(own).chain([arguments.task.clone()]);
    let mut outputs = Outputs::of(inputs);
    let notes = arguments.truth.save(&mut outputs, &truth)?;
    crate::simulate::write(outputs, arguments.output.as_deref(), &log, &notes)
}
