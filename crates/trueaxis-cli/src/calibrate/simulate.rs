//! `trueaxis calibrate simulate`.

use super::{SimulateArgs, read};
use anyhow::Result;
use trueaxis_evaluation::simulated::rehearsal::calibrate;
use trueaxis_tables::output::Outputs;

pub(super) fn run(arguments: &SimulateArgs) -> Result<()> {
    let conditions = arguments.disturbances.conditions(arguments.set_up)?;
    let read = read(&arguments.task)?;
    let truth = arguments.truth.machine(&read.path, &read.machine, &conditions)?;
    let log = calibrate(&read.task, &read.machine, &truth, &conditions)?;
    let inputs = arguments.truth.inputs(&read.path).into_iter().chain([arguments.task.clone()]);
    let mut outputs = Outputs::of(inputs);
    let notes = arguments.truth.save(&mut outputs, &truth)?;
    crate::simulate::write(outputs, arguments.output.as_deref(), &log, &notes)
}
